// SimBenchmark's scenes of balls (Kang, Hwangbo, ETH Zürich 2018, leggedrobotics/SimBenchmark), g = 9.81.
// True balls over a half-space, peers' over a plane.
#include "../scenes/balls.h"
#include "benchmark_scenes.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

constexpr double kRadius = scenes::kBallRadius;  // [m]
using Rolling = scenes::RollingBalls;

/// `balls` true balls for peers, from link `first` on, over a plane.
std::vector<peers::PeerShape> trueBalls(int first, int balls) {
  std::vector<peers::PeerShape> shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}};
  for (int i = 0; i < balls; ++i) shapes.push_back({first + i, peers::PeerShape::Kind::kSphere, kRadius, 0});
  return shapes;
}

double stiffnessOf(const Choice& choice, double own) {
  return choice.stiffness > 0 ? choice.stiffness : own;
}

/// The hand that pulls, for peers too.
HandSpring pullOf(const Rolling& r) {
  HandSpring h;
  h.link = 1;
  h.damping = Rolling::kPull;
  h.path = [r](double) { return BodyState{Pose(), r.handTwist()}; };
  return h;
}

Scene rolling(const std::string& name, const Vector3& direction, const std::string& along) {
  const Rolling r{direction};
  Scene s;
  s.name = name;
  s.title = "SimBenchmark rolling: 25 balls on a box that is pulled along " + along;
  s.parameters =
      "balls 1 kg, R 0.1 m; box 10 kg, 20 x 20 x 0.1 m; 150 N; mu 0.4 under the box, 0.8 under the balls, no "
      "damping there; g "
      "9.81";
  s.reference = "rigid: the box slides, the balls roll on it (closed form)";
  s.benchmark =
      "SimBenchmark, rolling (Kang, Hwangbo 2018). Their finding: friction pyramids fail it off the axes.";
  s.seconds = 4;
  s.samples = 40;
  s.size = 0.2;
  s.stiffness = 1e8;
  s.smallest_step = 1e-3 / 3;
  s.round = true;
  for (int i = 0; i <= Rolling::kBalls; ++i) s.bodies.push_back(1 + i);
  s.peer_shapes = trueBalls(2, Rolling::kBalls);
  s.make = [r](const Choice& choice) {
    return r.make(settingsOf(choice), stiffnessOf(choice, 1e8), ballShape(kRadius, choice));
  };
  s.exact = [r](double t) {
    std::vector<BodyState> states;
    for (int body = -1; body < Rolling::kBalls; ++body) states.push_back({r.poseAt(t, body), r.twistAt(t, body)});
    return states;
  };
  s.hands = {pullOf(r)};
  s.measures = {mean("velocity_squared", [r](const Sample& now) {
    return r.squaredError(now.time, [&now](int body) { return now.bodies[body + 1].V_WL.linear; });
  })};
  return s;
}

scenes::BallGrid gridOf(const Choice& choice, bool elastic) {
  scenes::BallGrid grid;
  grid.stiffness = stiffnessOf(choice, 1e9);
  if (elastic) grid.mu = grid.dissipation = 0;
  return grid;
}

double overlap(const Sample& s) {
  std::vector<Vector3> centres;
  for (const BodyState& b : s.bodies) centres.push_back(b.X_WL.p);
  return scenes::squaredOverlaps(centres);
}

Scene balls(const std::string& name, const std::string& title, int side, int layers, double seconds) {
  Scene s;
  s.name = name;
  s.title = title;
  s.seconds = seconds;
  s.samples = 40;
  s.size = 2 * kRadius;
  s.stiffness = 1e9;
  s.chaotic = true;
  s.smallest_step = layers > 1 ? 1e-3 : 1e-3 / 3;
  for (int i = 0; i < side * side * layers; ++i) s.bodies.push_back(1 + i);
  s.peer_shapes = trueBalls(1, side * side * layers);
  return s;
}

std::function<std::string(const Sample&)> aboveGround(double highest) {
  return [highest](const Sample& sample) -> std::string {
    for (const BodyState& b : sample.bodies) {
      if (b.X_WL.p.z() < 0) return "a ball went through the ground";
      if (b.X_WL.p.z() > highest) return "a ball was launched";
    }
    return "";
  };
}

Scene bouncing() {
  Scene s = balls("bouncing", "SimBenchmark bouncing: 49 balls that bounce without loss", 7, 1, 20);
  s.parameters =
      "R 0.1 m, 10 kg, fall 5 m, restitution 1, mu 0, g 9.81; lost: a ball one size above its start or below "
      "the ground";
  s.benchmark =
      "SimBenchmark, bouncing (Kang, Hwangbo 2018): mean over time of the squared error of the energy.";
  s.restitution = 1;
  s.make = [](const Choice& choice) {
    scenes::BallGrid grid = gridOf(choice, true);
    grid.side = 7;
    grid.layers = 1;
    grid.pitch = 2;
    grid.lowest = kRadius + 5;
    grid.jitter = 0;
    return grid.make(settingsOf(choice), ballShape(kRadius, choice));
  };
  s.measures = {energySquared()};
  s.escaped = aboveGround(3 * kRadius + 5);
  return s;
}

Scene six(bool elastic) {
  Scene s = balls(elastic ? "six_elastic" : "six",
                  std::string("SimBenchmark ") + (elastic ? "elastic 666" : "666") + ": 216 balls", 6, 6, 2);
  s.parameters = std::string("R 0.1 m, 10 kg, pitch 0.21 m, offsets of 1 mm, ") +
                 (elastic ? "lowest centres at 1.1 m, restitution 1, mu 0, g 9.81"
                          : "lowest centres at 0.101 m, mu 0.5, g 9.81");
  s.benchmark =
      elastic ? "SimBenchmark, elastic 666 (Kang, Hwangbo 2018): mean over time of the squared error of the "
                "energy. "
                "Without friction, so that the energy is conserved."
              : "SimBenchmark, 666 (Kang, Hwangbo 2018): mean over time of the sum of squared overlaps.";
  const double lowest = elastic ? 1.1 : 0.101;
  s.make = [elastic, lowest](const Choice& choice) {
    scenes::BallGrid grid = gridOf(choice, elastic);
    grid.lowest = lowest;
    return grid.make(settingsOf(choice), ballShape(kRadius, choice));
  };
  s.measures = {elastic ? energySquared() : mean("overlap", overlap)};
  s.restitution = elastic ? 1 : 0;
  // An elastic ball may take the energy of several: only what leaves altogether is lost.
  s.escaped = aboveGround(elastic ? 20 : lowest + 5 * 0.21 + 2 * kRadius);
  return s;
}

}  // namespace

std::vector<Scene> ballScenes() {
  return {rolling("rolling", Vector3(0.5, std::sqrt(0.75), 0), "(1/2, sqrt(3)/2)"),
          rolling("rolling_y", Vector3::UnitY(), "y"), bouncing(), six(false), six(true)};
}

}  // namespace haptic::report
