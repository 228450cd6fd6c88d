/// How one device's grip moves its pointer and feels it.
#pragma once
#include "haptic_core/loop/passivity.h"
#include "haptic_core/loop/workspace_map.h"

namespace haptic {

/// How one grip moves its pointer and feels it.
struct HandSettings {
  /// Where the device stands in the world, and its scale.
  WorkspaceSettings workspace;
  double force_scale = 1;          ///< hand newtons per world newton
  /// Of the observer and controller at the port.
  PassivitySettings passivity;
  double soft_start_s = 0.5;       ///< force fades in, and the pointer glides to the grip, over this time after
                                   ///< enable, load, reset and overrun [s]
  int clutch_button = -1;          ///< grip button that holds the pointer while pressed; -1: none
  int grab_button = -1;            ///< grip button that grabs the free body in touch, and lets it go; -1: none

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.workspace), visit(s.force_scale), visit(s.passivity), visit(s.soft_start_s), visit(s.clutch_button),
        visit(s.grab_button);
  }
};

}  // namespace haptic
