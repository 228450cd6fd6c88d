#include <cmath>
#include <cstdio>
#include <functional>

#include "../comparators/named_attempts.h"
#include "../scenes/motions.h"
#include "allocation_count.h"
#include "dynamics_figures.h"
#include "figure.h"
#include "peer_world.h"

namespace haptic::bench {
namespace {

using namespace scenes;

WorldSettings verlet(double h) {
  WorldSettings s;
  s.step = h;
  s.comparator = comparators::velocityVerlet;
  s.pressure_law = PressureLaw::kLinear;
  s.energy_ledger = false;
  return s;
}

CubeParameters stackCube() {
  CubeParameters c;
  c.stiffness = 1e7;
  c.ratio = 0.1;
  c.tangential_ratio = 0.1;
  return c;
}

/// Seconds per step at rest, median of nine.
double stepSeconds(World& world, int calls) {
  for (int i = 0; i < 200; ++i) world.step();
  return secondsPerCall([&](int) { world.step(); }, calls);
}

double speedRms(const World& world, int first, int count) {
  double sum = 0;
  for (int i = first; i < first + count; ++i) sum += world.linkTwist(i).linear.squaredNorm();
  return std::sqrt(sum / count);
}

/// Slope of log(time per step) over log(N).
double exponent(const std::vector<int>& sizes, const std::function<WorldDef(int)>& scene) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int n : sizes) {
    World world(scene(n));
    const double seconds = stepSeconds(world, std::max(20, 4000 / n));
    const double x = std::log(n), y = std::log(seconds);
    std::printf("blocks: %d in %.3f us\n", n, 1e6 * seconds);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double n = static_cast<double>(sizes.size());
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// N cubes beside one another on one floor.
WorldDef spread(int n, const CubeParameters& c, const WorldSettings& settings) {
  WorldDef def = cubeOnFloor(c, settings);
  def.articulations.resize(1);
  def.articulations[0] = floorBox(10);
  const int side = static_cast<int>(std::ceil(std::sqrt(n)));
  for (int i = 0; i < n; ++i) {
    const Vector3 p(0.2 * (i % side) - 0.1 * side, 0.2 * (i / side) - 0.1 * side, c.size / 2 - c.restDepth());
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(p)));
  }
  return def;
}

/// Five rows of 5, 4, 3, 2, 1 cubes, each on the joint of two below.
WorldDef pyramid(const CubeParameters& c, const WorldSettings& settings) {
  WorldDef def = cubeOnFloor(c, settings);
  def.articulations.resize(1);
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i < 5 - row; ++i) {
      const double x = (i - 0.5 * (4 - row)) * (c.size + 0.01);
      const double z = c.size / 2 + row * c.size - (row + 1) * c.restDepth();
      def.articulations.push_back(cube("cube" + std::to_string(row) + std::to_string(i), c, Pose(Vector3(x, 0, z))));
    }
  }
  return def;
}

}  // namespace

void stacks() {
  {
    World world(cubeOnFloor(CubeParameters{}, verlet(1e-3)));
    figure("one_cube.step_ns", 1e9 * stepSeconds(world, 5000), "ns");
  }
  const CubeParameters c = stackCube();
  {
    World world(stack(15, c, verlet(0.25e-3)));
    figure("stack15.substep_us", 1e6 * stepSeconds(world, 400), "us");
    while (world.time() < 5) world.step();
    double squares = 0, depth_error = 0;
    for (int i = 0; i < 400; ++i) {
      world.step();
      squares += std::pow(speedRms(world, 1, 15), 2);
    }
    for (int i = 0; i < world.contactCount(); ++i) {
      const ContactReport& contact = world.contact(i);
      const double expected = (15 - std::min(contact.link_a, contact.link_b)) * c.restDepth();
      depth_error = std::max(depth_error, std::abs(contact.volume / contact.area / expected - 1));
    }
    const bool stands = world.linkPose(15).p.z() > 14.4 * c.size;
    figure("stack15.stands", stands ? 1 : 0, "1");
    figure("stack15.depth_rel_err", depth_error, "1");
    figure("stack15.rms_v", std::sqrt(squares / 400), "m/s");
    double deepest = 0;
    for (int i = 0; i < world.contactCount(); ++i) deepest = std::max(deepest, world.contact(i).depth);
    figure("stack15.sink_explicit_um", 1e6 * deepest, "um");
    figure("stack15.sink_top_explicit_um", 1e6 * (14.5 * c.size - world.linkPose(15).p.z()), "um");
  }
  {
    World world(stack(15, c, verlet(0.25e-3), 1e-4));
    while (world.time() < 5) world.step();
    figure("stack15.stands_jittered", world.linkPose(15).p.z() > 14.4 * c.size ? 1 : 0, "1");
  }
  {
    World world(pyramid(c, verlet(0.25e-3)));
    while (world.time() < 1) world.step();
    std::vector<Vector3> start;
    for (int i = 1; i <= 15; ++i) start.push_back(world.linkPose(i).p);
    while (world.time() < 6) world.step();
    double drift = 0;
    for (int i = 1; i <= 15; ++i) drift = std::max(drift, (world.linkPose(i).p - start[i - 1]).norm());
    figure("pyramid15.drift_mm", 1e3 * drift, "mm");
  }
  std::vector<int> stacked, apart = {4, 8, 16, 31, 62, 125, 250, 500};
  for (int n = 4; n <= 15; ++n) stacked.push_back(n);
  const double a = exponent(stacked, [&](int n) { return stack(n, c, verlet(0.25e-3)); });
  const double b = exponent(apart, [&](int n) { return spread(n, CubeParameters{}, verlet(1e-3)); });
  figure("blocks.time_exponent", std::max(a, b), "1");
}

