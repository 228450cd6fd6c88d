/// A scene under a simulated hand, and a recorded session again, as the page in the browser runs them.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "browser/picture.h"
#include "haptic_core/analysis/error_estimate.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/world.h"
#include "scene/packed_scene.h"

namespace haptic {

/// World, Spidar, DeviceTwin and HapticLoop, as in the demo. Whoever draws it calls `tick` once per step of simulated time; `aim` is where
/// the mouse, a finger or a gamepad wants the grip. Until then the hands follow the scene's paths.
class Touch {
 public:
  explicit Touch(PackedScene packed);  ///< throws SetupError as World does

  /// One tick of the loop: World::settings().step of simulated time.
  void tick() noexcept;

  /// The hand leads the grip of `hand` towards this point of the world [m], held within the device's frame; it keeps its orientation.
  void aim(int hand, const Vector3& p_W) noexcept;
  void letGo(int hand) noexcept;  ///< the hand follows the scene's path again
  Vector3 aimed(int hand) const;  ///< where it is led, or the grip, in W [m]
  bool led(int hand) const;       ///< since `aim`, until `letGo`

  /// Stiffness of all contacts and friction, as factors of the scene's own. Throws SetupError outside of WorldTuning's bounds.
  void tune(double stiffness, double friction);

  /// Error of the step over the next ErrorEstimator::kWindowSteps, as the world stands (analysis/error_estimate.h). Costs 50 steps.
  ErrorEstimate estimate();

  const PackedScene& packed() const { return packed_; }             ///< as constructed
  const std::vector<DrawnHand>& hands() const { return drawn_; }    ///< for `picture`
  HapticLoop& loop() { return loop_; }                              ///< of the last tick

 private:
  struct Device {
    Device(const DeviceDef& def, const TwinSettings& settings) : spidar(def), twin(def, settings) {}
    Spidar spidar;
    DeviceTwin twin;
    bool led = false;
    Vector3 target_W = Vector3::Zero();
  };

  PackedScene packed_;
  World world_;
  std::vector<std::unique_ptr<Device>> devices_;  ///< in the order of the scene's hands
  std::vector<DrawnHand> drawn_;
  HapticLoop loop_{world_};
  ErrorEstimator estimator_;
};

/// A recorded session, tick by tick, its hashes compared with the recorded ones.
class Again {
 public:
  explicit Again(PackedSession session);  ///< throws SetupError as SessionReplay does

  /// The next tick, with the commands before it; nothing after the last. A command that is refused ends the session.
  void tick() noexcept;
  int ticks() const { return static_cast<int>(session_.ticks.size()); }  ///< recorded
  int done() const { return done_; }          ///< of them
  int compared() const { return compared_; }  ///< of those: had a recorded hash
  int same() const { return same_; }          ///< of those: came to it, bit for bit

  const PackedSession& session() const { return session_; }       ///< as constructed
  const std::vector<DrawnHand>& hands() const { return drawn_; }  ///< for `picture`, as they were at the start
  HapticLoop& loop() { return replay_.loop(); }                   ///< of the last tick

 private:
  PackedSession session_;
  SessionReplay replay_;
  std::vector<DrawnHand> drawn_;
  std::size_t event_ = 0;
  int done_ = 0, compared_ = 0, same_ = 0;
};

}  // namespace haptic
