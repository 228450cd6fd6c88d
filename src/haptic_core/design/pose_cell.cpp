#include "haptic_core/design/pose_cell.h"

#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {
namespace {

/// J of exp: exp(θ + u) = exp(J u) exp(θ) to first order in u.
Matrix3 leftJacobian(const Vector3& turn) {
  const Matrix3 K = crossMatrix(turn);
  const double square = turn.squaredNorm(), angle = std::sqrt(square);
  if (angle < 1e-4) return Matrix3::Identity() + 0.5 * K + K * K / 6;  // what is left out is below 1e-13
  const elementary::SineCosine s = elementary::sinCos(angle);
  return Matrix3::Identity() + (1 - s.cosine) / square * K + (angle - s.sine) / (square * angle) * (K * K);
}

}  // namespace

GripPose PoseCell::pose(const Vector6& at) const {
  GripPose x;
  x.X_BG.p = at.head<3>();
  x.X_BG.R = rotationFromVector(at.tail<3>()).toRotationMatrix();
  return x;
}

double PoseCell::volume() const {
  double product = 1;
  for (int j = 0; j < 6; ++j)
    if (half[j] > 0) product *= 2 * half[j];
  return product;
}

CellRows::CellRows(const DeviceDef& def)
    : strings_(static_cast<int>(def.strings.size())), dof_(def.dof), radius_(StringKinematics(def).knotRadius()) {
  for (int i = 0; i < strings_; ++i) {
    exit_[i] = def.strings[i].p_BE;
    knot_[i] = dof_ == 3 ? Vector3::Zero() : def.strings[i].p_GK;
    knot_per_opening_[i] = dof_ == 7 ? def.strings[i].dp_GK : Vector3::Zero();
  }
}

void CellRows::evaluate(const PoseCell& cell, RowBounds& out) const {
  out.strings = strings_;
  out.moves = 0;
  for (int j = 0; j < 6; ++j)
    if (cell.half[j] > 0) {
      out.moving[out.moves] = j;
      out.half[out.moves++] = cell.half[j];
    }
  const Matrix3 R = cell.pose().X_BG.R;
  const Matrix3 J = leftJacobian(cell.centre.tail<3>());
  std::array<Matrix3, 3> turned;  // dR/dθ_j
  for (int j = 0; j < 3; ++j) turned[j] = crossMatrix(J.col(j)) * R;
  out.bounded = true;
  for (int i = 0; i < strings_ && out.bounded; ++i) evaluateString(i, R, turned, cell, out);
}

void CellRows::evaluateString(int i, const Matrix3& R, const std::array<Matrix3, 3>& turned, const PoseCell& cell, RowBounds& out) const {
  const Vector3 k = R * knot_[i], g = R * knot_per_opening_[i], v = exit_[i] - cell.centre.head<3>() - k;
  const double l = v.norm(), per_radius = dof_ >= 6 ? 1 / radius_ : 0;
  const double phi = cell.half.tail<3>().norm(), lever = knot_[i].norm(), s = cell.half.head<3>().norm() + lever * phi;
  if (!(l > 1.01 * s)) {
    out.bounded = false;
    return;
  }
  const Vector3 d = v / l;
  out.row[i] << d, per_radius * k.cross(d), d.dot(g);
  const double D1 = s / (l - s), D2 = 2 / std::sqrt(3.0) * D1 * D1 + lever * phi * phi / (l - s), M = D2 + 2 * phi * D1 + phi * phi;
  out.bend[i] = 0.5 * std::sqrt(D2 * D2 + (lever * lever * per_radius * per_radius + knot_per_opening_[i].squaredNorm()) * M * M);
  out.spread[i] = out.bend[i];
  for (int m = 0; m < out.moves; ++m) {
    const int j = out.moving[m];
    const Vector3 dk = j < 3 ? Vector3::Zero() : Vector3(turned[j - 3] * knot_[i]);
    const Vector3 moved = j < 3 ? Vector3(Vector3::Unit(j)) : dk;
    const Vector3 dd = (d * d.dot(moved) - moved) / l;
    const double dg = j < 3 ? 0 : d.dot(turned[j - 3] * knot_per_opening_[i]);
    out.slope[i][m] << dd, per_radius * (dk.cross(d) + k.cross(dd)), dd.dot(g) + dg;
    out.spread[i] += out.half[m] * out.slope[i][m].norm();
  }
}

}  // namespace haptic
