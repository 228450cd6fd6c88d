#include "haptic_core/world/hand_bound.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/world/hands.h"

namespace haptic {
namespace {

/// A contact keeps this share of its law however little a hand bears: a force of nothing leaves a solve without a spring.
constexpr double kLeastShare = 1e-6;
/// Share of the volume that two bodies may share in which a tool rests under its hand's whole force [1]. At a half a ball lies to its
/// middle in a thin plate, and gives back there what the elastic energy of its patch does not tell; less, and surfaces are stiffer.
constexpr double kShared = 0.05;

/// What a contact of unit stiffness along n, at the arm r, opposes: the root of its part of M.
Vector6 opposed(const Vector3& n_W, const Vector3& arm_W, double turn_of_way) noexcept {
  Vector6 J;
  J << arm_W.cross(n_W) / std::sqrt(turn_of_way), n_W;
  return J;
}

/// M of a pointer's link, about the point p_WP of it.
Matrix6 metStiffness(const Model& model, const State& state, const std::vector<int>& pairs, const Placement& placement, int link,
                     const Vector3& p_WP, double turn_of_way) noexcept {
  Matrix6 met = Matrix6::Zero();
  for (const int i : pairs) {
    const ActivePair& pair = state.pairs[i];
    const int a = pair.shapeA(), b = pair.shapeB();
    if (pair.friction.touching == 0 || (model.shapes[a].link != link && model.shapes[b].link != link)) continue;
    const ModelShape& A = model.shapes[a];  // its place in W follows its link's within a step, and not at the end of an implicit one
    const Pose X_WA = placement.link[A.link].X_WL * A.X_LS;
    const Vector6 J = opposed(X_WA.R * pair.friction.normal_A, X_WA * pair.friction.point_A - p_WP, turn_of_way);
    met += model.law(a, b, false, false).material.stiffness * pair.friction.area * J * J.transpose();
  }
  return met;
}

/// The largest eigenvalue m + 2 p cos φ, with m the mean, 6 p² = |A - m 1|² and 2 p³ cos 3φ = det(A - m 1) (O. K. Smith, 1961).
double largest(const Matrix3& met) noexcept {
  const double mean = met.trace() / 3;
  const Matrix3 rest = met - mean * Matrix3::Identity();
  const double p = std::sqrt(rest.squaredNorm() / 6);
  if (!(p > 0)) return std::max(0.0, mean);
  const double cosine = std::clamp(0.5 * (rest / p).determinant(), -1.0, 1.0);
  return std::max(0.0, mean + 2 * p * elementary::cos(elementary::acos(cosine) / 3));
}

/// Largest damper over K_max [s].
double mostDamping(const PointerBound& bound, double h) noexcept { return kMostDamping * std::max(bound.lag, kLeastLag * h); }

/// A spring and damper that a hand bears, K and b at most: those values where the scene leaves them to be derived. A lesser damper leaves
/// a lesser spring (1 of wall_bound.h).
void bear(double asked_stiffness, double asked_damping, double K, double b, double& stiffness, double& damping) noexcept {
  if (asked_stiffness == PointerCoupling::kDerived && std::isfinite(K)) stiffness = K;
  if (asked_damping == PointerCoupling::kDerived && std::isfinite(b)) damping = b;
  damping = std::min(damping, b);
  const double share = std::isfinite(b) && b > 0 ? damping / b : 1.0;
  stiffness = std::min(stiffness, std::max(kLeastShare, std::sqrt(share * (2 - share))) * K);
}

PointerCoupling borne(const PointerCoupling& asked, PointerCoupling own, const PointerBound& bound) noexcept {
  if (std::isinf(bound.damping)) {  // whoever moves the pointer has no port: what the scene says, up to K
    own.stiffness = std::min(own.stiffness, bound.stiffness);
    return own;
  }
  bear(asked.stiffness, asked.damping, bound.stiffness, bound.damping, own.stiffness, own.damping);
  bear(asked.rotational_stiffness, asked.rotational_damping, bound.turn_of_way * bound.stiffness, bound.turn_of_way * bound.damping,
       own.rotational_stiffness, own.rotational_damping);
  return own;
}

}  // namespace

double firmer(double force, const ConvexShape& a, const ConvexShape& b, double width_a, double width_b, double k) noexcept {
  const auto within = [](const ConvexShape& shape, double width_of_other) {
    if (!shape.bounded()) return std::numeric_limits<double>::infinity();
    return shape.volume() * std::min(1.0, width_of_other / (2 * shape.boundingRadius()));
  };
  const double carried = kShared * k * std::min(within(a, width_b), within(b, width_a));
  return carried < force ? force / carried : 1.0;
}

void firm(const Model& model, double force, int a, int b, PairLaw& law) noexcept {
  if (!(force > 0)) return;
  const ModelShape &A = model.shapes[a], &B = model.shapes[b];
  ContactMaterial& m = law.material;
  const double times = firmer(force, *A.shape, *B.shape, A.width, B.width, m.stiffness);
  m.stiffness *= times;
  m.tangential_stiffness *= times;
  m.damping *= std::sqrt(times);  // the same damping ratio
}

void boundHands(const Model& model, const State& state, const Placement& placement, HandWork& hands) noexcept {
  for (const int i : hands.acting) {
    HandBound& bound = hands.bound[i];
    if (!model.holds(i)) {
      const int link = state.pointers[i].link;
      hands.coupling[i] = borne(model.tuning.coupling[i], hands.own_coupling[i], bound);
      hands.pressed[link] = bound.press > 0 ? bound.press + model.links[link].mass * model.settings.gravity.norm() : 0.0;
    } else if (!std::isinf(bound.stiffness)) {
      const int link = state.pointers[i].link;
      const Vector3 p_WP = placement.link[link].X_WL * model.pointerFrame(i, link).p;
      bound.met_W = metStiffness(model, state, state.pairs.awake(), placement, link, p_WP, bound.turn_of_way);
    }
  }
}

void boundLaw(const HandBound& bound, double period, const FrictionMemory& before, const Matrix3& R_WA, const Vector3& arm_W,
              const ContactVolume& contact, PairLaw& law) noexcept {
  if (std::isinf(bound.stiffness)) return;
  ContactMaterial& m = law.material;
  const Vector3 n_W = R_WA * contact.normal();
  // A push beside the origin turns the hand as well, and is as much stiffer to it.
  const Vector6 J = opposed(n_W, arm_W, bound.turn_of_way);
  const double own = m.stiffness * contact.A0 * J.squaredNorm();
  double others = J.dot(bound.met_W * J) / J.squaredNorm(), rubs = bound.met_W.trace();
  if (before.touching != 0) {
    const Vector3 before_W = R_WA * before.normal_A;
    const Vector6 J_before = opposed(before_W, arm_W, bound.turn_of_way);
    const double along = J.dot(J_before);
    others -= m.stiffness * before.area * along * along / J.squaredNorm();
    rubs -= m.stiffness * before.area * J_before.squaredNorm();
  }
  const double met = own + std::max(0.0, others);
  const double area = layerArea(contact), lever = 1 + arm_W.squaredNorm() / bound.turn_of_way;
  // Friction's springs add up whatever the normals: each neighbour's is taken as stiff against k A0 as this one's.
  const double rubbed = m.tangential_stiffness * area * lever + m.tangential_stiffness / m.stiffness * std::max(0.0, rubs);
  double rub_share = rubbed > bound.stiffness ? std::max(kLeastShare, bound.stiffness / rubbed) : 1.0;
  if (met > bound.stiffness) {
    const double share = std::max(kLeastShare, bound.stiffness / met);
    m.stiffness *= share;
    m.damping *= share;
    rub_share = std::min(rub_share, share);
  }
  m.tangential_stiffness *= rub_share;
  m.tangential_damping *= rub_share;  // NaN, derived, follows the spring
  const double layer = m.stiffness * area;
  const double share = area > contact.A0 ? layer / (layer + std::max(0.0, others)) : own / met;
  const double most = mostDamping(bound, period) * bound.stiffness * share;  // [N·s/m]
  if (tangentialDamping(law, area) * area * lever > most) m.tangential_damping = most / (area * lever);
  const double most_along = most / J.squaredNorm();
  if (m.damping * area > most_along) m.damping = most_along / area;
  if (m.dissipation * m.stiffness * contact.volume > most_along) m.dissipation = most_along / (m.stiffness * contact.volume);
}

double stiffnessMet(const Model& model, const State& state, const Visits& visits, const Placement& placement, const HandWork& hands,
                    int pointer) noexcept {
  if (!model.holds(pointer)) {  // one that is left to be derived is what the hand bears
    const HandBound& bound = hands.bound[pointer];
    const bool derived = model.tuning.coupling[pointer].stiffness == PointerCoupling::kDerived && std::isfinite(bound.damping);
    return derived ? bound.stiffness : hands.own_coupling[pointer].stiffness;
  }
  const int link = state.pointers[pointer].link;
  const bool rests = visits.phase[model.links[link].articulation] != Phase::kMoves;
  const std::vector<int>& pairs = rests ? state.pairs.resting() : state.pairs.awake();
  return largest(metStiffness(model, state, pairs, placement, link, Vector3::Zero(), INFINITY).bottomRightCorner<3, 3>());
}

}  // namespace haptic
