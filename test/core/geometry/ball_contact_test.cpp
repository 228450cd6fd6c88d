#include "haptic_core/geometry/pairs/ball_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "ball_oracle.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_integrals.h"
#include "haptic_core/geometry/volume/round_patch.h"
#include "random_pairs.h"

namespace haptic {
namespace ball_contact_test {

using random_pairs::Contact;
using random_pairs::contactOf;
using random_pairs::randomPose;
using random_pairs::stone;
using Status = ContactVolume::Status;
constexpr double kEps = std::numeric_limits<double>::epsilon();

TEST(BallContact, OnAFaceIsASphericalCap) {
  const double R = 0.3;
  const ConvexPolyhedron box = makeBox(Vector3(4, 4, 4));
  for (double depth : {1e-9, 1e-6, 1e-3, 0.1, 0.3, 0.45, 0.59}) {
    const Contact c = contactOf(box, Ball(R), Pose(Vector3(0.1, -0.2, 2 + R - depth)));
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    const double V = M_PI * depth * depth * (R - depth / 3), a2 = depth * (2 * R - depth);
    // The centre's height is rounded to kEps · 2.3 m, which the depth has too.
    const double rounding = 4 * kEps * 2.3 / depth + 10 * kEps;
    EXPECT_NEAR(c.volume.volume, V, 2 * rounding * V) << depth;
    EXPECT_NEAR(c.volume.A0, M_PI * a2, rounding * M_PI * a2);
    EXPECT_NEAR(c.volume.A2(0, 0), M_PI * a2 * a2 / 4, 2 * rounding * a2 * a2);
    EXPECT_NEAR((c.volume.normal() - Vector3::UnitZ()).norm(), 0, kEps);
    // ∫ t dV from the pole, ρ² = t (2R - t).
    const double mean = (2 * R / 3 - depth / 4) / (R - depth / 3) * depth;
    EXPECT_NEAR(c.volume.X_AP.p.z(), 2 - depth + mean, 4 * kEps * 2.3);
    EXPECT_NEAR(c.volume.V2(1, 1),
                M_PI / 4 * std::pow(depth, 3) * (4 * R * R / 3 - R * depth + depth * depth / 5),
                4 * rounding * V * a2);
  }
}

TEST(BallContact, WithEdgesAndCornersMatchesTheOracle) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1, 1);
  std::normal_distribution<double> normal;
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(1, 1.2, 0.8)), makeBox(Vector3(2, 2, 0.05)),
                                                stone(100, 0.5, 1), stone(4, 0.7, 2)};
  for (const ConvexPolyhedron& shape : shapes) {
    for (const double R : {0.02, 0.5, 3.0}) {
      const Ball ball(R);
      ContactWorkspace workspace;
      workspace.reserve(shape, ball);
      for (int i = 0; i < 40; ++i) {
        const auto& face = shape.faces()[random() % shape.faceCount()];
        const auto corner = [&](int k) { return shape.vertices()[shape.loopVertex(face.first + k)]; };
        // Over a corner, an edge or a face, by 1e-9 to 1 radius deep; centres on faces, edges and corners;
        // anywhere.
        const double depth = R * std::pow(10, -9 * std::abs(u(random)));
        const Vector3 out = (face.normal + 0.8 * Vector3(u(random), u(random), u(random))).normalized();
        const double s = std::abs(u(random)), t = (1 - s) * std::abs(u(random));
        const Vector3 on_edge = corner(0) + s * (corner(1) - corner(0)),
                      on_face = on_edge + t * (corner(2) - corner(0));
        // The oracle needs the centre off planes and edges, by any distance.
        const Vector3 off =
            1e-8 * R *
            Vector3(0.3 + std::abs(u(random)), 0.2 + std::abs(u(random)), -0.1 - std::abs(u(random)));
        const Vector3 places[] = {
            corner(0) + (R - depth) * out,
            on_edge + (R - depth) * out,
            on_face + (R - depth) * face.normal,
            corner(0) + off,
            on_edge + off,
            on_face + off,
            shape.centre() + (shape.boundingRadius() + R) * Vector3(u(random), u(random), u(random))};
        for (const Vector3& c : places) {
          PairCache cache;
          ContactVolume found;
          contactVolume(shape, ball, Pose(c), cache, workspace, found);
          const oracle::BallOverlap exact(shape, c, R);
          const double V = std::max(0.0, static_cast<double>(exact.volume)),
                       size = shape.boundingRadius() + R;
          const Vector3 S(static_cast<double>(exact.area_vector[0]),
                          static_cast<double>(exact.area_vector[1]),
                          static_cast<double>(exact.area_vector[2]));
          const double volume = found.status == Status::kOverlap ? found.volume : 0;
          // Rounded places of faces and of the ball: ten roundings of the size over the surface that looks
          // out.
          const double surface = std::min(std::pow(V, 2.0 / 3) * 1e2, R * R) + S.norm();
          EXPECT_NEAR(volume, V, 1e-13 * V + 10 * kEps * size * surface + 1e-33 * R * R * R)
              << c.transpose() << " R " << R;
          EXPECT_FALSE(volume == 0 && V > 1e-30 * R * R * R) << c.transpose();
          if (!(V > 1e-6 * R * R * R)) continue;
          EXPECT_NEAR((found.area_vector_A - S).norm(), 0, 1e-11 * R * R);
          const Vector3 centroid(static_cast<double>(exact.first[0] / exact.volume),
                                 static_cast<double>(exact.first[1] / exact.volume),
                                 static_cast<double>(exact.first[2] / exact.volume));
          EXPECT_NEAR((found.X_AP.p - c - centroid).norm(), 0, 1e-9 * size);
        }
      }
    }
  }
}

