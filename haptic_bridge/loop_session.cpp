#include "haptic_bridge/loop_session.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/analysis/deadline.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/pointer_on_path.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr char kHolder[] = "the bridge";
constexpr double kRateTolerance = 1e-6;  // relative: two files that mean the same rate
// Tensions are clamped by min and max, the wrench by a product of square roots: rounding of a few ulp.
constexpr double kClampTolerance = 1e-9;

void checkPeriod(const std::string& what, double period, double rate) {
  if (std::fabs(period * rate - 1) < kRateTolerance) return;
  throw SetupError(what, "has a step of " + std::to_string(1e3 * period) + " ms, the bridge one of " +
                             std::to_string(1e3 / rate) + " ms", "give all three the same ~rate");
}

}  // namespace

LoopSession::LoopSession(const BridgeParameters& parameters, PortLease<WorldPort> world)
    : parameters_(parameters), world_(std::move(world)) {}

std::unique_ptr<LoopSession> LoopSession::open(const BridgeParameters& parameters, std::uint64_t first_tick,
                                               std::string& missing) {
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
  std::unique_ptr<LoopSession> session(new LoopSession(parameters, std::move(world)));
  checkPeriod("the world " + name, session->world_->world.settings().step, parameters.rate);
  if (!claimDevices(parameters, *session, missing)) return nullptr;
  session->connect(first_tick);
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
    const auto* twin = dynamic_cast<DeviceTwin*>(&hand.lease->transport);
    hand.twin = twin;
    const double fastest = hand.lease->transport.maxRateHz();
    if (twin) checkPeriod("the twin of " + hand.name, 1 / fastest, parameters.rate);
    if (parameters.rate > fastest * (1 + kRateTolerance)) {
      throw SetupError("~rate", "is " + std::to_string(parameters.rate) + " Hz",
                       hand.name + " carries at most " + std::to_string(fastest) + " Hz");
    }
    session.hands_.push_back(std::move(hand));
  }
  if (session.hands_.empty()) throw SetupError("~devices", "none of them is a hand of the scene", "name one of the scene's");
  return true;
}

/// The budget of a step that keeps its share of a tick here, from a run of the scene in which the hands follow their paths.
void LoopSession::findBudget() {
  WorldTuning tuning = world_->world.tuning();
  const bool wanted = parameters_.deadline_share > 0 && world_->definition();
  if (!wanted && tuning.budget == 0) return;
  tuning.budget = wanted ? budgetHere() : 0;
  world_->world.tune(tuning);
}

double LoopSession::budgetHere() {
  constexpr double kSeconds = 1;  // simulated: most paths touch something by then
  const double h = world_->world.settings().step;
  const DeadlineReport report = certifyDeadline(*world_->definition(), parameters_.deadline_share * h, kSeconds, [&](World& copy) {
    for (const Hand& hand : hands_) {
      const WorkspaceMap map = pointerOnPath(hand.placement.settings.workspace, hand.placement.path, copy.time() + h);
      copy.setPointerTarget(hand.placement.pointer, map.X_WP(), map.V_WP());
    }
  });
  deadline_ = report.text();
  if (report.steps == 0) return 0;
  return report.kept() ? report.budget : report.deadline / report.seconds_per_unit;  // all but what cannot give way keeps it
}

void LoopSession::connect(std::uint64_t first_tick) {
  World& world = world_->world;
  findBudget();
  loop_ = std::make_unique<HapticLoop>(world);
  start_ = SessionStart{first_tick, world.settings().step, world.save(), world.tuning().numbers(), {}, world_->paused(), {}};
  if (world_->bodies()) start_.bodies = *world_->bodies();
  loop_->take({PauseWorld{world_->paused()}});
  for (Hand& hand : hands_) {
    HandSettings settings = hand.placement.settings;
    settings.soft_start_s = parameters_.soft_start;
    settings.silent = parameters_.silent;
    settings.passivity.mode = parameters_.passivity;
    settings.clutch_button = parameters_.clutch_button;
    settings.grab_button = parameters_.grab_button;
    Spidar& device = hand.lease->device;
    loop_->attach(device, hand.placement.pointer, settings);
    hand.origin = static_cast<int>(start_.hands.size());
    auto* twin = dynamic_cast<DeviceTwin*>(&hand.lease->transport);
    if (twin && hand.lease->follows_script) twin->setHandPath(hand.placement.path);
    device.handOver();
    const std::vector<double> memory = device.save();
    device.restore(memory);  // a replay starts from these numbers: what they leave out must not act here either
    start_.hands.push_back({hand.name, device.def(), hand.placement.pointer, settings, memory, {}});
  }
  input_.tick = first_tick;
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

void LoopSession::note(const LoopCommand& command) {
  noted_ = noted_tick_ == input_.tick ? noted_ + 1 : 1;
  noted_tick_ = input_.tick;
  if (!events_) return;
  const auto* change = std::get_if<ChangeBodies>(&command.kind);
  // The compiled world is its sender's: the recording must not be the last to let go of a world.
  events_->push({input_.tick, change ? LoopCommand{ChangeBodies{change->packed, nullptr}} : command});
}

void LoopSession::take(const LoopCommand& command) {
  loop_->take(command);
  if (isForHand(command) || command.is<TuneWorld>() || command.is<SetGravity>()) ++changes_;
  note(command);
}

void LoopSession::dropRecalledDevices() {
  for (int i = static_cast<int>(hands_.size()) - 1; i >= 0; --i) {
    if (!hands_[i].lease.recalled()) continue;
    hands_[i].lease->transport.zeroDrive();
    take({DropHand{}, i});  // before the device that it refers to
    hands_.erase(hands_.begin() + i);
  }
}

void LoopSession::serve(Commands& commands) noexcept {
  commands.drain([this](const Command& command) { carryOut(command); });
  world_->serve([this](const LoopCommand& command) { take(command); });
}

void LoopSession::carryOut(const Command& command) {
  if (const auto* remember = std::get_if<Remember>(&command)) copyTo(*remember->into);
  if (const auto* look = std::get_if<Look>(&command)) copyTo(*look->into);
  if (const auto* change = std::get_if<Change>(&command)) {
    *change->outdated = change->seen->start != start_.first_tick || change->seen->changes != changes_;
    for (std::size_t i = 0; i < change->tell.count && !*change->outdated; ++i) take(change->tell.first[i]);
  }
}

void LoopSession::copyTo(Memory& memory) const {
  memory.needs = world_->world.history().latest().packedCapacity();
  if (memory.loop.world_state.capacity() < memory.needs) return;
  remember(*loop_, input_.tick, memory.loop);
  for (std::size_t i = 0; i < hands_.size(); ++i) memory.origins[i] = hands_[i].origin;
  memory.events = noted_tick_ == input_.tick ? noted_ : 0;
}

void LoopSession::copyTo(View& view) const {
  view.start = start_.first_tick;
  view.changes = changes_;
  view.tuning = world_->world.tuning();
  view.defined.clear();
  for (int i = 0; i < world_->world.pointerCount(); ++i) view.defined.push_back(world_->world.pointer(i).coupling);
  view.hands.clear();
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    const haptic::Hand& hand = loop_->hand(static_cast<int>(i));
    const DeviceDef& def = hand.device().def();
    view.hands.push_back({hands_[i].name, hand.settings(), hands_[i].placement.settings, hand.device().tuning(),
                          {def.border_lambda > 0 ? def.border_lambda : def.lambda, def.max_force, def.max_torque},
                          hand.report().in_contact, hand.report().clutched});
  }
}

