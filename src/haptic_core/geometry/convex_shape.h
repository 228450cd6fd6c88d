/// A convex solid that collides: a polyhedron (convex_polyhedron.h), a ball (ball.h), a cylinder or capsule (rod.h), or a
/// half-space (half_space.h).
#pragma once
#include <string>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/mass_properties.h"

namespace haptic {

class Ball;
class ConvexPolyhedron;
class HalfSpace;
class Rod;

/// What all shapes have in common. Immutable; all queries are const, without heap and safe from any number of threads.
class ConvexShape {
 public:
  /// A box along the axes of some frame.
  struct Box {
    Vector3 lower, upper;  ///< [m]
  };

  virtual ~ConvexShape() = default;

  /// The shape as what it is; null: it is of another kind. Defined beside the classes.
  const ConvexPolyhedron* polyhedron() const;
  const Ball* ball() const;  ///< null: it is no ball
  const Rod* rod() const;    ///< null: it is no cylinder or capsule
  const HalfSpace* halfSpace() const;  ///< null: it is bounded

  const std::string& name() const { return name_; }          ///< for messages
  const Vector3& centre() const { return properties_.com; }  ///< centroid of the solid [m]
  double boundingRadius() const { return radius_; }          ///< about centre() [m]
  const Box& aabb() const { return aabb_; }                  ///< in the shape's frame
  virtual Box aabb(const Pose& X_WS) const = 0;              ///< in W; O(1)
  double volume() const { return properties_.volume; }       ///< [m³]
  /// Of `density` [kg/m³].
  MassProperties massProperties(double density) const {
    MassProperties result = properties_;
    result.mass *= density;
    result.I_com *= density;
    return result;
  }
  virtual TriangleMesh triangles() const = 0;                ///< for drawing; of a round surface an approximation
  /// The shape is all that is within rounding() [m] of its core, whose farthest point along `direction` (not zero) this is.
  /// (in realtime)
  virtual Vector3 core(const Vector3& direction) const = 0;
  virtual double rounding() const { return 0; }  ///< see `core`

 protected:
  /// What the shape is, so that queries need no dynamic cast.
  enum class Kind : unsigned char { kPolyhedron, kBall, kRod, kHalfSpace };
  /// The derived class fills in the properties, radius and box below.
  ConvexShape(Kind kind, const std::string& name) : name_(name), kind_(kind) {}
  ConvexShape(const ConvexShape&) = default;  ///< for derived classes: a shape is not copied through its base
  ConvexShape(ConvexShape&&) = default;  ///< likewise
  ConvexShape& operator=(const ConvexShape&) = default;  ///< likewise
  ConvexShape& operator=(ConvexShape&&) = default;  ///< likewise

  std::string name_;           ///< for messages
  MassProperties properties_;  ///< at density 1
  double radius_ = 0;                           ///< about the centre [m]
  Box aabb_{Vector3::Zero(), Vector3::Zero()};  ///< in the shape's frame

 private:
  Kind kind_;
};

}  // namespace haptic
