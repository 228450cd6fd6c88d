#include "haptic_core/contact/friction.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {
namespace {

/// r_τ over the radius of gyration of the pressure: ⅔ R over R/√2 for uniform pressure on a disc of radius R.
constexpr double kTorsionRadius = 2.0 / 3.0 * M_SQRT2;

/// Turn of B on A from which an anchor is set anew [rad]: over surfaces that are neither flat nor round the patch's way then misses a
/// share of the turn's square. At 1e-4 the anchor of a body that a hand rocks by as much is set anew at every turn, and the body wanders by
/// a quarter of a millimetre.
constexpr double kMostTurn = 1e-3;

/// Force and torque of friction, or slip and twist.
struct Planar {
  Vector2 force = Vector2::Zero();
  double torque = 0;
  Planar operator-(const Planar& o) const { return {force - o.force, torque - o.torque}; }
  Planar operator+(const Planar& o) const { return {force + o.force, torque + o.torque}; }
  Planar operator*(double s) const { return {s * force, s * torque}; }
  double dot(const Planar& o) const { return force.dot(o.force) + torque * o.torque; }
};

/// The elastic layer under the patch.
struct Layer {
  double A0, J, k, b;
  Planar force(const Planar& slip, const Planar& rate) const {
    return {-A0 * (k * slip.force + b * rate.force), -J * (k * slip.torque + b * rate.torque)};
  }
  Planar slipFor(const Planar& f) const { return {-f.force / (A0 * k), J > 0 ? -f.torque / (J * k) : 0.0}; }
};

/// Forces that stick: (|f|/F)² + (τ/T)² ≤ 1.
struct LimitEllipsoid {
  double F, T;
  double load(const Planar& f) const {
    const double torsion = T > 0 ? f.torque / T : 0.0;
    return std::sqrt(f.force.squaredNorm() / (F * F) + torsion * torsion);
  }
  /// The larger of force and torque, as a share of its axis.
  double largestShare(const Planar& f) const {
    return std::max(f.force.norm() / F, T > 0 ? std::abs(f.torque) / T : 0.0);
  }
  /// Friction on a patch that slips by `slip`: the point of the surface whose normal is -slip.
  Planar against(const Planar& slip) const {
    const double size = std::sqrt(F * F * slip.force.squaredNorm() + T * T * slip.torque * slip.torque);
    if (size == 0) return {};
    return {-F * F / size * slip.force, -T * T / size * slip.torque};
  }
};

/// The nearest force that the limit allows, and how it follows the trial force.
struct Returned {
  Planar force;
  double straight = 1, turning = 1;  ///< shares of the trial that are left: of the force, of the torque
  bool outside = false;
};

/// Minimises (f - trial)ᵀ L⁻¹ (f - trial), L = diag(A0, A0, J), over the ellipsoid. f = (1 + λ L Q)⁻¹ trial with
/// Q = diag(F⁻², F⁻², T⁻²). With s² = fᵀ Q f, λ ≥ 0 is the root of 1/s(λ) = 1, a rising concave function that is linear
/// where the trial does not turn: Newton comes from one side, in a few steps however far outside the trial lies (Moré,
/// Sorensen, Computing a trust region step, 1983).
Returned nearest(const Planar& trial, const LimitEllipsoid& limit, const Layer& layer) {
  constexpr int kMostIterations = 30;  // 2–5 in practice
  const bool turns = limit.T > 0 && layer.J > 0;
  const double a = layer.A0 / (limit.F * limit.F), b = turns ? layer.J / (limit.T * limit.T) : 0.0;  // of L Q
  const double p = trial.force.squaredNorm() / (limit.F * limit.F), r = turns ? trial.torque * trial.torque / (limit.T * limit.T) : 0.0;
  Returned out{{trial.force, turns ? trial.torque : 0.0}};
  double square = p + r;
  out.outside = square > 1;
  if (!out.outside) return out;
  double lambda = square * (std::sqrt(square) - 1) / (p * a + r * b);
  for (int i = 0; i < kMostIterations; ++i) {
    out.straight = 1 / (1 + lambda * a);
    out.turning = 1 / (1 + lambda * b);
    const double p_left = p * out.straight * out.straight, r_left = r * out.turning * out.turning;
    square = p_left + r_left;
    const double beyond = square - 1;
    if (beyond <= 1e-14) break;
    // Near the limit (s² - 1)/((s² + 3)/2) is s - 1 to the third order, never more, and needs no root.
    const double s_1 = square > 2 ? std::sqrt(square) - 1 : 2 * beyond / (square + 3);
    lambda += square * s_1 / (p_left * a * out.straight + r_left * b * out.turning);
  }
  out.force = {out.straight * trial.force, turns ? out.turning * trial.torque : 0.0};
  return out;
}

/// How the force that was returned answers a change of slip: see FrictionForce.
Matrix3 compliantArea(const Returned& returned, const LimitEllipsoid& limit, const Layer& layer) {
  const bool turns = limit.T > 0 && layer.J > 0;
  const Vector3 left(returned.straight * layer.A0, returned.straight * layer.A0, turns ? returned.turning * layer.J : 0.0);
  Matrix3 area = left.asDiagonal();
  if (!returned.outside) return area;
  const double q = 1 / (limit.F * limit.F);
  const Vector3 normal(q * returned.force.force.x(), q * returned.force.force.y(),
                       turns ? returned.force.torque / (limit.T * limit.T) : 0.0);
  const Vector3 along = left.cwiseProduct(normal);
  return area - along * (along / normal.dot(along)).transpose();
}

/// Slip and twist that a layer holds at another pose when nothing yields.
struct Displaced {
  Vector3 slip_A;
  double twist;
  bool turned;  ///< by kMostTurn or more, about any axis
};

/// Length of an arc over that of its chord, less 1, where the normal at its ends differs by `turned`: asin(σ)/σ - 1, σ = |turned|/2.
double arcBeyondChord(const Vector3& turned) {
  const double sine2 = 0.25 * turned.squaredNorm();
  return sine2 * (1.0 / 6 + sine2 * (3.0 / 40));
}

/// The patch's way over A less its way over B, of which B slips on A: as it moves within a step or rolls over both. With E the
/// motion since the anchor, of A's axes and points, the patch's chord on B is seen from half of E's rotation, so that a body that
/// rolls forth and back returns; and arcs are as long as their chord and the normals at their ends make them: exact for flat and
/// round surfaces.
Displaced displacedFrom(const FrictionAnchor& anchor, const Matrix3& E, const SharedTurn& turn, const Pose& X_AB, const Pose& X_AP) {
  const double w = turn.halfCosine();
  const Vector3 &u = turn.halfAxis(), n = X_AP.R.col(2);
  const Vector3 shift = X_AB.p - E * anchor.X_AB.p, way = X_AP.p - anchor.point_A;
  const Vector3 chords = u.cross(X_AP.p + anchor.point_A - shift) + shift + u.cross(u.cross(shift - way)) / (1 + w);
  const Vector3 slip = chords + arcBeyondChord(n - anchor.normal_A) * way - arcBeyondChord(n - E * anchor.normal_A) * (way - chords);
  const double sine2 = u.squaredNorm();
  const double stretch = sine2 < 1e-6 ? 2 + sine2 / 3 : 2 * elementary::atan2(std::sqrt(sine2), w) / std::sqrt(sine2);
  // The slip of the anchor goes with both bodies, and then turns with n.
  const Vector3 n0 = turn.toA(anchor.normal_A), before = turn.toA(anchor.slip_A);
  const Vector3 held = before - n.dot(before) / std::max(1.0, 1 + n.dot(n0)) * (n + n0);
  return {held + turn.halfway(slip), anchor.twist + stretch * u.dot(n), 4 * sine2 >= kMostTurn * kMostTurn};
}

/// How points of a surface move while it has this rate in the plane of the patch: steadily, so about one axis.
Pose surfaceMotion(const Vector3& rate, double time, const Pose& X_AP) {
  const Vector3 straight = X_AP.R.leftCols<2>() * (time * rate.head<2>());
  if (rate.z() == 0) return Pose(straight);  // exactly without a turn, however often
  const Vector3 n = X_AP.R.col(2);
  const double half = 0.5 * time * rate.z();
  const Matrix3 R = rotationAbout(n, 2 * half);
  const Vector3 chord = half == 0 ? straight : Vector3(elementary::sin(half) / half * (rotationAbout(n, half) * straight));
  return {R, X_AP.p - R * X_AP.p + chord};
}

}  // namespace