/// Two planes whose circles all but touch, the centre inside: the ball less two caps. The point of the sphere from which the sums look
/// away is then as near to the other circle as it can be.
TEST(BallContact, CutByTwoPlanesAroundItsCentreIsTheBallLessTheirCaps) {
  const double R = 0.5, whole = 4 * M_PI / 3 * R * R * R;
  const ConvexPolyhedron box = makeBox(Vector3(2, 2, 2));
  for (int i = 1; i < 40; ++i) {
    const double angle = i * M_PI / 160, other = (M_PI / 2 - angle) * (1 - 1e-6);  // of the circles, seen from the centre
    const Vector3 c(1 - R * std::cos(angle), 1 - R * std::cos(other), 0.1);
    const auto cap = [&](double height) { return M_PI * (R - height) * (R - height) * (2 * R + height) / 3; };
    const double V = whole - cap(1 - c.x()) - cap(1 - c.y());
    // 16 roundings of the sums, and of the planes' places over R.
    EXPECT_NEAR(contactOf(box, Ball(R), Pose(c)).volume.volume, V, (16 + 2 / R) * kEps * whole) << i;
  }
}

/// The sphere through a corner, within rounding, has the volume of spheres a little smaller and larger; so have all that follow it.
TEST(BallContact, ThroughACornerIsBetweenItsNeighbours) {
  std::mt19937 random(9);
  const double R = 0.2;
  for (const ConvexPolyhedron& shape : {makeBox(Vector3(0.5, 0.4, 0.3)), stone(30, 0.4, 5), stone(4, 0.3, 6)}) {
    for (int i = 0; i < 300; ++i) {
      const Vector3 way = random_pairs::randomDirection(random);
      const Vector3 c = shape.vertices()[random() % shape.vertexCount()] - R * way;
      const auto volume = [&](double radius) {
        const Contact found = contactOf(shape, Ball(radius), Pose(c));
        return found.volume.status == Status::kOverlap ? found.volume.volume : 0;
      };
      const double slack = 1e-13 * R * R * R;
      EXPECT_GE(volume(R), volume(R * (1 - 1e-9)) - slack) << i;
      EXPECT_LE(volume(R), volume(R * (1 + 1e-9)) + slack) << i;
    }
  }
}

