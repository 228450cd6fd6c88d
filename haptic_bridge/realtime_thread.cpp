#include "haptic_bridge/realtime_thread.h"

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/force_slew.h"
#include "haptic_core/world/step_history.h"

namespace haptic {
namespace {

// Telemetry drains at 60 Hz; two seconds of ticks outlast any of its hiccups.
constexpr double kRingSeconds = 2;
constexpr std::chrono::milliseconds kPortPoll{20};
// A start per reload and an event per user's request: nobody makes more of them within a drain.
constexpr std::size_t kStarts = 16, kEvents = 256;
// How long the first tick waits for a recorder: rosbag record needs a second or two to start and one to find the topics,
// on a machine that starts a dozen other programs ten times that.
constexpr std::chrono::milliseconds kRecorderPatience{30000};
// The full report is for people: every 16th tick, so that its 3 KB cost nothing at 10 kHz.
constexpr std::uint64_t kReportEvery = 16;

}  // namespace

RealtimeThread::RealtimeThread(const BridgeParameters& parameters)
    : parameters_(parameters),
      samples_(static_cast<std::size_t>(kRingSeconds * parameters.rate)),
      records_(static_cast<std::size_t>(kRingSeconds * parameters.rate)),
      starts_(kStarts),
      events_(kEvents),
      thread_([this] { run(); }) {}

RealtimeThread::~RealtimeThread() { stop(); }

void RealtimeThread::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void RealtimeThread::set(Phase phase, const std::string& text) {
  std::lock_guard<std::mutex> lock(text_mutex_);
  (phase == Phase::kFailed ? failure_ : missing_) = text;
  phase_ = phase;
}

std::unique_ptr<LoopSession> RealtimeThread::waitForPorts() {
  const std::int64_t begin = steadyNow();
  set(Phase::kWaiting, "");
  while (!stop_) {
    std::string missing;
    parameters_.silent = silent_;
    auto session = LoopSession::open(parameters_, ticks_, missing);
    if (session) return session;
    set(Phase::kWaiting, missing);
    const double waited = 1e-9 * static_cast<double>(steadyNow() - begin);
    if (parameters_.port_timeout > 0 && waited > parameters_.port_timeout) {
      throw SetupError("the loop cannot start", missing, "load the nodelet that offers it into the same manager");
    }
    std::this_thread::sleep_for(kPortPoll);
  }
  return nullptr;
}

void RealtimeThread::run() {
  const RealtimeReport setup = enterRealtime(parameters_.realtime);
  {
    std::lock_guard<std::mutex> lock(text_mutex_);
    setup_ = setup;
  }
  try {
    while (!stop_ && phase_ != Phase::kFinished) {
      const auto session = waitForPorts();
      if (session && waitForRecorder(*session)) tickUntilRecalled(*session);
    }
  } catch (const std::exception& error) {
    set(Phase::kFailed, error.what());
  }
}

void RealtimeThread::nameHands(const LoopSession& session) {
  std::lock_guard<std::mutex> lock(text_mutex_);
  device_names_ = session.deviceNames();
  pointer_names_ = session.pointerNames();
  felt_ = {session.definition(), session.placements(), session.deviceDefs()};
  deadline_ = session.deadline();
}

/// Hands over how the session begins. False: stopped or recalled meanwhile.
bool RealtimeThread::waitForRecorder(LoopSession& session) {
  session.sendEventsTo(events_);
  starts_.push(std::make_shared<const Start>(
      Start{session.start(), session.source(), session.sceneName(), session.linkNames(), session.world().hash(),
            session.world().history().latest().packedCapacity()}));
  const std::int64_t begin = steadyNow();
  if (parameters_.record && !may_tick_) set(Phase::kWaiting, "rosbag record does not listen to recorded/ticks yet");
  while (parameters_.record && !may_tick_) {
    if (stop_ || session.recalled()) return false;
    if (std::chrono::nanoseconds(steadyNow() - begin) > kRecorderPatience) {
      throw SetupError("~record", "nobody subscribes to recorded/ticks", "start rosbag record, or set ~record to false");
    }
    std::this_thread::sleep_for(kPortPoll);
  }
  return true;
}

bool RealtimeThread::send(const LoopSession::Command& command) { return commands_.send(command, kPortPatience, [] {}); }

bool RealtimeThread::change(const std::function<std::vector<LoopCommand>(const LoopSession::View&)>& commandsFor) {
  LoopSession::View view;
  bool outdated = true;
  while (outdated) {
    if (!send(LoopSession::Look{&view})) return false;
    const std::vector<LoopCommand> commands = commandsFor(view);
    if (commands.empty()) return true;
    if (!send(LoopSession::Change{{commands.data(), commands.size()}, &view, &outdated})) return false;
  }
  return true;
}

void RealtimeThread::tickUntilRecalled(LoopSession& session) {
  nameHands(session);
  set(Phase::kTicking, "");
  const std::uint64_t limit = parameters_.tickLimit();
  PeriodicWake wake(parameters_.rate);
  const double h = wake.period();
  TickSample sample;
  RecordedTick record;
  ++sessions_;
  wake.start();
  const auto tick = [&] {
    session.serve(commands_);  // before the wait: what it takes is not missing in a tick
    session.tick(wake.wait(), ticks_, h, sample, record);
    samples_.push(sample);
    records_.push(record);
    if (sample.lost_periods > 0) ++missed_;
    if (ticks_ % kReportEvery == 0) last_tick_.write({session.report(), missed_});
    ++ticks_;
  };
  while (!stop_.load(std::memory_order_relaxed) && !session.recalled() && (limit == 0 || ticks_ < limit)) {
    if (session.dropsDevice()) {
      session.dropRecalledDevices();
      nameHands(session);
    }
    tick();
  }
  if (session.recalled()) leadOut(session, tick);
  if (limit > 0 && ticks_ >= limit) set(Phase::kFinished, "");
}

/// The ports go back to their owners, as for another scene: the world stands, and no hand is let go of within a tick.
void RealtimeThread::leadOut(LoopSession& session, const std::function<void()>& tick) {
  if (!session.presses()) return;
  session.take({PauseWorld{true}});
  const std::uint64_t end = ticks_ + static_cast<std::uint64_t>(kLeadOutSeconds * parameters_.rate);
  while (!stop_.load(std::memory_order_relaxed) && session.presses() && ticks_ < end) tick();
}

std::string RealtimeThread::failure() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return failure_;
}

std::string RealtimeThread::missing() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return missing_;
}

std::string RealtimeThread::deadline() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return deadline_;
}

RealtimeReport RealtimeThread::setup() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return setup_;
}

std::vector<std::string> RealtimeThread::deviceNames() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return device_names_;
}

void RealtimeThread::feel(std::shared_ptr<const WorldDef> definition) {
  std::lock_guard<std::mutex> lock(text_mutex_);
  felt_.definition = std::move(definition);
  ++changes_;
}

RealtimeThread::Felt RealtimeThread::felt() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return felt_;
}

std::vector<std::string> RealtimeThread::pointerNames() const {
  std::lock_guard<std::mutex> lock(text_mutex_);
  return pointer_names_;
}

}  // namespace haptic
