#include "haptic_core/world/sensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <utility>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"
#include "haptic_core/base/word_hash.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/link_forces.h"

namespace haptic {
namespace {

constexpr double kMostPeriod = 9007199254740992;  ///< steps between samples: 2⁵³, a whole number as a double
constexpr const char* kKindNames[] = {"wrench", "contact", "imu"};

/// Hash of text, in words of 8 bytes, the last filled up with zeros.
std::uint64_t hashText(std::uint64_t hash, const std::string& text) {
  std::vector<std::uint64_t> words(text.size() / 8 + 1);
  std::memcpy(words.data(), text.data(), text.size());
  return hashWords(hash, words.data(), 8 * words.size());
}

/// A word all of whose bits depend on all of x: hashWords alone leaves the low bits of neighbouring steps alike. Two rounds of a shift
/// and a product, as G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014, have them.
std::uint64_t mixed(std::uint64_t x) noexcept {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ x >> 27) * 0x94d049bb133111ebull;
  return x ^ x >> 31;
}

/// In (0, 1], of the upper 53 bits.
double unit(std::uint64_t word) noexcept { return (static_cast<double>(word >> 11) + 1) * 0x1p-53; }

/// A number of the standard normal distribution.
double gaussian(std::uint64_t key, std::uint64_t step, std::uint64_t component) noexcept {
  const std::uint64_t words[] = {step, component};
  const std::uint64_t hash = hashWords(key, words, sizeof words);
  constexpr double kTurn = 6.283185307179586;  // 2π
  return std::sqrt(-2 * elementary::log(unit(mixed(hash)))) * elementary::cos(kTurn * unit(mixed(~hash)));
}

Vector3 noise(double deviation, std::uint64_t key, std::uint64_t step, std::uint64_t first) noexcept {
  if (deviation == 0) return Vector3::Zero();
  return deviation * Vector3(gaussian(key, step, first), gaussian(key, step, first + 1), gaussian(key, step, first + 2));
}

/// Origin of a pointer's frame, in W.
Vector3 pulledAt(const Model& model, const State& state, const Placement& placement, int pointer) noexcept {
  const int link = state.pointers[pointer].link;
  return placement.link[link].X_WL * model.pointerFrame(pointer, link).p;
}

/// Shapes of a link of the definition, or those of its collisions that `some` names.
std::vector<int> shapesOf(const Model& model, int link, const std::vector<int>* some) {
  std::vector<int> of_link, found;
  for (int s = 0; s < static_cast<int>(model.shapes.size()); ++s) {
    if (model.shapes[s].link == link) of_link.push_back(s);
  }
  if (!some) return of_link;
  for (const int c : *some) {
    if (c >= 0 && c < static_cast<int>(of_link.size())) found.push_back(of_link[c]);
  }
  return found;
}

}  // namespace

void Sensors::Motion::add(double mass, const Matrix3& I_C_W, const Vector3& p_WC, const Vector3& v_C, const Vector3& omega) noexcept {
  const Vector3 r = p_WC - about;
  linear += mass * v_C;
  angular += I_C_W * omega + mass * r.cross(v_C);
  first += mass * r;
}

Sensors::Motion Sensors::Motion::movedTo(const Vector3& point, double mass) const noexcept {
  const Vector3 way = about - point;
  return {point, linear, angular + way.cross(linear), first + mass * way};
}