Matrix3 carryMemory(const BeltRates& belts, double run, const Pose& X_AB, const Pose& X_AP, FrictionMemory& memory) noexcept {
  if (memory.touching == 0 || !belts.any()) return Matrix3::Identity();
  FrictionAnchor& anchor = memory.anchor;
  if (!belts.b.isZero(0)) anchor.X_AB = anchor.X_AB * (X_AB.inverse() * (surfaceMotion(belts.b, -run, X_AP) * X_AB));
  if (belts.a.isZero(0)) return Matrix3::Identity();
  const Pose of_A = surfaceMotion(belts.a, run, X_AP);
  anchor.X_AB = of_A * anchor.X_AB;
  anchor.point_A = of_A * anchor.point_A;
  for (Vector3* v : {&anchor.normal_A, &anchor.slip_A, &memory.normal_A, &memory.slip_M, &memory.rate_M, &memory.force_M}) *v = of_A.R * *v;
  return of_A.R;
}

SharedTurn::SharedTurn(const Matrix3& E) {
  const Quaternion turn(E);
  const double sign = turn.w() < 0 ? -1 : 1;
  w_ = sign * turn.w();
  u_ = sign * turn.vec();
}

Vector3 SharedTurn::halfway(const Vector3& v) const {
  const double cosine = std::sqrt(0.5 * (1 + w_));  // of a quarter of the angle
  return turned(v, u_ / (2 * cosine), cosine);
}

