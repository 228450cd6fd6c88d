#include "haptic_core/loop/hand.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/wall_bound.h"
#include "haptic_core/world/model.h"

namespace haptic {
namespace {

StringVector quantumOf(const DeviceDef& def) {
  StringVector quantum = StringVector::Zero(static_cast<Eigen::Index>(def.strings.size()));
  for (std::size_t i = 0; i < def.strings.size(); ++i) {
    quantum[static_cast<Eigen::Index>(i)] = std::fabs(def.strings[i].length_per_count);
  }
  return quantum;
}

}  // namespace

Hand::Hand(Spidar& device, int pointer, const HandSettings& settings, double h)
    : device_(device),
      pointer_(pointer),
      settings_(settings),
      map_(settings.workspace),
      passivity_(settings.passivity, device.def().grip_mass, quantumOf(device.def())),
      seen_line_(ticksOf(settings.delay.pose, h)),
      pushed_line_(ticksOf(settings.delay.force, h)),
      count_(quantumOf(device.def()).maxCoeff()),
      velocity_filter_(1 / (2 * M_PI * device.settings().velocity_cutoff_hz)) {
  check(settings);
}

void Hand::check(const HandSettings& settings) const {
  const auto require = [this](bool good, const char* name, double value, const char* remedy) {
    if (good) return;
    std::ostringstream is;
    is << name << " is " << value;
    throw SetupError(device_.def().name, is.str(), remedy);
  };
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };
  const WorkspaceSettings& w = settings.workspace;
  require(w.X_WB.p.allFinite() && w.X_WB.R.allFinite(), "the base's pose", w.X_WB.p.norm(), "give finite numbers");
  require(within(w.scale, 1e-6, 1e6), "workspace scale", w.scale, "give a number > 0, 1e-6 to 1e6");
  require(within(settings.force_scale, 0, 1e6), "force scale", settings.force_scale, "give a number >= 0, at most 1e6");
  require(within(settings.soft_start_s, 0, 60), "soft start", settings.soft_start_s, "give a time of 0 to 60 s");
  require(within(settings.passivity.radius, 1e-4, 10), "passivity radius", settings.passivity.radius, "give 1e-4 to 10 m");
  require(within(settings.passivity.max_damping, 0, 1e4), "passivity damping", settings.passivity.max_damping,
          "give 0 to 1e4 N·s/m");
  for (const double delay : {settings.delay.pose, settings.delay.force}) {
    require(within(delay, 0, kMostAddedDelay), "an added delay", delay, "give 0 to 0.2 s");
  }
  for (const int button : {settings.clutch_button, settings.grab_button}) {
    require(button >= -1 && button < 32, "a button", button, "give 0 to 31, or -1 for none");
  }
}

void Hand::setSettings(const HandSettings& settings) {
  check(settings);
  if (!(settings.delay == settings_.delay)) {
    throw SetupError(device_.def().name, "its added delay cannot change while it runs", "load a scene that has it");
  }
  const WorkspaceSettings &now = settings_.workspace, &next = settings.workspace;
  const bool stands_elsewhere = now.X_WB.p != next.X_WB.p || now.X_WB.R != next.X_WB.R;
  if (now.scale != next.scale || stands_elsewhere) map_.setSettings(next);
  if (stands_elsewhere && settings.soft_start_s > 0) map_.rebase(map_.X_WP(), Rebase::kGlide, settings.soft_start_s);
  passivity_.setSettings(settings.passivity);
  settings_ = settings;
}

void Hand::take(const LoopCommand& command) {
  apply(command, device_);
  if (const auto* change = std::get_if<ChangeHand>(&command.kind)) setSettings(change->settings);
  if (const auto* clutch = std::get_if<HoldClutch>(&command.kind)) clutch_held_ = clutch->held;
}

void Hand::followWorld(const World& world, int link_before, bool jumped) noexcept {
  const int link = world.pointerLink(pointer_);
  if (jumped) pressing_ = -1;
  if (jumped || link != link_before) {
    rebase_ = jumped || link == world.pointerHome(pointer_) ? Rebase::kGlide : Rebase::kKeep;
  }
}

void Hand::followBodies(const World& world, const NextWorld& change, int link_before) noexcept {
  if (pressing_ >= 0) pressing_ = change.linkNow(pressing_);
  followWorld(world, change.linkNow(link_before), false);
}

