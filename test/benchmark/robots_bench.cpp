/// Published robots: loaded whole, and the cost of a step of Panda and Allegro in touch with a block.
#include "articulated_robots.h"

int main() {
  haptic::bench::measureRobots();
  return 0;
}
