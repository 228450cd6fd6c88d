// Balls, cylinders and capsules: what a contact costs beside ODE's points and our own polyhedron, how exact it
// is, and how they roll.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "allocation_count.h"
#include "ball_oracle.h"
#include "figure.h"
#include "haptic_core/contact/located_force.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "round_figures.h"
#include "round_peers.h"

namespace haptic::bench {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

ConvexPolyhedron stone(int corners, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < corners; ++i) {
    points.push_back(size * Vector3(normal(random), normal(random), normal(random)).normalized());
  }
  return ConvexPolyhedron::hull(points);
}

/// Eight poses of one pair; everything that a wrench needs, or ODE's points.
struct Pair {
  const ConvexShape &A, &B;
  Pose X[8];
  PairCache cache[8];
  ContactWorkspace workspace;
  ContactMaterial material = combine({}, {}, ContactMaterial());
  double sum = 0;

  Pair(const ConvexShape& a, const ConvexShape& b, const Vector3& place, const Vector3& axis = Vector3(1, 2, 3),
       const Matrix3& R = Matrix3::Identity())
      : A(a), B(b) {
    workspace.reserve(a, b);
    for (int i = 0; i < 8; ++i) {
      X[i].R = Eigen::AngleAxisd(0.3 + 0.1 * i, axis.normalized()).toRotationMatrix() * R;
      X[i].p = place + 1e-4 * i * Vector3(1, 1, 0);
    }
  }
  void ours(int i) {
    ContactVolume volume;
    contactVolume(A, B, X[i & 7], cache[i & 7], workspace, volume);
    if (volume.status != ContactVolume::Status::kOverlap) return;
    sum += normalPressure(volume, workspace, Twist{Vector3(0, 0.1, 0), Vector3(0, 0, -0.01)},
                          PressureLaw::kHuntCrossley, material)
               .force;
  }
};

double speeds(const char* name, Pair& pair, double& worst) {
  OdePair ode(pair.A, pair.B);
  int found = 0;
  // Turn by turn, so that a busy machine disturbs both alike.
  std::vector<double> mine, theirs;
  for (int turn = 0; turn < 15; ++turn) {
    mine.push_back(1e9 * secondsPerCall([&](int i) { pair.ours(i); }, 5000, 1));
    theirs.push_back(1e9 * secondsPerCall([&](int i) { found += ode.points(pair.X[i & 7]); }, 5000, 1));
  }
  const double ns = median(mine), ode_ns = median(theirs);
  figure(std::string(name) + "_ns", ns, "ns");
  if (found > 0) {
    figure(std::string(name) + "_ode_ns", ode_ns, "ns");
    worst = std::max(worst, ns / ode_ns);
  }
  return ns;
}

void measureSpeed() {
  const Ball ball(0.05);
  const ConvexPolyhedron box = makeBox(Vector3(0.1, 0.1, 0.1)), floor = makeBox(Vector3(4, 4, 0.5)),
                         hull = stone(100, 0.05, 1),
                         tessellated = makeSphere(0.05, 2, RoundFit::kEqualVolume);
  double worst = 0, other = 0;
  Pair on_floor(floor, ball, Vector3(0.1, 0.2, 0.299)), on_ball(ball, ball, Vector3(0.01, 0.005, 0.095)),
      on_box(box, ball, Vector3(0.01, 0.005, 0.099)), on_edge(box, ball, Vector3(0.085, 0.005, 0.085)),
      on_hull(hull, ball, Vector3(0.01, 0.005, 0.095)),
      hull_on_box(box, tessellated, Vector3(0.01, 0.005, 0.099));
  const HalfSpace ground;
  Pair on_plane(ground, ball, Vector3(0.1, 0.2, 0.049));
  speeds("sphere_halfspace", on_plane, worst);
  speeds("sphere_floor", on_floor, worst);
  speeds("sphere_sphere", on_ball, worst);
  const double mine = speeds("sphere_box", on_box, worst);
  speeds("sphere_box_edge", on_edge, worst);
  speeds("sphere_hull100", on_hull, worst);
  // Lying, turned about the vertical; a capsule along an edge of the box, over it.
  const Matrix3 lying = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()).toRotationMatrix();
  const Rod cylinder(0.05, 0.1, Rod::Ends::kFlat), capsule(0.05, 0.1, Rod::Ends::kRound);
  const ConvexPolyhedron table = makeBox(Vector3(0.4, 0.4, 0.1));
  Pair lies(floor, cylinder, Vector3(0.1, 0.2, 0.299), Vector3::UnitZ(), lying),
      stands(floor, cylinder, Vector3(0.1, 0.2, 0.299), Vector3::UnitZ()),
      lies_on_plane(ground, cylinder, Vector3(0.1, 0.2, 0.049), Vector3::UnitZ(), lying),
      stands_on_plane(ground, cylinder, Vector3(0.1, 0.2, 0.049), Vector3::UnitZ()),
      capsule_on_plane(ground, capsule, Vector3(0.1, 0.2, 0.049), Vector3::UnitZ(), lying),
      on_table(table, capsule, Vector3(0.01, 0.005, 0.099), Vector3::UnitZ(), lying),
      over_edge(table, capsule, Vector3(0.2, 0.005, 0.099), Vector3::UnitZ(), lying),
      on_cylinder(cylinder, ball, Vector3(0.06, 0.078, 0.01)), on_capsule(capsule, ball, Vector3(0.06, 0.078, 0.01));
  speeds("cylinder_halfspace", lies_on_plane, worst);
  speeds("cylinder_halfspace_standing", stands_on_plane, worst);
  speeds("capsule_halfspace", capsule_on_plane, worst);
  speeds("cylinder_floor", lies, worst);
  speeds("cylinder_floor_standing", stands, worst);
  speeds("capsule_box", on_table, worst);
  speeds("capsule_box_edge", over_edge, worst);
  speeds("sphere_cylinder", on_cylinder, worst);
  speeds("sphere_capsule", on_capsule, worst);
  figure("round.worst_vs_ode", worst, "");
  figure("sphere_box_vs_hull162", mine / speeds("hull162_box", hull_on_box, other), "");
  const long before = allocationCount();
  for (int i = 0; i < 1000; ++i)
    on_floor.ours(i), on_ball.ours(i), on_box.ours(i), on_edge.ours(i), on_hull.ours(i), lies.ours(i), stands.ours(i), on_table.ours(i),
        over_edge.ours(i), on_plane.ours(i), lies_on_plane.ours(i), capsule_on_plane.ours(i), on_cylinder.ours(i), on_capsule.ours(i);
  figure("allocations.round", static_cast<double>(allocationCount() - before), "");
}