TEST(BallContact, WithItsCentreOnACornerAnEdgeOrAFaceIsAnEighthAQuarterOrAHalf) {
  const double R = 0.1, V = 4 * M_PI / 3 * R * R * R;
  const ConvexPolyhedron box = makeBox(Vector3(1, 1, 1));
  const std::pair<Vector3, double> cases[] = {
      {{0.5, 0.5, 0.5}, 8}, {{0.5, 0, 0.5}, 4}, {{0.5, 0.1, 0.2}, 2}, {{0, 0, 0}, 1}};
  for (const auto& [place, share] : cases) {
    const Contact c = contactOf(box, Ball(R), Pose(place));
    EXPECT_NEAR(c.volume.volume, V / share, 20 * kEps * V) << share;
    // Each flat side is 3/8 R from the centroid.
    const Vector3 way = place.cwiseSign() * (share > 1 ? 0.375 * R : 0);
    if (share == 8) EXPECT_NEAR((c.volume.X_AP.p - place + way).norm(), 0, 20 * kEps);
  }
}

/// Against a polyhedron of 10 242 corners of the same volume: moments to its own error, and which body comes
/// first.
TEST(BallContact, MomentsAreThoseOfAFinePolyhedron) {
  std::mt19937 random(3);
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8)),
                         fine = makeSphere(0.5, 5, RoundFit::kEqualVolume);
  const Ball ball(0.5);
  int compared = 0;
  for (int i = 0; i < 60; ++i) {
    Pose X = randomPose(random, 0.9);
    const bool box_first = i % 2 == 0;
    if (!box_first) X = X.inverse();
    Contact c = box_first ? contactOf(box, ball, X) : contactOf(ball, box, X);
    Contact f = box_first ? contactOf(box, fine, X) : contactOf(fine, box, X);
    if (c.volume.status != Status::kOverlap || c.volume.volume < 0.01 || c.volume.A0 < 0.1) continue;
    ++compared;
    // Surfaces 1e-4 apart at most, alternating in sign: about 1e-5 of the moments.
    EXPECT_NEAR(c.volume.volume, f.volume.volume, 3e-5 * 0.5);
    EXPECT_NEAR((c.volume.normal() - f.volume.normal()).norm(), 0, 2e-4);
    EXPECT_NEAR((c.volume.X_AP.p - f.volume.X_AP.p).norm(), 0, 5e-5);
    EXPECT_NEAR((c.volume.X_AP.R * c.volume.V2.trace() - f.volume.X_AP.R * f.volume.V2.trace()).norm(), 0,
                1e-5);
    EXPECT_NEAR((c.volume.V2 - f.volume.V2).norm(), 0, 1e-5);
    EXPECT_NEAR(c.volume.A0, f.volume.A0, 1e-4);
    EXPECT_NEAR((c.volume.A1 - f.volume.A1).norm(), 0, 1e-4);
    EXPECT_NEAR((c.volume.A2 - f.volume.A2).norm(), 0, 1e-4);
    if (c.volume.volume > 0.2) continue;  // more than half inside V folds over, and an ellipse stands in
    EXPECT_NEAR(thicknessSquared(c.workspace, c.volume), thicknessSquared(f.workspace, f.volume),
                2e-3 * thicknessSquared(f.workspace, f.volume));
  }
  EXPECT_GT(compared, 20);
}

