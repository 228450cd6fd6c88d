#include "haptic_core/world/world.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/stepping/turns.h"
#include "haptic_core/world/carry_over.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/put.h"
#include "haptic_core/world/runaway.h"
#include "haptic_core/world/saved_state.h"
#include "haptic_core/world/sensors.h"
#include "haptic_core/world/step.h"
#include "haptic_core/world/step_history.h"

namespace haptic {
namespace {

int indexOfName(const std::string& name, int count, const std::string& (World::*nameOf)(int) const, const World& world) {
  for (int i = 0; i < count; ++i) {
    if ((world.*nameOf)(i) == name) return i;
  }
  return -1;
}

/// Steps that a world takes before it is put in place of another. Without them the first tick costs some 100 us more.
constexpr int kWarmingSteps = 3;

}  // namespace

struct World::Impl {
  explicit Impl(const WorldDef& def)
      : model(def), work(model), state(initialState(model, work)), history(model.settings.history_steps, state),
        sensors(model, def.sensors) {}

  /// (in realtime) Between two steps: the next one visits everything.
  void wake() noexcept { work.activity.wakeAll(model, false, state, work); }

  /// (in realtime) Between two steps: whatever waits for a turn comes to the present.
  void bringToPresent() noexcept {
    work.activity.wakeAll(model, true, state, work);
    if (model.turn_steps > 1) stepping::bringToPresent(model, state, work, report);
  }

  /// (in realtime) Between two steps, before somebody changes something.
  void prepare() noexcept {
    wake();
    bringToPresent();
  }

  /// (in realtime) Stands at a packed state of its own. Warm starts beside the state are gone.
  void begin(const std::vector<double>& packed) {
    wake();
    state.unpack(packed);
    report = StepReport{};
    report.step = state.step;
    work.stopped = false;
    work.reported.clear();  // a slot may get its pair again, at another time
    history.clear();
    sensors.clear();
    refreshHands(model, state, work.hands);
    placeAll(model, state, work.placement);
  }

