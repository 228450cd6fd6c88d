#include "haptic_core/dynamics/tree_motion.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {
namespace {

// Newton steps that put positions on the rings [1]; each gains 3 digits or more at a turn of 0.1 rad a step.
constexpr int kNewtonSteps = 5;
// Largest change of a degree in one of them [rad, m]: further, the linear model of the gap is no guide.
constexpr double kLongestMove = 0.3;
// Newton steps for an initial state, which may be far off [1].
constexpr int kClosingSteps = 200;
// Gap at which those stop [m, rad]: a thousandth of the bound that users see (1 µm).
constexpr double kGap = 1e-10;
// Gap, and way by which velocities open it in a step, that a smooth step may leave [m, rad]: a tenth of the bound that users see. With
// kGap a rhombus that folds flat takes Euler's steps there, and loses or gains .4 % of its energy in 10 s at 30 rad/s.
constexpr double kHeld = 1e-7;

/// The inertia of one articulation, with the forces of the step's start.
class TreeInertia final : public JointOperator {
 public:
  /// `tau`: generalised forces besides, or null. Room for: `forces` and `v_dot` [nv], `response` [12 per link].
  TreeInertia(const Articulation& articulation, const Vector3& gravity, double h, const double* tau, LinkWork* work,
              double* forces, double* v_dot, double* response)
      : articulation_(articulation), gravity_(gravity), h_(h), tau_(tau), work_(work), forces_(forces), v_dot_(v_dot),
        response_(response) {}

  bool factor(const double* diag) noexcept override {
    diag_ = diag;
    return true;
  }
  void solve(const double* force, double* u) noexcept override {
    const int nv = articulation_.nv();
    for (int k = 0; k < nv; ++k) {
      forces_[k] = force[k] + (tau_ ? tau_[k] : 0);
      v_dot_[k] = u[k] / h_;  // read where it is prescribed
    }
    accelerations(articulation_, gravity_, forces_, diag_, work_, v_dot_);
    for (int k = 0; k < nv; ++k) u[k] = h_ * v_dot_[k];
  }
  void respond(const double* force, double* x) noexcept override {
    accelerationResponse(articulation_, force, work_, response_, x);
  }
  double required(int link, int row, const double*) noexcept override {
    const Wrench F = jointWrench(articulation_, work_, link, gravity_);
    const Vector3 axis = work_[link].S.col(0);
    return axis.dot(articulation_.link(link).slides ? F.force : F.torque) - (tau_ ? tau_[row] : 0);
  }

 private:
  const Articulation& articulation_;
  const Vector3 gravity_;
  const double h_;
  const double *tau_, *diag_ = nullptr;
  LinkWork* work_;
  double *forces_, *v_dot_, *response_;
};

/// Wrenches or generalised forces act.
bool isPulled(const Articulation& articulation, const LinkWork* work, const double* tau) {
  const auto acts = [](double force) { return force != 0; };
  return (tau && std::any_of(tau, tau + articulation.nv(), acts)) ||
         std::any_of(work, work + articulation.linkCount(), [](const LinkWork& link) {
           return (link.F_ext.torque.array() != 0).any() || (link.F_ext.force.array() != 0).any();
         });
}

}  // namespace

TreeMotion::TreeMotion(const Articulation& articulation, std::vector<RingDef> rings)
    : articulation_(articulation), smooth_(articulation, joints_) {
  const int n = articulation.linkCount(), nv = articulation.nv();
  joints_.add(articulation, rings);
  joints_.reserveRows(nv);
  joints_.select(nv, [](int v) { return v; });
  for (int i = 0; i < n; ++i) {
    const LinkModel& link = articulation.link(i);
    if (link.dof < 2 || link.floating) continue;
    JointDef rest = ownLaw(articulation.def().links[i].joint);
    rest.damping = 0;
    if (hasLaw(rest))
      unsupported_.push_back(articulation.def().name + "/" + rest.name +
                             ": friction, limits, springs and drives of joints of several degrees are not simulated");
  }
  for (auto* by_degree : {&tau_, &v_dot_, &change_, &v_end_, &v_start_}) by_degree->resize(nv);
  q_start_.resize(articulation.nq());
  response_.resize(12 * n);
  force_.resize(n);
  stages_.resize(rungeKuttaScratch(articulation));
}

const JointReport& TreeMotion::accelerate(const Vector3& gravity, double h, const JointCommand* commands,
                                          const double* q, const double* v, LinkWork* work, double* v_dot,
                                          const double* tau) noexcept {
  report_ = {};
  if (isPlain()) {
    accelerations(articulation_, gravity, tau, nullptr, work, v_dot);
    report_.passes = 1;
    return report_;
  }
  joints_.start(commands, q, h);
  joints_.standAt(v);
  joints_.lookAtRings(work, q, 1, v);
  TreeInertia inertia(articulation_, gravity, h, tau, work, tau_.data(), v_dot, response_.data());
  report_.converged = joints_.solve(inertia, v, change_.data()) == JointSolver::Found::kAll;
  report_.passes = joints_.passes();
  for (std::size_t k = 0; k < v_end_.size(); ++k) v_end_[k] = v[k] + change_[k];
  joints_.account(commands, h, nullptr, v, v_end_.data(), force_.data(), report_);
  return report_;
}

