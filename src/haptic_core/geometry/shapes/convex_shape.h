/// A convex solid that collides: a polyhedron (convex_polyhedron.h), a ball (ball.h), a cylinder or capsule (rod.h), an ellipsoid
/// (ellipsoid.h), a half-space (half_space.h), or any other that has a support function (support_shape.h), such as a cone (cone.h).
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/shapes/mass_properties.h"

namespace haptic {

class Ball;
class ConvexPolyhedron;
class Ellipsoid;
class HalfSpace;
class Rod;

/// Kinds of shapes, in the order of the table of pairs (table.h).
enum class ShapeKind : unsigned char { kHalfSpace, kPolyhedron, kBall, kRod, kEllipsoid, kSupport };
inline constexpr int kShapeKinds = 6;  ///< so many

/// Takes the numbers that make up a shape, one after the other.
class NumberVisitor {
 public:
  virtual ~NumberVisitor() = default;
  virtual void visit(double value) = 0;  ///< a length or coordinate [m]
  virtual void visit(int value) = 0;     ///< a count
};

/// Where a shape is in contact, in its frame.
struct ContactPlace {
  Vector3 normal;    ///< of the contact, unit, out of the shape
  Vector3 centroid;  ///< of the overlap V [m]
  Matrix3 variance;  ///< of V's thickness about its centroid, along the patch [m²]
};

/// Turns that move a shape's surface along itself where it is in contact, so that the overlap V stays congruent.
struct OwnTurns {
  Vector3 about = Vector3::Zero();  ///< a point that all their axes share [m]
  Matrix3 axes = Matrix3::Zero();   ///< Σ s e eᵀ over unit axes e; the share s is 1 where the surface stays where it is [1]
};

/// What all shapes have in common. Immutable; all queries are const, without heap and safe from any number of threads.
class ConvexShape {
 public:
  /// A box along the axes of some frame.
  struct Box {
    Vector3 lower, upper;  ///< [m]
  };

  virtual ~ConvexShape() = default;

  ShapeKind kind() const { return kind_; }  ///< for the table of pairs; all others ask the questions below
  /// The shape as its kind, for the table of pairs; null: it is of another kind. Defined beside the classes.
  const ConvexPolyhedron* polyhedron() const;
  const Ball* ball() const;  ///< null: it is no ball
  const Rod* rod() const;    ///< null: it is no cylinder or capsule
  const HalfSpace* halfSpace() const;  ///< null: it is bounded
  const Ellipsoid* ellipsoid() const;  ///< null: it is no ellipsoid

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
  bool bounded() const { return std::isfinite(radius_); }    ///< false: it has no end, no mass and no centre
  virtual bool flat() const = 0;                             ///< all of its surface consists of planar faces
  virtual double surface() const = 0;                        ///< area [m²]; infinite without end
  virtual double leastWidth() const = 0;                     ///< [m]; of a polyhedron over the normals of its faces
  virtual int faceCount() const { return 0; }                ///< of a polyhedron, or of the tessellation
  virtual int edgeCount() const { return 0; }                ///< likewise
  /// Outward unit normals of which every other side is like one: of a polyhedron its faces', of a rod an end's and the side's.
  virtual std::vector<Vector3> sides() const = 0;
  virtual std::vector<Vector3> corners() const = 0;          ///< [m]; of a round shape those of a hull of it; without end none
  virtual void eachNumber(NumberVisitor& visitor) const = 0;  ///< all that tells it from others of its kind
  /// The shape is all that is within rounding() [m] of its core, whose farthest point along `direction` (not zero) this is.
  /// (in realtime)
  virtual Vector3 core(const Vector3& direction) const = 0;
  virtual double rounding() const { return 0; }  ///< see `core`
  bool spins() const { return spins_; }  ///< some turns move its surface along itself
  /// (in realtime) These turns, of a shape that `spins`: unless it knows more, those about z through its origin.
  virtual OwnTurns ownTurns(const ContactPlace&) const { return {Vector3::Zero(), Vector3(0, 0, 1).asDiagonal()}; }
  /// The polyhedron that stands in for the shape in pairs that have no row of their own in the table of pairs, made once at set-up;
  /// null: none of its pairs needs one.
  virtual const ConvexPolyhedron* tessellation() const { return nullptr; }
  virtual double tessellationError() const { return 0; }  ///< largest distance between the shape's surface and that one's [m]

 protected:
  /// The derived class fills in the properties, radius and box below.
  ConvexShape(ShapeKind kind, const std::string& name) : name_(name), kind_(kind) {}
  ConvexShape(const ConvexShape&) = default;  ///< for derived classes: a shape is not copied through its base
  ConvexShape(ConvexShape&&) = default;  ///< likewise
  ConvexShape& operator=(const ConvexShape&) = default;  ///< likewise
  ConvexShape& operator=(ConvexShape&&) = default;  ///< likewise

  std::string name_;           ///< for messages
  MassProperties properties_;  ///< at density 1
  double radius_ = 0;                           ///< about the centre [m]
  Box aabb_{Vector3::Zero(), Vector3::Zero()};  ///< in the shape's frame
  bool spins_ = false;                          ///< see ownTurns()

 private:
  ShapeKind kind_;
};

}  // namespace haptic