Sensors::Sensors(const Model& model, const std::vector<SensorDef>& defs)
    : defs_(defs), readings_(defs.size()), start_(defs.size()), pulls_(model.pointers.size()), pushes_(kMostWrenches),
      forces_(model.forces.size()) {
  for (const SensorDef& def : defs) {
    const std::string where = model.name + ", sensor '" + def.name + "'";
    const auto same = [&](const SensorDef& other) { return other.name == def.name; };
    if (std::count_if(defs.begin(), defs.end(), same) > 1) throw SetupError(where, "is there twice", "give every sensor a name of its own");
    if (!(def.rate >= 0) || !std::isfinite(def.rate)) throw SetupError(where, "its rate is no frequency", "write samples per second, > 0");
    for (const double deviation : {def.noise_torque, def.noise_force, def.noise_rate, def.noise_specific_force, def.noise_orientation}) {
      if (!(deviation >= 0) || !std::isfinite(deviation)) throw SetupError(where, "its noise is no size", "write standard deviations, ≥ 0");
    }
    for (const auto& [articulation, link] : {std::pair{def.articulation, def.link}, std::pair{def.with_articulation, def.with_link}}) {
      if (!model.hasLink(articulation, link) && !(link < 0 && articulation < 0 && def.link >= 0)) {
        throw SetupError(where, "its link is not there", "name a link of the world");
      }
    }
    plans_.push_back(compile(model, def));
  }
}

Sensors::Plan Sensors::compile(const Model& model, const SensorDef& def) const {
  Plan plan;
  plan.link = model.link(def.articulation, def.link);
  const double steps = std::round(1 / (def.rate * model.settings.step));
  if (def.rate > 0) plan.period = static_cast<std::uint64_t>(std::clamp(steps, 1.0, kMostPeriod));
  plan.key = hashText(hashWords(kHashStart, &def.seed, sizeof def.seed), def.name);
  plan.own.resize(model.links.size());
  if (def.kind == SensorDef::Kind::kWrench) compileWrench(model, def, plan);
  if (def.kind == SensorDef::Kind::kContact) compileContact(model, def, plan);
  return plan;
}

void Sensors::compileWrench(const Model& model, const SensorDef& def, Plan& plan) const {
  const ModelTree& tree = model.trees[model.links[plan.link].articulation];
  const std::string where = model.name + ", sensor '" + def.name + "'";
  if (!def.on_part && tree.model->link(plan.link - tree.link).floating) {
    throw SetupError(where, "link '" + model.links[plan.link].name + "' floats: its joint carries nothing",
                     "name a joint that holds something");
  }
  const int links = tree.model->linkCount();
  std::vector<char> beyond(static_cast<std::size_t>(links));
  if (!def.on_part) beyond[plan.link - tree.link] = 1;
  for (const int child : def.part.children) beyond[model.link(def.articulation, child) - tree.link] = 1;
  if (def.on_part) plan.mass = def.part.inertia.mass;
  plan.side.assign(model.shapes.size(), kPartner);
  for (int i = 0; i < links; ++i) {
    const LinkModel& link = tree.model->link(i);
    if (link.parent >= 0 && beyond[link.parent]) beyond[i] = 1;
    if (!beyond[i]) continue;
    plan.links.push_back(tree.link + i);
    plan.own[tree.link + i] = 1;
    plan.mass += link.mass;
    for (const int s : shapesOf(model, tree.link + i, nullptr)) plan.side[s] = kOwn;
  }
  if (def.on_part) {
    for (const int s : shapesOf(model, plan.link, &def.part.collisions)) plan.side[s] = kOwn;
  }
  for (const RingDef& ring : tree.rings) {
    const auto isBeyond = [&](int link) { return link >= 0 && beyond[link]; };
    if (isBeyond(ring.link_a) == isBeyond(ring.link_b)) continue;
    throw SetupError(where, "loop '" + ring.name + "' carries a share that no sensor tells from the joint's",
                     "measure at a joint whose far side the loop does not hold");
  }
}

void Sensors::compileContact(const Model& model, const SensorDef& def, Plan& plan) const {
  plan.side.assign(model.shapes.size(), def.with_link < 0 ? kPartner : kElsewhere);
  if (def.with_link >= 0) {
    const int partner = model.link(def.with_articulation, def.with_link);
    for (const int s : shapesOf(model, partner, def.with_part ? &def.with_collisions : nullptr)) plan.side[s] = kPartner;
  }
  for (const int s : shapesOf(model, plan.link, def.on_part ? &def.part.collisions : nullptr)) plan.side[s] = kOwn;
}

