#include "haptic_core/world/held_proxy.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/work.h"

namespace haptic {
namespace {

/// Weight of a row over the inverse of its mobility [1]: rows are kept to 1e-8 of the way held back, a nanometre of 0.1 m, and in the
/// second pass to the square of that; 6×6 systems are solved to as much.
constexpr double kRowWeight = 1e8;
/// Newton steps; a handful of contacts takes two to four.
constexpr int kRounds = 30;
/// Motions that differ by less, over the way wanted, are the same [1].
constexpr double kSettled = 1e-9;
/// Share of the room that a link may use up in a step [1]: at a bound it slows down over some steps, and its damper's force with it. All
/// of it at once, and a ball at 0.3 m/s lost 3 N in a tick.
constexpr double kApproach = 0.3;
/// Share of its excess depth by which a link comes out in a step [1]: within 50 steps. Its bound moves when another piece begins to
/// touch and the depth is the whole body's: at once, and the link was thrown out, sank again and hummed.
constexpr double kOut = 0.02;
constexpr double kRhoPerReach = 10;  ///< ρ over the link's reach [1]: less, and a tool turns under the hand before it stays behind
/// Stiffness bound over k times the largest section from which a contact counts as unweakened; above 1, η falls by then [1].
constexpr double kUnweakened = 1.1;
/// A body of extent H has no section larger than 3 Vol/H: a cone's.
constexpr double kConeSection = 3;

/// The extent of a shape along a unit vector of W [m]; infinite for a half-space.
double extent(const ConvexShape& shape, const Pose& X_WS, const Vector3& n_W) noexcept {
  if (!shape.bounded()) return INFINITY;
  return supportHeight(shape, X_WS, n_W) + supportHeight(shape, X_WS, -n_W);
}

/// M = diag(ρ² 1, 1).
Matrix6 inertiaOf(double rho) noexcept {
  Matrix6 M = Matrix6::Identity();
  M.topLeftCorner<3, 3>() *= rho * rho;
  return M;
}

/// Scales spring and damper so that their present force stays within `most`.
void saturate(double& stiffness, double& damping, double given, double most) noexcept {
  if (!(given > most)) return;
  stiffness *= most / given;
  damping *= most / given;
}

/// Share of `step` after which ½ |δ - δ*|²_M + ½ Σ w max(0, J δ - c)² is least along it: its slope, -`pull` at first, grows by
/// `metric` and, of the rows that are over there, w (J·step)² per share. Walks from row to row that begins or ends to count.
double leastAlong(LoadedVector<ProxyRow>& rows, double pull, double metric, const Vector6& step) noexcept {
  double share = 0;
  for (ProxyRow& row : rows) row.along = row.J.dot(step);
  for (int i = 0; i <= rows.size(); ++i) {
    double grows = metric, next = INFINITY;
    for (const ProxyRow& row : rows) {
      const double turn = -row.over / row.along;  // where it begins to count, or ends
      if (row.along > 0 ? turn <= share : turn > share) grows += row.weight * row.along * row.along;
      if (turn > share) next = std::min(next, turn);
    }
    if (!(pull > (next - share) * grows)) return share + pull / grows;
    pull -= (next - share) * grows;
    share = next;
  }
  return share;
}

/// A contact of a pointer's link, as the rows need it.
struct HeldContact {
  Vector3 push, arm;      ///< unit force on the link, in W; its point from the pointer's origin [m]
  Vector3 force;          ///< pressure and friction on the link, in W [N]
  double stiffness = 0;   ///< k A0 [N/m]
  double damping = 0;     ///< of the pressure [N·s/m]
  double receding = 0;    ///< depth that the other body's motion takes away in the time left [m], ≤ 0
  bool rubs = false;      ///< has friction: as stiff across as along its normal

