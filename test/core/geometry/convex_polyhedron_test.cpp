#include "haptic_core/geometry/shapes/convex_polyhedron.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace convex_polyhedron_test {

using Loops = std::vector<std::vector<int>>;

/// A unit cube's vertices and loops, to be spoiled.
struct Cube {
  std::vector<Vector3> vertices;
  Loops loops = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  Cube() {
    for (int i = 0; i < 8; ++i) vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  }
};

/// The message with which a spoiled cube is refused; empty when it is taken.
std::string refusal(const std::function<void(Cube&)>& spoil) {
  Cube cube;
  spoil(cube);
  try {
    ConvexPolyhedron(cube.vertices, cube.loops, "crate");
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

void expectNamed(const std::string& message, std::initializer_list<const char*> parts) {
  EXPECT_EQ(message.rfind("crate: ", 0), 0u) << message;
  EXPECT_NE(message.find("; "), std::string::npos) << "no advice: " << message;
  for (const char* part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(ConvexPolyhedron, TakesASoundCube) {
  EXPECT_EQ(refusal([](Cube&) {}), "");
}

TEST(ConvexPolyhedron, NamesWhatIsNotClosed) {
  expectNamed(refusal([](Cube& c) { c.loops.pop_back(); }), {"not closed", "face "});
}

TEST(ConvexPolyhedron, NamesTheVertexThatMakesItConcave) {
  // A vertex pushed in; its three squares are split, so that every face stays planar.
  const std::string message = refusal([](Cube& c) {
    c.vertices[7] = Vector3(0.6, 0.6, 0.6);
    c.loops = {{0, 4, 6, 2}, {0, 1, 5, 4}, {0, 2, 3, 1}, {1, 3, 7}, {1, 7, 5},
               {2, 6, 7},    {2, 7, 3},    {4, 5, 7},    {4, 7, 6}};
  });
  expectNamed(message, {"not convex", "vertex ", "face "});
}

TEST(ConvexPolyhedron, NamesTheVertexThatIsNotANumber) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()})
    expectNamed(refusal([bad](Cube& c) { c.vertices[5].y() = bad; }), {"vertex 5", "not finite"});
}

TEST(ConvexPolyhedron, RefusesFewerThanFourVertices) {
  expectNamed(refusal([](Cube& c) {
                c.vertices.resize(3);
                c.loops = {{0, 1, 2}, {0, 2, 1}};
              }),
              {"3 vertices"});
}

TEST(ConvexPolyhedron, RefusesABodyWithoutVolume) {
  expectNamed(refusal([](Cube& c) {
                for (Vector3& v : c.vertices) v.z() = 0;
              }),
              {"volume is zero"});
}

TEST(ConvexPolyhedron, NamesFacesThatPointInwards) {
  const auto turn = [](std::vector<int>& loop) { std::reverse(loop.begin(), loop.end()); };
  expectNamed(refusal([&](Cube& c) { turn(c.loops[3]); }), {"face 3"});
  expectNamed(refusal([&](Cube& c) {
                for (auto& loop : c.loops) turn(loop);
              }),
              {"face 0", "inward"});
}

TEST(ConvexPolyhedron, NamesOtherDefectsOfTheLists) {
  expectNamed(refusal([](Cube& c) { c.vertices.emplace_back(0.5, 0.5, 0.5); }), {"vertex 8"});
  expectNamed(refusal([](Cube& c) { c.loops[2][1] = 9; }), {"face 2", "vertex 9"});
  expectNamed(refusal([](Cube& c) { c.loops[4].resize(2); }), {"face 4", "fewer than 3"});
  expectNamed(refusal([](Cube& c) { c.loops[1][2] = c.loops[1][1]; }), {"face 1"});
  expectNamed(refusal([](Cube& c) { c.loops.clear(); }), {"vertex 0"});
  expectNamed(refusal([](Cube& c) { c.vertices[7] += Vector3(1e-3, 0, 0); }), {"not planar", "face "});
  // Two cubes in one list.
  expectNamed(refusal([](Cube& c) {
                const Cube other;
                for (const Vector3& v : other.vertices) c.vertices.push_back(v + Vector3(3, 0, 0));
                for (std::vector<int> loop : other.loops) {
                  for (int& i : loop) i += 8;
                  c.loops.push_back(loop);
                }
              }),
              {"one closed surface"});
}

TEST(ConvexPolyhedron, RefusesASizeBeyondItsNumbers) {
  // 1e120 m: the volume's terms overflow.
  expectNamed(refusal([](Cube& c) {
                for (Vector3& v : c.vertices) v *= 1e120;
              }),
              {"volume"});
}

TEST(ConvexPolyhedron, HullRefusesWhatHasNoVolume) {
  const auto message = [](const std::vector<Vector3>& points) -> std::string {
    try {
      ConvexPolyhedron::hull(points, "crate");
    } catch (const SetupError& error) {
      return error.what();
    }
    return "";
  };
  Cube cube;
  EXPECT_EQ(message(cube.vertices), "");
  expectNamed(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), {"3 points"});
  expectNamed(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}}), {"plane"});
  expectNamed(message(std::vector<Vector3>(9, Vector3(1, 2, 3))), {"hull"});
  cube.vertices[4].x() = std::nan("");
  expectNamed(message(cube.vertices), {"point 4"});
}

