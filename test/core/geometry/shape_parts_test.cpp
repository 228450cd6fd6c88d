// A shape that was made again from its parts is the same bit for bit: its numbers, mass, bounds, and what it answers.
#include "haptic_core/geometry/shapes/shape_parts.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace shape_parts_test {

std::vector<std::shared_ptr<const ConvexShape>> allKinds() {
  std::mt19937 random(1);
  std::vector<Vector3> points;
  for (int i = 0; i < 40; ++i) {
    const auto next = [&] { return 1e-9 * static_cast<double>(random()) - 2; };
    points.push_back(Vector3(next(), next(), next()));
  }
  return {std::make_shared<HalfSpace>("ground"),
          std::make_shared<Ball>(0.1 / 3, "ball"),
          std::make_shared<Rod>(0.1 / 3, 0.7 / 9, Rod::Ends::kFlat, "cylinder"),
          std::make_shared<Rod>(0.1 / 3, 0.7 / 9, Rod::Ends::kRound, "capsule"),
          std::make_shared<Ellipsoid>(Vector3(0.1, 0.2, 0.3) / 7, "ellipsoid"),
          std::make_shared<Cone>(0.1 / 3, 0.0, 0.3, "cone"),
          std::make_shared<Cone>(0.1 / 3, 0.2 / 3, 0.3 / 7, "frustum"),
          std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.1, 0.2, 0.3) / 3, "box")),
          std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(points, "hull"))};
}

struct Numbers : NumberVisitor {
  void visit(double value) override { all.push_back(value); }
  void visit(int value) override { all.push_back(value); }
  std::vector<double> all;
};

std::vector<double> numbersOf(const ConvexShape& shape) {
  Numbers numbers;
  shape.eachNumber(numbers);
  const auto add = [&](const auto& matrix) { numbers.all.insert(numbers.all.end(), matrix.data(), matrix.data() + matrix.size()); };
  add(shape.centre()), add(shape.aabb().lower), add(shape.aabb().upper);
  const OwnTurns turns = shape.ownTurns({Vector3(1, 2, 2) / 3, 0.9 * shape.core(Vector3(1, 2, 2)), Matrix3::Identity()});
  if (shape.spins()) add(turns.about), add(turns.axes);
  numbers.all.insert(numbers.all.end(), {shape.volume(), shape.boundingRadius(), shape.surface(), shape.leastWidth(), shape.rounding()});
  if (shape.bounded()) add(shape.massProperties(1.0 / 3).I_com);
  for (const Vector3& direction : {Vector3(1, 2, 3), Vector3(-3, 1, -0.5)}) add(shape.core(direction));
  for (const Vector3& corner : shape.corners()) add(corner);
  for (const auto& triangle : shape.triangles().triangles) numbers.all.insert(numbers.all.end(), triangle.begin(), triangle.end());
  if (const auto* hull = shape.tessellation()) add(hull->vertices()[0]);
  return numbers.all;
}

TEST(ShapeParts, AShapeIsMadeAgain) {
  for (const auto& shape : allKinds()) {
    const auto again = makeShape(partsOf(*shape));
    EXPECT_EQ(again->kind(), shape->kind()) << shape->name();
    EXPECT_EQ(again->name(), shape->name());
    const std::vector<double> one = numbersOf(*shape), two = numbersOf(*again);
    ASSERT_EQ(two.size(), one.size()) << shape->name();
    EXPECT_EQ(std::memcmp(two.data(), one.data(), one.size() * sizeof(double)), 0) << shape->name();
    if (shape->polyhedron()) EXPECT_EQ(again->polyhedron()->isBox(), shape->polyhedron()->isBox()) << shape->name();
  }
}

TEST(ShapeParts, PartsOfNoShapeAreRefused) {
  for (const auto& shape : allKinds()) {
    ShapeParts parts = partsOf(*shape);
    if (parts.kind == ShapeKind::kHalfSpace) continue;  // has no numbers
    parts.lengths.clear();
    parts.vertices.clear();
    EXPECT_THROW(makeShape(parts), SetupError) << shape->name();
  }
}

}  // namespace shape_parts_test
}  // namespace haptic