/// Over faces, edges and corners by 1e-9 to 1 radius, centres on them, and anywhere.
Vector3 hardPlace(const ConvexPolyhedron& shape, double R, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  const auto& face = shape.faces()[random() % shape.faceCount()];
  const auto corner = [&](int k) { return shape.vertices()[shape.loopVertex(face.first + k)]; };
  const double depth = R * std::pow(10, -9 * std::abs(u(random))), s = std::abs(u(random)),
               t = (1 - s) * std::abs(u(random));
  const Vector3 out = (face.normal + 0.8 * Vector3(u(random), u(random), u(random))).normalized();
  const Vector3 on_edge = corner(0) + s * (corner(1) - corner(0)),
                on_face = on_edge + t * (corner(2) - corner(0));
  // The oracle needs the centre off planes and edges, by any distance.
  const Vector3 off =
      1e-8 * R * Vector3(0.3 + std::abs(u(random)), 0.2 + std::abs(u(random)), -0.1 - std::abs(u(random)));
  switch (random() % 7) {
    case 0:
      return corner(0) + (R - depth) * out;
    case 1:
      return on_edge + (R - depth) * out;
    case 2:
      return on_face + (R - depth) * face.normal;
    case 3:
      return corner(0) + off;
    case 4:
      return on_edge + off;
    case 5:
      return on_face + off;
    default:
      return shape.centre() + (shape.boundingRadius() + R) * Vector3(u(random), u(random), u(random));
  }
}

/// Error of the volume beyond what the rounding of the bodies' places makes of it, and as it is.
void measureAccuracy(int pairs) {
  const std::vector<ConvexPolyhedron> shapes = {makeBox(Vector3(1, 1.2, 0.8)), makeBox(Vector3(2, 2, 0.05)),
                                                stone(100, 0.5, 1), stone(4, 0.7, 2)};
  std::mt19937_64 random(11);
  double beyond = 0, deep = 0, rounding = 0;
  int empty = 0, failures = 0;
  for (int i = 0; i < pairs; ++i) {
    const ConvexPolyhedron& shape = shapes[random() % shapes.size()];
    const double R = std::vector<double>{0.02, 0.5, 3}[random() % 3];
    const Ball ball(R);
    ContactWorkspace workspace;
    workspace.reserve(shape, ball);
    const Vector3 c = hardPlace(shape, R, random);
    PairCache cache;
    ContactVolume found;
    contactVolume(shape, ball, Pose(c), cache, workspace, found);
    const oracle::BallOverlap exact(shape, c, R);
    const double V = static_cast<double>(exact.volume), size = shape.boundingRadius() + R;
    if (!(V > 1e-30 * R * R * R)) continue;
    if (found.status != ContactVolume::Status::kOverlap) {
      ++empty;
      continue;
    }
    failures += !std::isfinite(found.volume) || !found.X_AP.p.allFinite() || !found.V2.allFinite() ||
                !found.A2.allFinite();
    const double error = std::abs(static_cast<double>(exact.volume - static_cast<__float128>(found.volume)));
    const double surface = std::min(std::pow(V, 2.0 / 3) * 1e2, R * R) + found.area_vector_A.norm();
    beyond = std::max(beyond, (error - 4 * kEps * size * surface) / V);
    rounding = std::max(rounding, error / (size * surface));
    if (V > 1e-2 * R * R * R) deep = std::max(deep, error / V);
  }
  figure("round.volume_err_beyond_rounding", std::max(0.0, beyond), "");
  figure("round.volume_err_deep", deep, "");
  figure("round.volume_err_eps", rounding / kEps, "eps·size·area");
  figure("round.false_empty", empty, "");
  figure("round.failures", failures, "");
}