Vector3 FrictionLayer::strain(const Vector3& rate, double time) const noexcept {
  return stiffness * (before + time * rate) + damping * (rate + rest);
}

FrictionLayer::Hold FrictionLayer::hold(const Vector3& rate, double time, double N) const noexcept {
  Hold out;
  if (!(N > 0) || !(area.x() > 0) || !(mu > 0)) return out;
  if (dragged) {
    out.force = N * offset;
    out.outside = true;
    return out;
  }
  out.force = -area.cwiseProduct(strain(rate, time));
  if (!limited) return out;
  const Vector3 from = out.force - N * offset;
  const Returned returned = nearest({from.head<2>(), from.z()}, {mu * N, mu * N * radius}, {area.x(), area.z(), stiffness, damping});
  out.outside = returned.outside;
  if (!out.outside) return out;
  out.force << returned.force.force, returned.force.torque;
  out.force += N * offset;
  out.straight = returned.straight;
  out.turning = returned.turning;
  return out;
}

Matrix3 FrictionLayer::compliantArea(const Hold& held, double N) const noexcept {
  if (!(N > 0) || !(area.x() > 0) || !(mu > 0)) return Matrix3::Zero();
  if (!held.outside) return area.asDiagonal();
  if (dragged) return Matrix3::Zero();
  const Vector3 returned = held.force - N * offset;
  return haptic::compliantArea({{returned.head<2>(), returned.z()}, held.straight, held.turning, true}, {mu * N, mu * N * radius},
                               {area.x(), area.z(), stiffness, damping});
}

Vector3 FrictionLayer::perLoad(const Hold& held, const Vector3& rate, double time, double N) const noexcept {
  if (!held.outside) return Vector3::Zero();
  return (held.force + compliantArea(held, N) * strain(rate, time)) / N;
}

