#include "haptic_core/world/hand_bound.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/world/hands.h"

namespace haptic {
namespace {

/// A contact keeps this share of its law however little a hand bears: a force of nothing leaves a solve without a spring.
constexpr double kLeastShare = 1e-6;

Matrix3 metStiffness(const Model& model, const State& state, const Placement& placement, int link) noexcept {
  Matrix3 met = Matrix3::Zero();
  for (int i = 0; i < state.pair_count; ++i) {
    const ActivePair& pair = state.pairs[i];
    const int a = pair.shapeA(), b = pair.shapeB();
    if (pair.friction.touching == 0 || (model.shapes[a].link != link && model.shapes[b].link != link)) continue;
    const ModelShape& A = model.shapes[a];  // its place in W follows its link's within a step, and not at the end of an implicit one
    const Vector3 n_W = placement.link[A.link].X_WL.R * (A.X_LS.R * pair.friction.normal_A);
    met += model.law(a, b, false, false).material.stiffness * pair.friction.area * n_W * n_W.transpose();
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

void weaken(double& stiffness, double& damping, double bound, double most_damping) noexcept {
  const double share = std::min(1.0, std::max(kLeastShare, bound / stiffness));
  stiffness *= share;
  damping = std::min(share * damping, most_damping * bound);
}

PointerCoupling weakened(PointerCoupling coupling, const PointerBound& bound, double h) noexcept {
  const double most_damping = mostDamping(bound, h);
  weaken(coupling.stiffness, coupling.damping, bound.stiffness, most_damping);
  weaken(coupling.rotational_stiffness, coupling.rotational_damping, bound.turn_of_way * bound.stiffness, most_damping);
  return coupling;
}

}  // namespace

void boundHands(const Model& model, const State& state, const Placement& placement, HandWork& hands) noexcept {
  for (const int i : hands.acting) {
    HandBound& bound = hands.bound[i];
    if (!model.holds(i)) {
      hands.coupling[i] = weakened(hands.own_coupling[i], bound, model.settings.step);
    } else if (!std::isinf(bound.stiffness)) {
      bound.met_W = metStiffness(model, state, placement, state.pointers[i].link);
    }
  }
}

void boundLaw(const HandBound& bound, double period, const FrictionMemory& before, const Matrix3& R_WA, const Vector3& arm_W,
              const ContactVolume& contact, PairLaw& law) noexcept {
  if (std::isinf(bound.stiffness)) return;
  ContactMaterial& m = law.material;
  const Vector3 n_W = R_WA * contact.normal();
  const double along = before.touching != 0 ? n_W.dot(R_WA * before.normal_A) : 0;
  const double others = n_W.dot(bound.met_W * n_W) - m.stiffness * before.area * along * along;
  // A push beside the origin turns the hand as well, and is as much stiffer to it.
  const double own = m.stiffness * contact.A0 * (1 + arm_W.cross(n_W).squaredNorm() / bound.turn_of_way);
  const double met = own + std::max(0.0, others);
  const double area = layerArea(contact), lever = 1 + arm_W.squaredNorm() / bound.turn_of_way;
  // Friction's springs add up whatever the normals: each neighbour's is taken as stiff against k A0 as this one's.
  const double neighbours = std::max(0.0, bound.met_W.trace() - (before.touching != 0 ? m.stiffness * before.area : 0.0));
  const double rubbed = m.tangential_stiffness * area * lever + m.tangential_stiffness / m.stiffness * neighbours;
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
  if (m.damping * area > most) m.damping = most / area;
  if (m.dissipation * m.stiffness * contact.volume > most) m.dissipation = most / (m.stiffness * contact.volume);
}

double stiffnessMet(const Model& model, const State& state, const Placement& placement, const HandWork& hands,
                    int pointer) noexcept {
  if (!model.holds(pointer)) return hands.own_coupling[pointer].stiffness;
  return largest(metStiffness(model, state, placement, state.pointers[pointer].link));
}

}  // namespace haptic
