// ContactBench's scenes with their exact rigid solutions.
#include "contactbench_scenes.h"

#include "../scenes/contactbench.h"

namespace haptic::report {
namespace {

using scenes::Along;
using scenes::DraggedCube;
using scenes::Finger;
using scenes::UnequalStack;

constexpr double kOwn = 1e9;  // k of the scenes [N/m³]: the cubes sink by 1e-6 m, under 100 kg by 1e-4
const char kSource[] =
    "Le Lidec and others, Contact models in robotics: a comparative analysis, 2023 (ContactBench): residuals of Signorini's and Coulomb's "
    "laws and of maximum dissipation for a cube that is dragged, two cubes of mass ratio 1000, a finger on a plane. Their residuals: "
    "bench_peers contactbench.";

RuledScene ruled(const std::string& name, const std::string& title, const std::string& parameters) {
  RuledScene r;
  r.scene.name = "contactbench_" + name;
  r.scene.title = title;
  r.scene.parameters = parameters;
  r.scene.benchmark = kSource;
  r.scene.stiffness = kOwn;
  return r;
}

double ruledStiffness(const Choice& choice) { return choice.stiffness > 0 ? choice.stiffness : kOwn; }

std::function<Vector3(const BodyState&, const Vector3&)> cornerOf(double size) {
  return [size](const BodyState& s, const Vector3& n) {
    const Vector3 n_L = s.X_WL.R.transpose() * n;
    return s.X_WL * Vector3(0.5 * size * n_L.unaryExpr([](double x) { return x > 0 ? -1.0 : 1.0; }));
  };
}

RuledScene cube(const std::string& name, const std::string& title, const std::string& parameters, const DraggedCube& cube) {
  RuledScene r = ruled(name, title, "0.1 m, 1 kg, mu 0.4, 0.5 rad from x: " + parameters);
  Scene& s = r.scene;
  s.reference = "rigid: Coulomb's friction, an impact without rebound whose friction is mu times it";
  s.seconds = 0.5;
  s.size = DraggedCube::kSize;
  s.bodies = {1};
  s.make = [cube](const Choice& choice) { return cube.make(settingsOf(choice), ruledStiffness(choice)); };
  s.exact = [cube](double t) {
    const Along along = cube.along(t), up = cube.upright(t);
    const Vector3 d = scenes::dragDirection(), z = Vector3::UnitZ();
    return std::vector<BodyState>{{Pose(Vector3(along.way * d + up.way * z)), {Vector3::Zero(), along.speed * d + up.speed * z}}};
  };
  if (cube.pull > 0) {
    HandSpring hand;
    hand.link = 1;
    hand.damping = DraggedCube::kLead;
    hand.path = [cube](double) {
      return BodyState{Pose(), {Vector3::Zero(), cube.force() / DraggedCube::kLead * scenes::dragDirection()}};
    };
    s.hands = {hand};
  }
  const double weight = DraggedCube::kMass * scenes::kBallGravity;
  r.contacts = {{1, 0, {1}, 0, DraggedCube::kMu, cube.height > 0 ? 0 : weight, cornerOf(DraggedCube::kSize)}};
  return r;
}

RuledScene stack(bool heavy_above) {
  const UnequalStack stack{heavy_above};
  RuledScene r = ruled(heavy_above ? "heavy_above" : "heavy_below",
                       heavy_above ? "A heavy cube on a light one" : "A light cube on a heavy one",
                       "0.1 m, 0.1 and 100 kg, mu 0.5, at rest");
  Scene& s = r.scene;
  s.reference = "rigid: it stays";
  s.seconds = 0.5;
  s.size = UnequalStack::kSize;
  s.bodies = {1, 2};
  s.make = [stack](const Choice& choice) { return stack.make(settingsOf(choice), ruledStiffness(choice)); };
  s.exact = [](double) {
    return std::vector<BodyState>{{Pose(UnequalStack::place(false)), {}}, {Pose(UnequalStack::place(true)), {}}};
  };
  const auto corner = cornerOf(UnequalStack::kSize);
  r.contacts = {{1, 0, {1, 2}, 0, UnequalStack::kMu, stack.force(false), corner},
                {2, 1, {2}, 0.5 * UnequalStack::kSize, UnequalStack::kMu, stack.force(true), corner}};
  return r;
}

RuledScene finger() {
  RuledScene r = ruled("finger", "A driven finger on a plane",
                       "ball of 20 mm, 0.1 kg, with its centre of mass at its tip; mu 0.5, pressed with 5 N, led at 0.05 m/s by 300 N/m, "
                       "critically damped");
  Scene& s = r.scene;
  s.reference = "rigid: a mass on a critically damped spring against mu N";
  s.seconds = 0.5;
  s.size = Finger::kRadius;
  s.bodies = {1};
  s.make = [](const Choice& choice) { return Finger::make(settingsOf(choice), ruledStiffness(choice)); };
  s.exact = [](double t) {
    const Along along = Finger::along(t);
    const Vector3 d = scenes::dragDirection();
    return std::vector<BodyState>{{Pose(Vector3(along.way * d)), {Vector3::Zero(), along.speed * d}}};
  };
  HandSpring hand;
  hand.link = 1;
  hand.stiffness = Finger::kSpring;
  hand.damping = Finger::damping();
  hand.path = [](double t) {
    const Vector3 v = Finger::kSpeed * scenes::dragDirection();
    return BodyState{Pose(Vector3(t * v + Finger::height() * Vector3::UnitZ())), {Vector3::Zero(), v}};
  };
  s.hands = {hand};
  r.contacts = {{1, 0, {1}, 0, Finger::kMu, Finger::kPress, [](const BodyState& state, const Vector3& n) {
                   return Vector3(state.X_WL * Vector3(0, 0, Finger::kRadius) - Finger::kRadius * n);
                 }}};
  return r;
}

}  // namespace

std::vector<RuledScene> contactbenchScenes() {
  return {cube("slide", "A cube that is dragged", "pulled with 1.5 mu m g at its centre", {1.5, 0, 0}),
          cube("stick", "A cube that is pulled and sticks", "pulled with 0.9 mu m g at its centre", {0.9, 0, 0}),
          cube("drop", "A cube that is dropped while it flies along", "from 20 mm, flat, at 1 m/s", {0, 0.02, 1}),
          stack(true),
          stack(false),
          finger()};
}

}  // namespace haptic::report
