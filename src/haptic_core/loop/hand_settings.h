/// How one device's grip moves its pointer and feels it.
#pragma once
#include "haptic_core/loop/delay_line.h"
#include "haptic_core/loop/passivity.h"
#include "haptic_core/loop/workspace_map.h"

namespace haptic {

/// Rate at which a force fades out [N/s]: 0.01 N in a tick of 1 kHz, and 10 N are gone after a second. A step is felt from about 0.05 N on.
inline constexpr double kFadeRate = 10;
/// Factor on that rate where the hand leaves a contact [1]: 4 N take 0.1 s, in which a hand at 0.1 m/s gets 20 mJ.
inline constexpr double kLeavingFade = 4;

/// How one grip moves its pointer and feels it.
struct HandSettings {
  /// Where the device stands in the world, and its scale.
  WorkspaceSettings workspace;
  double force_scale = 1;          ///< hand newtons per world newton
  /// Of the observer and controller at the port.
  PassivitySettings passivity;
  double soft_start_s = 0.5;       ///< force fades in, and the pointer glides to the grip, over this time after
                                   ///< load, reset and pause [s]
  int clutch_button = -1;          ///< grip button that holds the pointer while pressed; -1: none
  int grab_button = -1;            ///< grip button that grabs the free body in touch, and lets it go; -1: none
  AddedDelay delay;                ///< beside the wire's; constant while the hand is attached
  bool silent = false;             ///< the force fades out by kFadeRate, and stays out

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.workspace), visit(s.force_scale), visit(s.passivity), visit(s.soft_start_s), visit(s.clutch_button),
        visit(s.grab_button), visit(s.delay), visit(s.silent);
  }
};

}  // namespace haptic
