/// `./run bench right`: contact against statics, kinematics and conservation laws, with every integrator.
///
/// An argument runs only the groups whose name contains it: corner, seam, overlay, carrier, balance, energy, power, impact, rolling, ring,
/// drop, order, belt, ground.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>

#include "../comparators/velocity_verlet.h"
#include "../scenes/inner_corner.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/contact/located_force.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

struct CornerRun {
  double force_error = 0;  ///< over the weight, last 20 steps
  double iterations = 0;   ///< most of any step
  double seconds = 0;      ///< of a step at rest
};

CornerRun runCorner(const CornerParameters& p, const NamedAttempts& method) {
  WorldSettings settings;
  method.into(settings);
  const double longest = 0.3 * std::sqrt(p.mass / (p.stiffness * 0.01));  // of an explicit step
  settings.step = method.comparator ? std::min(1e-3, longest) : 1e-3;
  World world(innerCorner(p, settings));
  CornerRun out;
  // Some thirty time constants of the start's motion, at least 250 steps.
  const int steps = 250, measured = 20;
  for (int i = 0; i < steps; ++i) {
    world.step();
    out.iterations = std::max<double>(out.iterations, world.report().iterations);
  }
  const double start = cpuSeconds();
  for (int i = 0; i < measured; ++i) {
    world.step();
    out.iterations = std::max<double>(out.iterations, world.report().iterations);
    out.force_error = std::max(out.force_error, cornerForceError(world, p) / (p.mass * kGravity));
  }
  out.seconds = (cpuSeconds() - start) / measured;
  return out;
}

void runCorners() {
  double worst = 0, iterations = 0;
  for (double k : {1e6, 1e7, 1e8, 1e9, 1e10, 1e11}) {
    double of_k = 0;
    for (const NamedAttempts& i : kNamedAttempts) {
      for (const Matrix3& R : quarterTurns()) {
        for (bool one_body : {false, true}) {
          CornerParameters p;
          p.R = R;
          p.stiffness = k;
          p.one_body = p.cube_first = one_body;
          const CornerRun run = runCorner(p, i);
          of_k = std::max(of_k, run.force_error);
          iterations = std::max(iterations, run.iterations);
        }
      }
    }
    char name[64];
    std::snprintf(name, sizeof name, "corner.force_err_rel_1e%d", static_cast<int>(std::lround(std::log10(k))));
    figure(name, of_k, "1");
    worst = std::max(worst, of_k);
  }
  figure("corner.force_err_rel", worst, "1");
  figure("corner.newton_max", iterations, "1");
  double ratio = 0;
  for (const NamedAttempts& i : kNamedAttempts) {
    if (i.comparator) continue;
    std::vector<double> ratios;
    for (int pair = 0; pair < 21; ++pair) {
      CornerParameters p;
      p.stiffness = 1e8;
      const double touching = runCorner(p, i).seconds;
      p.gap = 1e-3;
      ratios.push_back(touching / runCorner(p, i).seconds);
    }
    ratio = std::max(ratio, median(ratios));
  }
  figure("corner.cost_vs_gap", ratio, "1");
}

/// Largest change between steps of the wrench on a cube that is led over the floor, about its centre, over the weight.
struct Jump {
  double force = 0, torque = 0;
  double depth = 0;  ///< [m]
};

