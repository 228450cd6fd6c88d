// What a hand that presses with 9 N feels when something changes beside the contact: how far the wrench of the tensions changes in a tick
// beyond what the stiffest wall makes of the grip's way. `hand.event_tension_jump_over_n`: max over ticks, 1 s after each event, of
// |F_k - F_(k-1)| - K_max |x_k - x_(k-1)|, F of the tensions told at the measured pose, x the measured grip. Pressed by a jig that trembles
// and by a relaxed hand, with both couplings, five times each. What may end a force at once (STOP, a fault, the guard, an interruption, a
// suspend, the dead-man switch) is counted apart, each under a name of its own.
#include <algorithm>
#include <cstdio>
#include <string>

#include "../scenes/pressed_hand.h"
#include "figure.h"

namespace haptic::bench {
namespace {

constexpr int kAfter = 1000, kRounds = 5;  // ticks after an event; rounds of the four ways of pressing

int measure() {
  double worst = 0;
  int weak = 0;
  for (const scenes::HandEvent& event : scenes::handEvents()) {
    double jump = 0;
    for (int i = 0; i < 4 * kRounds; ++i) {
      scenes::PressedHand rig(i & 1, i & 2);
      rig.run(17 * (i / 4));
      weak += rig.force() < 0.8 * scenes::kPressed;
      rig.jump = 0;
      event.happen(rig);
      rig.run(kAfter);
      jump = std::max(jump, rig.jump);
    }
    std::printf("# %-14s %6.3f N%s\n", event.name, jump, event.at_once ? ", may end at once" : "");
    std::fflush(stdout);
    if (event.at_once) figure((std::string("hand.end_tension_jump_over_n_") + event.name).c_str(), jump, "N");
    if (!event.at_once) worst = std::max(worst, jump);
  }
  figure("hand.event_tension_jump_over_n", worst, "N");
  figure("hand.event_pressed_too_weakly", weak, "1");
  return weak == 0 ? 0 : 1;
}

}  // namespace
}  // namespace haptic::bench

int main() { return haptic::bench::measure(); }