void LoopSession::exchange(const TimeLost& lost, std::int64_t& io_ns, std::int64_t& twin_ns) noexcept {
  io_ns = twin_ns = 0;
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    DevicePort& port = *hands_[i].lease;
    const std::int64_t before = steadyNow();
    input_.sample[i] = port.transport.exchange(port.device.driveAfter(lost));
    const std::int64_t spent = steadyNow() - before;
    io_ns += spent;
    if (port.transport.truth()) twin_ns += spent;  // a twin's physics, no wire
  }
}

void LoopSession::tick(const PeriodicWake::Wake& wake, std::uint64_t index, double h, TickSample& sample,
                       RecordedTick& record) noexcept {
  input_.tick = index;
  input_.lost_periods = wake.lost_periods;
  input_.asleep = wake.asleep;
  input_.hands = static_cast<int>(hands_.size());
  std::int64_t twin_ns = 0;
  exchange(input_.lost(h), sample.io_ns, twin_ns);
  for (int i = 0; i < input_.hands; ++i) {
    hands_[i].lease->serve(input_.sample[i], [&](const LoopCommand& command) { take({command.kind, i}); });
  }

  const std::int64_t before = steadyNow();
  loop_->tick(input_, h);
  sample.tick_ns = steadyNow() - before + twin_ns;

  record.input = input_;
  if (parameters_.keepsTicks()) hashTick(*loop_, record.hash);
  sample.tick = index;
  sample.start_ns = wake.start_ns;
  sample.lateness_ns = wake.lateness_ns;
  sample.lost_periods = wake.lost_periods;
  sample.paused = loop_->paused();
  sample.simulated_time = world_->world.time();
  sample.step = world_->world.report();
  sample.hands = input_.hands;
  for (int i = 0; i < sample.hands; ++i) {
    observe(hands_[i], sample.hand[i]);
    hands_[i].lease->record(index, wake.start_ns, input_.sample[i]);
  }
  world_->noteTick(wake.start_ns);
  input_.tick = index + 1;  // events from now on are before that one
}

void LoopSession::observe(Hand& hand, HandSample& sample) const noexcept {
  const Spidar& device = hand.lease->device;
  sample.X_BG = device.pose();
  sample.flags = device.flags();
  sample.state = device.state();
  sample.F_asked_B = device.askedWrench();
  sample.F_achieved_B = device.achievedWrench();
  sample.pointer_force = world_->world.pointerWrench(hand.placement.pointer).force.norm();
  const DeviceDef& def = device.def();
  const TensionReport& tension = device.tension();
  sample.over_clamp = sample.F_asked_B.force.norm() > def.max_force * (1 + kClampTolerance) ||
                      sample.F_asked_B.torque.norm() > def.max_torque * (1 + kClampTolerance);
  for (int s = 0; s < tension.tension.size(); ++s) {
    sample.over_clamp |= tension.tension[s] > def.strings[s].max_tension * (1 + kClampTolerance);
  }
  sample.opening = device.opening();
  sample.calibrated = device.calibrated();
  const Pose* truth = hand.lease->transport.truth();
  sample.simulated = truth != nullptr;
  if (truth) sample.X_BG_true = *truth;
  sample.strings_known = hand.twin != nullptr;
  if (hand.twin) sample.F_strings_B = hand.twin->stringWrench();
}

std::vector<DeviceDef> LoopSession::deviceDefs() const {
  std::vector<DeviceDef> defs;
  for (const Hand& hand : hands_) defs.push_back(hand.lease->device.def());
  return defs;
}

std::vector<HandPlacement> LoopSession::placements() const {
  std::vector<HandPlacement> placements;
  for (const Hand& hand : hands_) placements.push_back(hand.placement);
  return placements;
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

std::vector<std::string> LoopSession::linkNames() const {
  std::vector<std::string> names;
  for (int i = 0; i < world_->world.linkCount(); ++i) names.push_back(world_->world.linkName(i));
  return names;
}

}  // namespace haptic