Jump slideOver(bool seam, const CubeParameters& c) {
  WorldSettings settings;
  settings.comparator = comparators::velocityVerlet;
  settings.step = 1e-4;
  WorldDef def = cubeOnFloor(c, settings);
  if (seam) {
    def.articulations[0] = staticBox("left", Vector3(2, 4, 0.5), Pose(Vector3(-1, 0, -0.25)));
    def.articulations.insert(def.articulations.begin() + 1, staticBox("right", Vector3(2, 4, 0.5), Pose(Vector3(1, 0, -0.25))));
  }
  const int cube_link = static_cast<int>(def.articulations.size()) - 1;
  PointerDef hand;
  hand.articulation = cube_link;
  hand.link = 0;
  def.pointers.push_back(hand);
  World world(def);
  const double speed = 0.1, h = settings.step, weight = c.mass * kGravity;
  Jump out;
  out.depth = c.restDepth();
  Wrench last;
  for (int i = 0; i < 20000; ++i) {
    const Vector3 p(-0.1 + speed * h * (i + 1), 0.013, c.size / 2 - c.restDepth());
    world.setPointerTarget(0, Pose(p), {Vector3::Zero(), Vector3(speed, 0, 0)});
    world.step();
    const Wrench F = world.pointerWrench(0);
    if (i > 2000) {  // slides everywhere
      out.force = std::max(out.force, (F.force - last.force).norm() / weight);
      out.torque = std::max(out.torque, (F.torque - last.torque).norm() / (weight * c.size));
    }
    last = F;
  }
  return out;
}

void runSeams() {
  const CubeParameters c;
  const Jump seam = slideOver(true, c), plain = slideOver(false, c);
  const double worst = std::max(seam.force - plain.force, seam.torque - plain.torque);
  figure("seam.wrench", std::max(0.0, worst), "1");
  figure("seam.bound", 1e-6 * c.size / seam.depth, "1");
}

/// Prisms of many sides on a floor, their damper pulling over half of the patch: corners left out of the overlay.
void runOverlay() {
  int dropped = 0;
  double error = 0;
  for (int sides : {64, 256, 1024}) {
    const ConvexPolyhedron floor = makeBox(Vector3(1, 1, 0.2)), prism = makeCylinder(0.05, 0.1, sides);
    ContactWorkspace workspace;
    workspace.reserve(floor, prism);
    ContactVolume volume;
    PairCache cache;
    const double depth = 1e-3;
    const Pose X_AB(Vector3(0, 0, 0.15 - depth));
    contactVolume(floor, prism, X_AB, cache, workspace, volume);
    PairLaw law;
    law.pressure = PressureLaw::kLinear;
    law.material = combine({}, {}, ContactMaterial{});
    law.material.stiffness = 1e6;
    law.material.damping = 2e3;
    law.reduced_mass = 1;
    // p = k d - b w y: zero on the line y = k d/(b w), a quarter of the radius from the middle.
    const double turn = law.material.stiffness * depth / (law.material.damping * 0.0125);
    const Twist V{volume.X_AP.R.transpose() * Vector3(turn, 0, 0), Vector3::Zero()};
    const LocatedForce force = locatedForce(volume, X_AB, workspace, V, FrictionMemory{}, law, Advance{});
    dropped += force.incomplete ? 1 : 0;
    // On a disc of radius R, with y0 = R/4 the line: ∫(y0 - y)₊ dA = y0 (π R²/2 + …); by the segment's closed form.
    const double R = std::sqrt(volume.A0 / M_PI), y0 = 0.0125;
    const double angle = std::acos(-y0 / R);  // of the part below the line
    const double area = R * R * (angle - std::sin(angle) * std::cos(angle)), first = -2.0 / 3 * std::pow(R * std::sin(angle), 3);
    const double expected = law.material.damping * turn * (y0 * area - first);
    error = std::max(error, std::abs(force.normal_force / expected - 1) * sides * sides);
  }
  figure("overlay.dropped", dropped, "1");
  figure("overlay.err_times_sides2", error, "1");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const struct {
    const char* name;
    void (*run)();
  } groups[] = {{"overlay", runOverlay}, {"carrier", runCarriers}, {"balance", runBalances}, {"seam", runSeams},
                {"impact", runImpacts},  {"energy", runEnergy},    {"corner", runCorners},   {"rolling", runRolling},
                {"power", runPower},     {"ring", runRings},       {"drop", runDrops},     {"order", runOrder},
                {"belt", runBelts},      {"ground", runGround}};
  for (const auto& group : groups) {
    if (argc > 1 && !std::strstr(group.name, argv[1])) continue;
    std::fprintf(stderr, "%s\n", group.name);
    group.run();
  }
  return 0;
}