  /// Of its point, over the link's motion.
  Eigen::Matrix<double, 3, 6> way() const noexcept {
    Eigen::Matrix<double, 3, 6> way;
    way << -crossMatrix(arm), Matrix3::Identity();
    return way;
  }
  /// Its depth, over the link's motion.
  Vector6 deeper() const noexcept { return -way().transpose() * push; }
  /// Force on the link over its motion, at `slope` [N/m].
  Eigen::Matrix<double, 3, 6> change(double slope) const noexcept {
    if (rubs) return -slope * way();
    return slope * push * deeper().transpose();
  }
};

/// Elastic slip of B against A, in W, as the last step left it [m].
Vector3 slipOf(const FrictionMemory& memory, const Matrix3& R_WA, const Matrix3& R_AB) noexcept {
  return R_WA * SharedTurn(R_AB * memory.anchor.X_AB.R.transpose()).toA(memory.slip_M);
}

/// Force or torque of all contacts on a link, linear in its motion: |now + J δ| ≤ most.
struct Load {
  Vector3 now = Vector3::Zero();                                    ///< [N] or [N·m]
  Eigen::Matrix<double, 3, 6> J = Eigen::Matrix<double, 3, 6>::Zero();
  double most = 0, pull = 0;                                        ///< pull: multiplier of its plane
};

/// How deep a contact is along its normal, and may become.
struct Depth {
  double now = 0;             ///< h [m]
  double extent = INFINITY;   ///< H of what sinks there, the lesser of the two shapes [m]
  double share = 0;           ///< η
  double room() const noexcept { return share * extent - now; }
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
  void pull(int pointer) noexcept;
  HeldGoal linkGoal(const Vector3& p_WP, const Quaternion& q_WL, const Twist& V_WP) const noexcept;
  double rhoOf(int link) const noexcept;
  bool follow(int pointer, double rho, Vector6& motion) noexcept;
  Depth depthOf(const ContactEvaluation& c, const ActivePair& pair, int own, const Vector3& in_W, double K_max) const noexcept;
  void addLoads(const PointerBound& bound) noexcept;
  bool isFree(const Vector6& motion) const noexcept;
  bool nearest(double rho, const Vector6& wanted, Vector6& motion) noexcept;
  void addRow(const Vector6& J, double room) noexcept;

