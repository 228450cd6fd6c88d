/// Robots and scenes as users have them, what acts on them from outside, and the cost of a step of Panda and Allegro in touch with a block.
#include "articulated_robots.h"
#include "robots_actors.h"
#include "robots_files.h"
#include "robots_sensors.h"

int main() {
  haptic::bench::measureSensors();
  haptic::bench::measureRobotFiles();
  haptic::bench::measureChosenStiffness();
  haptic::bench::measureRobots();
  haptic::bench::measureActors();
  return 0;
}
