/// Ours beside today's peers, on the scenes that makers of simulators publish, and rigid when asked.
///
/// `bench_peers [GROUP...]`: groups sinks, times, grasp, cradle, gyro, pyramid, six; without a word all. `pyramid=ROWS` takes another
/// number of rows. Lines that begin with `peers` are the table beside the figures, one setting of one simulator each.
#include <cstdlib>
#include <string>
#include <vector>

#include "peers_figures.h"
#include "round_figures.h"

int main(int count, char** arguments) {
  using namespace haptic::bench;
  const std::vector<std::string> words(arguments + 1, arguments + count);
  int rows = 100;
  const auto wanted = [&](const std::string& group) {
    if (words.empty()) return true;
    for (const std::string& word : words) {
      if (word == group) return true;
      if (word.rfind(group + "=", 0) == 0) return (rows = std::atoi(word.c_str() + group.size() + 1)) > 0;
    }
    return false;
  };
  if (wanted("sinks")) measureRigidSinks();
  if (wanted("times")) measureRigidTimes();
  if (wanted("grasp")) measureGrasp();
  if (wanted("cradle")) measureCradle();
  if (wanted("gyro")) measureGyroscope();
  if (wanted("six")) measureSix();
  if (wanted("pyramid")) measurePyramid(rows);
  return 0;
}
