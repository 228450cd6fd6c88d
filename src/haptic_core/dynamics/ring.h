/// Constraints on top of a tree: two frames held together (a ring), a joint that follows another (mimic).
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"

namespace haptic {

/// Two frames of one tree held together; link −1 is the world. A ring over two trees makes them one forest.
struct RingDef {
  std::string name;              ///< for messages
  int link_a = -1, link_b = -1;  ///< index in the tree; −1: the world
  Pose X_AF, X_BF;  ///< where the frames lie in the links
  /// Part of the frames that is held together: their origin (three turns stay free), origin and axis (one turn) or everything
  /// (none).
  enum class Type : unsigned char { kPoint, kHinge, kWeld } type = Type::kPoint;
  Vector3 axis = Vector3::UnitZ();  ///< of a hinge, in F
};

/// Constraints on top of a tree: rings and mimic joints.
/// Rows φ(q) = 0 with φ' = G v, of all rings and mimic joints of a tree.
/// Ring: the difference of the origins (b − a) in a's axes [m]; hinge: the two components of axis_a × axis_b
/// across the axis; weld: the rotation vector from a to b [rad]. Mimic: q_j − (m q_i + c).
class Rings {
 public:
  Rings(const Articulation& articulation,
        std::vector<RingDef> rings);  ///< throws SetupError: link out of range
  int rows() const { return rows_; }         ///< constraint equations: 3, 5 or 6 a ring, 1 a mimic
  int mimicRow(int link) const;              ///< of the joint of `link`, which follows another
  bool empty() const { return rows_ == 0; }  ///< nothing is constrained
  /// (in realtime) φ at the poses in `work`; `phi[rows()]`.
  void residual(const LinkWork* work, const double* q, double* phi) const noexcept;
  /// (in realtime) G, rows() × nv row-major, at the poses in `work`.
  void jacobian(const LinkWork* work, double* G) const noexcept;
  /// (in realtime) φ'' = G v̇ + G' v by the accelerations of the links in `work`, which `v_dot` are those of; `phi_ddot[rows()]`.
  void acceleration(const LinkWork* work, const double* v_dot, double* phi_ddot) const noexcept;
  /// (in realtime) A number for each equation, [1/kg] of lengths and [1/(kg m²)] of turns: of a ring the largest, turns by the radius of
  /// gyration of its links about its frames. Rows that the tree does not move at all, the tilts of a hinge in a planar ring or the lengths
  /// of a weld in a spherical one, hold rounding alone, and get the scale of the others.
  void shareScale(double* of_equation) const noexcept;
  /// (in realtime) Followers to where their leaders are, to the last bit: a solve leaves 1e-10 of the way that a step would open.
  void follow(double* q, double* v) const noexcept;
  /// Largest distance between the origins of a ring's frames [m].
  double closure(const LinkWork* work) const noexcept;

 private:
  struct Frames {
    Pose X_WA, X_WB;
  };
  Frames frames(const RingDef& ring, const LinkWork* work) const noexcept;
  const Articulation& articulation_;
  std::vector<RingDef> rings_;
  std::vector<double> gyration2_;  ///< by ring: square of that radius [m²]
  std::vector<int> mimics_;  ///< links whose joint follows another
  int rows_ = 0;
};

}  // namespace haptic