/// Across faces, edges, corners and the centre's cases, 1e-9 radii at a time: change of the force beyond its
/// derivative.
void measureJumps(int moves) {
  const double R = 0.5, step = 1e-9 * R;
  const ConvexPolyhedron box = makeBox(Vector3(1, 1.2, 0.8));
  const Ball ball(R);
  ContactWorkspace workspace;
  workspace.reserve(box, ball);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  const Vector3 turning[] = {{0.5, 0.6, 0.4},   {0.5, 0, 0.4},   {0, 0, 0.4},    {0, 0, 0.7},
                             {0.8, 0.9, 0.4},   {0.3, 0.6, 0.7}, {0, 0.7, 0.65}, {0, 0, -0.1},
                             {0.25, 0.1, 0.65}, {0.6, 0.7, 0.5}};
  double worst = 0;
  for (int i = 0; i < moves; ++i) {
    const Vector3 at = turning[i % 10] + 2 * step * Vector3(u(random), u(random), u(random));
    const Vector3 move = step * Vector3(u(random), u(random), u(random));
    ContactVolume before, after;
    PairCache cache;
    contactVolume(box, ball, Pose(at), cache, workspace, before);
    contactVolume(box, ball, Pose(at + move), cache, workspace, after);
    if (before.status != ContactVolume::Status::kOverlap) continue;
    const double change = after.volume - before.volume + before.area_vector_A.dot(move);
    worst = std::max(worst, std::abs(change) / before.volume);
  }
  figure("round.wrench_jump", worst, "");
}

/// The same of rods, over faces, edges, corners and ends, and how well two halves of a box add up.
void measureRods(int moves) {
  const double R = 0.2, L = 0.6, step = 1e-9 * R;
  const Vector3 size(1, 1.2, 0.8);
  const ConvexPolyhedron box = makeBox(size), left = makeBox(size - Vector3(0.37, 0, 0)), right = makeBox(Vector3(0.37, 1.2, 0.8));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  double jump = 0, halves = 0;
  int failures = 0;
  for (const auto ends : {Rod::Ends::kFlat, Rod::Ends::kRound}) {
    const Rod rod(R, L, ends);
    ContactWorkspace workspace;
    workspace.reserve(box, rod);
    const auto volume = [&](const ConvexPolyhedron& shape, const Pose& X) {
      ContactVolume found;
      PairCache cache;
      contactVolume(shape, rod, X, cache, workspace, found);
      failures += found.status == ContactVolume::Status::kOverlap && !(found.X_AP.p.allFinite() && found.V2.allFinite());
      return found;
    };
    for (int i = 0; i < moves / 2; ++i) {
      const Matrix3 about = Quaternion(u(random), u(random), u(random), u(random)).normalized().toRotationMatrix();
      const Vector3 at = 0.9 * Vector3(u(random), u(random), u(random)), move = step * Vector3(u(random), u(random), u(random));
      const ContactVolume before = volume(box, Pose(about, at));
      if (before.status != ContactVolume::Status::kOverlap || before.volume < 1e-6) continue;
      const double change = volume(box, Pose(about, at + move)).volume - before.volume;
      jump = std::max(jump, std::abs(change + before.area_vector_A.dot(move)) / before.volume);
      const auto part = [&](const ConvexPolyhedron& shape, double x) {
        const ContactVolume found = volume(shape, Pose(about, at - Vector3(x, 0, 0)));
        return found.status == ContactVolume::Status::kOverlap ? found.volume : 0;
      };
      halves = std::max(halves, std::abs(part(left, -0.185) + part(right, 0.315) - before.volume) / before.volume);
    }
  }
  figure("rod.wrench_jump", jump, "");
  figure("rod.halves_err_rel", halves, "");
  figure("rod.failures", failures, "");
}

}  // namespace
}  // namespace haptic::bench

/// Without a word all; else those groups whose name holds it.
int main(int count, char** arguments) {
  using namespace haptic::bench;
  const auto wanted = [&](const char* group) { return count < 2 || std::strstr(group, arguments[1]) != nullptr; };
  if (wanted("speed")) measureSpeed();
  if (wanted("accuracy")) measureAccuracy(100000);
  if (wanted("jumps")) measureJumps(1000000);
  if (wanted("rods")) measureRods(100000);
  if (wanted("motion")) measureRoundMotion();
  if (wanted("rolling")) measureRollingBalls();
  if (wanted("six")) measureSix();
}
