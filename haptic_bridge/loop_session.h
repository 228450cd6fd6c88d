/// The ports that the bridge holds, and the loop between them, from claim to release.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_bridge/bridge_parameters.h"
#include "haptic_bridge/recorded_tick.h"
#include "haptic_bridge/tick_sample.h"
#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/realtime.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

class DeviceTwin;

class LoopSession {
 public:
  /// Claims the world and its devices. Empty, with `missing` telling what is not there yet, when one of them cannot
  /// be had now. Throws SetupError when they do not fit together (rates, pointers).
  /// `first_tick` is the index that its first tick will have.
  static std::unique_ptr<LoopSession> open(const BridgeParameters& parameters, std::uint64_t first_tick,
                                           std::string& missing);
  ~LoopSession();  ///< zero drive, and the ports back to their owners

  /// (in realtime) One tick: exchange, loop, records.
  void tick(const PeriodicWake::Wake& wake, std::uint64_t index, double h, TickSample& sample,
            RecordedTick& record) noexcept;

  const std::string& deadline() const { return deadline_; }  ///< for the user, a sentence; empty: none was asked for

  bool recalled() const noexcept;                      ///< (in realtime) the world, or the last device, must go back
  bool dropsDevice() const noexcept;                   ///< (in realtime) one of several devices must go back
  void dropRecalledDevices();                          ///< between ticks: goes on with the others

  /// Between ticks: carries a command out and records it as it was told. Throws SetupError when it cannot be done.
  void take(const LoopCommand& command);

  /// What there is now, between ticks: a recording can begin here. `origins` are the hands' indices in start().
  struct Memory {
    LoopMemory loop;
    std::array<int, kMaxHands> origins{};
    int events = 0;                                    ///< that were noted before the next tick already
    std::size_t needs = 0;                             ///< numbers of the greatest state; without room for them, all that is filled in
  };

  /// What the loop's settings are, and who its hands are: for who changes them by what they are.
  struct View {
    struct Hand {
      std::string name;
      HandSettings settings, defined;                  ///< as they are, and as the scene gives them
      Spidar::Tuning tuning, stated;                   ///< as it is, and as the device's file says
      bool in_contact = false, clutched = false;
    };
    std::vector<Hand> hands;
    WorldTuning tuning;
    std::vector<PointerCoupling> defined;              ///< per pointer, as the scene gives them
    std::uint64_t start = 0, changes = 0;              ///< of which session, and after how many commands about these
  };
  /// Commands of the bridge's own threads. All storage is the sender's.
  struct Remember {
    Memory* into;                                      ///< not allocated into; `loop` is from roomFor, and has let go of its bodies
  };
  struct Look {
    View* into;                                        ///< allocates
  };
  struct Change {
    Tell tell;
    const View* seen;                                  ///< what the commands were made from
    bool* outdated;                                    ///< true: it is another loop by now, nothing was done
  };
  using Command = std::variant<Remember, Look, Change>;
  using Commands = CommandRing<Command>;
  /// (in realtime: an atomic load each when nothing waits) Between ticks: carries out what the bridge's threads and the world's
  /// owner have sent. Devices wait for their counts, see `tick`.
  void serve(Commands& commands) noexcept;

  /// How it began, and where its scene came from: for recordings.
  const SessionStart& start() const { return start_; }
  const SceneSource& source() const { return world_->source; }
  /// What happened between ticks, for one reader.
  using EventRing = RecordRing<LoopEvent>;
  void sendEventsTo(EventRing& ring) { events_ = &ring; }

  bool presses() const noexcept { return loop_->presses(); }  ///< (in realtime) a hand feels a force

  World& world() { return world_->world; }
  const TickReport& report() const { return loop_->report(); }
  std::vector<std::string> deviceNames() const;
  std::vector<DeviceDef> deviceDefs() const;
  std::vector<HandPlacement> placements() const;
  std::shared_ptr<const WorldDef> definition() const { return world_->definition(); }
  std::vector<std::string> pointerNames() const;
  std::vector<std::string> linkNames() const;
  std::string sceneName() const { return world_->scene; }

 private:
  struct Hand {
    PortLease<DevicePort> lease;
    std::string name;
    HandPlacement placement;
    const DeviceTwin* twin = nullptr;                  ///< behind the lease; null: a real wire
    int origin = 0;                                    ///< its index in start()
  };
  LoopSession(const BridgeParameters& parameters, PortLease<WorldPort> world);
  static bool claimDevices(const BridgeParameters& parameters, LoopSession& session, std::string& missing);
  void findBudget();
  double budgetHere();
  void connect(std::uint64_t first_tick);
  void carryOut(const Command& command);
  void copyTo(Memory& memory) const;
  void copyTo(View& view) const;
  void note(const LoopCommand& command);
  void exchange(const TimeLost& lost, std::int64_t& io_ns, std::int64_t& twin_ns) noexcept;
  void observe(Hand& hand, HandSample& sample) const noexcept;

  BridgeParameters parameters_;
  PortLease<WorldPort> world_;
  std::vector<Hand> hands_;
  std::unique_ptr<HapticLoop> loop_;
  std::string deadline_;
  SessionStart start_;
  EventRing* events_ = nullptr;
  std::uint64_t changes_ = 0;                          ///< commands so far about hands, devices or tuning
  std::uint64_t noted_tick_ = 0;                       ///< of the last event, and how many there were before that tick
  int noted_ = 0;
  TickInput input_;
};

}  // namespace haptic
