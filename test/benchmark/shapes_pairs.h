/// Random pairs of rods: radii 1…50 mm, lengths 0.2…20 radii, depths 1e-6…1 of the lesser radius, axes
/// parallel or at 1e-12…90°.
#pragma once
#include <cmath>
#include <random>

#include "haptic_core/geometry/shapes/rod.h"

namespace haptic::bench {

struct RodPose {
  double radius[2], length[2];  ///< [m]
  bool round[2];
  Pose X_AB;
  double depth;  ///< along a random direction [m]

  Rod rod(int i) const { return Rod(radius[i], length[i], round[i] ? Rod::Ends::kRound : Rod::Ends::kFlat); }
  double lesser() const { return std::min(radius[0], radius[1]); }
};

enum class RodKinds { kCylinders, kCapsules, kBoth };

class RodPoses {
 public:
  RodPoses(RodKinds kinds, unsigned seed) : kinds_(kinds), random_(seed) {}

  RodPose next() {
    RodPose out;
    for (int i = 0; i < 2; ++i) {
      out.radius[i] = 1e-3 * std::pow(50, uniform());
      out.length[i] = 0.2 * out.radius[i] * std::pow(100, uniform());
      out.round[i] = kinds_ == RodKinds::kCapsules || (kinds_ == RodKinds::kBoth && i == 0);
    }
    out.depth = out.lesser() * std::pow(10, -6 * uniform());
    const double angle = uniform() < 0.15 ? 0 : M_PI / 2 * std::pow(10, -12 * uniform()),
                 about = 2 * M_PI * uniform();
    const Matrix3 R =
        Eigen::AngleAxisd(angle, Vector3(std::cos(about), std::sin(about), 0)).toRotationMatrix();
    // A's farthest point and B's, along a direction that is often across A's axis; there A's may lie anywhere
    // along its side.
    Vector3 way(normal_(random_), normal_(random_), normal_(random_));
    if (uniform() < 0.4) way.z() *= 1e-3;
    way.normalize();
    const Rod A = out.rod(0), B = out.rod(1);
    Vector3 a = A.core(way) + A.rounding() * way;
    if (std::abs(way.z()) < 0.05) a.z() *= 2.4 * uniform() - 1.2;
    const Vector3 b = R * B.core(R.transpose() * -way) - B.rounding() * way;
    out.X_AB = {R, a - b - out.depth * way};
    return out;
  }

 private:
  double uniform() { return uniform_(random_); }

  RodKinds kinds_;
  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::normal_distribution<double> normal_;
};

}  // namespace haptic::bench
