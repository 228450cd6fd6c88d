// Many cubes at rest, and a joint between two floors.
#include "../scenes/blocks.h"
#include "report_scene.h"

namespace haptic::report {
namespace {

using namespace scenes;

CubeParameters pileCube(const Choice& choice) {
  CubeParameters c;
  c.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e7;  // k_eff 1e5 N/m: twice what 15 cubes need to stand
  c.ratio = 0.1;
  c.tangential_ratio = 0.1;
  return c;
}

Scene pile(const std::string& name, const std::string& title, const std::vector<Vector3>& places) {
  Scene s;
  s.name = name;
  s.title = title;
  s.parameters = "0.1 m, 0.1 kg, mu 0.5, start touching";
  s.reference = "rigid: it stays";
  s.seconds = 1;
  s.samples = 10;
  s.stiffness = 1e7;
  for (std::size_t i = 0; i < places.size(); ++i) s.bodies.push_back(1 + static_cast<int>(i));
  s.make = [places](const Choice& choice) {
    const CubeParameters c = pileCube(choice);
    WorldDef def = cubeOnFloor(c, settingsOf(choice));
    def.articulations.resize(1);
    for (const Vector3& p : places) {
      def.articulations.push_back(cube("cube" + std::to_string(def.articulations.size()), c, Pose(p)));
    }
    return def;
  };
  s.exact = [places](double) {
    std::vector<BodyState> states;
    for (const Vector3& p : places) states.push_back({Pose(p), Twist{}});
    return states;
  };
  return s;
}

Scene pyramid() {
  std::vector<Vector3> places;
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i < 5 - row; ++i) places.emplace_back((i - 0.5 * (4 - row)) * 0.11, 0, 0.05 + 0.1 * row);
  }
  return pile("pyramid15", "Pyramid of 15 cubes", places);
}

Scene seam() {
  Scene s;
  s.name = "seam";
  s.title = "Cube that slides without friction over the joint of two floors";
  s.parameters = "0.1 m, 0.1 kg, mu 0, 0.1 m/s, two boxes of 2 m side by side";
  s.reference = "rigid: constant speed, no turn";
  s.seconds = 1;
  s.bodies = {1};
  s.stiffness = 1e6;
  s.make = [](const Choice& choice) {
    CubeParameters c;
    c.mu_static = c.mu_dynamic = 0;
    if (choice.stiffness > 0) c.stiffness = choice.stiffness;
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth());
    def.articulations[0] = staticBox("floor left", Vector3(2, 4, 0.5), Pose(Vector3(-1, 0, -0.25)));
    def.articulations.push_back(staticBox("floor right", Vector3(2, 4, 0.5), Pose(Vector3(1, 0, -0.25))));
    def.articulations[1].X_WA.p.x() = -0.05;
    def.articulations[1].V_WA.linear.x() = 0.1;
    return def;
  };
  s.exact = [](double t) {
    return std::vector<BodyState>{
        {Pose(Vector3(-0.05 + 0.1 * t, 0, 0.05)), Twist{Vector3::Zero(), Vector3(0.1, 0, 0)}}};
  };
  return s;
}

}  // namespace

Scene stackScene(int n) {
  std::vector<Vector3> places;
  for (int i = 0; i < n; ++i) places.emplace_back(0, 0, 0.05 + 0.1 * i);
  return pile("stack" + std::to_string(n), std::to_string(n) + " cubes on one another", places);
}

std::vector<Scene> pileScenes() {
  return {stackScene(5), stackScene(15), pyramid(), seam()};
}

}  // namespace haptic::report