TEST(BallContact, TwoBallsAreTwoCaps) {
  const double ra = 0.3, rb = 0.2;
  for (double depth : {1e-9, 1e-4, 0.05, 0.2, 0.39}) {
    const double d = ra + rb - depth;
    const Pose X(d * Vector3(2, 3, 6) / 7);
    const Contact c = contactOf(Ball(ra), Ball(rb), X), r = contactOf(Ball(rb), Ball(ra), X);
    const double V =
        M_PI * depth * depth * (d * d + 2 * d * (ra + rb) - 3 * (ra - rb) * (ra - rb)) / (12 * d);
    const double rounding = 4 * kEps / depth + 20 * kEps;
    ASSERT_EQ(c.volume.status, Status::kOverlap);
    EXPECT_NEAR(c.volume.volume, V, 2 * rounding * V);
    EXPECT_NEAR(r.volume.volume, V, 2 * rounding * V);
    EXPECT_NEAR((c.volume.normal() - Vector3(2, 3, 6) / 7).norm(), 0, 4 * kEps);
    EXPECT_NEAR(c.volume.X_AP.p.dot(c.volume.normal()) + r.volume.X_AP.p.dot(r.volume.normal()), d, 4 * kEps);
  }
  const Contact inside = contactOf(Ball(ra), Ball(rb), Pose(Vector3(0, 0.05, 0)));
  EXPECT_NEAR(inside.volume.volume, 4 * M_PI / 3 * rb * rb * rb, 1e-15);
  EXPECT_NEAR((inside.volume.normal() - Vector3::UnitY()).norm(), 0, kEps);
  const Contact same = contactOf(Ball(ra), Ball(rb), Pose());
  EXPECT_EQ(same.volume.status, Status::kOverlap);
  EXPECT_TRUE(same.volume.flags & ContactVolume::kNormalFromHistory);
  EXPECT_EQ(contactOf(Ball(ra), Ball(rb), Pose(Vector3(0, 0, 0.51))).volume.status, Status::kSeparated);
}

/// A small move changes the force by its derivative, k δ·S, and by no jump: over faces, edges, corners and
/// through the centre.
TEST(BallContact, DoesNotJumpWhereTheCaseChanges) {
  const double R = 0.5, step = 1e-9 * R;
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8));
  const Ball ball(R);
  ContactWorkspace workspace;
  workspace.reserve(box, ball);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  const Vector3 turning[] = {{0.5, 0.6, 0.4}, {0.5, 0, 0.4},    {0, 0, 0.4},   {0, 0, 0.9},
                             {1, 0.6, 0.4},   {0.5, 0.6, 0.9},  {0, 0.6, 0.9}, {0.5, 0.6, 0.4 + R},
                             {0, 0, -0.1},    {0.25, 0.1, 0.65}};
  for (int i = 0; i < 20000; ++i) {
    const Vector3 at = turning[i % 10] + 2 * step * Vector3(u(random), u(random), u(random));
    const Vector3 move = step * Vector3(u(random), u(random), u(random));
    ContactVolume before, after;
    PairCache cache;
    contactVolume(box, ball, Pose(at), cache, workspace, before);
    if (before.status != Status::kOverlap || before.volume < 1e-9) continue;
    contactVolume(box, ball, Pose(at + move), cache, workspace, after);
    const double change = after.volume - before.volume, rate = -before.area_vector_A.dot(move);
    // Rounding of the places over the surface.
    EXPECT_NEAR(change, rate, 20 * kEps * R * R + 1e-13 * before.volume) << at.transpose();
    EXPECT_NEAR((after.X_AP.p - before.X_AP.p).norm(), 0, 20 * step + 1e-12) << at.transpose();
  }
}

/// d(r) = √(R² - r²) - h over the disc of radius a.
struct Cap {
  double R = 0.5, depth = 0.05, h = R - depth, a2 = depth * (2 * R - depth);
  template <class Weight>
  double integral(Weight weight) const {  // ∫ weight(r, d) 2π r dr, midpoints in r²: d is smooth there
    const int n = 200000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double r2 = (i + 0.5) / n * a2;
      sum += M_PI * a2 / n * weight(std::sqrt(r2), std::sqrt(R * R - r2) - h);
    }
    return sum;
  }
};

