// Ground of many pieces: whether its inner edges are felt, and what it costs.
#include <ctime>
#include <memory>
#include <vector>

#include "../comparators/velocity_verlet.h"
#include "../scenes/ground.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "shapes_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

std::vector<LedBody> bodies() {
  return {{std::make_shared<Ball>(0.05), 0.05 - 1e-3},
          {std::make_shared<Rod>(0.05, 0.02, Rod::Ends::kFlat), 0.01 - 1e-4},
          {box(Vector3::Constant(0.1)), 0.05 - 1e-4}};
}

/// Over several edges, corners among them, straight along the rows and across.
std::vector<LedMotion> ways() {
  std::vector<LedMotion> ways;
  for (const double speed : {0.03, 0.3}) {
    const double share = speed / 0.3;
    ways.push_back({Vector3(-0.12 * share, 0, 0), Vector3(speed, 0, 0)});
    ways.push_back({Vector3(-0.1 * share, -0.04 * share, 0), Vector3(speed, 0.4 * speed, 0), 0.4});
  }
  return ways;
}

double largestJump(const std::vector<ArticulationDef>& ground, const std::vector<ArticulationDef>& plane,
                   const std::vector<LedBody>& bodies, double rolls_on = 0, double spin = 0) {
  const Matrix3 tilted = rotationAbout(Vector3(1, 0.5, 0).normalized(), 0.2);
  double worst = 0;
  for (const LedBody& body : bodies) {
    for (LedMotion way : ways()) {
      way.spin = spin;
      way.rolls_on = rolls_on;
      for (const Matrix3& R : {Matrix3(Matrix3::Identity()), tilted}) {
        const double jump = edgeJump(ground, plane, body, way, 800, R);
        worst = std::isnan(jump) ? jump : std::max(worst, jump);
      }
    }
  }
  return worst;
}

/// Hills, of whose triangles no two lie in one plane; cells of 10 cm.
HeightGrid rollingHills(int cells) {
  return heightGrid(cells, 0.1 * cells, [](double x, double y) {
    return 0.3 * elementary::sin(1.3 * x) * elementary::cos(1.1 * y) + 0.02 * x;
  });
}

/// A cube of 10 cm that has come to rest [s a step].
double secondsOfStep(WorldDef def, const Pose& X_WL) {
  CubeParameters c;
  def.settings.default_material = c.material();
  def.settings.gravity = Vector3(0, 0, -kGravity);
  def.settings.comparator = comparators::velocityVerlet;
  def.articulations.push_back(cube("cube", c, X_WL));
  World world(def);
  for (int i = 0; i < 1500; ++i) world.step();
  return secondsPerCall([&](int) { world.step(); }, 200);
}

}  // namespace

void measureTerrain() {
  const auto field = [](const GroundShapes& pieces) { return std::vector<ArticulationDef>{staticPieces("field", pieces)}; };
  const std::vector<ArticulationDef> plane{floorBox(2, 0.2)};
  const auto prisms = field(flatPrisms(10, 1.5)), rough = field(groundOf(plateau(20, 2))), tiled = tiles(10, 1.5);
  double worst = 0;
  for (const auto& ground : {prisms, rough, tiled}) worst = std::max(worst, largestJump(ground, plane, bodies()));
  figure("terrain.edge_jump_rel", worst, "");
  // Beyond the definition: pieces of one plane have one normal, but each has its own friction.
  figure("terrain.edge_jump_spinning_rel", largestJump(prisms, plane, bodies(), 0, 3), "");
  figure("terrain.edge_jump_rolling_rel", largestJump(prisms, plane, {bodies()[0]}, 0.05 - 1e-3 / 3), "");

  const std::clock_t start = std::clock();
  WorldDef hills;
  hills.articulations.push_back(staticPieces("hills", groundOf(rollingHills(100))));
  { const World world(hills); }
  figure("terrain.load_20000_s", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, "s");
  WorldDef on_box;
  on_box.articulations.push_back(floorBox());
  const double flat = secondsOfStep(on_box, Pose(Vector3(0, 0, 0.05)));
  WorldDef level = hills;
  level.articulations[0] = staticPieces("level", groundOf(heightGrid(100, 10, [](double, double) { return 0.0; })));
  figure("terrain.level_step_vs_box", secondsOfStep(level, Pose(Vector3(0, 0, 0.05))) / flat, "");
  figure("terrain.hills_step_vs_box", secondsOfStep(hills, Pose(Vector3(0.03, 0.02, 0.08))) / flat, "");
  // The same hills on a hundredth of the area: what lies elsewhere costs nothing.
  WorldDef few;
  few.articulations.push_back(staticPieces("few", groundOf(rollingHills(10))));
  figure("terrain.hills_step_vs_few",
         secondsOfStep(hills, Pose(Vector3(0.03, 0.02, 0.08))) / secondsOfStep(few, Pose(Vector3(0.03, 0.02, 0.08))), "");
}

}  // namespace haptic::bench
