/// The thread that closes the loop: absolute deadlines, no ROS call, no lock while it ticks.
#pragma once
#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "haptic_bridge/loop_session.h"
#include "haptic_core/base/latest_value.h"
#include "haptic_core/base/record_ring.h"

namespace haptic {

class RealtimeThread {
 public:
  explicit RealtimeThread(const BridgeParameters& parameters);
  ~RealtimeThread();  ///< stops at the next tick, with zero drive

  void stop();

  enum class Phase { kWaiting, kTicking, kFinished, kFailed };
  Phase phase() const { return phase_; }
  std::string failure() const;             ///< one line; empty unless kFailed
  std::string missing() const;             ///< the port that is waited for
  std::string deadline() const;            ///< the deadline that the budget of a step keeps here, a sentence; empty: there is none
  RealtimeReport setup() const;            ///< what the system allowed
  std::vector<std::string> deviceNames() const;
  std::vector<DeviceDef> deviceDefs() const { return felt().devices; }
  std::vector<std::string> pointerNames() const;
  /// What the hands feel, and how: for who judges whether they can bear it. Empty definition: not known.
  struct Felt {
    std::shared_ptr<const WorldDef> definition;
    std::vector<HandPlacement> placements;   ///< per hand
    std::vector<DeviceDef> devices;          ///< per hand
  };
  Felt felt() const;
  /// Another thread's, when it learns that bodies have come or gone: hands feel these from now on.
  void feel(std::shared_ptr<const WorldDef> definition);

  unsigned sessions() const { return sessions_; }  ///< claims of the ports so far that came to ticking
  unsigned changes() const { return changes_; }    ///< calls of `feel` so far

  /// Any other thread: has a command carried out between two ticks. False: the loop does not tick, and nothing was done. Throws
  /// the SetupError that refused it.
  bool send(const LoopSession::Command& command);
  /// Likewise: `commandsFor` makes commands of what the loop is now, here; where another thread's come first, anew.
  bool change(const std::function<std::vector<LoopCommand>(const LoopSession::View&)>& commandsFor);
  /// Any other thread: scenes that are loaded from now on begin without a force, until this is false again.
  void startSilent(bool silent) { silent_ = silent; }

  /// A start of the loop, for recordings: how it began, and its scene.
  struct Start {
    SessionStart session;
    SceneSource source;
    std::string scene;
    std::vector<std::string> links;
    std::uint64_t world_hash = 0;
    std::size_t world_numbers = 0;         ///< room for the greatest world state
  };
  RecordRing<std::shared_ptr<const Start>>& starts() { return starts_; }  ///< one per claim of the ports; one reader
  LoopSession::EventRing& events() { return events_; }      ///< one reader
  RecordRing<RecordedTick>& records() { return records_; }  ///< one per tick; one reader
  /// With ~record the first tick waits for this; without, it is not asked.
  void letTick() { may_tick_ = true; }

  /// Both of the same tick: a force that an interruption ends and the count of missed ticks agree.
  struct LastTick {
    TickReport report;
    std::uint64_t missed = 0;  ///< ticks that started more than a period late, since the start
  };

  RecordRing<TickSample>& samples() { return samples_; }   ///< one per tick; one reader
  LatestValue<LastTick>& lastTick() { return last_tick_; }  ///< at the end of every 16th tick; one reader

 private:
  void run();
  std::unique_ptr<LoopSession> waitForPorts();
  bool waitForRecorder(LoopSession& session);
  void tickUntilRecalled(LoopSession& session);
  void leadOut(LoopSession& session, const std::function<void()>& tick);
  void nameHands(const LoopSession& session);
  void set(Phase phase, const std::string& text);

  BridgeParameters parameters_;
  std::atomic<bool> silent_{false};
  RecordRing<TickSample> samples_;
  RecordRing<RecordedTick> records_;
  RecordRing<std::shared_ptr<const Start>> starts_;
  LoopSession::EventRing events_;
  LoopSession::Commands commands_;
  std::atomic<bool> may_tick_{false};
  LatestValue<LastTick> last_tick_;
  std::atomic<bool> stop_{false};
  std::atomic<Phase> phase_{Phase::kWaiting};
  std::atomic<unsigned> sessions_{0}, changes_{0};
  std::uint64_t ticks_ = 0, missed_ = 0;
  mutable std::mutex text_mutex_;          ///< of what follows; never taken while ticking
  std::string failure_, missing_;
  RealtimeReport setup_;
  std::vector<std::string> device_names_, pointer_names_;
  Felt felt_;
  std::string deadline_;
  std::thread thread_;
};

}  // namespace haptic