Vector3 FrictionLayer::slip(const Hold& held, const Vector3& rate, double time, double N) const noexcept {
  if (!(N > 0) || !(area.x() > 0) || !(mu > 0)) return Vector3::Zero();
  if (!held.outside) return before + time * rate;
  // Slip in the springs once the limit has cut the force: f = -L (k s + b ((s - before)/time + w)).
  if (!(time > 0)) return before;
  const double viscous = damping / (lag > 0 ? lag : time), stiff = 1 / (stiffness + viscous);
  Vector3 slip = viscous * before - damping * rest;
  for (int i = 0; i < 3; ++i) slip[i] = area[i] > 0 ? stiff * (slip[i] - held.force[i] / area[i]) : 0.0;
  return slip;
}

double FrictionLayer::load(const Hold& held, double N) const noexcept {
  if (!(N > 0) || !(area.x() > 0) || !(mu > 0)) return 0;
  return held.outside ? 1 : LimitEllipsoid{mu * N, mu * N * radius}.load({held.force.head<2>(), held.force.z()});
}

double tangentialDamping(const PairLaw& law, double area) noexcept {
  const ContactMaterial& m = law.material;
  return m.tangential_damping >= 0 ? m.tangential_damping
                                   : 2 * std::sqrt(m.tangential_stiffness * law.reduced_mass / area);
}

double layerArea(const ContactVolume& contact) noexcept {
  return contact.depth > 0 ? std::max(contact.A0, 0.5 * contact.volume / contact.depth) : contact.A0;
}

double torsionArea(const ContactVolume& contact) noexcept {
  return std::max(0.0, contact.A2.trace() - contact.A1.squaredNorm() / contact.A0);
}

namespace {

/// One evaluation: its arguments, and the values that its stages hand on.
class Evaluation {
 public:
  Evaluation(const ContactVolume& contact, ContactWorkspace& workspace, const NormalPressure& normal, const PairLaw& law,
             const FrictionMemory& memory, const Advance& advance)
      : contact_(contact), workspace_(workspace), normal_(normal), law_(law), memory_(memory), advance_(advance),
        R_PA_(contact.X_AP.R.transpose()), fresh_(memory.touching == 0), slid_(memory.sliding > 0),
        solving_(advance.yielding != Yielding::kAtOnce) {
    const double area = layerArea(contact);
    layer_ = {area, law.torsion ? torsionArea(contact) : 0.0, law.material.tangential_stiffness, tangentialDamping(law, area)};
    const double gyration2 = contact.volume > 0 ? contact.V2.trace() / contact.volume : layer_.J / layer_.A0;
    torsion_radius_ = layer_.J > 0 ? kTorsionRadius * std::sqrt(std::max(0.0, gyration2)) : 0.0;
  }

  /// The slip without any yielding, and its anchor: into `trial`, `renewed`.
  void load(const Pose& X_AB, const Twist& V, FrictionForce& out);
  /// The layer that a solve may evaluate at other rates: into `layer`, but for its offset.
  void keepLayer(FrictionForce& out) const;
  /// The share of the trial force that the limit allows: into everything else.
  void yield(FrictionForce& out);

 private:
  LimitEllipsoid limit(double mu) const { return {mu * normal_.force, mu * normal_.force * torsion_radius_}; }
  /// Upper bound over all pressures of this force and radius of gyration [N, N·m].
  LimitEllipsoid mostOfPressure(double mu) const {
    return {mu * normal_.force, mu * normal_.force * torsion_radius_ / kTorsionRadius};
  }
  /// Slip of the springs under a force after a step in which the dampers held the rest: -f = A (k s + b (s - s0)/h). Springs that
  /// held all of it would have energy that no motion has put there. Without a step there is no motion.
  Planar heldBy(const Planar& f) const {
    if (!(advance_.time > 0)) return before_;
    const double viscous = layer_.b / (layer_.k * advance_.lag());
    return (layer_.slipFor(f) + before_ * viscous) * (1 / (1 + viscous));
  }
  bool isDragged() const { return slid_ && advance_.yielding == Yielding::kDragged; }
  Planar standOff(double mu, const Planar& held, FrictionForce& out) const;
  void bringBack(const Planar& held, FrictionForce& out);

