#include "haptic_bridge/telemetry.h"

#include <haptic_msgs/TickStatistics.h>
#include <nodelet/NodeletList.h>
#include <ros/init.h>
#include <ros/service.h>
#include <ros/this_node.h>

#include <boost/make_shared.hpp>
#include <cstdio>
#include <fstream>

#include "haptic_bridge/conversions.h"
#include "haptic_msgs/flag_words.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

constexpr std::chrono::milliseconds kDrainPeriod{16};
constexpr std::int64_t kClockPatienceNs = 2000000000;  // a slow bag's clock ticks more often than this
constexpr std::int64_t kStatisticsPeriodNs = 100000000, kReminderPeriodNs = 5000000000;
// What was published last is on its way to the recorder, another process.
constexpr std::chrono::milliseconds kRecorderGrace{500};
constexpr std::size_t kNodelets = 3;  // driver, simulation, bridge

/// True when the driver's, the simulation's and this nodelet's library run in this process: its manager lists them.
bool nodeletsTogether() {
  nodelet::NodeletList list;
  return ros::service::call(ros::this_node::getName() + "/list", list) && list.response.nodelets.size() >= kNodelets;
}

}  // namespace

Telemetry::Telemetry(ros::NodeHandle& nh, ros::NodeHandle& priv, const std::string& name,
                     const BridgeParameters& parameters, RealtimeThread& loop)
    : name_(name),
      parameters_(parameters),
      loop_(loop),
      statistics_(nh.advertise<haptic_msgs::TickStatistics>("tick_statistics", 10)),
      recorder_(nh, parameters, loop),
      diagnostics_(nh, priv, name) {
  diagnostics_.setHardwareID("haptic loop");
  diagnostics_.add("loop", this, &Telemetry::diagnose);
  if (parameters.tickLimit() > 0) figures_ = std::make_unique<RunFigures>(parameters.tickLimit());
  thread_ = std::thread([this] { run(); });
}

Telemetry::~Telemetry() {
  stop_ = true;
  thread_.join();
}

void Telemetry::run() {
  while (!stop_) {
    drain();
    const std::int64_t now = steadyNow();
    if (now >= next_statistics_ns_) {
      next_statistics_ns_ = now + kStatisticsPeriodNs;
      publishStatistics();
    }
    if (now >= next_diagnostics_ns_) {  // by the steady clock: without /clock the updater's own would wait for ever
      next_diagnostics_ns_ = now + static_cast<std::int64_t>(1e9 * diagnostics_.getPeriod());
      diagnostics_.force_update();
    }
    watchClock(now);
    if (!followPhase()) return;
    std::this_thread::sleep_for(kDrainPeriod);
  }
}

void Telemetry::drain() {
  recorder_.drain();
  loop_.lastTick().read(last_tick_);  // first: the samples that follow are those up to it, and newer ones
  if (figures_ && loop_.phase() == RealtimeThread::Phase::kTicking) figures_->setDevices(loop_.deviceDefs());
  TickSample sample;
  while (loop_.samples().pop(sample)) {
    last_ = sample;
    const std::string kept = recorder_.flight().add(sample);
    if (!kept.empty()) ROS_ERROR_STREAM_NAMED(name_, kept);
    ++ticks_;
    period_.add(sample);
    second_.add(sample);
    if (figures_) figures_->add(sample);
  }
}

/// The loop runs by the steady clock whatever ROS's does; stamps are ROS's. So a simulated clock that stands still or
/// jumps back harms nobody's force, but whoever reads the stamps should know.
void Telemetry::watchClock(std::int64_t now_ns) {
  if (!ros::Time::isSimTime()) return;
  const ros::Time clock = ros::Time::now();
  if (clock < last_clock_) {
    ROS_WARN_STREAM_NAMED(name_, "/clock jumped back by " << (last_clock_ - clock).toSec() << " s; the loop goes on by its own clock");
  }
  if (clock != last_clock_ || clock_moved_ns_ == 0) {
    clock_moved_ns_ = now_ns;
    clock_told_ = false;
  } else if (!clock_told_ && now_ns - clock_moved_ns_ > kClockPatienceNs) {
    clock_told_ = true;
    ROS_WARN_STREAM_NAMED(name_, "/use_sim_time is set and no clock arrives: stamps stand at " << clock
                                     << "; start rosbag play --clock, or set /use_sim_time to false");
  }
  last_clock_ = clock;
}

/// Tells what the loop waits for, or why it ended. False: there is nothing more to do.
bool Telemetry::followPhase() {
  const std::int64_t now = steadyNow();
  switch (loop_.phase()) {
    case RealtimeThread::Phase::kWaiting:
      if (next_reminder_ns_ == 0) next_reminder_ns_ = now + kReminderPeriodNs;
      if (now > next_reminder_ns_) {
        next_reminder_ns_ = now + kReminderPeriodNs;
        ROS_WARN_STREAM_NAMED(name_, "the loop waits: " << loop_.missing());
      }
      return true;
    case RealtimeThread::Phase::kTicking:
      if (!setup_told_) {
        for (const std::string& line : loop_.setup().advice) ROS_INFO_STREAM_NAMED(name_, "for less lateness: " << line);
      }
      setup_told_ = true;
      if (const std::string deadline = loop_.deadline(); deadline != deadline_told_) {
        deadline_told_ = deadline;
        if (!deadline.empty()) ROS_INFO_STREAM_NAMED(name_, deadline);
      }
      return true;
    case RealtimeThread::Phase::kFinished:
      drain();
      finish();
      if (parameters_.record) std::this_thread::sleep_for(kRecorderGrace);
      ros::requestShutdown();
      return false;
    case RealtimeThread::Phase::kFailed:
      ROS_FATAL_STREAM_NAMED(name_, loop_.failure());
      drain();
      if (ticks_ > 0) recorder_.flight().writeNow("the loop failed: " + loop_.failure());
      ros::requestShutdown();
      return false;
  }
  return false;
}

