#include "haptic_core/geometry/pairs/internal_faces.h"

#include <gtest/gtest.h>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

namespace haptic {
namespace internal_faces_test {

/// Faces of a box: 2·axis + (looks along + ? 1 : 0).
std::vector<int> internalOf(const InnerFaces& inner) {
  std::vector<int> faces;
  for (int f = 0; f < 6 && !inner.covers.empty(); ++f)
    if (inner.has(f)) faces.push_back(f);
  return faces;
}

using Faces = std::vector<int>;

TEST(InternalFaces, AreThoseOnWhichANeighbourLies) {
  const ConvexPolyhedron big = makeBox(Vector3(0.2, 0.2, 0.1)), half = makeBox(Vector3(0.2, 0.1, 0.1));
  const Pose turned(rotationFromVector(Vector3(0.4, -1, 0.3)), Vector3(0.3, 2, -1));
  using Pairs = std::vector<std::pair<int, int>>;
  for (const Pose& X : {Pose(), turned}) {
    const auto at = [&](const ConvexPolyhedron& shape, const Vector3& p) {
      return PlacedPiece{&shape, X * Pose(p)};
    };
    InternalFaces found =
        internalFaces({at(big, {0, 0, 0}), at(half, {0.2, 0.05, 0}), at(half, {0.2, -0.05, 0})});
    EXPECT_EQ(internalOf(found.inner[0]), Faces({1}));
    EXPECT_EQ(internalOf(found.inner[1]), Faces({0, 2}));
    EXPECT_EQ(internalOf(found.inner[2]), Faces({0, 3}));
    EXPECT_EQ(found.neighbours, Pairs({{0, 1}, {0, 2}, {1, 2}}));
    // A wide gap is a gap; rounding is none; between them it is kept for contacts to judge. An edge on an edge shares no area; nor does
    // a face that looks the same way.
    EXPECT_EQ(internalFaces({at(big, {0, 0, 0}), at(big, {0.2 + 2e-3, 0, 0})}).neighbours, Pairs());
    for (const double gap : {1e-5, -1e-5}) {
      found = internalFaces({at(big, {0, 0, 0}), at(big, {0.2 + gap, 0, 0})});
      ASSERT_EQ(found.neighbours, Pairs({{0, 1}}));
      const InnerFaces::Cover& cover = found.inner[0].covers[0];
      EXPECT_NEAR(cover.gap, 1e-5, 1e-15);
      EXPECT_EQ(cover.share(2e-4), 1);
      EXPECT_NEAR(cover.share(1e-4 / 1.5), 0.5, 1e-9);
      EXPECT_EQ(cover.share(1e-5), 0);
    }
    found = internalFaces({at(big, {0, 0, 0}), at(big, {0.2 + 1e-12, 0, 0})});
    EXPECT_EQ(found.neighbours, Pairs({{0, 1}}));
    EXPECT_EQ(found.inner[0].covers[0].gap, 0);
    EXPECT_EQ(internalFaces({at(big, {0, 0, 0}), at(big, {0.2, 0.2, 0})}).neighbours, Pairs());
    EXPECT_EQ(internalFaces({at(big, {0, 0, 0}), at(half, {0, 0.05, 0})}).neighbours, Pairs());
  }
}

/// A contact that ends at an internal face says so, by both algorithms and in either order.
TEST(InternalFaces, MarkTheContactsThatTheyBound) {
  const ConvexPolyhedron tile = makeBox(Vector3(0.2, 0.2, 0.1)), probe = makeBox(Vector3(0.02, 0.02, 0.02));
  const auto internal = internalFaces({{&tile, Pose()}, {&tile, Pose(Vector3(0.2, 0, 0))}}).inner;
  const InnerSides of_a{&internal[0], nullptr}, of_b{nullptr, &internal[0]};
  ContactWorkspace workspace;
  workspace.reserve(tile, probe);
  for (const bool at_joint : {true, false}) {
    const Pose X(rotationFromVector(Vector3(0, 0.05, 0.1)), Vector3(at_joint ? 0.09 : -0.09, 0, 0.059));
    const auto marked = [&](auto&& find) {
      PairCache cache;
      ContactVolume v;
      find(cache, v);
      EXPECT_EQ(v.status, ContactVolume::Status::kOverlap);
      return (v.flags & ContactVolume::kOnSeam) != 0;
    };
    constexpr NormalRule kRule = NormalRule::kAreaVector;
    EXPECT_EQ(at_joint,
              marked([&](auto& c, auto& v) { contactVolume(tile, probe, X, c, workspace, v, {kRule, of_a, Vector3::Zero()}); }));
    EXPECT_EQ(at_joint, marked([&](auto& c, auto& v) {
                contactVolume(probe, tile, X.inverse(), c, workspace, v, {kRule, of_b, Vector3::Zero()});
              }));
    EXPECT_EQ(at_joint, marked([&](auto& c, auto& v) {
                contactVolumeByCutting(tile, probe, X, c, workspace, v, {kRule, of_a, Vector3::Zero()});
              }));
    EXPECT_FALSE(marked([&](auto& c, auto& v) { contactVolume(tile, probe, X, c, workspace, v); }));
  }
}

}  // namespace internal_faces_test
}  // namespace haptic