TEST(ConvexPolyhedron, HullKeepsExtremePointsAlone) {
  Cube cube;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> inside(0.01, 0.99);
  for (int i = 0; i < 50; ++i) cube.vertices.emplace_back(inside(random), inside(random), inside(random));
  const ConvexPolyhedron hull = ConvexPolyhedron::hull(cube.vertices);
  EXPECT_EQ(hull.vertexCount(), 8);
  EXPECT_EQ(hull.faceCount(), 6);  // coplanar triangles are one face
  EXPECT_NEAR(hull.volume(), 1, 1e-15);
}

TEST(ConvexPolyhedron, SupportIsTheFarthestVertexFromAnyHint) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vector3(normal(random), normal(random), normal(random)).normalized(); };
  std::vector<Vector3> points;
  for (int i = 0; i < 200; ++i) points.push_back(0.05 * direction());
  for (const ConvexPolyhedron& shape :
       {ConvexPolyhedron::hull(points), makeBox(Vector3(0.1, 0.2, 0.3)), makeCylinder(0.05, 0.1, 24)})
    for (int i = 0; i < 500; ++i) {
      const Vector3 d = i < 3 ? Vector3(Vector3::Unit(i)) : direction();
      double farthest = -INFINITY;
      for (const Vector3& v : shape.vertices()) farthest = std::max(farthest, d.dot(v));
      const int hint = static_cast<int>(random() % shape.vertexCount());
      EXPECT_NEAR(d.dot(shape.vertices()[shape.support(d, hint)]), farthest, 1e-16);
    }
}

TEST(ConvexPolyhedron, AdjacencyIsConsistent) {
  for (const ConvexPolyhedron& shape : {makeBox(Vector3(1, 1, 1)), makeSphere(1, 2), makeCylinder(1, 1, 7)}) {
    EXPECT_EQ(shape.vertexCount() - shape.edgeCount() + shape.faceCount(), 2);
    for (const auto& face : shape.faces())
      for (int h = face.first; h < face.first + face.count; ++h) {
        EXPECT_EQ(shape.twin(shape.twin(h)), h);
        EXPECT_EQ(shape.edgeOf(h), shape.edgeOf(shape.twin(h)));
        const int next = h + 1 < face.first + face.count ? h + 1 : face.first;
        EXPECT_EQ(shape.loopVertex(shape.twin(h)), shape.loopVertex(next));
      }
    for (int v = 0; v < shape.vertexCount(); ++v)
      for (int i = shape.neighbourBegin(v); i < shape.neighbourBegin(v + 1); ++i) {
        EXPECT_EQ(shape.loopVertex(shape.outgoing()[i]), v);
        EXPECT_EQ(shape.loopVertex(shape.twin(shape.outgoing()[i])), shape.neighbours()[i]);
      }
  }
}

}  // namespace convex_polyhedron_test
}  // namespace haptic
