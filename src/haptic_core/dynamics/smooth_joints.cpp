#include "haptic_core/dynamics/smooth_joints.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/dynamics/articulated_body.h"

namespace haptic {
namespace {

/// Bound of Σ h s_i (M⁻¹)_ii [1], see smooth_joints.h: M may change by a sixth in a step. What decays by e^−z in it errs by more than
/// implicit Euler's from z = 2.7 on, which the sum overestimates; with 2.5 an arm with a load errs by 2000 times as much at 3.3 ms.
constexpr double kResolved = 3;

/// The tree as `accelerations` has factored it.
class FactoredTree final : public JointResponse {
 public:
  FactoredTree(const Articulation& articulation, const LinkWork* work, double* scratch)
      : articulation_(articulation), work_(work), scratch_(scratch) {}
  void respond(const double* force, double* x) noexcept override { accelerationResponse(articulation_, force, work_, scratch_, x); }

 private:
  const Articulation& articulation_;
  const LinkWork* work_;
  double* scratch_;
};

}  // namespace

SmoothJoints::SmoothJoints(const Articulation& articulation, JointSolver& rings) : articulation_(articulation), rings_(rings) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    const JointDef joint = ownLaw(articulation.def().links[i].joint);
    if (link.dof == 1 && hasLaw(joint)) laws_.push_back({joint, i, link.q, link.v, {}});
    for (int k = 0; link.dof > 1 && !link.floating && joint.damping > 0 && k < link.dof; ++k) {
      damped_.push_back({link.v + k, joint.damping});
    }
  }
  scratch_.resize(36 * static_cast<std::size_t>(articulation.linkCount()));
  mobility_.resize(articulation.nv());
  none_.resize(articulation.nv());
}

void SmoothJoints::begin(const JointCommand* commands, double h) noexcept {
  commands_ = commands;
  h_ = h;
  first_ = true;
  work_ = {};
}

bool SmoothJoints::at(const double* q, const double* v, double time, double* tau) noexcept {
  if (rings_.hasThreads()) return false;  // their friction is that of the forces of a step
  std::fill_n(tau, articulation_.nv(), 0.0);
  for (const Damped& d : damped_) {
    tau[d.v] = -d.damping * v[d.v];
    work_.damping += time * d.damping * v[d.v] * v[d.v];
  }
  for (Law& law : laws_) {
    const double rate = v[law.v];
    const SmoothForce force = law.force = smoothForce(law.joint, commands_[law.link], q[law.q], rate, h_);
    if (first_) {
      law.side = force.side;
      law.slope = force.slope;
    }
    if (force.side == SmoothForce::kOnAKink || force.side != law.side) return false;
    tau[law.v] = force.all;
    work_.damping += time * law.joint.damping * rate * rate;
    work_.drives += time * force.drive * rate;
    work_.friction += time * law.joint.friction * std::abs(rate);
  }
  first_ = false;
  return true;
}

bool SmoothJoints::areResolved(const LinkWork* work) noexcept {
  jointMobilities(articulation_, work, scratch_.data(), mobility_.data());
  double rate = 0;
  for (const Damped& d : damped_) rate += d.damping * mobility_[d.v];
  for (const Law& law : laws_) rate += law.slope * mobility_[law.v];
  return h_ * rate <= kResolved;
}

void SmoothJoints::accelerate(const Vector3& gravity, const double* q, const double* v, const double* tau, LinkWork* work,
                              double* v_dot) noexcept {
  if (!haveRings()) return accelerations(articulation_, gravity, tau, nullptr, work, v_dot);
  accelerations(articulation_, gravity, tau, none_.data(), work, v_dot);
  rings_.lookAtRings(work, q, 0, v);
  FactoredTree tree(articulation_, work, scratch_.data());
  rings_.factorRings(tree);
  rings_.holdAccelerations(work, v_dot);
}

void SmoothJoints::readForces(JointForce* by_link) const noexcept {
  for (const Law& law : laws_) by_link[law.link] = {law.force.drive, law.force.all};
}

}  // namespace haptic
