#include "scene/progress_watch.h"

#include <utility>

namespace haptic {

ProgressWatch::ProgressWatch(std::function<void(const std::string&)> tell, std::string stage)
    : tell_(std::move(tell)), stage_(std::move(stage)), thread_([this] { run(); }) {}

ProgressWatch::~ProgressWatch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ProgressWatch::stage(std::string what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stage_ = std::move(what);
  began_ = Clock::now();
}

void ProgressWatch::tell(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  told_ = Clock::now();
  tell_(line);
}

void ProgressWatch::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ends_) {
    const Clock::time_point due = told_ + kSilence;
    if (wake_.wait_until(lock, due, [this] { return ends_; })) return;
    if (Clock::now() < told_ + kSilence) continue;  // a line came meanwhile
    told_ = Clock::now();
    tell_(stage_ + ": " + std::to_string(std::chrono::duration_cast<std::chrono::seconds>(told_ - began_).count()) + " s");
  }
}

}  // namespace haptic
