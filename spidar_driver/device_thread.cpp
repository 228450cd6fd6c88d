#include "spidar_driver/device_thread.h"

#include <ros/console.h>

#include "haptic_core/spidar/force_slew.h"

namespace haptic {
namespace {

/// How often the thread asks for the port while the bridge has it; the strings are then the bridge's.
constexpr std::chrono::milliseconds kRetry{20};

}  // namespace

DeviceThread::DeviceThread(const std::string& port, double rate_hz, const RealtimeSettings& realtime, WrenchInput& input)
    : port_(port), rate_hz_(rate_hz), realtime_(realtime), input_(input), thread_([this] { run(); }) {}

DeviceThread::~DeviceThread() {
  stop_ = true;
  thread_.join();
}

void DeviceThread::run() {
  for (const std::string& line : enterRealtime(realtime_).advice) ROS_DEBUG_STREAM(port_ << ": " << line);
  while (!stop_) {
    auto lease = PortTable::process().claim<DevicePort>(port_, ClaimRank::kOwner, "the driver's own thread");
    if (lease) {
      runDevice(lease);
    } else {
      std::this_thread::sleep_for(kRetry);
    }
  }
}

void DeviceThread::runDevice(PortLease<DevicePort>& lease) {
  DevicePort& port = *lease;
  port.device.handOver();
  PeriodicWake wake(rate_hz_);
  wake.start();
  const auto leaving_ticks = static_cast<int>(kLeadOutSeconds * rate_hz_);
  int leaving = 0;  // ticks since somebody wants the port: nothing is asked for, until no hand feels a force
  for (std::uint64_t tick = 0; !stop_; ++tick) {
    if (lease.recalled() && (!port.device.presses() || ++leaving > leaving_ticks)) break;
    const PeriodicWake::Wake now = wake.wait();
    const TimeLost lost{wake.period() * now.lost_periods, now.asleep};
    const DeviceSample sample = port.transport.exchange(port.device.driveAfter(lost));
    port.serve(sample, [&](const LoopCommand& command) { apply(command, port.device); });
    port.device.sense(sample, wake.period(), lost);
    const WrenchInput::Command command = input_.latest();
    const double age = 1e-9 * static_cast<double>(now.start_ns - command.received_ns);
    const WrenchInput::Grasp& grasp = input_.latestGrasp();
    const bool fresh = 1e-9 * static_cast<double>(now.start_ns - grasp.received_ns) <=
                       port.device.settings().command_age_limit_s;
    const bool asked = command.given && leaving == 0;
    port.device.actuate(asked ? command.F_G_B : Wrench{}, fresh ? grasp.force : 0, wake.period(), asked ? age : 0);
    port.record(tick, now.start_ns, sample);
  }
  port.transport.zeroDrive();
}

}  // namespace haptic
