/// Robots and scenes as users have them, what acts on them from outside, and the cost of a step of Panda and Allegro in touch with a block.
#include <cstring>

#include "articulated_robots.h"
#include "robots_actors.h"
#include "robots_files.h"
#include "robots_numbers.h"
#include "robots_sensors.h"

/// `bench_robots numbers`, `bench_robots services`: these alone.
int main(int argc, char** argv) {
  const auto asked = [&](const char* part) { return argc < 2 || std::strcmp(argv[1], part) == 0; };
  if (asked("services")) haptic::bench::measureServices();
  if (asked("numbers")) haptic::bench::measureOddNumbers(), haptic::bench::measureFalseAlarms();
  if (argc > 1) return 0;
  haptic::bench::measureSensors();
  haptic::bench::measureRobotFiles();
  haptic::bench::measureChosenStiffness();
  haptic::bench::measureRobots();
  haptic::bench::measureActors();
  return 0;
}