/// Heap allocations of 2000 steps of each method, on a scene with touch, slip and parting.
void allocations() {
  long count = 0;
  for (const comparators::NamedAttempts& method : comparators::kNamedAttempts) {
    WorldSettings settings = verlet(1e-3);
    method.into(settings);
    settings.energy_ledger = true;
    WorldDef def = stack(4, CubeParameters{}, settings, 1e-3);
    def.articulations[4].V_WA.linear = Vector3(0.5, 0.1, 1);
    World world(def);
    const long before = allocationCount();
    for (int i = 0; i < 2000; ++i) world.step();
    count += allocationCount() - before;
  }
  figure("allocations.dynamics", static_cast<double>(count), "1");
}

/// What the same scenes cost the peers, and how far the stack sinks there.
void peers() {
  using haptic::peers::Peer;
  const haptic::peers::PeerSettings list[] = {{Peer::kOdeExact, 20, 1e-3},      {Peer::kOdeQuick, 20, 1e-3},
                                              {Peer::kBullet, 10, 1e-3},        {Peer::kBullet, 50, 1e-3},
                                              {Peer::kMujocoEuler, 20, 1e-3},   {Peer::kMujocoRk4, 20, 1e-3}};
  CubeParameters c;
  for (const auto& settings : list) {
    const std::string label = haptic::peers::name(settings);
    for (int n : {1, 15}) {
      WorldDef def = stack(n, c, verlet(1e-3));
      for (int i = 1; i <= n; ++i) def.articulations[i].X_WA.p.z() = (i - 0.5) * c.size;
      const auto world = haptic::peers::makePeer(def, settings);
      for (int i = 0; i < 1000; ++i) world->step();
      const double seconds = secondsPerCall([&](int) { world->step(); }, n == 1 ? 200 : 20, 5);
      figure("peer." + label + (n == 1 ? ".one_cube_us" : ".stack15_us"), 1e6 * seconds, "us");
      if (n == 15) figure("peer." + label + ".stack15_sink_top_um", 1e6 * (14.5 * c.size - world->linkPose(15).p.z()), "um");
    }
    // So stiff that the edge starts on the floor: peers push out what overlaps. When it passes is interpolated, as for ours.
    const auto world = haptic::peers::makePeer(scenes::tiltedCube(verlet(1e-3), 1e16), settings);
    double squares = 0, when = 0;
    EdgeState before{0.1, 0};
    for (int i = 0; i < 2000; ++i) {
      world->step();
      const EdgeState now{tiltOf(world->linkPose(1)), -world->linkTwist(1).angular.y()};
      if (when == 0 && now.angle < 0.01) when = (i + passage(before, now, 0.01, 1e-3)) * 1e-3;
      before = now;
      if (i >= 1500) squares += std::pow(2.0 / 3 * world->linkTwist(1).angular.norm(), 2);
    }
    figure("peer." + label + ".tilt_time_err_ms", 1e3 * (when - 0.2318494), "ms");
    figure("peer." + label + ".tilt_residual_nms", std::sqrt(squares / 500), "N m s");
  }
}

}  // namespace haptic::bench
