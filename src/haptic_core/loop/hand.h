/// One hand: a device on its pointer. Sense → couple → (the world steps) → render.
#pragma once
#include <vector>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/force_slew.h"

namespace haptic {

/// One hand of a HapticLoop: a device on its pointer.
class Hand {
 public:
  /// For ticks of `h` [s]. Allocates the lines of an added delay. Throws SetupError.
  Hand(Spidar& device, int pointer, const HandSettings& settings, double h);

  /// (in realtime) Counts → pose; the port's energy is observed on the displacement since the last sample.
  void sense(const DeviceSample& sample, double h, const TimeLost& lost = {}) noexcept;
  /// (in realtime) Grip → pointer target. Without a valid pose the pointer stands still.
  void couple(World& world, double h) noexcept;
  /// (in realtime) Before any step of the world: how stiff contacts of the pointer may be, and how hard it may press.
  void bear(World& world) const noexcept;
  /// (in realtime) The pointer's wrench → the device's limits, gain and law of change → passivity → tensions, drive.
  void render(const World& world, double h) noexcept;
  /// (in realtime) In place of couple and render while the world is paused: nothing is asked for.
  void rest(const World& world, double h) noexcept;

  // Between two ticks.
  /// Carries out a command to this hand; throws SetupError.
  void take(const LoopCommand& command);
  /// A command changed the world, whose pointer was `link_before`: when that moved the pointer, the map takes up the
  /// difference and the force fades in anew.
  void followWorld(const World& world, int link_before, bool jumped) noexcept;
  /// (in realtime) Bodies have come or gone: links have other numbers. `link_before`: the pointer's old one.
  void followBodies(const World& world, const NextWorld& change, int link_before) noexcept;
  /// Throws SetupError; the pointer keeps its place, and glides after a base that moved.
  void setSettings(const HandSettings& settings);
  /// Between two ticks: the pointer stands from now on.
  void letGo(World& world) noexcept;

  /// Complete memory but for the settings, for recordings: `restore` of it makes this hand or another with the same
  /// settings go on bit for bit. Between two ticks; allocates unless `out` has room for `mostMemory`. `restore` throws
  /// SetupError when it does not fit.
  void save(std::vector<double>& out) const;
  /// See `save`.
  void restore(const std::vector<double>& memory);
  /// Upper bound of what `save` appends, for ticks of `h` [s].
  static std::size_t mostMemory(const HandSettings& settings, double h);
  /// What sense, couple, render or a hash read before they write it, but for the settings.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.map_), visit(s.passivity_);
    visit(s.report_.X_BG), visit(s.report_.X_WP), visit(s.report_.port_energy);
    visit(s.report_.in_contact), visit(s.report_.clutched);
    visit(s.clutch_held_), visit(s.rebase_), visit(s.buttons_), visit(s.last_buttons_), visit(s.was_valid_);
    visit(s.pressing_), visit(s.given_B_), visit(s.seen_line_), visit(s.pushed_line_);
  }

  /// Of the last tick.
  const HandReport& report() const noexcept { return report_; }
  /// For the next exchange.
  const DriveCommand& drive() const noexcept;
  /// With its observer's energy.
  const PassivityController& passivity() const noexcept { return passivity_; }
  /// Constant between two commands.
  const HandSettings& settings() const noexcept { return settings_; }
  /// Largest wall [N/m] that a relaxed hand bears over this wire and the added delay.
  double stableStiffness() const noexcept;
  /// The caller's.
  Spidar& device() noexcept { return device_; }
  /// The caller's.
  const Spidar& device() const noexcept { return device_; }
  /// Index in the world.
  int pointer() const noexcept { return pointer_; }

 private:
  /// The grip as the pointer follows it: an added delay of the pose ago.
  struct Seen {
    Pose X_BG;    ///< steady
    Twist V_BG;   ///< filtered, at G's origin, in B
    Twist moved;  ///< mean velocity since the sample before, not filtered, in B

    template <class Self, class Visit>
    static void eachField(Self& s, Visit&& visit) {
      visit(s.X_BG), visit(s.V_BG), visit(s.moved);
    }
  };
  /// The world's answer to it.
  struct Pushed {
    Wrench F_W;   ///< on the hand at the pointer's origin, in W
    Twist moved;  ///< of the grip, as the world saw it

    template <class Self, class Visit>
    static void eachField(Self& s, Visit&& visit) {
      visit(s.F_W), visit(s.moved);
    }
  };
  void check(const HandSettings& settings) const;
  bool pressed(int button) const noexcept { return button >= 0 && ((buttons_ >> button) & 1u) != 0; }
  int pressing(const World& world) const noexcept;
  void followGrabButton(World& world) noexcept;
  /// The passivity controller is off: no bound of the hand, no limit but the device's own.
  bool feelsAnything() const noexcept { return settings_.passivity.mode == PassivityMode::kOff; }
  Wrench ledOut(const Wrench& whole_B, double h) const noexcept;
  ForceSlew slewOf(const World& world) const noexcept;
  void give(const Wrench& F_B, const World& world, const Twist& moved, double h) noexcept;
  double worldToGrip() const noexcept { return settings_.workspace.scale * settings_.force_scale; }  ///< of a stiffness
  Spidar& device_;
  int pointer_;
  HandSettings settings_;
  WorkspaceMap map_;
  PassivityController passivity_;
  HandReport report_;
  DelayLine<Seen> seen_line_;
  DelayLine<Pushed> pushed_line_;
  double count_;                                   ///< of the coarsest string [m]
  double velocity_filter_;                         ///< time constant of the device's velocity [s]
  Seen seen_;                                      ///< of this tick
  bool clutch_held_ = false;                       ///< by command
  Rebase rebase_ = Rebase::kGlide;                 ///< due at the next `couple`: the pointer starts where the scene has it
  std::uint32_t buttons_ = 0, last_buttons_ = 0;   ///< of this tick and the one before
  int pressing_ = -1;                              ///< link that the grab button would grab, as the last step left it; -1: none
  bool was_valid_ = false;
  Wrench given_B_;                                 ///< asked of the device in the last tick, within its limits
  Twist moved_;                                    ///< mean velocity since the last sample, not filtered, in B
};

}  // namespace haptic
