#include "haptic_bridge/loop_session.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr char kHolder[] = "the bridge";
constexpr double kRateTolerance = 1e-6;  // relative: two files that mean the same rate
// The grip's range in which the pose's accuracy is stated.
constexpr double kStatedReach = 0.03;   // [m]
constexpr double kStatedAngle = 0.5;    // [rad]
// Tensions are clamped by min and max, the wrench by a product of square roots: rounding of a few ulp.
constexpr double kClampTolerance = 1e-9;
// The full-presentation area: with this λ a wrench that the bounds admit is met to λ·|t|, some 1e-6 N.
constexpr double kExactLambda = 1e-7, kExactError = 1e-4;  // [1], [N]

void checkPeriod(const std::string& what, double period, double rate) {
  if (std::fabs(period * rate - 1) < kRateTolerance) return;
  throw SetupError(what, "has a step of " + std::to_string(1e3 * period) + " ms, the bridge one of " +
                             std::to_string(1e3 / rate) + " ms", "give all three the same ~rate");
}

}  // namespace

LoopSession::LoopSession(const BridgeParameters& parameters, PortLease<WorldPort> world, std::string world_name)
    : parameters_(parameters), world_(std::move(world)), world_name_(std::move(world_name)) {}

std::unique_ptr<LoopSession> LoopSession::open(const BridgeParameters& parameters, std::string& missing) {
  std::string name = parameters.world;
  if (name.empty()) {
    const auto worlds = PortTable::process().names(PortKind::kWorld);
    if (worlds.empty()) {
      missing = "no world is offered in this process";
      return nullptr;
    }
    if (worlds.size() > 1) throw SetupError("~world", "there are several worlds", "name one of them");
    name = worlds.front();
  }
  auto world = PortTable::process().claim<WorldPort>(name, ClaimRank::kBridge, kHolder, &missing);
  if (!world) return nullptr;
  std::unique_ptr<LoopSession> session(new LoopSession(parameters, std::move(world), name));
  checkPeriod("the world " + name, session->world_->world.settings().step, parameters.rate);
  if (!claimDevices(parameters, *session, missing)) return nullptr;
  session->connect();
  return session;
}

bool LoopSession::claimDevices(const BridgeParameters& parameters, LoopSession& session, std::string& missing) {
  for (const HandPlacement& placement : session.world_->hands) {
    const auto& wanted = parameters.devices;
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), placement.device) == wanted.end()) continue;
    Hand hand;
    hand.name = placement.device;
    hand.placement = placement;
    hand.lease = PortTable::process().claim<DevicePort>(hand.name, ClaimRank::kBridge, kHolder, &missing);
    if (!hand.lease) return false;
    hand.twin = dynamic_cast<DeviceTwin*>(&hand.lease->transport);
    const Spidar& device = hand.lease->device;
    hand.exact = std::make_unique<TensionDistribution>(device.def(), device.kinematics());
    hand.exact->setLambda(kExactLambda);
    const double fastest = hand.lease->transport.maxRateHz();
    if (hand.twin) checkPeriod("the twin of " + hand.name, 1 / fastest, parameters.rate);
    if (parameters.rate > fastest * (1 + kRateTolerance)) {
      throw SetupError("~rate", "is " + std::to_string(parameters.rate) + " Hz",
                       hand.name + " carries at most " + std::to_string(fastest) + " Hz");
    }
    session.hands_.push_back(std::move(hand));
  }
  if (session.hands_.empty()) throw SetupError("~devices", "none of them is a hand of the scene", "name one of the scene's");
  return true;
}

void LoopSession::connect() {
  loop_ = std::make_unique<HapticLoop>(world_->world);
  for (Hand& hand : hands_) {
    HandSettings settings = hand.placement.settings;
    settings.soft_start_s = parameters_.soft_start;
    settings.passivity.mode = parameters_.passivity;
    loop_->attach(hand.lease->device, hand.placement.pointer, settings);
    if (hand.twin && hand.lease->follows_script) hand.twin->setHandPath(hand.placement.path);
  }
  seen_jumps_ = world_->jumps;
}

LoopSession::~LoopSession() {
  for (Hand& hand : hands_) hand.lease->transport.zeroDrive();
}

bool LoopSession::recalled() const noexcept {
  if (world_.recalled()) return true;
  for (const Hand& hand : hands_) {
    if (!hand.lease.recalled()) return false;
  }
  return true;
}

bool LoopSession::dropsDevice() const noexcept {
  for (const Hand& hand : hands_) {
    if (hand.lease.recalled()) return true;
  }
  return false;
}

void LoopSession::dropRecalledDevices() {
  for (Hand& hand : hands_) {
    if (hand.lease.recalled()) hand.lease->transport.zeroDrive();
  }
  loop_.reset();  // before the devices that it refers to
  hands_.erase(std::remove_if(hands_.begin(), hands_.end(), [](const Hand& hand) { return hand.lease.recalled(); }),
               hands_.end());
  connect();
}

