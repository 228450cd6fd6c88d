#include "haptic_core/world/held_proxy.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/shape_distance.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace {

constexpr int kSweeps = 20;
/// Share of the room that a link may use up in a step [1]: at a bound it slows down over some steps, and its damper's force with it. All
/// of it at once, and a ball at 0.3 m/s lost 3 N in a tick.
constexpr double kApproach = 0.3;
constexpr double kRhoPerReach = 10;  ///< ρ over the link's reach [1]: less, and a tool turns under the hand before it stays behind
/// Stiffness bound over k times the largest section from which a contact counts as unweakened; above 1, η falls by then [1].
constexpr double kUnweakened = 1.1;
/// A body of extent H has no section larger than 3 Vol/H: a cone's.
constexpr double kConeSection = 3;

/// The extent of a shape along a unit vector of W [m]; infinite for a half-space.
double extent(const ConvexShape& shape, const Pose& X_WS, const Vector3& n_W) noexcept {
  if (shape.halfSpace()) return INFINITY;
  return supportHeight(shape, X_WS, n_W) + supportHeight(shape, X_WS, -n_W);
}

/// A contact of a held link, as the rows need it.
struct HeldContact {
  Vector6 J;              ///< its depth over the link's motion
  Vector3 push, arm;      ///< unit force on the link, in W; its point from L's origin [m]
  double force = 0;       ///< k Vol [N]
  double stiffness = 0;   ///< k A0 [N/m]
  double damping = 0;     ///< of the pressure [N·s/m]
  double receding = 0;    ///< depth that the other body's motion takes away in the time left [m], ≤ 0
};

class Aim {
 public:
  Aim(const Model& model, const State& state, double left, Work& work)
      : model_(model), state_(state), left_(left), work_(work), proxy_(work.hands.proxy) {}

  void gather() noexcept;
  void aim(int pointer) noexcept;

 private:
  bool held(int link) const noexcept { return work_.hands.held_by[link] >= 0; }
  void addContact(int index, int pointer) noexcept;
  double room(const ContactEvaluation& c, const ActivePair& pair, int shape, double K_max) const noexcept;
  void addForceRows(const PointerBound& bound) noexcept;
  void addRow(const Vector6& J, double room) noexcept;

  const Model& model_;
  const State& state_;
  const double left_;
  Work& work_;
  ProxyWork& proxy_;
  HeldContact contacts_[ProxyWork::kMostRows - 2];
  int count_ = 0;
};

/// The pairs that touch held links, copied: looking at them advances their caches, which are state.
void Aim::gather() noexcept {
  proxy_.touching.clear();
  for (int i = 0; i < state_.pair_count; ++i) {
    const ActivePair& pair = state_.pairs[i];
    if (pair.friction.touching == 0) continue;
    const int shapes[2] = {pair.shapeA(), pair.shapeB()};
    if (!held(model_.shapes[shapes[0]].link) && !held(model_.shapes[shapes[1]].link)) continue;
    proxy_.pairs[i] = pair;
    proxy_.touching.push_back(i);
    for (const int s : shapes) proxy_.X_WS[s] = work_.placement.link[model_.shapes[s].link].X_WL * model_.shapes[s].X_LS;
  }
  Seams& seams = work_.contacts.seams;
  if (proxy_.touching.empty() || !seams.any()) return;
  seams.find(proxy_.pairs.data(), proxy_.touching.data(), static_cast<int>(proxy_.touching.size()), proxy_.X_WS.data(),
             work_.contacts.workspace);
}

void Aim::addRow(const Vector6& J, double room) noexcept {
  const int row = proxy_.rows.size();
  proxy_.rows.resize(row + 1);
  proxy_.rows[row] = {J, room > 0 ? kApproach * room : room, 0};
}