void Hand::sense(const DeviceSample& sample, double h, const TimeLost& lost) noexcept {
  device_.sense(sample, h, lost);
  // The grip may be elsewhere by now: the pointer glides to it from where the world has it, and nobody knows what the strings did.
  const bool lasted = lost.seconds > LoopClock::kLasting;
  if (lasted) rebase_ = Rebase::kGlide;
  last_buttons_ = buttons_;
  buttons_ = sample.buttons;
  const Pose X_last = report_.X_BG;
  report_.valid = device_.poseValid();
  report_.X_BG = device_.pose();
  report_.V_BG = device_.twist();
  report_.opening = device_.opening();
  report_.length = device_.lengths();
  report_.pose_residual = device_.solution().residual;
  moved_ = Twist{};
  if (report_.valid && (lasted || !was_valid_)) passivity_.start(report_.length);
  if (report_.valid && was_valid_ && !lasted) {
    passivity_.observe(report_.length);
    moved_ = {vectorFromRotation(Quaternion(report_.X_BG.R * X_last.R.transpose())) / h, (report_.X_BG.p - X_last.p) / h};
  }
  // Without a pose there was nothing to be late: the line begins with the first one.
  const Seen now{device_.steadyPose(), report_.V_BG, moved_};
  if (report_.valid && !was_valid_) seen_line_.fill(now);
  seen_ = report_.valid ? seen_line_.through(now) : Seen{};
  was_valid_ = report_.valid;
}

/// The free body that presses most on the pointer; -1: none. Only a step knows it: a world that was restored has no contacts yet.
int Hand::pressing(const World& world) const noexcept {
  const int held = world.pointerLink(pointer_);
  int pressing = -1;
  double most = 0;
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& contact = world.contact(i);
    if (contact.link_a != held && contact.link_b != held) continue;
    const int other = contact.link_a == held ? contact.link_b : contact.link_a;
    if (contact.normal_force <= most || !world.canGrab(pointer_, other)) continue;
    most = contact.normal_force;
    pressing = other;
  }
  return pressing;
}

/// Grabs the body that pressed most in the last step; pressed again, takes the scene's own pointer back.
void Hand::followGrabButton(World& world) noexcept {
  const std::uint32_t edge = buttons_ & ~last_buttons_;
  if (settings_.grab_button < 0 || !((edge >> settings_.grab_button) & 1u)) return;
  const int own = world.pointerHome(pointer_);
  if (world.pointerLink(pointer_) != own) {
    if (world.tryGrab(pointer_, own)) rebase_ = Rebase::kGlide;
  } else if (pressing_ >= 0 && world.tryGrab(pointer_, pressing_)) {
    rebase_ = Rebase::kKeep;
  }
}

void Hand::couple(World& world, double h) noexcept {
  followGrabButton(world);
  if (!report_.valid) {
    report_.X_WP = map_.X_WP();
    return;
  }
  if (rebase_ != Rebase::kNone) {
    device_.beginAnew(settings_.soft_start_s);
    given_B_ = Wrench{};
    pushed_line_.fill({});  // of another state of the world
    map_.rebase(world.pointerPose(pointer_), rebase_, settings_.soft_start_s);
    rebase_ = Rebase::kNone;
  }
  const bool held = clutch_held_ || pressed(settings_.clutch_button);
  map_.update(seen_.X_BG, seen_.V_BG, held && (map_.clutched() || !report_.in_contact), h);
  report_.X_WP = map_.X_WP();
  report_.clutched = map_.clutched();
  world.setPointerTarget(pointer_, map_.X_WP(), map_.V_WP());
}

double Hand::stableStiffness() const noexcept {
  return withAddedDelay(device_.stableStiffness(), device_.def().grip_damping + kRelaxedHandDamping, settings_.delay.total());
}

std::size_t Hand::mostMemory(const HandSettings& settings, double h) {
  constexpr std::size_t kWithoutDelay = 256;  // of numbers; what there is of eachField without lines, and room
  const DelayLine<Seen> seen(ticksOf(settings.delay.pose, h));
  const DelayLine<Pushed> pushed(ticksOf(settings.delay.force, h));
  return kWithoutDelay + countFields(seen) + countFields(pushed);
}

/// A relaxed hand over this wire at this rate, and the device's limits. Not of the gain: a force that is faded in is that of the same
/// contact, and a spring that changed in time would give what it had not taken.
void Hand::bear(World& world) const noexcept {
  PointerBound bound;
  if (!feelsAnything() && settings_.force_scale > 0) {
    const Spidar::Tuning limits = device_.tuning();
    const double K = stableStiffness(), B = device_.def().grip_damping + kRelaxedHandDamping;
    bound.stiffness = stiffestWall(K, count_) / worldToGrip();
    if (K > 0) bound.lag = B / K;
    if (!world.model().holds(pointer_) && K > 0) {
      const CouplingBound coupling = stiffestCoupling({B, B / K, world.settings().step, count_, velocity_filter_});
      bound.stiffness = coupling.stiffness / worldToGrip();
      bound.damping = coupling.damping / worldToGrip();
      bound.press = std::max(0.0, limits.max_force) / settings_.force_scale;
    }
    if (limits.max_force > 0) bound.force = limits.max_force / settings_.force_scale;  // else the hand feels nothing, wherever the link is
    if (limits.max_torque > 0) bound.torque = limits.max_torque * settings_.workspace.scale / settings_.force_scale;
    const double turn = settings_.workspace.scale * settings_.workspace.scale * kRelaxedHandTurnDamping / kRelaxedHandDamping;
    bound.turn_of_way = device_.def().dof > 3 ? turn : INFINITY;  // a point grip turns nothing, and feels no torque
  }
  world.setPointerBound(pointer_, bound);
}

