/// Whether a hand can bear the contacts of its pointer: their stiffness against the bound that the device's damping sets.
///
/// A foundation has no one stiffness. Pressed with F on a flat wall a pointer sinks until k V(δ) = F and then meets
/// K = k A0(δ): k A for a flat face whatever F, 2 √(π R k F) for a ball of radius R. The bound on K is that of
/// wall_bound.h; friction's springs and the contact's damper are not in it. Whether the loop itself rings, loop/hand_trial.h tries.
#pragma once
#include <string>

#include "haptic_core/spidar/device_def.h"
#include "haptic_core/world/definition.h"

namespace haptic {

/// How a pointer hangs on its device.
struct HandMapping {
  double scale = 1;        ///< world metres per grip metre
  double force_scale = 1;  ///< grip newtons per world newton
  double delay = 0;        ///< added on purpose, of pose and force together [s]
};

/// Whether a hand can bear what its pointer touches: stiffness against its bounds.
struct HandCertificate {
  std::string pointer, against;  ///< links; `against` is empty where the pointer touches nothing
  double press = 0;              ///< F at the grip [N]
  double foundation = 0;         ///< k of the stiffest pair of surfaces [N/m³]
  double stiffness = 0;          ///< K at the grip, of its stiffest side on a flat wall [N/m]
  double alone = 0;              ///< bound on K for the device alone, without a hand [N/m]
  double held = 0;               ///< and with a relaxed hand [N/m]
  double carries = 0;            ///< most force that its weakest side can bring to the hand: beyond it stays behind [N]
  double most = 0;               ///< the device's greatest force [N]
  double bearable = 0;           ///< largest k [N/m³] with K ≤ `held`, up to 100 foundations; 0: none
  double coupling = 0;           ///< of a virtual coupling as the scene has it, at the grip [N/m]; 0: direct
  double coupling_borne = 0;     ///< stiffest one that the hand bears in front of anything [N/m]
  double firmer = 1;             ///< times as stiff as in the scene is the surface for a virtual coupling's tool (world/hand_bound.h) [1]
  double rate = 0;               ///< [Hz]
  double delay = 0;              ///< added on purpose [s]
  double held_without = 0;       ///< `held` without that [N/m]

  /// A relaxed hand bears contact and coupling as the scene says, or there is no contact; else the loop weakens them.
  bool holds() const { return against.empty() || (coupling > 0 ? coupling <= coupling_borne : stiffness <= held); }
  /// The loop changes something of the scene for this hand, which `text` says.
  bool changes() const { return !holds() || firmer > 1; }
  std::string text() const;      ///< one line
};

/// For pointer `pointer` of the definition. `press` of 2 N is a firm touch: 4 mm into a relaxed hand. At set-up:
/// allocates. Throws SetupError as `World` does.
HandCertificate certifyHand(const WorldDef& def, int pointer, const HandMapping& mapping, const DeviceDef& device,
                            double press = 2);

/// Largest k [N/m³] with which K ≤ `bound` [N/m] at the grip, whatever side of the pointer's shapes is pressed on a flat wall
/// with `press` [N] at the grip; 0: none. At set-up.
double bearableFoundation(const WorldDef& def, int pointer, const HandMapping& mapping, double bound, double press = 2);

}  // namespace haptic