void LoopSession::exchange(std::int64_t& io_ns, std::int64_t& twin_ns) noexcept {
  io_ns = twin_ns = 0;
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    DevicePort& port = *hands_[i].lease;
    port.between_ticks.serve();
    const std::int64_t before = steadyNow();
    samples_[i] = port.transport.exchange(port.device.drive());
    const std::int64_t spent = steadyNow() - before;
    io_ns += spent;
    if (hands_[i].twin) twin_ns += spent;
  }
}

/// The world is paused: poses go on, strings rest at minimum tension.
void LoopSession::rest(double h) noexcept {
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    hands_[i].lease->device.sense(samples_[i], h);
    hands_[i].lease->device.actuate(Wrench{}, 0, h);
  }
}

void LoopSession::tick(const PeriodicWake::Wake& wake, std::uint64_t index, double h, TickSample& sample) noexcept {
  world_->between_ticks.serve();
  std::int64_t twin_ns = 0;
  exchange(sample.io_ns, twin_ns);
  const bool paused = world_->paused.load(std::memory_order_relaxed);
  const unsigned jumps = world_->jumps.load(std::memory_order_relaxed);
  if (jumps != seen_jumps_ || (was_paused_ && !paused)) {
    for (int i = 0; i < loop_->handCount(); ++i) loop_->hand(i).requestSoftStart();
  }
  seen_jumps_ = jumps;
  was_paused_ = paused;
  if (wake.lost_periods > 0) loop_->noteOverrun(wake.lost_periods);

  const std::int64_t before = steadyNow();
  if (paused) {
    rest(h);
  } else {
    loop_->tick(samples_.data(), h);
  }
  sample.tick_ns = steadyNow() - before + twin_ns;

  sample.tick = index;
  sample.start_ns = wake.start_ns;
  sample.lateness_ns = wake.lateness_ns;
  sample.lost_periods = wake.lost_periods;
  sample.paused = paused;
  sample.simulated_time = world_->world.time();
  sample.step = world_->world.report();
  sample.hands = static_cast<int>(hands_.size());
  for (int i = 0; i < sample.hands; ++i) {
    observe(hands_[i], sample.hand[i]);
    hands_[i].lease->record(index, wake.start_ns, samples_[i]);
  }
  if (world_->wants_snapshot.load(std::memory_order_relaxed) && world_->wants_snapshot.exchange(false)) {
    world_->takeSnapshot(wake.start_ns);
  }
}

void LoopSession::observe(Hand& hand, HandSample& sample) const noexcept {
  const Spidar& device = hand.lease->device;
  sample.F_asked_B = device.askedWrench();
  sample.F_achieved_B = device.achievedWrench();
  sample.pointer_force = world_->world.pointerWrench(hand.placement.pointer).force.norm();
  const bool asks = sample.F_asked_B.force.squaredNorm() + sample.F_asked_B.torque.squaredNorm() > 0;
  sample.presentable = false;
  if (asks && device.state() == DeviceState::kEnabled) {  // for the figures only; not in tick_us
    hand.exact->setStructure(device.kinematics().scaledStructure(device.solution().pose));
    sample.presentable = hand.exact->solve(sample.F_asked_B).error < kExactError;
  }
  const DeviceDef& def = device.def();
  const TensionReport& tension = device.tension();
  sample.over_clamp = sample.F_asked_B.force.norm() > def.max_force * (1 + kClampTolerance) ||
                      sample.F_asked_B.torque.norm() > def.max_torque * (1 + kClampTolerance);
  for (int s = 0; s < tension.tension.size(); ++s) {
    sample.over_clamp |= tension.tension[s] > def.strings[s].max_tension * (1 + kClampTolerance);
  }
  sample.position_error = sample.rotation_error = std::nan("");
  if (!device.calibrated()) return;
  const Pose& measured = device.pose();
  const Pose& truth = hand.twin ? hand.twin->latchedPose().X_BG : measured;  // of hardware nobody knows it
  sample.inside = truth.p.norm() <= kStatedReach && vectorFromRotation(Quaternion(truth.R)).norm() <= kStatedAngle;
  if (!hand.twin) return;
  sample.position_error = (measured.p - truth.p).norm();
  sample.rotation_error = vectorFromRotation(Quaternion(measured.R * truth.R.transpose())).norm();
}

std::vector<std::string> LoopSession::deviceNames() const {
  std::vector<std::string> names;
  for (const Hand& hand : hands_) names.push_back(hand.name);
  return names;
}

std::vector<std::string> LoopSession::pointerNames() const {
  std::vector<std::string> names;
  for (const Hand& hand : hands_) {
    names.push_back(world_->world.linkName(world_->world.pointerLink(hand.placement.pointer)));
  }
  return names;
}

}  // namespace haptic
