// Scenes that makers of simulators publish: MotrixSim's grasp, Newton's cradle, Box3D's pyramid.
#include "../scenes/grasp.h"
#include "benchmark_scenes.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

using scenes::Cradle;
using scenes::CubePyramid;
using scenes::Grasp;

double ownStiffness(const Choice& choice, double own) { return choice.stiffness > 0 ? choice.stiffness : own; }

std::vector<HandSpring> fingersOf(const Grasp& grasp) {
  std::vector<HandSpring> hands;
  for (const int side : {-1, 1}) {
    HandSpring hand;
    hand.link = Grasp::kLeft + (side > 0);
    hand.stiffness = Grasp::kSpring;
    hand.damping = Grasp::kDamping;
    hand.path = [grasp, side](double t) {
      BodyState state;
      state.X_WL = grasp.target(side, t, state.V_WL.linear);
      return state;
    };
    hands.push_back(hand);
  }
  return hands;
}

/// Largest slip in the fingers after friction was lowered.
Measure slip() {
  return {"slip", [](const std::vector<Sample>& samples) {
            const auto of = [](const Sample& sample) {
              return [&sample](int link) { return sample.bodies[link].X_WL.p.z(); };
            };
            const Sample* first = &samples.front();
            double most = 0;
            for (const Sample& now : samples) {
              if (now.time <= Grasp::kLowered * (1 + 1e-9)) first = &now;
              const std::function<double(int)> z_now = of(now), z_first = of(*first);
              most = std::max(most, std::abs(scenes::slipBetween(z_now, z_first)));
            }
            return most;
          }};
}

Scene grasp(const std::string& name, double factor, bool shaken) {
  Grasp g;
  g.factor = factor;
  if (shaken) g.amplitude = 0.02, g.rate = 2;
  Scene s;
  s.name = name;
  const std::string f = std::to_string(factor).substr(0, 4);
  s.title = shaken ? "MotrixSim's grasp, shaken by 20 mm at 2 Hz" : "MotrixSim's grasp, friction lowered to " + f + " of what holds";
  s.parameters = "cube 40 mm, 64 g; fingers 20 x 60 x 60 mm, 200 g, each on a hand of 300 N/m, 6 N s/m; 6.96 N from both together; mu " +
                 f + " m g/N from .5 s on, with N as the simulator has it then; three times that before";
  s.benchmark =
      "Motphys, MotrixSim: Grasp Contact Mechanics Benchmark, 2026: slip after 5 s for f .90, .98, 1.00, 1.02, 1.10. Published: "
      "MotrixSim 154, 150, 0, 0, 0 mm; MuJoCo Euler 154, 153, 151, 152, 150; MuJoCo implicitfast 152, 151, 152, 150, 11. Here "
      "without the Panda: fingers on springs of the hands, which every simulator here can run.";
  s.seconds = factor < 1 ? 0.7 : 5.5;
  s.samples = factor < 1 ? 14 : 55;
  s.size = 0.04;
  s.stiffness = 1e8;
  s.bodies = {0, 1, 2};
  s.make = [g](const Choice& choice) { return g.make(settingsOf(choice), ownStiffness(choice, 1e8)); };
  s.hands = fingersOf(g);
  FrictionChange lowered;
  lowered.time = Grasp::kLowered, lowered.before = Grasp::kFirst;
  lowered.after = [](const std::function<BodyState(int)>& body) {
    return Grasp::frictionFor(body(Grasp::kLeft).X_WL.p.x(), body(Grasp::kLeft + 1).X_WL.p.x());
  };
  s.friction = lowered;
  if (factor < 1) {
    s.reference = "rigid: slides by g (1 - f) t^2/2";
    s.bodies = {0};
    s.exact = [g](double t) {
      return std::vector<BodyState>{{Pose(Vector3(0, 0, -g.slid(t))), Twist{Vector3::Zero(), Vector3(0, 0, -g.speed(t))}}};
    };
    return s;
  }
  s.chaotic = true;  // what hands do to the fingers is not asked; the slip between them is
  s.measures = {slip()};
  s.escaped = [](const Sample& sample) {
    const auto z = [&sample](int link) { return sample.bodies[link].X_WL.p.z(); };
    return 0.5 * (z(1) + z(2)) - z(0) > 5e-3 ? std::string("the cube was dropped, by more than 5 mm") : std::string();
  };
  return s;
}

Scene cradle() {
  Scene s;
  s.name = "cradle";
  s.title = "Newton's cradle without strings: five balls with gaps of 0.1 mm";
  s.parameters = "R 50 mm, 1 kg, 1 m/s, no gravity, no friction, restitution 1";
  s.reference = "rigid, elastic: the speed is handed on one after the other";
  s.benchmark = "MotrixSim's page of 2026 shows a cradle as a video; the closed form is ours.";
  s.seconds = 0.2;
  s.size = 0.1;
  s.stiffness = 1e9;  // as the elastic balls of SimBenchmark have here: a bounce of 7 ms
  s.restitution = 1;
  for (int i = 0; i < Cradle::kBalls; ++i) s.bodies.push_back(i);
  s.make = [](const Choice& choice) { return Cradle::make(settingsOf(choice), ownStiffness(choice, 1e9)); };
  s.exact = [](double t) {
    std::vector<BodyState> states;
    for (int i = 0; i < Cradle::kBalls; ++i) {
      states.push_back({Pose(Vector3(Cradle::place(i, t), 0, 0)), Twist{Vector3::Zero(), Vector3(Cradle::speed(i, t), 0, 0)}});
    }
    return states;
  };
  s.measures = {{"last_ball", [](const std::vector<Sample>& samples) {
                   return std::abs(1 - samples.back().bodies.back().V_WL.linear.x() / Cradle::kSpeed);
                 }}};
  return s;
}

}  // namespace

Scene pyramidScene(int rows) {
  const CubePyramid p{rows};
  Scene s;
  s.name = "pyramid" + std::to_string(p.count());
  s.title = "Box3D's pyramid of " + std::to_string(p.count()) + " boxes";
  s.parameters = "0.1 m, 0.1 kg, mu 0.5, gaps of 10 mm in a row, start touching";
  s.reference = "rigid: it stays";
  s.benchmark =
      "Box3D (Catto, 2026), large pyramid: 5050 boxes, 60 Hz with four sub-steps, one thread: about 2.05 us a box and step on the "
      "author's machine.";
  s.seconds = 0.2;
  s.samples = 2;
  s.stiffness = 1e7;
  for (int i = 0; i < p.count(); ++i) s.bodies.push_back(1 + i);
  s.make = [p](const Choice& choice) { return p.make(settingsOf(choice), ownStiffness(choice, 1e7)); };
  s.exact = [p](double) {
    std::vector<BodyState> states;
    for (int i = 0; i < p.count(); ++i) states.push_back({Pose(p.place(i)), Twist{}});
    return states;
  };
  return s;
}

std::vector<Scene> publishedScenes() {
  return {grasp("grasp_090", 0.90, false), grasp("grasp_098", 0.98, false), grasp("grasp_100", 1.00, false),
          grasp("grasp_102", 1.02, false), grasp("grasp_110", 1.10, false), grasp("grasp_shake", 1.25, true), cradle()};
}

}  // namespace haptic::report