/// Chord Newton: q on φ = 0 with the factors of the last pass; the gap of the mimics and rings left [m, rad].
double TreeMotion::correct(int steps, double* q, const double* v, LinkWork* work) noexcept {
  for (int pass = 0;; ++pass) {
    forwardKinematics(articulation_, q, v, work);
    const double gap = joints_.gapAt(work, q);
    if (gap < kGap || pass == steps) return gap;
    joints_.closingWay(change_.data());
    double longest = kLongestMove;
    for (const double way : change_) longest = std::max(longest, std::abs(way));
    integratePositions(articulation_, q, change_.data(), kLongestMove / longest);
  }
}

/// Takes from v what opens rings at the poses in `work`. False: it still does, by kHeld in a step.
bool TreeMotion::holdVelocities(double h, const double* q, double* v, LinkWork* work) noexcept {
  for (int pass = 0;; ++pass) {
    joints_.lookAtRings(work, q, 0, v);
    if (joints_.openingRate() * h <= kGap) return true;
    if (pass == kNewtonSteps) return joints_.openingRate() * h <= kHeld;
    joints_.holdVelocities(v);
    forwardKinematics(articulation_, q, v, work);
  }
}

/// The whole step to fourth order. False: not this one; q and v are as before.
bool TreeMotion::stepSmoothly(const Vector3& gravity, double h, const JointCommand* commands, double* q, double* v,
                              LinkWork* work) noexcept {
  smooth_.begin(commands, h);
  if (!joints_.hasRings()) {
    if (!stepRungeKutta(articulation_, gravity, h, q, v, work, stages_.data(), &smooth_)) return false;
    report_ = {smooth_.work()};
  } else {
    std::copy_n(q, articulation_.nq(), q_start_.begin());
    std::copy_n(v, articulation_.nv(), v_start_.begin());
    joints_.lookAtRings(work, q, 0, v);
    bool held = joints_.openingRate() * h <= kGap;
    if (!held) {
      smooth_.accelerate(gravity, q, v, nullptr, work, v_dot_.data());
      held = holdVelocities(h, q, v, work);
    }
    held = held && stepRungeKutta(articulation_, gravity, h, q, v, work, stages_.data(), &smooth_);
    if (held) joints_.follow(q, v);
    held = held && correct(kNewtonSteps, q, v, work) < kHeld && holdVelocities(h, q, v, work);
    if (!held) {
      std::copy(q_start_.begin(), q_start_.end(), q);
      std::copy(v_start_.begin(), v_start_.end(), v);
      forwardKinematics(articulation_, q, v, work);
      return false;
    }
    report_ = {smooth_.work()};
    report_.closure = joints_.closure(work);
  }
  smooth_.readForces(force_.data());
  return true;
}

const JointReport& TreeMotion::step(const Vector3& gravity, double h, const JointCommand* commands, double* q,
                                    double* v, LinkWork* work, const double* tau) noexcept {
  const int nv = articulation_.nv();
  const auto moves = [h](double rate) { return std::abs(rate) * h > kStandingWay; };
  const bool alone = !isPulled(articulation_, work, tau), moved = std::any_of(v, v + nv, moves);
  if (alone && moved && stepSmoothly(gravity, h, commands, q, v, work)) return report_;
  accelerate(gravity, h, commands, q, v, work, v_dot_.data(), tau);
  for (int k = 0; k < nv; ++k) v_end_[k] = v[k] + h * v_dot_[k];
  joints_.settle(v_end_.data());
  const bool sets_off = alone && !moved && std::any_of(v_end_.begin(), v_end_.end(), moves);
  if (sets_off && stepSmoothly(gravity, h, commands, q, v, work)) return report_;
  std::copy(v_end_.begin(), v_end_.end(), v);
  integratePositions(articulation_, q, v, h);
  if (joints_.hasRings()) {
    joints_.follow(q, v);
    correct(kNewtonSteps, q, v, work);
    report_.closure = joints_.closure(work);
  }
  return report_;
}

bool TreeMotion::close(double* q, double* v, LinkWork* work) noexcept {
  if (!joints_.hasRings()) return true;
  TreeInertia inertia(articulation_, Vector3::Zero(), 1, nullptr, work, tau_.data(), v_dot_.data(), response_.data());
  std::fill(v_end_.begin(), v_end_.end(), 0.0);  // forces and diagonal: nothing but the inertia counts
  for (int pass = 0; pass < kClosingSteps; ++pass) {
    forwardKinematics(articulation_, q, v, work);
    inertia.factor(v_end_.data());
    inertia.solve(v_end_.data(), change_.data());
    joints_.lookAtRings(work, q, 1, nullptr);
    joints_.factorRings(inertia);
    if (correct(1, q, v, work) < 1e-9) return true;
  }
  return false;
}

}  // namespace haptic