/// How much deeper the contact may go [m].
double Aim::room(const ContactEvaluation& c, const ActivePair& pair, int shape, double K_max) const noexcept {
  const Vector3 n_W = c.X_WP.R.col(2);
  const double k = model_.law(pair.shapeA(), pair.shapeB(), false, false).material.stiffness;
  double depth = c.volume.depth, least = INFINITY, share = kMostSunkWeakened;
  for (const int s : {pair.shapeA(), pair.shapeB()}) {
    const ConvexShape& solid = *model_.shapes[s].shape;
    const double H = extent(solid, proxy_.X_WS[s], n_W);
    least = std::min(least, H);
    if (!solid.halfSpace()) share = std::max(share, mostSunk(K_max, k, solid.volume(), H));
  }
  if (c.volume.flags & ContactVolume::kOnSeam) {  // the link as a whole: its foremost shape is as much deeper as it lies ahead
    const int link = model_.shapes[shape].link;
    const Vector3 in_W = pair.shapeA() == shape ? n_W : Vector3(-n_W);
    double front = -INFINITY, back = -INFINITY;
    for (std::size_t s = 0; s < model_.shapes.size(); ++s) {
      if (model_.shapes[s].link != link) continue;
      const Pose X_WS = work_.placement.link[link].X_WL * model_.shapes[s].X_LS;
      front = std::max(front, supportHeight(*model_.shapes[s].shape, X_WS, in_W));
      back = std::max(back, supportHeight(*model_.shapes[s].shape, X_WS, -in_W));
    }
    depth += front - supportHeight(*model_.shapes[shape].shape, proxy_.X_WS[shape], in_W);
    least = front + back;
  }
  return share * least - depth;
}

void Aim::addContact(int index, int pointer) noexcept {
  if (count_ == ProxyWork::kMostRows - 2) return;
  ActivePair& pair = proxy_.pairs[index];
  const int link = state_.pointers[pointer].link;
  const bool is_a = model_.shapes[pair.shapeA()].link == link;
  const ContactPlaces places{work_.placement.link.data(), proxy_.X_WS.data(), work_.hands.held_by.data(),
                             work_.hands.bound.data()};
  ContactEvaluation c;
  if (!locateContact(model_, work_.contacts.seams, index, pair, places, work_.contacts.workspace, c)) return;
  const Vector3 n_W = c.X_WP.R.col(2), in_W = is_a ? n_W : Vector3(-n_W);
  const int other = model_.shapes[is_a ? pair.shapeB() : pair.shapeA()].link;
  const ContactMaterial& m = c.law.material;
  HeldContact& contact = contacts_[count_++];
  contact.push = -in_W;
  contact.arm = c.X_WP.p - work_.placement.link[link].X_WL.p;
  contact.J << contact.arm.cross(in_W), in_W;
  contact.force = m.stiffness * c.volume.volume;
  contact.stiffness = m.stiffness * c.volume.A0;
  contact.damping = jumpsAtTouch(c.law.pressure) ? kindOf(c.law.pressure).damping(m) * c.volume.A0
                                                 : kindOf(c.law.pressure).damping(m) * contact.force;
  const double speed = held(other) ? 0.0 : in_W.dot(work_.placement.link[other].twistAt(c.X_WP.p).linear);
  contact.receding = -std::max(0.0, speed) * left_;
  const double room = this->room(c, pair, is_a ? pair.shapeA() : pair.shapeB(), work_.hands.bound[pointer].stiffness);
  addRow(contact.J, (held(other) ? 0.5 : 1.0) * (room - contact.receding));
}

void Aim::addForceRows(const PointerBound& bound) noexcept {
  if (std::isinf(bound.force) && std::isinf(bound.torque)) return;
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();
  for (int i = 0; i < count_; ++i) {
    force += contacts_[i].force * contacts_[i].push;
    torque += contacts_[i].force * contacts_[i].arm.cross(contacts_[i].push);
  }
  const auto add = [&](const Vector3& now, double most, auto&& part) {
    const double size = now.norm();
    if (!(size > 0) || std::isinf(most)) return;
    Vector6 J = Vector6::Zero();
    double room = most - size;
    for (int i = 0; i < count_; ++i) {
      const HeldContact& c = contacts_[i];
      const double share = now.dot(part(c)) / size, slope = c.stiffness + (room > 0 ? c.damping / left_ : 0.0);
      J += share * slope * c.J;
      room -= share * slope * c.receding;
    }
    addRow(J, room);
  };
  add(force, bound.force, [](const HeldContact& c) { return c.push; });
  add(torque, bound.torque, [](const HeldContact& c) { return Vector3(c.arm.cross(c.push)); });
}