std::string Sensors::text() const {
  std::ostringstream out;
  out << (empty() ? "  left out sensors: the scene has none\n" : "");
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    out << "  runs     sensor " << defs_[i].name << ": " << kKindNames[static_cast<int>(defs_[i].kind)] << " in " << defs_[i].frame
        << ", every " << plans_[i].period << (plans_[i].period == 1 ? " step\n" : " steps\n");
  }
  return out.str();
}

Sensors::Motion Sensors::motionOf(const Model& model, int i, const Placement& placement, const Vector3& about) const noexcept {
  const Plan& plan = plans_[i];
  const SensorDef& def = defs_[i];
  Motion sum;
  sum.about = about;
  for (const int l : plan.links) {
    const ModelTree& tree = model.trees[model.links[l].articulation];
    const LinkModel& link = tree.model->link(l - tree.link);
    const LinkWork& w = placement.link[l];
    const Vector3 p_WC = w.p_WC();
    sum.add(link.mass, w.X_WL.R * link.I_C * w.X_WL.R.transpose(), p_WC, w.twistAt(p_WC).linear, w.omega);
  }
  if (def.on_part) {
    const LinkWork& w = placement.link[plan.link];
    const Vector3 p_WC = w.X_WL * def.part.inertia.p_LC;
    sum.add(def.part.inertia.mass, w.X_WL.R * def.part.inertia.I_C * w.X_WL.R.transpose(), p_WC, w.twistAt(p_WC).linear, w.omega);
  }
  return sum;
}

void Sensors::begin(const Model& model, const State& state, const Placement& placement) noexcept {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const Plan& plan = plans_[i];
    if (!due(plan, state.step + 1)) continue;
    const LinkWork& link = placement.link[plan.link];
    const Vector3 p_WS = link.X_WL * defs_[i].X_LS.p;
    if (defs_[i].kind == SensorDef::Kind::kWrench) start_[i].motion = motionOf(model, static_cast<int>(i), placement, p_WS);
    if (defs_[i].kind == SensorDef::Kind::kImu) start_[i].velocity = link.twistAt(p_WS).linear;
  }
  for (std::size_t p = 0; p < pulls_.size(); ++p) {
    pulls_[p] = {-state.pointers[p].F_W, pulledAt(model, state, placement, static_cast<int>(p))};
  }
  int kept = 0;
  for (int i = 0; i < state.wrench_count; ++i) {
    const AppliedWrench& applied = state.wrenches[i];
    const LinkWork& link = placement.link[applied.link];
    if (applied.end > state.step) pushes_[kept++] = {wrenchInWorld(applied.wrench, link), link.X_WL * applied.wrench.p_L};
  }
  for (std::size_t i = 0; i < forces_.size(); ++i) forces_[i] = forceNow(model, model.forces[i], placement.link.data());
}

void Sensors::finish(const Model& model, const State& state, const Placement& placement, const ContactReports& contacts) noexcept {
  for (std::size_t i = 0; i < plans_.size(); ++i) {
    const Plan& plan = plans_[i];
    if (!due(plan, state.step)) continue;
    const SensorDef& def = defs_[i];
    const LinkWork& link = placement.link[plan.link];
    const Pose X_WS = link.X_WL * def.X_LS;
    const Matrix3 R_SW = X_WS.R.transpose();
    SensorReading reading;
    reading.step = state.step;
    switch (def.kind) {
      case SensorDef::Kind::kWrench:
        reading.F_S = throughJoint(model, static_cast<int>(i), state, placement, contacts, X_WS.p).rotated(R_SW);
        break;
      case SensorDef::Kind::kContact:
        reading.F_S = contactsOn(plan, contacts, X_WS.p).rotated(R_SW);
        break;
      case SensorDef::Kind::kImu:
        reading.q_WS = Quaternion(X_WS.R);
        reading.omega_S = R_SW * link.omega;
        const Vector3 gained = link.twistAt(X_WS.p).linear - start_[i].velocity;
        reading.specific_force_S = R_SW * (gained / model.settings.step - model.settings.gravity);
        break;
    }
    addNoise(static_cast<int>(i), reading);
    readings_[i] = reading;
  }
}

