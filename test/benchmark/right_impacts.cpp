/// Impacts shorter than the step, and steps that make energy: right, or said.
#include <algorithm>
#include <cmath>
#include <random>

#include "../scenes/moving.h"
#include "figure.h"
#include "haptic_core/base/error.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr unsigned kSays = kImpactUnresolved | kRunaway | kNotConverged;

struct Hit {
  double error = 0;  ///< of the rod's rate, relative
  bool flagged = false;
};

Hit hitRod(const NamedAttempts& method, double h) {
  WorldSettings settings;
  method.into(settings);
  settings.step = h;
  World world(rodAndCube(settings));
  Hit out;
  for (double t = 0; t < 0.02 && world.report().finite; t += h) {
    world.step();
    out.flagged |= (world.report().flags & kSays) != 0;
  }
  out.error = std::abs(std::abs(world.linkTwist(world.linkIndex("rod")).angular.y()) / kRodRate - 1);
  return out;
}

void runRod() {
  double unflagged = 0;
  bool all_flagged = true;
  for (const NamedAttempts& i : kNamedAttempts) {
    const Hit hit = hitRod(i, 1e-3);
    figure(std::string("impact.err_pct_") + i.name, 100 * hit.error, "%");
    figure(std::string("impact.flagged_") + i.name, hit.flagged, "1");
    if (!hit.flagged) unflagged = std::max(unflagged, 100 * hit.error);
    all_flagged &= hit.flagged || hit.error <= 0.02;
  }
  figure("impact.err_pct", unflagged, "%");  // of those that say nothing
  figure("impact.flagged", all_flagged, "1");
  double resolved = 0;
  for (const NamedAttempts& i : kNamedAttempts) resolved = std::max(resolved, 100 * hitRod(i, 1e-6).error);
  figure("impact.resolved_err_pct", resolved, "%");
}

/// One of the random scenes: up to four boxes that fall, spin and fly at one another over a floor, with settings that need
/// not suit them.
struct RandomScene {
  WorldDef def;
  double kinetic = 0, potential = 0;  ///< at the start, the latter above the floor [J]
  double mass = 0, least_size = 1;
};

RandomScene randomScene(std::mt19937& random) {
  std::uniform_real_distribution<double> u(0, 1);
  const auto between = [&](double low, double high) { return low * std::pow(high / low, u(random)); };
  const auto vector = [&](double size) {
    const double x = 2 * u(random) - 1, y = 2 * u(random) - 1, z = 2 * u(random) - 1;
    return Vector3(size * x, size * y, size * z);
  };
  RandomScene out;
  WorldSettings& s = out.def.settings;
  kNamedAttempts[random() % std::size(kNamedAttempts)].into(s);
  s.step = between(1e-4, 1e-2);
  s.pressure_law = random() % 2 ? PressureLaw::kLinear : PressureLaw::kHuntCrossley;
  s.energy_ledger = random() % 4 != 0;
  ContactMaterial& m = s.default_material;
  m.stiffness = between(1e4, 1e13);
  m.damping = random() % 2 ? 0.0 : between(1, 1e7);
  m.dissipation = random() % 2 ? 0.0 : between(1e-2, 1e5);
  m.mu_static = m.mu_dynamic = u(random);
  out.def.name = "random";
  out.def.articulations.push_back(floorBox(4, 1));
  const int count = 1 + static_cast<int>(random() % 4);
  double z = 0;
  for (int i = 0; i < count; ++i) {
    const Vector3 size(between(0.02, 0.2), between(0.02, 0.2), between(0.02, 0.2));
    const double mass = between(1e-2, 10), reach = 0.5 * size.norm();
    const Twist V{vector(5), vector(2)};
    z += reach + 1e-3;
    Matrix3 R = Matrix3::Identity();
    if (random() % 2) R = Eigen::AngleAxisd(3 * u(random), vector(1).normalized()).toRotationMatrix();
    const Pose X(R, Vector3(0.02 * u(random), 0, z));
    z += reach;
    out.def.articulations.push_back(freeBox("b" + std::to_string(i), size, mass, X, V));
    const Vector3 w = R.transpose() * V.angular;
    out.kinetic += 0.5 * mass * V.linear.squaredNorm() + 0.5 * w.dot(boxInertia(size, mass) * w);
    out.potential += mass * kGravity * X.p.z();
    out.mass += mass;
    out.least_size = std::min(out.least_size, size.minCoeff());
  }
  return out;
}

double kineticEnergyOf(const World& world, const WorldDef& def) {
  double sum = 0;
  for (std::size_t i = 1; i < def.articulations.size(); ++i) {
    const LinkInertia& body = def.articulations[i].links[0].inertia;
    const Twist V = world.linkTwist(static_cast<int>(i));
    const Vector3 w = world.linkPose(static_cast<int>(i)).R.transpose() * V.angular;
    sum += 0.5 * body.mass * V.linear.squaredNorm() + 0.5 * w.dot(body.I_C * w);
  }
  return sum;
}

/// A run has run away when its bodies move with more than three times the energy that they had and could have fallen for.
void runRandom() {
  constexpr int kScenes = 10000, kSteps = 60;
  std::mt19937 random(16);
  int silent = 0, ran_away = 0, stopped = 0;
  for (int i = 0; i < kScenes; ++i) {
    const RandomScene scene = randomScene(random);
    World world(scene.def);
    bool away = false, said = false;
    for (int step = 0; step < kSteps && world.report().finite && !away; ++step) {
      world.step();
      said |= (world.report().flags & kSays) != 0 || !world.report().finite;
      double drop = scene.potential;  // the floor's top is at z = 0; below it there is more to fall
      for (std::size_t b = 1; b < scene.def.articulations.size(); ++b) {
        drop -= scene.def.articulations[b].links[0].inertia.mass * kGravity * std::min(0.0, world.linkPose(static_cast<int>(b)).p.z());
      }
      const double kinetic = kineticEnergyOf(world, scene.def);
      away = !(kinetic <= 3 * (scene.kinetic + drop));
    }
    ran_away += away;
    stopped += !world.report().finite;
    silent += away && !said;
    if (i % 1000 == 999) std::fprintf(stderr, "  %d of %d random scenes\n", i + 1, kScenes);
  }
  figure("runaway.scenes", kScenes, "1");
  figure("runaway.ran_away", ran_away, "1");
  figure("runaway.stopped", stopped, "1");
  figure("runaway.silent", silent, "1");
}

}  // namespace

void runImpacts() {
  runRod();
  runRandom();
}

}  // namespace haptic::bench