  Model model;
  Work work;
  State state;
  StepReport report;
  StepHistory history;
  Sensors sensors;
};

World::World(const WorldDef& def) : impl_(std::make_unique<Impl>(def)) {}
World::~World() = default;

void World::step() noexcept {
  const bool runs = !impl_->work.stopped;
  const bool measures = runs && !impl_->sensors.empty();
  if (measures) impl_->sensors.begin(impl_->model, impl_->state, impl_->work.placement);
  haptic::step(impl_->model, impl_->state, impl_->work, impl_->report);
  if (!runs || impl_->work.stopped) return;
  if (measures) impl_->sensors.finish(impl_->model, impl_->state, impl_->work.placement, impl_->work.reported);
  impl_->history.keep(impl_->model, impl_->work.visits.trees, impl_->work.activity.changes());
}

void World::measureStages(bool on) noexcept {
  impl_->work.clock.on = on;
  impl_->report.stages = {};
}

const WorldSettings& World::settings() const { return impl_->model.settings; }
const StepReport& World::report() const { return impl_->report; }
double World::time() const { return impl_->state.time; }
const Model& World::model() const { return impl_->model; }
const State& World::state() const { return impl_->state; }
const std::vector<double>& World::q() const { return impl_->state.q; }
const std::vector<double>& World::v() const { return impl_->state.v; }
const Work& World::work() const { return impl_->work; }
const StepHistory& World::history() const { return impl_->history; }

int World::linkCount() const { return static_cast<int>(impl_->model.links.size()); }
const std::string& World::linkName(int link) const { return impl_->model.links[link].name; }
int World::linkIndex(const std::string& name) const { return indexOfName(name, linkCount(), &World::linkName, *this); }
Pose World::linkPose(int link) const { return impl_->work.placement.link[link].X_WL; }
Twist World::linkTwist(int link) const { return impl_->work.placement.link[link].twistAtOrigin(); }
bool World::stands(int link) const noexcept {
  return impl_->work.visits.phase[impl_->model.links[link].articulation] == Phase::kRests;
}

int World::jointCount() const { return static_cast<int>(impl_->model.joints.size()); }
const std::string& World::jointName(int joint) const { return impl_->model.joints[joint].name; }
int World::jointIndex(const std::string& name) const { return indexOfName(name, jointCount(), &World::jointName, *this); }
int World::jointLink(int joint) const { return impl_->model.joints[joint].link; }
bool World::obeysCommands(int joint) const { return impl_->model.joints[joint].driven; }

JointReading World::joint(int i) const noexcept {
  const Impl& world = *impl_;
  const ModelJoint& joint = world.model.joints[i];
  const ModelLink& link = world.model.links[joint.link];
  const TreeMotion* motion = world.work.joints[link.articulation].get();
  const bool implicit = world.work.implicit && world.state.mode[link.articulation] == TreeMode::kImplicit;
  const JointForce force = implicit ? world.work.implicit->stage.joints.force(joint.link)
                           : motion ? motion->forceOf(link.local)
                                    : JointForce{};
  return {world.state.q[joint.q], world.state.v[joint.v], force.all, force.drive};
}

bool World::setJointCommand(int joint, const JointCommand& command) noexcept {
  const Model& model = impl_->model;
  if (joint < 0 || joint >= jointCount() || !model.joints[joint].driven || !isFinite(command)) return false;
  const ModelLink& link = model.links[model.joints[joint].link];
  impl_->state.commands[model.trees[link.articulation].command + link.local] = command;
  return true;
}

int World::wrenchCount() const { return impl_->state.wrench_count; }
const AppliedWrench& World::wrench(int i) const { return impl_->state.wrenches[static_cast<std::size_t>(i)]; }

void World::applyWrench(int link, const LinkWrench& wrench, double seconds) {
  impl_->prepare();
  haptic::applyWrench(impl_->model, link, wrench, seconds, impl_->state, impl_->work);
}

void World::setBodyPose(int link, const Pose& X_WL, const Twist& V_WL) {
  impl_->prepare();
  putBody(impl_->model, link, X_WL, V_WL, impl_->state, impl_->work);
  impl_->work.reported.clear();
}

void World::setJointPositions(const std::vector<std::pair<int, double>>& positions) {
  impl_->prepare();
  putJoints(impl_->model, positions, impl_->state, impl_->work);
  impl_->work.reported.clear();
}

int World::forceCount() const { return static_cast<int>(impl_->model.forces.size()); }
const std::string& World::forceName(int i) const { return impl_->model.forces[static_cast<std::size_t>(i)].name; }
LinkForce World::force(int i) const noexcept {
  return forceNow(impl_->model, impl_->model.forces[static_cast<std::size_t>(i)], impl_->work.placement.link.data());
}

int World::motionCount() const { return static_cast<int>(impl_->model.motions.size()); }
const ModelMotion& World::motion(int i) const { return impl_->model.motions[static_cast<std::size_t>(i)]; }
int World::motionIndex(const std::string& name) const {
  for (int i = 0; i < motionCount(); ++i) {
    if (motion(i).name == name) return i;
  }
  return -1;
}

bool World::leadBody(int i, const MotionPoint& to, double seconds) noexcept {
  if (i < 0 || i >= motionCount() || !motion(i).time.empty()) return false;
  const bool finite = to.p_WL.allFinite() && to.q_WL.coeffs().allFinite() && to.V_WL.linear.allFinite() && to.V_WL.angular.allFinite();
  if (!finite || !std::isfinite(seconds) || std::abs(to.q_WL.norm() - 1) > 1e-6) return false;
  State& state = impl_->state;
  state.motions[static_cast<std::size_t>(i)] = leavingFor(motion(i), state.motions[static_cast<std::size_t>(i)], to, state.time,
                                                          std::max(seconds, settings().step));
  return true;
}

bool World::followBody(int i, const MotionPoint& to, double seconds) noexcept {
  if (i < 0 || i >= motionCount() || !motion(i).time.empty()) return false;
  const State& state = impl_->state;
  const MotionPoint from = motionAt(motion(i), state.motions[static_cast<std::size_t>(i)], state.time);
  const Approach approach = approachTo(from, to, std::max(seconds, settings().step));
  return leadBody(i, approach.to, approach.seconds);
}

int World::pointerCount() const { return static_cast<int>(impl_->model.pointers.size()); }
const PointerDef& World::pointer(int i) const { return impl_->model.pointers[i]; }
int World::pointerLink(int i) const { return impl_->state.pointers[i].link; }
int World::pointerHome(int i) const { return impl_->model.pointerHome(i); }
Wrench World::pointerWrench(int i) const noexcept { return impl_->state.pointers[i].F_W; }

double World::pointerForceError(int i) const noexcept { return impl_->work.hands.force_error[i]; }

Pose World::pointerPose(int i) const { return linkPose(pointerLink(i)) * impl_->model.pointerFrame(i, pointerLink(i)); }

void World::setPointerTarget(int i, const Pose& X_WP, const Twist& V_WP) noexcept {
  aim(impl_->state.pointers[i], X_WP, V_WP);
  impl_->work.activity.stir();
}

void World::setPointerBound(int i, const PointerBound& bound) noexcept {
  static_cast<PointerBound&>(impl_->work.hands.bound[i]) = bound;
}
const PointerBound& World::pointerBound(int i) const noexcept { return impl_->work.hands.bound[i]; }

double World::pointerStiffness(int i) const noexcept {
  return stiffnessMet(impl_->model, impl_->state, impl_->work.visits, impl_->work.placement, impl_->work.hands, i);
}

bool World::canGrab(int pointer, int link) const noexcept {
  return haptic::canGrab(impl_->model, impl_->work.hands, pointer, link);
}

bool World::tryGrab(int pointer, int link) noexcept {
  if (!canGrab(pointer, link)) return false;
  impl_->prepare();
  haptic::grab(impl_->model, impl_->work.placement, pointer, link, impl_->state, impl_->work.hands);
  for (int t = 0; t < static_cast<int>(impl_->state.mode.size()); ++t) impl_->state.beginAnew(t);
  renewSupply(impl_->model, impl_->work, impl_->state);
  return true;
}

void World::grab(int pointer, int link) {
  checkGrab(impl_->model, impl_->work.hands, pointer, link);
  tryGrab(pointer, link);
}

const WorldTuning& World::tuning() const { return impl_->model.tuning; }

void World::tune(const WorldTuning& tuning) {
  Model& model = impl_->model;
  WorldTuning wanted = tuning;
  if (wanted.gravity.array().isNaN().all()) wanted.gravity = model.settings.gravity;
  std::vector<CouplingLoad> loads;
  for (const PointerState& pointer : impl_->state.pointers) loads.push_back(model.loadOf(pointer.link));
  check(wanted, loads, model.settings.step);
  impl_->prepare();
  model.tune(wanted);
  refreshHands(model, impl_->state, impl_->work.hands);
  for (int i = 0; i < pointerCount(); ++i) {
    if (!canGrab(i, pointerLink(i))) grab(i, pointerHome(i));
  }
  for (int t = 0; t < static_cast<int>(impl_->state.mode.size()); ++t) impl_->state.beginAnew(t);
  renewSupply(model, impl_->work, impl_->state);
}

int World::contactCount() const { return impl_->work.reported.count(); }
const ContactReport& World::contact(int i) const { return impl_->work.reported.listed(i); }

int World::sensorCount() const { return static_cast<int>(impl_->sensors.defs().size()); }
const SensorDef& World::sensor(int i) const { return impl_->sensors.defs()[static_cast<std::size_t>(i)]; }
const SensorReading& World::sensorReading(int i) const { return impl_->sensors.readings()[static_cast<std::size_t>(i)]; }

int World::sensorIndex(const std::string& name) const {
  for (int i = 0; i < sensorCount(); ++i) {
    if (sensor(i).name == name) return i;
  }
  return -1;
}

struct NextWorld::Impl {
  Impl(const World& running, const WorldDef& def, const std::vector<int>& kept)
      : world(def), map(carryOverOf(running.model(), world.model(), kept)) {
    // A few steps touch the storage, which the first tick would otherwise have mapped page by page.
    start = world.save();
    for (int i = 0; i < kWarmingSteps; ++i) world.step();
    world.restore(start);
  }
  World world;
  std::vector<double> start;
  CarryOver map;
};

NextWorld::NextWorld(const World& running, const WorldDef& def, const std::vector<int>& kept)
    : impl_(std::make_unique<Impl>(running, def, kept)) {}
NextWorld::~NextWorld() = default;
const std::vector<double>& NextWorld::start() const { return impl_->start; }
std::size_t NextWorld::stateCapacity() const { return impl_->world.state().packedCapacity(); }

void NextWorld::refuseHeld(const World& running) const {
  for (int p = 0; p < running.pointerCount(); ++p) {
    const int before = running.pointerLink(p), now = linkNow(before);
    bool led = false;
    for (int m = 0; m < impl_->world.motionCount(); ++m) led |= impl_->world.motion(m).link == now;
    if (now >= 0 && !led) continue;
    throw SetupError("link " + running.linkName(before),
                     "is held by the hand of " + running.pointer(p).device + (now < 0 ? "" : ", and a motion is to lead it"),
                     "let it go first");
  }
}

int NextWorld::linkNow(int link_before) const noexcept { return impl_->map.link[static_cast<std::size_t>(link_before)]; }

bool World::exchange(NextWorld& next) noexcept {
  if (next.impl_->map.from != &impl_->model) return false;
  Impl& to = *next.impl_->world.impl_;
  impl_->bringToPresent(), to.wake();
  carryOver(next.impl_->map, impl_->state, impl_->work, to.model, to.state, to.work);
  to.report = impl_->report;
  to.work.clock.on = impl_->work.clock.on;
  std::swap(impl_, next.impl_->world.impl_);
  return true;
}

void World::rehearse(NextWorld& next, bool steps) noexcept {
  if (next.impl_->map.from != &impl_->model) return;
  Impl& to = *next.impl_->world.impl_;
  to.wake();
  carryOver(next.impl_->map, impl_->state, impl_->work, to.model, to.state, to.work);
  to.report = impl_->report;
  if (steps) next.impl_->world.step();
  to.begin(next.impl_->start);
}

std::uint64_t World::hash() const { return impl_->state.hash(); }
std::vector<double> World::save() const { return state().pack(); }

void World::restore(const std::vector<double>& packed) {
  refuseDamaged(impl_->model, impl_->state, packed);
  impl_->begin(packed);
  // What it may draw on was found under the gravity that held then. Under the same one, as in a replay, no bit changes.
  if (impl_->state.energy.gravity != impl_->model.settings.gravity) renewSupply(impl_->model, impl_->work, impl_->state);
}

std::string World::planText() const {
  std::string text = impl_->model.text() + impl_->sensors.text();
  for (const auto& motion : impl_->work.joints) {
    if (!motion) continue;
    for (const std::string& line : motion->unsupported()) text += "  not simulated: " + line + "\n";
  }
  return text;
}

}  // namespace haptic
