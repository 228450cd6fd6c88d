/// What kinds of joints there are. This file is all that is known of a type: everything else loops over its axes.
///
/// A joint moves its link along and about axes that stand still in the parent: first `slides` axes, then `turns`. Its
/// velocity v has a rate per axis. Its position q has a displacement per slide, then the angle of one turn, or a
/// quaternion for three. Slides come before turns on the way from parent to child, so that a link turns about where it
/// has slid to. The one exception is the floating joint: see articulation.h.
///
/// A joint whose axes move with q (universal) or turn and slide at once (screw, thread.h) is not of this form; two joints with
/// a massless link between them are.
#pragma once
#include <string>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// The types that files can name, see `kJointKinds`.
enum class JointType : unsigned char { kFixed, kRevolute, kPrismatic, kPlanar, kSpherical, kFloating };

/// A row of `kJointKinds`: all that is known of a type.
struct JointKind {
  JointType type;       ///< the type it describes
  const char* name;     ///< in files
  bool in_urdf;         ///< false: written <joint type="floating"> with <haptic:joint type="NAME"/>
  int slides, turns;    ///< 0…3; turns: 0, 1 or 3
  /// A letter per axis, slides first, at most three: `a` the joint's axis; `u`, `w` across it (u, w, a right-handed);
  /// `x`, `y`, `z` those of the joint frame.
  const char* axes;
  bool floating;        ///< moves freely, whatever hangs above it
};

/// All types, in the order of `JointType`.
inline constexpr JointKind kJointKinds[] = {
    {JointType::kFixed, "fixed", true, 0, 0, "", false},
    {JointType::kRevolute, "revolute", true, 0, 1, "a", false},
    {JointType::kPrismatic, "prismatic", true, 1, 0, "a", false},
    {JointType::kPlanar, "planar", true, 2, 1, "uwa", false},
    {JointType::kSpherical, "spherical", false, 0, 3, "xyz", false},
    {JointType::kFloating, "floating", true, 3, 3, "", true},
};

/// The row of a type.
constexpr const JointKind& kindOf(JointType type) { return kJointKinds[static_cast<int>(type)]; }

/// The kind that files call `name`; null: none.
inline const JointKind* jointKind(const std::string& name) {
  for (const JointKind& kind : kJointKinds) {
    if (name == kind.name) return &kind;
  }
  return nullptr;
}

constexpr int degreesOf(const JointKind& kind) { return kind.slides + kind.turns; }  ///< velocities: 0…6
/// Numbers in q: a quaternion has four.
constexpr int positionsOf(const JointKind& kind) { return kind.slides + (kind.turns == 3 ? 4 : kind.turns); }
/// Files give it an axis.
constexpr bool hasAxis(const JointKind& kind) { return kind.axes[0] == 'a' || kind.axes[0] == 'u'; }
/// One degree of freedom: such a joint may have limits, a drive, friction.
constexpr bool isScalar(JointType type) { return degreesOf(kindOf(type)) == 1; }

/// Axis k in the joint frame, for the joint's own axis `a` of unit length.
inline Vector3 axisOf(const JointKind& kind, int k, const Vector3& a) {
  switch (kind.axes[k]) {
    case 'x':
      return Vector3::UnitX();
    case 'y':
      return Vector3::UnitY();
    case 'z':
      return Vector3::UnitZ();
    case 'u':  // x and y, turned with z the shortest way onto the axis
      return shortestTurn(Vector3::UnitZ(), a) * Vector3::UnitX();
    case 'w':
      return shortestTurn(Vector3::UnitZ(), a) * Vector3::UnitY();
    default:
      return a;
  }
}

/// X_JL of a joint of one degree at q.
inline Pose scalarPose(const JointKind& kind, const Vector3& axis, double q) {
  Pose X_JL;
  if (kind.slides) X_JL.p = q * axisOf(kind, 0, axis);
  if (kind.turns) X_JL.R = rotationAbout(axisOf(kind, 0, axis), q);
  return X_JL;
}

}  // namespace haptic
