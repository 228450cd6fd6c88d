#include "haptic_core/world/stability_number.h"

#include <cmath>
#include <limits>

namespace haptic {
namespace {

/// (tr X⁸)^⅛ of a product of two positive semidefinite matrices: its eigenvalues are real and not negative.
double largestEigenvalue(const Matrix6& X) noexcept {
  const double scale = X.diagonal().sum();
  if (!std::isfinite(scale)) return std::numeric_limits<double>::infinity();  // an unknown one is not stable
  if (!(scale > 0)) return 0;
  Matrix6 Y, Z;
  Y.noalias() = (1 / scale) * X.lazyProduct((1 / scale) * X);
  Z.noalias() = Y.lazyProduct(Y);
  const double trace = Z.cwiseProduct(Z.transpose()).sum();
  return scale * std::sqrt(std::sqrt(std::sqrt(std::max(0.0, trace))));
}

}  // namespace

Matrix6 ownMobility(const LinkModel& link, const Matrix3& R_WL, const Vector3& p_WC, const Pose& X_WP) noexcept {
  const Matrix3 R_PL = X_WP.R.transpose() * R_WL;
  const Matrix3 arm = crossMatrix(X_WP.R.transpose() * (X_WP.p - p_WC));
  Matrix6 W;
  if (link.rooted) {
    Eigen::Matrix<double, 6, 3> S;  // the joint's axes as twists of P
    S.topRows<3>() = R_PL * link.S_C.topRows<3>();
    S.bottomRows<3>() = R_PL * link.S_C.bottomRows<3>() - arm * S.topRows<3>();
    W.noalias() = S * link.joint_mobility * S.transpose();
    return W;
  }
  const Matrix3 inverse = R_PL * link.turn_mobility * R_PL.transpose();
  W.topLeftCorner<3, 3>() = inverse;
  W.topRightCorner<3, 3>() = inverse * arm;  // torque of a force at P about C: arm × f
  W.bottomLeftCorner<3, 3>() = -arm * inverse;
  W.bottomRightCorner<3, 3>() = W.bottomLeftCorner<3, 3>() * arm;
  W.bottomRightCorner<3, 3>().diagonal().array() += link.mobility;
  return W;
}

double stabilityNumber(const PatchTangent& tangent, const Matrix6& W, bool both_move, double h) noexcept {
  const double w = both_move ? 2 : 1;
  const Matrix6 K = tangent.combined(h * h, 0), D = tangent.combined(0, h);
  const double springs = w * largestEigenvalue(W.lazyProduct(K));
  const double dampers = w * largestEigenvalue(W.lazyProduct(D));
  return springs + 2 * dampers / (1 + 0.5 * dampers);
}

}  // namespace haptic