TEST(RoundPatch, IntegratesTheLens) {
  const Cap cap;
  const ConvexPolyhedron box = makeBox(Vector3(4, 4, 4));
  for (const bool box_first : {true, false}) {
    const Pose X(Vector3(0.1, 0.2, 2 + cap.h));
    Contact c = box_first ? contactOf(box, Ball(cap.R), X) : contactOf(Ball(cap.R), box, X.inverse());
    EXPECT_NEAR(thicknessSquared(c.workspace, c.volume), cap.integral([](double, double d) { return d * d; }),
                1e-9 * c.volume.volume * cap.depth);
    // What a pressure that vanishes on a line through the middle has on one side, ∫ max(0, x) d dA = ∫ 2 r² d
    // dr. The samples see the bend to the square of their distance.
    const PartMoments half = momentsWhere(c.workspace, c.volume, Vector2(-1, 0), 0);
    const double exact = cap.integral([](double r, double d) { return r * d / M_PI; });
    EXPECT_NEAR(half.V1.x(), exact, 5e-3 * exact);
    EXPECT_EQ(momentsWhere(c.workspace, c.volume, Vector2(1, 0), 1).volume, c.volume.volume);
    const double square = thicknessSquared(c.workspace, c.volume);
    c.volume.rise = -0.7 * cap.depth;  // in a plane of its own, as on a seam
    c.volume.X_AP.p += c.volume.rise * c.volume.normal();
    EXPECT_NEAR(thicknessSquared(c.workspace, c.volume), square, 1e-12 * square);
  }
}

/// ∫ f from a to b by Simpson's rule, halved until two steps agree within `tolerance`.
template <class F>
double adaptive(const F& f, double a, double b, double tolerance, int halvings) {
  const double m = 0.5 * (a + b);
  struct Rule {
    const F& f;
    double between(double a, double fa, double m, double fm, double b, double fb, double whole, double tolerance, int halvings) const {
      const double l = 0.5 * (a + m), r = 0.5 * (m + b), fl = f(l), fr = f(r);
      const double left = (m - a) / 6 * (fa + 4 * fl + fm), right = (b - m) / 6 * (fm + 4 * fr + fb), change = left + right - whole;
      if (halvings <= 0 || std::abs(change) <= 15 * tolerance) return left + right + change / 15;
      return between(a, fa, l, fl, m, fm, left, tolerance / 2, halvings - 1) +
             between(m, fm, r, fr, b, fb, right, tolerance / 2, halvings - 1);
    }
  };
  const double fa = f(a), fm = f(m), fb = f(b);
  return Rule{f}.between(a, fa, m, fm, b, fb, (b - a) / 6 * (fa + 4 * fm + fb), tolerance, halvings);
}

/// ∫ d² dA of a ball and a polyhedron, d from the planes and the sphere, over a box about the patch's outline.
double squaresOf(const ConvexPolyhedron& shape, double R, const Pose& X_AB, const Contact& c, const RoundVolume& round) {
  const Pose& X_AP = c.volume.X_AP;
  const Vector3 centre = X_AP.R.transpose() * (X_AB.p - X_AP.p);
  Vector2 low(INFINITY, INFINITY), high = -low, rate;
  for (const RoundVolume::Curve& curve : round.curves) {
    for (int i = 0; i <= 32; ++i) low = low.cwiseMin(curve.at(i / 32.0, rate)), high = high.cwiseMax(curve.at(i / 32.0, rate));
  }
  const Vector2 beyond = 0.02 * (high - low);  // between two points of an arc, and where V folds over a little
  low -= beyond, high += beyond;
  const auto thickness = [&](double x, double y) {
    const double left = R * R - (Vector2(x, y) - centre.head<2>()).squaredNorm();
    if (left <= 0) return 0.0;
    double bottom = centre.z() - std::sqrt(left), top = centre.z() + std::sqrt(left);
    for (const auto& face : shape.faces()) {
      const Vector3 n = X_AP.R.transpose() * face.normal;
      const double room = face.offset - face.normal.dot(X_AP.p) - n.x() * x - n.y() * y;
      if (n.z() > 0) top = std::min(top, room / n.z());
      if (n.z() < 0) bottom = std::max(bottom, room / n.z());
      if (n.z() == 0 && room < 0) return 0.0;
    }
    return std::max(0.0, top - bottom);
  };
  const double tolerance = 1e-8 * c.volume.volume * c.volume.depth, width = high.x() - low.x();
  constexpr int kStrips = 16;
  const auto over = [&](int strips, double from, double to, double allowed, int halvings, const auto& f) {
    double sum = 0;
    for (int i = 0; i < strips; ++i)
      sum += adaptive(f, from + (to - from) * i / strips, from + (to - from) * (i + 1) / strips, allowed / strips, halvings);
    return sum;
  };
  return over(kStrips, low.x(), high.x(), tolerance, 12, [&](double x) {
    return over(kStrips, low.y(), high.y(), 0.1 * tolerance / width, 20, [&](double y) { return std::pow(thickness(x, y), 2); });
  });
}

