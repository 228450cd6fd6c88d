// The gear experiment at 2 N/mm, 1 kHz and at 20 N/mm, 10 kHz: how far the ball's path lies from that on a rigid gear, and
// how much friction deflects it. Two ways to lead the hand: it traces the teeth, pressing along their normal, as an
// explorer does; or it is drawn along r = 52 mm, where flanks of 20 degrees lock by friction of 0.5, the pull grows beyond
// what the device can hold against, and the ball is dragged through the teeth whatever their stiffness.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "../scenes/gear_path.h"
#include "figure.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/loop/hand.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr double kPress = 2, kSpeed = 0.05;  // [N], [m/s]

struct GearResult {
  double shape_error = 0;  ///< rms distance of the ball's centre from its path on a rigid gear, while in touch [m]
  double lateral = 0;      ///< mean of friction's share of the force on the ball
  double touching = 0;     ///< share of the time
};

GearResult explore(double stiffness, double rate, Lead lead, const char* csv) {
  SceneDef scene = sceneNamed("gear", rate);
  const double k = gearFoundation(stiffness, kPress);
  for (ArticulationDef& articulation : scene.world.articulations) {
    for (LinkDef& link : articulation.links) {
      for (CollisionDef& collision : link.collisions) collision.material.stiffness = k;
    }
  }
  const auto gear = sections(scene.world);
  // The hand presses by its goal, which lies deeper by F over the hand's stiffness.
  TwinSettings hand;
  hand.period = 1 / rate;
  if (lead == Lead::kTraced) {  // a firm grasp: the goal stays on this side of a tooth
    hand.hand_stiffness = 3000;
    hand.hand_damping = 30;
  }
  HandPath& path = hand.path;
  const double from = -0.5, to = 0.5, start = 1;
  const std::vector<Vector2> lane = goals(gear, lead, from, to, kPress / hand.hand_stiffness);
  const Vector3 p_WB = scene.hands[0].workspace.X_WB.p;
  const Matrix3 R_BW = scene.hands[0].workspace.X_WB.R.transpose();
  const auto inBase = [&](const Vector2& p) { return Vector3(R_BW * (Vector3(p.x(), p.y(), 0) - p_WB)); };
  path.keys.push_back({0.3, Vector3::Zero(), Vector3::Zero(), 0});
  path.keys.push_back({0.7, inBase(1.15 * lane.front()), Vector3::Zero(), 0});
  double end = start;
  for (std::size_t i = 0; i < lane.size(); ++i) {
    if (i > 0) end += (lane[i] - lane[i - 1]).norm() / kSpeed;
    path.keys.push_back({end, inBase(lane[i]), Vector3::Zero(), 0});
  }
  RigSettings settings;
  settings.rate = rate;
  Rig rig(scene, settings);
  rig.twin[0] = std::make_unique<DeviceTwin>(rig.device[0]->def(), hand);
  const int pointer = rig.world.pointerLink(0);
  const std::filesystem::path folder = repositoryFile("build/figures");
  std::filesystem::create_directories(folder);
  std::ofstream trace(folder / csv);
  trace << "x,y,fx,fy\n";
  GearResult result;
  long touching = 0, all = 0;
  for (int i = 0; i < static_cast<int>(end * rate); ++i) {
    rig.run(1);
    if (i < (start + 0.1) * rate) continue;
    ++all;
    const Vector3 p = rig.world.linkPose(pointer).p, F = rig.world.pointerWrench(0).force;
    if (i % static_cast<int>(rate / 1000) == 0) trace << p.x() << "," << p.y() << "," << F.x() << "," << F.y() << "\n";
    if (F.norm() == 0) continue;
    ++touching;
    result.shape_error += std::pow(clearance(gear, p.head<2>()), 2);
    double normal = 0;
    for (int c = 0; c < rig.world.contactCount(); ++c) normal += rig.world.contact(c).normal_force;
    result.lateral += normal > 0 ? std::sqrt(std::max(0.0, F.squaredNorm() - normal * normal)) / normal : 0;
  }
  result.shape_error = std::sqrt(result.shape_error / static_cast<double>(touching));
  result.lateral /= static_cast<double>(touching);
  result.touching = static_cast<double>(touching) / static_cast<double>(all);
  return result;
}

}  // namespace

void measureGear() {
  const struct {
    double stiffness, rate;
    const char *suffix, *csv;
  } kCases[] = {{2000, 1000, "_2n_1k", "gear_2n_1k.csv"}, {20000, 10000, "_20n_10k", "gear_20n_10k.csv"}};
  for (const auto& c : kCases) {
    const std::string suffix = c.suffix;
    const GearResult traced = explore(c.stiffness, c.rate, Lead::kTraced, c.csv);
    const GearResult drawn = explore(c.stiffness, c.rate, Lead::kDrawn, ("gear" + suffix + "_drawn.csv").c_str());
    std::printf("gear%s: traced, touching %.2f of the time; drawn along r = 52 mm, %.2f\n", c.suffix, traced.touching,
                drawn.touching);
    figure("gear.shape_error_um" + suffix, 1e6 * drawn.shape_error, "um");
    figure("gear.friction_ratio" + suffix, drawn.lateral, "1");
    figure("gear.traced_shape_error_um" + suffix, 1e6 * traced.shape_error, "um");
    figure("gear.traced_friction_ratio" + suffix, traced.lateral, "1");
  }
}

}  // namespace haptic::bench
