/// Whoever waits hears of it: silence is ended by a line of the stage, lines pass in order, and nothing is told after the end.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <vector>

#include "scene/progress_watch.h"

namespace haptic {
namespace progress_watch_test {

struct Heard {
  std::mutex mutex;
  std::condition_variable more;
  std::vector<std::string> lines;

  std::function<void(const std::string&)> ear() {
    return [this](const std::string& line) {
      const std::lock_guard<std::mutex> lock(mutex);
      lines.push_back(line);
      more.notify_all();
    };
  }
  /// Whether such a line came in a time that any machine has.
  bool hears(const std::string& start) {
    std::unique_lock<std::mutex> lock(mutex);
    return more.wait_for(lock, std::chrono::minutes(2), [&] { return !lines.empty() && lines.back().rfind(start, 0) == 0; });
  }
};

TEST(ProgressWatch, EndsSilenceByItsStage) {
  Heard heard;
  {
    ProgressWatch watch(heard.ear(), "one");
    EXPECT_TRUE(heard.hears("one: "));
    watch.stage("two");
    watch.tell("a line");
    EXPECT_TRUE(heard.hears("a line"));
    EXPECT_TRUE(heard.hears("two: "));
  }
  const std::size_t told = heard.lines.size();
  ProgressWatch(heard.ear(), "three");  // ends at once
  EXPECT_EQ(heard.lines.size(), told);
}

}  // namespace progress_watch_test
}  // namespace haptic
