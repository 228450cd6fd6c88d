/// Ours beside today's peers, on the scenes that makers of simulators publish, and rigid when asked.
///
/// `bench_peers [GROUP...]`: groups sinks, times, grasp, cradle, gyro, contactbench, cenic, haptic, pyramid, six; without a word all.
/// `pyramid=ROWS` takes another number of rows, 1 to 1000; any other word ends it with status 2. Lines that begin with `peers` are the
/// table beside the figures, one setting of one simulator each.
#include <cstdio>
#include <set>
#include <string>

#include "peers_figures.h"
#include "round_figures.h"

namespace haptic::bench {
namespace {

struct Wanted {
  std::set<std::string> groups = {};
  int rows = 100;
};

constexpr int kMostRows = 1000;  // half a million boxes

/// False: it is none of the words above.
bool take(const std::string& word, Wanted& wanted) {
  const std::set<std::string> groups = {"sinks", "times", "grasp", "cradle", "gyro", "contactbench", "cenic", "haptic", "pyramid", "six"};
  const std::string with_rows = "pyramid=";
  if (word.rfind(with_rows, 0) != 0) {
    wanted.groups.insert(word);
    return groups.count(word) > 0;
  }
  const std::string rows = word.substr(with_rows.size());
  if (rows.empty() || rows.size() > 4 || rows.find_first_not_of("0123456789") != std::string::npos) return false;
  wanted.groups.insert("pyramid");
  wanted.rows = std::stoi(rows);
  return wanted.rows >= 1 && wanted.rows <= kMostRows;
}

}  // namespace
}  // namespace haptic::bench

int main(int count, char** arguments) {
  using namespace haptic::bench;
  if (count == 4 && std::string(arguments[1]) == "count") {  // by itself, under callgrind
    countHapticTicks(arguments[2], arguments[3]);
    return 0;
  }
  Wanted asked;
  for (int i = 1; i < count; ++i) {
    if (take(arguments[i], asked)) continue;
    std::fprintf(stderr, "bench_peers: '%s' is no group; give sinks, times, grasp, cradle, gyro, contactbench, cenic, haptic, six, pyramid "
                 "or pyramid=ROWS, 1 to %d\n",
                 arguments[i], kMostRows);
    return 2;
  }
  const auto wanted = [&](const char* group) { return asked.groups.empty() || asked.groups.count(group) > 0; };
  if (wanted("sinks")) measureRigidSinks();
  if (wanted("times")) measureRigidTimes();
  if (wanted("grasp")) measureGrasp();
  if (wanted("cradle")) measureCradle();
  if (wanted("gyro")) measureGyroscope();
  if (wanted("contactbench")) measureContactbench();
  if (wanted("cenic")) measureCenic();
  if (wanted("haptic")) measureHaptic(), measureTwoHands();
  if (wanted("six")) measureSix();
  if (wanted("pyramid")) measurePyramid(asked.rows);
  return 0;
}
