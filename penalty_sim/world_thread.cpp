#include "penalty_sim/world_thread.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>

#include "haptic_core/world/world.h"

namespace haptic {
namespace {

/// How often the thread asks for the port while the bridge has it.
constexpr std::chrono::milliseconds kRetry{20};

}  // namespace

WorldThread::WorldThread(ros::NodeHandle& nh, const SimulationParameters& parameters,
                         const std::vector<HandPlacement>& hands)
    : parameters_(parameters), hands_(hands), frames_(nh, true) {
  for (const HandPlacement& hand : hands_) {
    inputs_.push_back(
        std::make_unique<PointerInput>(nh, hand, parameters.world_frame, parameters.pose_age_limit, frames_));
  }
  thread_ = std::thread([this] { run(); });
}

WorldThread::~WorldThread() {
  stop_ = true;
  thread_.join();
}

void WorldThread::run() {
  for (const std::string& line : enterRealtime(parameters_.realtime).advice) ROS_DEBUG_STREAM(line);
  while (!stop_) {
    auto lease = PortTable::process().claim<WorldPort>(parameters_.name, ClaimRank::kOwner, "the simulation's own thread");
    if (lease) {
      runWorld(lease);
    } else {
      std::this_thread::sleep_for(kRetry);
    }
  }
}

void WorldThread::runWorld(PortLease<WorldPort>& lease) {
  WorldPort& port = *lease;
  const double step = port.world.settings().step;
  PeriodicWake wake(1 / step);
  const long wrench_every = std::max(1L, std::lround(1 / (step * parameters_.wrench_rate)));
  wake.start();
  for (long tick = 0; !stop_ && !lease.recalled(); ++tick) {
    const PeriodicWake::Wake now = wake.wait();
    port.serve();
    if (!port.paused()) {
      for (const auto& input : inputs_) input->follow(port.world, now.start_ns);
      port.world.step();
    }
    if (tick % wrench_every == 0) publishWrenches(port.world);
    port.noteTick(now.start_ns);
  }
}

void WorldThread::publishWrenches(const World& world) {
  const std::int64_t now = steadyNow();
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    // A hand that sends no poses gets no wrench: its driver lets the last one decay.
    if (inputs_[i]->wanted() && inputs_[i]->fresh(now)) {
      inputs_[i]->publishWrench(world.pointerWrench(hands_[i].pointer), ros::Time::now());
    }
  }
}

}  // namespace haptic
