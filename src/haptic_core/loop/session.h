/// A recorded session in the core's terms: how it began, what happened between ticks, and the run of it again.
///
/// A session is the loop's memory at its start, one TickInput per tick, and commands between ticks. The same build gives
/// the same bits from them: no clock, no thread and no device is in it.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/tick_hash.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

/// Everything that a replay starts from, beside the scene.
struct SessionStart {
  /// A device and its hand.
  struct HandStart {
    std::string device;              ///< name of the device's port
    /// As its file stated it.
    DeviceDef def;
    /// Index in the world.
    int pointer = 0;
    /// Of the hand.
    HandSettings settings;
    std::vector<double> memory;      ///< Spidar::save()
    std::vector<double> loop_memory; ///< Hand::save(); empty: the hand is new

    template <class Self, class Visit>
    static void eachField(Self& s, Visit&& visit) {
      visit(s.device), visit(s.def), visit(s.pointer), visit(s.settings), visit(s.memory), visit(s.loop_memory);
    }
  };
  /// Of the recording.
  std::uint64_t first_tick = 0;
  double step = 1e-3;                ///< h [s]
  std::vector<double> world_state;   ///< World::save()
  std::vector<double> world_tuning;  ///< WorldTuning::numbers()
  std::vector<double> bodies;        ///< packBodies() of the last ChangeBodies before; empty: the scene's
  /// The world stands at the start.
  bool paused = false;
  /// In the order of the loop's.
  std::vector<HandStart> hands;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.first_tick), visit(s.step), visit(s.world_state), visit(s.world_tuning), visit(s.bodies), visit(s.paused);
    visit(s.hands);
  }
};

/// The loop between two ticks, complete: a session can start there.
struct LoopMemory {
  std::uint64_t tick = 0;            ///< the next one
  /// World::hash() there.
  std::uint64_t world_hash = 0;
  /// World::save().
  std::vector<double> world_state;
  /// At that instant.
  WorldTuning world_tuning;
  /// HapticLoop::bodies().
  std::shared_ptr<std::vector<double>> bodies;
  /// The world stands.
  bool paused = false;
  /// Valid entries of `hand`.
  int hands = 0;
  /// Of one hand.
  struct HandMemory {
    /// Of the hand.
    HandSettings settings;
    /// Spidar::save() and Hand::save().
    std::vector<double> device, loop;
  };
  /// In the order of the loop's.
  std::array<HandMemory, kMaxHands> hand;
};

/// Set-up: room for what `remember` keeps of a loop that began like this.
LoopMemory roomFor(const SessionStart& start, std::size_t world_numbers);
/// Between two ticks. Does not allocate into a memory that has room. `tick` is the next one.
void remember(HapticLoop& loop, std::uint64_t tick, LoopMemory& memory);
/// The same session begun there. `hands[i]` is the index in `start` of the loop's hand i: some may be gone.
SessionStart startedAt(const SessionStart& start, const LoopMemory& memory, const std::array<int, kMaxHands>& hands);

/// Hash of everything that a definition gives a world: shapes, inertias, joints, materials, settings. Two scenes with
/// the same fingerprint run alike from the same state.
std::uint64_t fingerprint(const WorldDef& def);

/// Runs a session again. Allocates at set-up and in `apply` only.
class SessionReplay {
 public:
  /// Throws SetupError when the start does not fit the scene.
  SessionReplay(const WorldDef& scene, const SessionStart& start);

  void apply(const LoopCommand& command);             ///< throws SetupError
  /// (in realtime) One tick from its recorded input; its hash is to be compared with the recorded one.
  const TickHash& tick(const TickInput& input) noexcept;

  /// As it was rebuilt from the scene.
  World& world() { return world_; }
  /// With a device per hand that is still there.
  HapticLoop& loop() { return *loop_; }
  /// Name of part `i` of a TickHash: a link's, or a hand's device.
  std::string partName(int i) const;

 private:
  World world_;
  double step_;
  std::vector<std::unique_ptr<Spidar>> devices_;      ///< in the order of the loop's hands
  std::vector<std::string> names_;
  std::unique_ptr<HapticLoop> loop_;
  TickHash hash_;
};

}  // namespace haptic