void Aim::aim(int pointer) noexcept {
  const PointerState& target = state_.pointers[pointer];
  HeldGoal& goal = work_.hands.goal[pointer];
  goal = {target.p_WL, target.q_WL, target.V_WL};
  proxy_.rows.clear();
  count_ = 0;
  for (const int index : proxy_.touching) {
    const ActivePair& pair = proxy_.pairs[index];
    const int a = model_.shapes[pair.shapeA()].link, b = model_.shapes[pair.shapeB()].link;
    if (a == target.link || b == target.link) addContact(index, pointer);
  }
  if (count_ == 0) return;
  addForceRows(work_.hands.bound[pointer]);
  const LinkWork& link = work_.placement.link[target.link];
  const Quaternion q_WL(link.X_WL.R);
  const double rho = kRhoPerReach * (model_.links[target.link].size + (link.p_WC() - link.X_WL.p).norm());
  Vector6 wanted, motion;
  wanted << vectorFromRotation(target.q_WL * q_WL.conjugate()), target.p_WL - link.X_WL.p;
  if (!nearestMotion(proxy_.rows, rho, wanted, motion)) return;
  goal.p_WL = link.X_WL.p + motion.tail<3>();
  goal.q_WL = (rotationFromVector(motion.head<3>()) * q_WL).normalized();
  // The velocity of a link that stays behind: as near to the hand's as the rows allow over the time left.
  for (int i = 0; i < proxy_.rows.size(); ++i) proxy_.rows[i].room = std::max(0.0, proxy_.rows[i].room) / left_;
  Vector6 velocity;
  if (nearestMotion(proxy_.rows, rho, target.V_WL.vector(), velocity)) goal.V_WL = {velocity.head<3>(), velocity.tail<3>()};
}

}  // namespace

ProxyWork::ProxyWork(const Model& model) : pairs(model.pair_capacity), X_WS(model.shapes.size()) {
  touching.reserve(model.pair_capacity);
  rows.reserve(kMostRows);
}

double mostSunk(double bound, double k, double volume, double H) noexcept {
  const double unweakened = std::clamp((bound * H / (k * kConeSection * volume) - 1) / (kUnweakened - 1), 0.0, 1.0);
  return kMostSunkWeakened + (kMostSunk - kMostSunkWeakened) * unweakened;
}

bool nearestMotion(LoadedVector<ProxyRow>& rows, double rho, const Vector6& wanted, Vector6& motion) noexcept {
  bool any = false;
  for (int i = 0; i < rows.size(); ++i) {
    rows[i].multiplier = 0;
    any = any || rows[i].J.dot(wanted) > rows[i].room;
  }
  if (!any) return false;
  const double turn = 1 / (rho * rho);
  const auto yields = [&](const Vector6& J) {
    Vector6 y = J;
    y.head<3>() *= turn;
    return y;
  };
  motion = wanted;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int i = 0; i < rows.size(); ++i) {
      ProxyRow& row = rows[i];
      const Vector6 y = yields(row.J);
      const double mobility = row.J.dot(y);
      if (!(mobility > 0)) continue;  // nothing that the link does changes it
      const double next = std::max(0.0, row.multiplier + (row.J.dot(motion) - row.room) / mobility);
      motion -= (next - row.multiplier) * y;
      row.multiplier = next;
    }
  }
  return true;
}

void aimHeld(const Model& model, const State& state, double left, Work& work) noexcept {
  const HandWork& hands = work.hands;
  const auto follows = [&](int i) { return model.holds(i) && state.pointers[i].targeted; };
  if (std::none_of(hands.acting.begin(), hands.acting.end(), follows)) return;
  Aim aim(model, state, left, work);
  aim.gather();
  for (const int i : hands.acting) {
    if (follows(i)) aim.aim(i);
  }
}

}  // namespace haptic
