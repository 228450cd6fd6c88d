#include "haptic_bridge/session_recorder.h"

#include <haptic_msgs/recorded_messages.h>

#include <boost/make_shared.hpp>

namespace haptic {
namespace {

/// A message holds at most so many ticks: some ten kilobytes.
constexpr std::uint32_t kTicksPerMessage = 64;
/// The flight recorder's recordings begin where the loop's memory was copied: as often as makes its five seconds six.
constexpr std::int64_t kMemoryPeriodNs = 1000000000;
/// Messages that may wait for a slow recorder: 30 s of 60 per second.
constexpr int kRecordQueue = 2000;

}  // namespace

SessionRecorder::SessionRecorder(ros::NodeHandle& nh, const BridgeParameters& parameters, RealtimeThread& loop)
    : parameters_(parameters), loop_(loop), flight_(parameters) {
  if (!parameters.record) return;
  session_ = nh.advertise<haptic_msgs::SessionInfo>("recorded/session", kRecordQueue, true);
  ticks_ = nh.advertise<haptic_msgs::TickRecord>("recorded/ticks", kRecordQueue);
  events_ = nh.advertise<haptic_msgs::LoopEvent>("recorded/events", kRecordQueue);
}

void SessionRecorder::begin(const RealtimeThread::Start& start) {
  strings_.clear();
  for (const SessionStart::HandStart& hand : start.session.hands) {
    strings_.push_back(static_cast<int>(hand.def.strings.size()));
  }
  device_texts_ = deviceTexts(start.session);
  const haptic_msgs::SessionInfo info = toSessionInfo(start, device_texts_, parameters_);
  flight_.begin(info, start);
  start_ = std::make_shared<const RealtimeThread::Start>(start);
  memory_.loop = roomFor(start.session, start.world_numbers);
  next_memory_ns_ = steadyNow() + kMemoryPeriodNs;
  if (session_) session_.publish(info);
}

/// Asks the loop for a copy of all that it remembers, once a second.
void SessionRecorder::remember() {
  const std::int64_t now = steadyNow();
  if (!start_ || parameters_.flight_folder.empty() || now < next_memory_ns_) return;
  if (loop_.phase() != RealtimeThread::Phase::kTicking) return;
  next_memory_ns_ = now + kMemoryPeriodNs;
  memory_.loop.world_state.reserve(memory_.needs);
  if (!loop_.send(LoopSession::Remember{&memory_})) return;
  if (memory_.loop.world_state.capacity() < memory_.needs) {  // bodies have come: at once, with room for them
    next_memory_ns_ = now;
    return;
  }
  RealtimeThread::Start start = *start_;
  if (memory_.loop.bodies) start.links = linkNames(unpackBodies(*memory_.loop.bodies));
  start.session = startedAt(start_->session, memory_.loop, memory_.origins);
  start.world_hash = memory_.loop.world_hash;
  std::vector<std::string> texts;
  for (int i = 0; i < memory_.loop.hands; ++i) texts.push_back(device_texts_.at(static_cast<std::size_t>(memory_.origins[i])));
  waiting_memories_.push_back({toSessionInfo(start, texts, parameters_), memory_.events});
  memory_.loop.bodies.reset();  // here, not in the loop
}

/// Bodies have come or gone.
void SessionRecorder::follow(const std::vector<double>& bodies) {
  const auto definition = std::make_shared<const WorldDef>(unpackBodies(bodies));
  flight_.nameLinks(linkNames(*definition));
  loop_.feel(definition);
}

void SessionRecorder::publish(const haptic_msgs::TickRecord& run) {
  if (run.ticks == 0) return;
  const auto message = boost::make_shared<haptic_msgs::TickRecord>(run);
  message->header.stamp = ros::Time::now();
  flight_.add(message);
  if (ticks_) ticks_.publish(boost::shared_ptr<const haptic_msgs::TickRecord>(message));
}

/// Starts and events are due before the tick that they name: ticks of one drain may lie on both sides of them.
void SessionRecorder::drain() {
  if (session_ && session_.getNumSubscribers() > 0 && ticks_.getNumSubscribers() > 0 && events_.getNumSubscribers() > 0) {
    loop_.letTick();
  }
  remember();
  RecordedTick tick;
  haptic_msgs::TickRecord run;
  bool more = true;
  while (more) {
    more = loop_.records().pop(tick);
    std::shared_ptr<const RealtimeThread::Start> start;
    while (loop_.starts().pop(start)) waiting_starts_.push_back(start);
    LoopEvent event;
    while (loop_.events().pop(event)) waiting_events_.push_back(event);
    const auto due = [&](std::uint64_t at) { return !more || at <= tick.input.tick; };
    while (!waiting_starts_.empty() && due(waiting_starts_.front()->session.first_tick)) {
      publish(run);
      run = haptic_msgs::TickRecord();
      begin(*waiting_starts_.front());
      waiting_starts_.pop_front();
    }
    while (!waiting_memories_.empty() && due(waiting_memories_.front().info.first_tick)) {
      publish(run);
      run = haptic_msgs::TickRecord();
      flight_.add(waiting_memories_.front());
      waiting_memories_.pop_front();
    }
    while (!waiting_events_.empty() && due(waiting_events_.front().tick)) {
      const LoopEvent& e = waiting_events_.front();
      if (e.command.is<DropHand>() && e.command.hand < static_cast<int>(strings_.size())) {
        publish(run);
        run = haptic_msgs::TickRecord();
        strings_.erase(strings_.begin() + e.command.hand);
      }
      if (const auto* change = std::get_if<ChangeBodies>(&e.command.kind)) follow(*change->packed);
      haptic_msgs::LoopEvent message = toLoopEvent(e);
      message.header.stamp = ros::Time::now();
      flight_.add(message);
      if (events_) events_.publish(message);
      waiting_events_.pop_front();
    }
    if (!more || tick.input.hands > static_cast<int>(strings_.size())) continue;
    if (run.ticks < kTicksPerMessage && addTick(tick.input, tick.hash, strings_, run)) continue;
    publish(run);
    run = haptic_msgs::TickRecord();
    addTick(tick.input, tick.hash, strings_, run);
  }
  publish(run);
}

}  // namespace haptic