/// The law for this hand. Who feels anything has the device's own rate.
ForceSlew Hand::slewOf(const World& world) const noexcept {
  const Model& model = world.model();
  const int held = world.pointerLink(pointer_);
  const ModelLink& link = model.links[static_cast<std::size_t>(held)];
  const LinkModel& body = model.trees[static_cast<std::size_t>(link.articulation)].model->link(link.local);
  const double reach = link.size + (body.p_LO + body.p_OC - model.pointerFrame(pointer_, held).p).norm();  // from the pointer's origin
  return {stableStiffness(), reach / settings_.workspace.scale, feelsAnything() ? device_.settings().force_slew : kForceRate};
}

/// Asks the device for a wrench, and presents what the device and the port's energy let through. With an added delay the way is the
/// delayed one, to which the world answered.
void Hand::give(const Wrench& F_B, const World& world, const Twist& moved, double h) noexcept {
  given_B_ = device_.withinLimits(F_B);
  device_.present(passivity_.act(device_.admit(F_B, slewOf(world), moved, h), moved_, h), 0.0, h);
  passivity_.hold(device_.achievedWrench(), device_.toldTension());
  report_.F_asked_B = device_.askedWrench();
  report_.F_achieved_B = device_.achievedWrench();
  report_.tension = device_.tension().tension;
  report_.fade = device_.gain();
  report_.slewed = (device_.flags() & kSlewLimited) != 0;
  report_.port_energy = passivity_.energy();
  report_.dissipated = passivity_.dissipated();
  report_.passivity_acts = passivity_.acting();
  report_.device_flags = device_.flags();
}

void Hand::render(const World& world, double h) noexcept {
  const Wrench F_W = world.pointerWrench(pointer_);
  report_.in_contact = F_W.force.squaredNorm() + F_W.torque.squaredNorm() > 0;
  pressing_ = settings_.grab_button < 0 ? -1 : pressing(world);
  const double stiffness = report_.in_contact ? world.pointerStiffness(pointer_) : 0;
  report_.stiffness = stiffness * worldToGrip();
  report_.stiffness_share = stiffness > 0 ? std::min(1.0, world.pointerBound(pointer_).stiffness / stiffness) : 1;
  const Pushed pushed = pushed_line_.through({F_W, seen_.moved});
  const Wrench whole_B = map_.toGrip(pushed.F_W) * settings_.force_scale;
  if (!report_.valid) device_.beginAnew(settings_.soft_start_s);
  give(settings_.silent ? ledOut(whole_B, h) : whole_B, world, pushed.moved, h);
  if (!settings_.silent) return;
  const double led = given_B_.force.norm(), whole = whole_B.force.norm();
  if (led == 0) device_.beginAnew(settings_.soft_start_s);  // the way back is a ramp
  report_.fade = led == 0 ? 0 : device_.gain() * std::min(1.0, led / std::max(led, whole));
}

/// The last tick's wrench, smaller: its size falls by kFadeRate, up to kFadeRate times kLeavingFade where the world's own is less. Neither
/// direction nor size is the world's: a hand that presses sinks in as the force goes, and counts make its speed uneven, which a contact's
/// damper and friction answer by 0.1 N a tick.
Wrench Hand::ledOut(const Wrench& whole_B, double h) const noexcept {
  const double force = given_B_.force.norm(), step = kFadeRate * h, whole = whole_B.force.norm();
  const double size = std::max(0.0, std::min(force - step, std::max(whole, force - kLeavingFade * step)));
  return size > 0 ? given_B_ * (size / force) : Wrench{};
}

void Hand::rest(const World& world, double h) noexcept {
  pushed_line_.through({});
  device_.beginAnew(settings_.soft_start_s);
  give({}, world, seen_.moved, h);
}

void Hand::save(std::vector<double>& out) const {
  out.clear();
  appendFields(*this, out);
}

void Hand::restore(const std::vector<double>& memory) {
  if (memory.size() != countFields(*this)) {
    throw SetupError("a hand", "its memory of " + std::to_string(memory.size()) + " numbers does not fit",
                     "use a recording of this version");
  }
  const double* next = memory.data();
  readFields(*this, next);
}

void Hand::letGo(World& world) noexcept {
  world.setPointerTarget(pointer_, map_.X_WP(), Twist{});
  world.setPointerBound(pointer_, PointerBound{});
}

const DriveCommand& Hand::drive() const noexcept {
  return device_.drive();
}

}  // namespace haptic