// Two ways to ∫ d² over edges and corners, V's moment about one plane less what other planes take off it, and samples of all of V, and
// an integration that knows neither. What round_patch.h states.
TEST(RoundPatch, SquareOverEdgesIsThatOfSamples) {
  constexpr double R = 0.3, kSquare = 1e-6, kSamples = 1e-5, kDeep = 1e-4;
  std::mt19937 random(5);
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8)), pebble = stone(40, 0.7, 6);
  int compared = 0, over_edges = 0, integrated = 0;
  for (int i = 0; i < 400; ++i) {
    const ConvexPolyhedron& other = i % 2 == 0 ? box : pebble;
    const Pose X = randomPose(random, 0.9);
    Contact c = contactOf(other, Ball(R), X);
    if (c.volume.status != Status::kOverlap) continue;
    const double square = thicknessSquared(c.workspace, c.volume);
    RoundVolume& round = c.workspace.round();
    RoundPatch patch(round, c.volume);
    patch.fit();
    const double found = round.sampled / c.volume.volume;
    if (!(std::abs(found - 1) < 1e-5)) continue;  // V folds over, or samples do not resolve it
    double sampled = 0;
    patch.eachSample([&](const Vector2&, double weight, double d) { sampled += weight * d * d; });
    const bool deep = c.volume.depth > 0.5 * R;
    EXPECT_NEAR(square, sampled, (deep ? kDeep : kSquare + kSamples) * sampled) << i;
    ++compared;
    over_edges += round.shares.size() > 1;
    if (deep || round.shares.size() == 1) continue;
    const double exact = squaresOf(other, R, X, c, round);
    EXPECT_NEAR(square, exact, kSquare * exact) << i;
    EXPECT_NEAR(sampled, exact, kSamples * exact) << i;
    ++integrated;
  }
  EXPECT_GT(compared, 60);
  EXPECT_GT(over_edges, 30);
  EXPECT_GT(integrated, 20);
}

TEST(ShapeDistance, OfBallsIsExact) {
  const ConvexPolyhedron box = makeBox(Vector3(1, 1, 1));
  const Ball ball(0.25);
  ClosestPoints near;
  closestPoints(box, ball, Pose(Vector3(0.8, 0.9, 0)), Vector3::UnitX(),
                near);  // nearest to an edge: (0.3, 0.4, 0) from it
  EXPECT_TRUE(near.separated);
  EXPECT_NEAR(near.distance, 0.25, 4 * kEps);
  EXPECT_NEAR((near.direction - Vector3(0.6, 0.8, 0)).norm(), 0, 4 * kEps);
  closestPoints(ball, box, Pose(Vector3(-0.8, -0.9, 0)), Vector3::UnitX(), near);
  EXPECT_NEAR(near.distance, 0.25, 4 * kEps);
  EXPECT_NEAR((near.direction + Vector3(0.6, 0.8, 0)).norm(), 0, 4 * kEps);
  EXPECT_NEAR((near.p_A - 0.25 * near.direction).norm(), 0, 4 * kEps);
  closestPoints(ball, Ball(0.5), Pose(Vector3(0, 0, 1)), Vector3::UnitX(), near);
  EXPECT_NEAR(near.distance, 0.25, 4 * kEps);
  closestPoints(ball, box, Pose(Vector3(0.1, 0, 0.7)), Vector3::UnitX(), near);
  EXPECT_FALSE(near.separated);
}

}  // namespace ball_contact_test
}  // namespace haptic