void Sensors::clear() noexcept { std::fill(readings_.begin(), readings_.end(), SensorReading{}); }

Wrench Sensors::contactsOn(const Plan& plan, const ContactReports& contacts, const Vector3& about) const noexcept {
  Wrench sum;
  for (int i = 0; i < contacts.count(); ++i) {
    const ContactReport& contact = contacts.listed(i);
    const Side a = plan.side[contact.shape_a], b = plan.side[contact.shape_b];
    if (!((a == kOwn && b == kPartner) || (a == kPartner && b == kOwn))) continue;
    const Wrench F_B = contact.F_BP_W.shifted(about - contact.X_WP.p);
    sum += b == kOwn ? F_B : -F_B;
  }
  return sum;
}

/// Hands that pull, applied wrenches and force elements: a hand that prescribes a motion holds a free body, which hangs on no joint.
Wrench Sensors::handsOn(const Model& model, const Plan& plan, const State& state, const Placement& placement,
                        const Vector3& about) const noexcept {
  Wrench sum;
  const auto add = [&](int link, const Wrench& F_W, const Vector3& at, const Pull& last) {
    const int tree = model.links[link].articulation;
    const Wrench now = F_W.shifted(about - at), before = last.F_W.shifted(about - last.at);
    // What flows takes the mean of the force before and after, of trees with laws the force before.
    const double share = state.mode[tree] == TreeMode::kImplicit ? 1 : model.trees[tree].has_laws ? 0 : 0.5;
    sum += now * share + before * (1 - share);
  };
  for (std::size_t p = 0; p < pulls_.size(); ++p) {
    const PointerState& pointer = state.pointers[p];
    if (model.holds(static_cast<int>(p)) || !pointer.targeted || !plan.own[pointer.link]) continue;
    add(pointer.link, -pointer.F_W, pulledAt(model, state, placement, static_cast<int>(p)), pulls_[p]);
  }
  for (int i = 0; i < state.wrench_count; ++i) {
    const AppliedWrench& applied = state.wrenches[i];
    const LinkWork& link = placement.link[applied.link];
    if (plan.own[applied.link]) add(applied.link, wrenchInWorld(applied.wrench, link), link.X_WL * applied.wrench.p_L, pushes_[i]);
  }
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const ModelForce& force = model.forces[i];
    const LinkForce now = forceNow(model, force, placement.link.data()), &before = forces_[i];
    if (plan.own[force.link_b]) add(force.link_b, now.onB(), now.p_WB, {before.onB(), before.p_WB});
    if (force.link_a >= 0 && plan.own[force.link_a]) add(force.link_a, -now.onB(), now.p_WA, {-before.onB(), before.p_WA});
  }
  return sum;
}

Wrench Sensors::throughJoint(const Model& model, int i, const State& state, const Placement& placement, const ContactReports& contacts,
                             const Vector3& about) const noexcept {
  const Plan& plan = plans_[i];
  const double h = model.settings.step;
  const Motion before = start_[i].motion.movedTo(about, plan.mass);
  const Motion after = motionOf(model, i, placement, about);
  const Vector3& g = model.settings.gravity;
  const Wrench weight{0.5 * (before.first + after.first).cross(g), plan.mass * g};
  const Wrench needed{(after.angular - before.angular) / h, (after.linear - before.linear) / h};
  return needed - weight - contactsOn(plan, contacts, about) - handsOn(model, plan, state, placement, about);
}

void Sensors::addNoise(int i, SensorReading& reading) const noexcept {
  const SensorDef& def = defs_[i];
  const std::uint64_t key = plans_[i].key, step = reading.step;
  reading.F_S.torque += noise(def.noise_torque, key, step, 0);
  reading.F_S.force += noise(def.noise_force, key, step, 3);
  reading.omega_S += noise(def.noise_rate, key, step, 6);
  reading.specific_force_S += noise(def.noise_specific_force, key, step, 9);
  if (def.noise_orientation > 0) {
    reading.q_WS = reading.q_WS * rotationFromVector(noise(def.noise_orientation, key, step, 12));
  }
}

}  // namespace haptic
