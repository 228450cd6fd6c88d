#include "scene/excited_inertia.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "haptic_core/base/dense_matrix.h"

namespace haptic {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Axes = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;

/// Spatial inertia about the point p_CO away from the centre of mass, in W's axes; turns first.
Matrix6 spatialInertia(double mass, const Matrix3& I_C_W, const Vector3& p_OC_W) {
  Matrix6 I;
  const Matrix3 c = crossMatrix(p_OC_W);
  I << I_C_W - mass * c * c, mass * c, -mass * c, mass * Matrix3::Identity();
  return I;
}

/// The same inertia about a point from which the present one lies at r.
Matrix6 movedBy(const Matrix6& I, const Vector3& r) {
  Matrix6 shift = Matrix6::Identity();  // V of the present point from V of the new one
  shift.bottomLeftCorner<3, 3>() = -crossMatrix(r);
  return shift.transpose() * I * shift;
}

/// Places of a joint at which axes of others can become parallel, and its limits.
std::vector<double> placesOf(const JointDef& joint) {
  std::vector<double> places = {joint.position};
  for (const double limit : {joint.lower, joint.upper}) {
    if (std::isfinite(limit) && std::abs(limit) < 1e6) places.push_back(limit);
  }
  if (kindOf(joint.type).slides) return places;
  for (const double quarter : {-M_PI_2, 0.0, M_PI_2, M_PI}) {
    if (quarter > joint.lower && quarter < joint.upper) places.push_back(quarter);
  }
  return places;
}

class Sweep {
 public:
  explicit Sweep(const ArticulationDef& tree)
      : tree_(tree), q_(tree.links.size()), X_WL_(q_.size()), locked_(q_.size()), articulated_(q_.size()) {
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] = tree.links[i].joint.position;
  }

  void takePlaces(std::uint32_t& random) {
    for (std::size_t i = 0; i < q_.size(); ++i) {
      const JointDef& joint = tree_.links[i].joint;
      if (!isScalar(joint.type)) continue;
      const std::vector<double> places = placesOf(joint);
      random = 1664525u * random + 1013904223u;
      q_[i] = places[(random >> 16) % places.size()];
    }
    for (std::size_t i = 0; i < q_.size(); ++i) {
      const JointDef& joint = tree_.links[i].joint;
      if (joint.mimic_joint >= 0) q_[i] = joint.mimic_multiplier * q_[joint.mimic_joint] + joint.mimic_offset;
    }
  }

  /// From the leaves to the root; the first link whose D is none.
  int run() {
    const int n = static_cast<int>(q_.size());
    for (int i = 0; i < n; ++i) place(i);
    for (int i = n - 1; i >= 0; --i) {
      if (!take(i)) return i;
    }
    return -1;
  }

 private:
  void place(int i) {
    const LinkDef& link = tree_.links[i];
    Pose X_JL;
    if (isScalar(link.joint.type)) X_JL = scalarPose(kindOf(link.joint.type), link.joint.axis, q_[i]);
    X_WL_[i] = (link.parent < 0 ? Pose() : X_WL_[link.parent]) * link.joint.X_PJ * X_JL;
    const Matrix3& R = X_WL_[i].R;
    locked_[i] = articulated_[i] = spatialInertia(link.inertia.mass, R * link.inertia.I_C * R.transpose(), R * link.inertia.p_LC);
  }

  Axes axesOf(int i) const {
    const JointDef& joint = tree_.links[i].joint;
    const JointKind& kind = kindOf(joint.type);
    const int dof = degreesOf(kind);
    if (dof == 6) return Matrix6::Identity();
    Axes S = Axes::Zero(6, dof);
    const int parent = tree_.links[i].parent;
    const Matrix3 R_WJ = (parent < 0 ? Pose() : X_WL_[parent]).R * joint.X_PJ.R;
    for (int k = 0; k < dof; ++k) S.col(k).segment<3>(k < kind.slides ? 3 : 0) = R_WJ * axisOf(kind, k, joint.axis);
    return S;
  }

  /// Hands the subtree of link i to its parent; false: one of its motions meets no inertia.
  bool take(int i) {
    const LinkDef& link = tree_.links[i];
    Matrix6& I = articulated_[i];
    const Axes S = axesOf(i);
    if (S.cols() > 0) {
      const Axes P = I * S;
      Eigen::MatrixXd D = S.transpose() * P;
      // About its centre of mass, where the subtree is, not how far from the joint.
      const double mass = locked_[i](3, 3);
      const Vector3 moment(locked_[i](2, 4), locked_[i](0, 5), locked_[i](1, 3));  // m c, from the cross matrix
      const Vector3 c = mass > 0 ? Vector3(moment / mass) : Vector3::Zero();
      const double turning = locked_[i].topLeftCorner<3, 3>().trace() - 2 * mass * c.squaredNorm();
      Eigen::VectorXd scale(S.cols());
      for (int k = 0; k < S.cols(); ++k) {
        const bool turns = S.col(k).head<3>().squaredNorm() > 0.5;
        scale[k] = turns ? std::max(turning, D(k, k)) : mass;
      }
      if (!(scale.minCoeff() > 0)) return false;
      const Eigen::VectorXd inverse = scale.cwiseSqrt().cwiseInverse();
      const Eigen::MatrixXd share = inverse.asDiagonal() * D * inverse.asDiagonal();
      if (!(eigenvalues(share)[0] > kLeastExcited)) return false;
      I -= P * solveSymmetric(D, P.transpose());
    }
    if (link.parent < 0) return true;
    const Vector3 r = X_WL_[i].p - X_WL_[link.parent].p;
    articulated_[link.parent] += movedBy(I, r);
    locked_[link.parent] += movedBy(locked_[i], r);
    return true;
  }

  const ArticulationDef& tree_;
  std::vector<double> q_;
  std::vector<Pose> X_WL_;
  std::vector<Matrix6> locked_, articulated_;  ///< of subtrees, about their link's origin, W's axes
};

}  // namespace

int linkWithoutInertia(const ArticulationDef& articulation) {
  Sweep sweep(articulation);
  int deepest = sweep.run();
  std::uint32_t random = 1;
  for (int pose = 0; pose < kSampledPoses && deepest < 0; ++pose) {
    sweep.takePlaces(random);
    deepest = sweep.run();
  }
  return deepest;
}

}  // namespace haptic