void Telemetry::finish() {
  if (!figures_) return;
  figures_->setNodeletsTogether(nodeletsTogether());
  const std::string text = figures_->text();
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
  if (parameters_.figures.empty()) return;
  std::ofstream file(parameters_.figures);
  file << text;
  file.close();
  if (!file) ROS_FATAL_STREAM_NAMED(name_, parameters_.figures << ": cannot be written; give a path in a folder that exists");
}

void Telemetry::publishStatistics() {
  const std::size_t ticks = period_.tick.size();
  if (ticks > 0 && statistics_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<haptic_msgs::TickStatistics>();
    m->header.stamp = ros::Time::now();
    m->header.frame_id = parameters_.world_frame;
    m->rate = parameters_.rate;
    m->simulated_time = last_.simulated_time;
    m->ticks = ticks_;
    m->missed_ticks = last_tick_.missed;
    m->paused = last_.paused;
    m->period_ticks = static_cast<std::uint32_t>(ticks);
    m->tick_us_p50 = percentile(period_.tick, 0.5);
    m->tick_us_p99 = percentile(period_.tick, 0.99);
    m->tick_us_max = percentile(period_.tick, 1);
    m->io_us_p50 = percentile(period_.io, 0.5);
    m->io_us_p99 = percentile(period_.io, 0.99);
    m->lateness_us_p50 = percentile(period_.lateness, 0.5);
    m->lateness_us_p99 = percentile(period_.lateness, 0.99);
    m->lateness_us_max = percentile(period_.lateness, 1);
    m->dropped_records = loop_.samples().dropped();
    const auto devices = loop_.deviceNames(), pointers = loop_.pointerNames();
    // While a hand is being lost, the report may still have it and the names not: nobody gets another's values.
    const int hands = last_tick_.report.hands == static_cast<int>(devices.size()) ? last_tick_.report.hands : 0;
    for (int i = 0; i < hands; ++i) {
      m->hands.push_back(toHandReport(last_tick_.report.hand[i], devices[i], pointers[i]));
    }
    m->energy = toLedger(last_.step.energy);
    statistics_.publish(boost::shared_ptr<const haptic_msgs::TickStatistics>(m));
  }
  period_.clear();
}

void Telemetry::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  const std::uint64_t missed = last_tick_.missed - missed_before_;
  missed_before_ = last_tick_.missed;
  if (loop_.phase() == RealtimeThread::Phase::kWaiting) {
    status.summary(Status::WARN, "waits: " + loop_.missing());
  } else if (!last_.step.finite) {
    status.summary(Status::ERROR, std::string("the world stopped: ") + whyStopped(last_.step));
  } else if (missed > 0) {
    status.summary(Status::WARN, std::to_string(missed) + " ticks missed in the last second");
  } else {
    status.summary(Status::OK, last_.paused ? "paused" : "ticking");
  }
  if (clock_told_) status.mergeSummary(Status::WARN, "/use_sim_time is set and no clock arrives");
  diagnoseHands(status);
  status.add("rate asked [Hz]", parameters_.rate);
  status.add("ticks", ticks_);
  status.add("missed ticks", last_tick_.missed);
  status.add("compute p50 [us]", percentile(second_.tick, 0.5));
  status.add("compute p99 [us]", percentile(second_.tick, 0.99));
  status.add("exchange p99 [us]", percentile(second_.io, 0.99));
  status.add("lateness p50 [us]", percentile(second_.lateness, 0.5));
  status.add("lateness p99 [us]", percentile(second_.lateness, 0.99));
  status.add("records dropped", loop_.samples().dropped());
  status.add("contacts", last_.step.contacts);
  const RealtimeReport setup = loop_.setup();
  status.add("SCHED_FIFO", setup.fifo ? "yes" : "no");
  status.add("memory locked", setup.memory_locked ? "yes" : "no");
  if (const std::string deadline = loop_.deadline(); !deadline.empty()) status.add("deadline", deadline);
  for (const std::string& line : setup.advice) status.add("advice", line);
  second_.clear();
}

void Telemetry::diagnoseHands(diagnostic_updater::DiagnosticStatusWrapper& status) const {
  const auto devices = loop_.deviceNames();
  for (int i = 0; i < last_tick_.report.hands && i < static_cast<int>(devices.size()); ++i) {
    const HandReport& hand = last_tick_.report.hand[i];
    status.add(devices[i] + ": pose residual [m]", hand.pose_residual);
    status.add(devices[i] + ": energy at the port [J]", hand.port_energy);
    status.add(devices[i] + ": contact stiffness at the grip [N/m]", hand.stiffness);
    status.add(devices[i] + ": share of it that the hand bears [1]", hand.stiffness_share);
    for (const FlagWords& words : kDeviceFlagWords) {
      if (words.grade == FlagGrade::kWarning && hand.device_flags & words.flag) {
        status.mergeSummary(diagnostic_msgs::DiagnosticStatus::WARN, devices[i] + ": " + words.text);
      }
    }
  }
}

}  // namespace haptic