  const ContactVolume& contact_;
  ContactWorkspace& workspace_;
  const NormalPressure& normal_;
  const PairLaw& law_;
  const FrictionMemory& memory_;
  const Advance& advance_;
  const Matrix3 R_PA_;
  const bool fresh_, slid_, solving_;
  Layer layer_;
  double torsion_radius_ = 0;
  Planar rate_, old_rate_, before_, slip_;
  Planar seen_;           ///< rate, by the damper
  Planar trial_, force_;  ///< force before and after yielding
  bool slides_ = false;
};

void Evaluation::load(const Pose& X_AB, const Twist& V, FrictionForce& out) {
  const bool torsion = law_.torsion;  // a law that does not resist a twist must not remember one
  rate_ = {V.linear.head<2>(), torsion ? V.angular.z() : 0.0};
  const Matrix3 E = fresh_ ? Matrix3(Matrix3::Identity()) : X_AB.R * memory_.anchor.X_AB.R.transpose();
  if (!fresh_) out.since = SharedTurn(E);
  old_rate_ = fresh_ ? rate_ : Planar{(R_PA_ * out.since.toA(memory_.rate_M)).head<2>(), torsion ? memory_.spin : 0.0};
  before_ = fresh_ ? Planar{} : Planar{(R_PA_ * out.since.toA(memory_.slip_M)).head<2>(), torsion ? memory_.twist : 0.0};
  // New area is unstrained: the mean slip falls as the area grows. With yesterday's slip on today's area springs would gain energy that no
  // motion has put there, and give it to the bodies. Area that leaves takes its energy along.
  const auto kept = [](double area, double now) { return area < now ? area / now : 1.0; };
  if (!fresh_) {
    out.spread << (1 - kept(memory_.area, layer_.A0)) * before_.force, (1 - kept(memory_.torsion, layer_.J)) * before_.torque;
    before_ = before_ - Planar{out.spread.head<2>(), out.spread.z()};
  }
  slip_ = before_ + rate_ * advance_.time;  // where nothing was, or nothing moves
  out.renewed = fresh_ || (slid_ && solving_);
  seen_ = rate_;
  // What slides in a solve holds what slides, wherever it began: there the way is the rate's, which the solve is linear in.
  if (!out.renewed && advance_.time > 0) {
    const Displaced now = displacedFrom(memory_.anchor, E, out.since, X_AB, contact_.X_AP);
    slip_ = {(R_PA_ * now.slip_A).head<2>() - out.spread.head<2>(), torsion ? now.twist - out.spread.z() : 0.0};
    out.renewed = now.turned;
    if (advance_.mean_rate) seen_ = (slip_ - before_) * (1 / advance_.time);
  }
  out.trial.slip_A = contact_.X_AP.R.leftCols<2>() * slip_.force;
  out.trial.twist = slip_.torque;
  trial_ = layer_.force(slip_, seen_);
}

void Evaluation::keepLayer(FrictionForce& out) const {
  if (!solving_) return;
  FrictionLayer& l = out.layer;
  l.area << layer_.A0, layer_.A0, layer_.J;
  l.stiffness = layer_.k;
  l.damping = layer_.b;
  l.before << slip_.force - advance_.time * rate_.force, slip_.torque - advance_.time * rate_.torque;
  l.rest << seen_.force - rate_.force, seen_.torque - rate_.torque;
  l.radius = torsion_radius_;
  l.mu = slid_ ? law_.material.mu_dynamic : law_.material.mu_static;
  l.slid = slid_;
  l.limited = slid_ || advance_.yielding != Yielding::kNever;
  l.dragged = isDragged();
  l.lag = out.renewed ? advance_.since : 0;
}

/// Where the area integral stands off the ellipsoid, for the direction of slip. Within a solve the direction is that of the
/// step before, so that it does not turn over with the iterates. It is that of the pressing part: while clipped patches had no such
/// force in a solve, implicit steps of a cube that slides and spins at 1e8 N/m³ converged with h to a motion that is off by .25 mm in
/// half a second. Where a damper beside the spring is clipped its field is not the pressure, and what pulls there would be friction beyond
/// μ N, up to thousands of times where it turns fast: it counts as far as a pressure could give it, |f| ≤ μ N and |τ| ≤ μ N r of
/// gyration, and in a solve not at all.
Planar Evaluation::standOff(double mu, const Planar& held, FrictionForce& out) const {
  const Planar slipped = solving_ ? old_rate_ : layer_.slipFor(trial_ - held), on_ellipsoid = limit(mu).against(slipped);
  const bool unknown = normal_.clipped && jumpsAtTouch(law_.pressure);
  Planar f = on_ellipsoid;
  if (!(solving_ && unknown)) {
    const SlidingIntegral s = slidingIntegral(workspace_, contact_, normal_.field, normal_.moments(contact_), slipped.force, slipped.torque,
                                              normal_.radius, normal_.clipped && !unknown);
    f = Planar{-mu * s.force, law_.torsion ? -mu * s.torque : 0.0};
    if (unknown) f = f * (1 / std::max(1.0, mostOfPressure(mu).largestShare(f)));
  }
  const Planar offset = f - on_ellipsoid, stand = out.layer.dragged ? f : offset;
  out.layer.offset << stand.force / normal_.force, stand.torque / normal_.force;
  return out.layer.dragged ? f : offset;
}

/// The trial force brought back to the limit, where it slides or may.
void Evaluation::bringBack(const Planar& held, FrictionForce& out) {
  const bool keeps = solving_ && !slid_;
  const double mu = keeps ? law_.material.mu_static : law_.material.mu_dynamic;
  const Planar stand = keeps ? Planar{} : standOff(mu, held, out);
  if (isDragged()) {
    force_ = stand;
    slip_ = heldBy(force_);
    out.load = 1;
    out.compliant_area.setZero();
    return;
  }
  const Returned returned = nearest(trial_ - stand, limit(mu), layer_);
  if (!slid_ || returned.outside) {
    force_ = stand + returned.force;
    slip_ = heldBy(force_);
    out.load = 1;
    out.compliant_area = compliantArea(returned, limit(mu), layer_);
    return;
  }
  slides_ = !solving_ && trial_.dot(rate_) < 0;
}

void Evaluation::yield(FrictionForce& out) {
  const ContactMaterial& m = law_.material;
  const LimitEllipsoid now = limit(slid_ ? m.mu_dynamic : m.mu_static);
  out.load = now.load(trial_);
  out.compliant_area.diagonal() << layer_.A0, layer_.A0, layer_.J;
  // Force of the springs on the limit surface: that of the last slip, or the trial force brought back to the surface.
  const Planar held = slid_ ? layer_.force(before_, {}) : trial_ * (1 / std::max(1.0, out.load));
  slides_ = slid_ || (advance_.yielding != Yielding::kNever && out.load > 1);
  force_ = trial_;
  if (slides_) bringBack(held, out);
  out.renewed = out.renewed || slides_;
  out.force = force_.force;
  out.torque = force_.torque;
  out.slip = slip_.force;
  out.twist = slip_.torque;
  out.sliding = slides_;
}

}  // namespace

FrictionForce frictionForce(const ContactVolume& contact, const Pose& X_AB, ContactWorkspace& workspace,
                            const NormalPressure& normal, const Twist& V, const FrictionMemory& memory,
                            const PairLaw& law, const Advance& advance) noexcept {
  FrictionForce out;
  out.trial = {X_AB, contact.X_AP.p, contact.X_AP.R.col(2), Vector3::Zero(), 0};
  out.renewed = true;  // what holds nothing begins anew
  if (contact.A0 <= 0 || law.material.mu_static <= 0) return out;
  const bool solving = advance.yielding != Yielding::kAtOnce;
  if (normal.force <= 0 && !solving) return out;
  Evaluation evaluation(contact, workspace, normal, law, memory, advance);
  evaluation.load(X_AB, V, out);
  evaluation.keepLayer(out);
  if (normal.force > 0) {
    evaluation.yield(out);
  } else {
    out.renewed = true;
  }
  return out;
}

}  // namespace haptic