  const Model& model_;
  const State& state_;
  const double left_;
  Work& work_;
  ProxyWork& proxy_;
  HeldContact contacts_[ProxyWork::kMostRows - 2];
  Load loads_[2];
  Pose X_LP_;          ///< of the pointer that is aimed
  Vector3 p_WP_;       ///< where its frame is now [m]
  int count_ = 0, load_count_ = 0;
};

/// The pairs that touch held links, copied: looking at them advances their caches, which are state.
void Aim::gather() noexcept {
  proxy_.pairs.clear();
  for (const int i : state_.pairs.awake()) {
    const ActivePair& pair = state_.pairs[i];
    if (pair.friction.touching == 0) continue;
    const int shapes[2] = {pair.shapeA(), pair.shapeB()};
    const auto by_hand = [&](int shape) {
      const int lead = work_.hands.held_by[model_.shapes[shape].link];
      return lead >= 0 && lead < static_cast<int>(model_.pointers.size());
    };
    if (!by_hand(shapes[0]) && !by_hand(shapes[1])) continue;
    proxy_.pairs.push_back(pair);
    for (const int s : shapes) proxy_.X_WS[s] = work_.placement.link[model_.shapes[s].link].X_WL * model_.shapes[s].X_LS;
  }
  Seams& seams = work_.contacts.seams;
  if (proxy_.pairs.empty() || !seams.any()) return;
  seams.find(proxy_.pairs.begin(), nullptr, proxy_.pairs.size(), proxy_.X_WS.data(), work_.contacts.workspace);
}

void Aim::addRow(const Vector6& J, double room) noexcept {
  const int row = proxy_.rows.size();
  proxy_.rows.resize(row + 1);
  proxy_.rows[row] = {J, room, 0};
}

/// Share of a room that is used up in a step: at a bound a link slows down over some steps.
double inOneStep(double room) noexcept { return room > 0 ? kApproach * room : room; }
/// Of a depth's room; a link that is deeper comes out by kOut of it.
double deeperInOneStep(double room) noexcept { return (room > 0 ? kApproach : kOut) * room; }

/// The share of a piece's back, seen along `in_W`, that other pieces of its body cover [1]: 0 where the piece ends there.
double coveredBack(const ModelShape& piece, const Pose& X_WS, const Vector3& in_W) noexcept {
  const Vector3 out_S = -(X_WS.R.transpose() * in_W);
  double covered = 0;
  for (const InnerFaces::Cover& cover : piece.inner.covers) {
    Vector3 twice = Vector3::Zero();
    for (std::size_t i = 0; i < cover.outline.size(); ++i) twice += cover.outline[i].cross(cover.outline[(i + 1) % cover.outline.size()]);
    covered += std::max(0.0, 0.5 * out_S.dot(twice));
  }
  return covered > 0 ? std::min(1.0, covered * extent(*piece.shape, X_WS, in_W) / piece.shape->volume()) : 0.0;
}

/// How deep the contact is, and may become. `in_W`: the way into the other body of the shape `own`.
Depth Aim::depthOf(const ContactEvaluation& c, const ActivePair& pair, int own, const Vector3& in_W, double K_max) const noexcept {
  const double k = model_.law(pair.shapeA(), pair.shapeB(), false, false).material.stiffness;
  const bool on_seam = c.volume.flags & ContactVolume::kOnSeam;
  const int other = pair.shapeA() == own ? pair.shapeB() : pair.shapeA();
  const auto height = [&](int s, const Vector3& along) { return supportHeight(*model_.shapes[s].shape, proxy_.X_WS[s], along); };
  // The whole's normal need not separate the two: along it they overlap by more than they are deep.
  const bool projected = model_.shapes[own].shape->bounded() && model_.shapes[other].shape->bounded() && !on_seam;
  Depth depth;
  depth.now = projected ? height(own, in_W) + height(other, -in_W) : c.volume.depth;
  depth.share = kMostSunkWeakened;
  for (const int s : {own, other}) {
    const ModelShape& piece = model_.shapes[s];
    if (!piece.shape->bounded()) continue;
    const Vector3 ahead_W = s == own ? in_W : Vector3(-in_W);
    double H = extent(*piece.shape, proxy_.X_WS[s], in_W);
    depth.share = std::max(depth.share, mostSunk(K_max, k, piece.shape->volume(), H));
    if (const double covered = on_seam ? coveredBack(piece, proxy_.X_WS[s], ahead_W) : 0; covered > 0) {
      // The body goes on behind the piece: it is as deep as its foremost piece.
      double front = -INFINITY, back = -INFINITY;
      for (std::size_t i = 0; i < model_.shapes.size(); ++i) {
        if (model_.shapes[i].link != piece.link) continue;
        const Pose X_WS = work_.placement.link[piece.link].X_WL * model_.shapes[i].X_LS;
        front = std::max(front, supportHeight(*model_.shapes[i].shape, X_WS, ahead_W));
        back = std::max(back, supportHeight(*model_.shapes[i].shape, X_WS, -ahead_W));
      }
      if (s == own) depth.now += covered * (front - height(s, ahead_W));
      H += covered * (front + back - H);
    }
    depth.extent = std::min(depth.extent, H);
  }
  return depth;
}

void Aim::addContact(int index, int pointer) noexcept {
  if (count_ == ProxyWork::kMostRows - 2) return;
  ActivePair& pair = proxy_.pairs[index];
  const int link = state_.pointers[pointer].link;
  const bool is_a = model_.shapes[pair.shapeA()].link == link;
  const ContactPlaces places{work_.placement.link.data(), proxy_.X_WS.data(), work_.hands.held_by.data(),
                             work_.hands.bound.data(), work_.hands.pressed.data()};
  ContactEvaluation c;
  if (!locateContact(model_, work_.contacts.seams, index, pair, places, work_.contacts.workspace, c)) return;
  const Vector3 n_W = c.X_WP.R.col(2), in_W = is_a ? n_W : Vector3(-n_W);
  const int other = model_.shapes[is_a ? pair.shapeB() : pair.shapeA()].link;
  const ContactMaterial& m = c.law.material;
  HeldContact& contact = contacts_[count_++];
  contact.push = -in_W;
  contact.arm = c.X_WP.p - p_WP_;
  const double pressure = m.stiffness * c.volume.volume;
  const Vector3 slip = slipOf(pair.friction, proxy_.X_WS[pair.shapeA()].R, c.X_AB.R);
  contact.stiffness = m.stiffness * c.volume.A0;
  contact.rubs = m.mu_static > 0;
  contact.force = pressure * contact.push + (is_a ? 1 : -1) * m.tangential_stiffness * c.volume.A0 * slip;
  contact.damping = jumpsAtTouch(c.law.pressure) ? kindOf(c.law.pressure).damping(m) * c.volume.A0
                                                 : kindOf(c.law.pressure).damping(m) * pressure;
  const double speed = held(other) ? 0.0 : in_W.dot(work_.placement.link[other].twistAt(c.X_WP.p).linear);
  contact.receding = -std::max(0.0, speed) * left_;
  const Depth depth = depthOf(c, pair, is_a ? pair.shapeA() : pair.shapeB(), in_W, work_.hands.bound[pointer].stiffness);
  addRow(contact.deeper(), deeperInOneStep((held(other) ? 0.5 : 1.0) * (depth.room() - contact.receding)));
}

/// Of force and torque of the contacts together.
void Aim::addLoads(const PointerBound& bound) noexcept {
  const auto add = [&](double most, auto&& part) {
    if (std::isinf(most)) return;
    Load load;
    for (int i = 0; i < count_; ++i) load.now += part(contacts_[i], contacts_[i].force);
    const bool rises = load.now.norm() < most;
    for (int i = 0; i < count_; ++i) {
      const HeldContact& c = contacts_[i];
      const double slope = c.stiffness + (rises ? c.damping / left_ : 0.0);
      load.now += part(c, slope * c.receding * c.push);
      load.J += part(c, c.change(slope));
    }
    const double size = load.now.norm();
    load.most = size + inOneStep(most - size);
    loads_[load_count_++] = load;
  };
  add(bound.force, [](const HeldContact&, const auto& F) { return F.eval(); });
  add(bound.torque, [](const HeldContact& c, const auto& F) { return (crossMatrix(c.arm) * F).eval(); });
}

/// No row and no load holds it back: so it is in most ticks, and nothing needs to be solved.
bool Aim::isFree(const Vector6& motion) const noexcept {
  for (const ProxyRow& row : proxy_.rows) {
    if (row.J.dot(motion) > row.room) return false;
  }
  return std::none_of(loads_, loads_ + load_count_, [&](const Load& load) { return (load.now + load.J * motion).norm() > load.most; });
}

/// The nearest motion within rows and loads. |F + J δ| ≤ F_most is a ball: a plane in its place, and a link between two walls went
/// along it past them, hummed by 1 mm. So Newton's method on the Lagrangian: each round the planes that touch the balls where the last
/// one ended, and the balls' curvature times the pull of their planes.
bool Aim::nearest(double rho, const Vector6& wanted, Vector6& motion) noexcept {
  const Matrix6 inertia = inertiaOf(rho);
  const int flat = proxy_.rows.size();
  bool stays = false;
  motion.setZero();
  for (int round = 0; round < (load_count_ > 0 ? kRounds : 1); ++round) {
    const Vector6 before = motion;
    Matrix6 metric = inertia;
    Vector6 goal = inertia * wanted;
    proxy_.rows.resize(flat);
    for (int i = 0; i < load_count_; ++i) {
      Load& load = loads_[i];
      const Vector3 F = load.now + load.J * motion;
      const double size = F.norm();
      if (!(size > 0)) continue;
      const Vector6 along = load.J.transpose() * F / size;
      addRow(along, load.most - size + along.dot(motion));
      const Matrix6 bend = load.pull / size * (load.J.transpose() * load.J - along * along.transpose());
      metric += bend;
      goal += bend * motion;
    }
    stays = nearestMotion(proxy_.rows, metric, load_count_ > 0 ? Vector6(metric.llt().solve(goal)) : wanted, motion);
    for (int i = flat; i < proxy_.rows.size(); ++i) loads_[i - flat].pull = proxy_.rows[i].pull();
    if ((motion - before).norm() <= kSettled * wanted.norm()) break;
  }
  return stays;
}

void Aim::aim(int pointer) noexcept {
  const PointerState& target = state_.pointers[pointer];
  X_LP_ = model_.pointerFrame(pointer, target.link);
  p_WP_ = work_.placement.link[target.link].X_WL * X_LP_.p;
  HeldGoal& goal = work_.hands.goal[pointer];
  goal = linkGoal(target.p_WP, target.q_WP * Quaternion(X_LP_.R).conjugate(), target.V_WP);
  if (!model_.holds(pointer)) return pull(pointer);
  proxy_.rows.clear();
  count_ = load_count_ = 0;
  for (int index = 0; index < proxy_.pairs.size(); ++index) {
    const ActivePair& pair = proxy_.pairs[index];
    const int a = model_.shapes[pair.shapeA()].link, b = model_.shapes[pair.shapeB()].link;
    if (a == target.link || b == target.link) addContact(index, pointer);
  }
  if (count_ > 0) addLoads(work_.hands.bound[pointer]);
  const double rho = rhoOf(target.link);
  Vector6 motion;
  if (!follow(pointer, rho, motion)) return;
  // The velocity of a link that stays behind: as near to the hand's as the rows allow over the time left.
  for (int i = 0; i < proxy_.rows.size(); ++i) proxy_.rows[i].room = std::max(0.0, proxy_.rows[i].room) / left_;
  Vector6 velocity;
  if (!nearestMotion(proxy_.rows, inertiaOf(rho), target.V_WP.vector(), velocity)) return;
  goal.V_WL = Twist{velocity.head<3>(), velocity.tail<3>()}.shifted(-(goal.q_WL * X_LP_.p));
}

/// Of the link, from place and twist of the pointer's origin and the link's orientation.
HeldGoal Aim::linkGoal(const Vector3& p_WP, const Quaternion& q_WL, const Twist& V_WP) const noexcept {
  const Vector3 p_LP_W = q_WL * X_LP_.p;
  return {p_WP - p_LP_W, q_WL, V_WP.shifted(-p_LP_W)};
}

/// The goal: of the way to the target, as much as rows and loads allow. False: it is the target itself.
bool Aim::follow(int pointer, double rho, Vector6& motion) noexcept {
  const PointerState& target = state_.pointers[pointer];
  HeldGoal& goal = work_.hands.goal[pointer];
  const LinkWork& link = work_.placement.link[target.link];
  const Quaternion q_WL(link.X_WL.R);
  Vector6 wanted;
  wanted << vectorFromRotation(goal.q_WL * q_WL.conjugate()), target.p_WP - p_WP_;
  if (isFree(wanted) || !nearest(rho, wanted, motion)) return false;
  goal = linkGoal(p_WP_ + motion.tail<3>(), (rotationFromVector(motion.head<3>()) * q_WL).normalized(), target.V_WP);
  return true;
}

/// A virtual coupling pulls from the target, with the force that its hand bears at most.
void Aim::pull(int pointer) noexcept {
  const PointerState& target = state_.pointers[pointer];
  PointerCoupling& coupling = work_.hands.coupling[pointer];
  const Wrench F_W = couplingForce(coupling, X_LP_, work_.hands.goal[pointer], work_.placement.link[target.link]);
  const PointerBound& bound = work_.hands.bound[pointer];
  saturate(coupling.stiffness, coupling.damping, F_W.force.norm(), bound.force);
  saturate(coupling.rotational_stiffness, coupling.rotational_damping, F_W.torque.norm(), bound.torque);
}

double Aim::rhoOf(int l) const noexcept {
  const LinkWork& link = work_.placement.link[l];
  return kRhoPerReach * (model_.links[l].size + (link.p_WC() - p_WP_).norm());
}

}  // namespace

ProxyWork::ProxyWork(const Model& model) : X_WS(model.shapes.size()) {
  // A link has at most a pair of each of its shapes with each shape of others.
  std::vector<long> own(model.links.size(), 0);
  for (const ModelShape& shape : model.shapes) ++own[shape.link];
  const long all = static_cast<long>(model.shapes.size());
  long most = 0;
  for (const long n : own) most = std::max(most, n * (all - n));
  const long held = most * static_cast<long>(model.pointers.size());
  pairs.reserve(static_cast<int>(std::min<long>(held, model.pair_capacity)));
  rows.reserve(kMostRows);
}

double mostSunk(double bound, double k, double volume, double H) noexcept {
  const double unweakened = std::clamp((bound * H / (k * kConeSection * volume) - 1) / (kUnweakened - 1), 0.0, 1.0);
  return kMostSunkWeakened + (kMostSunk - kMostSunkWeakened) * unweakened;
}

bool nearestMotion(LoadedVector<ProxyRow>& rows, const Matrix6& metric, const Vector6& wanted, Vector6& motion) noexcept {
  const Eigen::LLT<Matrix6> yields(metric);
  double give[ProxyWork::kMostRows] = {};
  bool beyond = false;
  for (ProxyRow& row : rows) {
    const double mobility = row.J.dot(yields.solve(row.J));
    row.weight = mobility > 0 ? kRowWeight / mobility : 0.0;  // 0: no motion of the link changes it
    row.over = row.J.dot(wanted) - row.room;
    beyond = beyond || (row.weight > 0 && row.over > 0);
  }
  motion = wanted;
  // Twice: the ways that the springs of the rows give at first are then added to them.
  for (int pass = 0; beyond && pass < 2; ++pass) {
    for (int i = 0; i < rows.size(); ++i) rows[i].over += give[i] = pass > 0 ? std::max(0.0, rows[i].over) : 0.0;
    bool settled = false;
    for (int round = 0; !settled && round < kRounds; ++round) {
      Matrix6 A = metric;
      Vector6 pull = metric * (wanted - motion);
      for (const ProxyRow& row : rows) {
        if (!(row.over > 0)) continue;
        A += row.weight * row.J * row.J.transpose();
        pull -= row.weight * row.over * row.J;
      }
      const Vector6 step = A.llt().solve(pull);
      const double share = leastAlong(rows, step.dot(pull), step.dot(metric * step), step);
      motion += share * step;
      settled = true;
      for (int i = 0; i < rows.size(); ++i) {
        const bool was_over = rows[i].over > 0;
        rows[i].over = rows[i].J.dot(motion) - rows[i].room + give[i];
        settled = settled && was_over == (rows[i].over > 0);
      }
    }
  }
  return beyond;
}

void aimHeld(const Model& model, const State& state, double left, Work& work) noexcept {
  const HandWork& hands = work.hands;
  const auto follows = [&](int i) { return state.pointers[i].targeted; };
  if (std::none_of(hands.acting.begin(), hands.acting.end(), follows)) return;
  Aim aim(model, state, left, work);
  aim.gather();
  for (const int i : hands.acting) {
    if (follows(i)) aim.aim(i);
  }
}

}  // namespace haptic
