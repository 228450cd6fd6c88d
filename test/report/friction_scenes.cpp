// Slopes, stick-slip and a hand that presses: what friction and the hand's wrench are judged by.
#include "../scenes/motions.h"
#include "report_scene.h"

namespace haptic::report {
namespace {

using namespace scenes;

Scene slope(bool slides) {
  constexpr double kMu = 0.5;
  const double tangent = slides ? 0.75 : 0.9 * kMu;
  Scene s;
  s.name = slides ? "slope_slide" : "slope_stick";
  s.title = slides ? "Cube on a slope that is too steep" : "Cube that friction holds on a slope, at 0.9 of the limit";
  s.parameters = std::string("0.1 m, 0.1 kg, mu 0.5, tangent ") + (slides ? "0.75" : "0.45");
  s.reference = slides ? "rigid: accelerates by g (sin - mu cos)" : "rigid: it stays";
  s.seconds = slides ? 0.5 : 2;
  s.bodies = {1};
  s.stiffness = 1e6;
  const double angle = std::atan(tangent);
  s.make = [angle](const Choice& choice) {
    CubeParameters c;
    if (choice.stiffness > 0) c.stiffness = choice.stiffness;
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth());
    def.articulations[0] = floorBox(8);
    def.settings.gravity = kGravity * Vector3(std::sin(angle), 0, -std::cos(angle));
    return def;
  };
  const double a = slides ? kGravity * (std::sin(angle) - kMu * std::cos(angle)) : 0;
  s.exact = [a](double t) {
    return std::vector<BodyState>{
        {Pose(Vector3(0.5 * a * t * t, 0, 0.05)), Twist{Vector3::Zero(), Vector3(a * t, 0, 0)}}};
  };
  return s;
}

/// Block drawn over the floor by a hand on a spring; with two coefficients of friction it sticks and slips.
Scene drawnBlock(bool two_coefficients) {
  using S = StickSlip;
  Scene s;
  s.name = two_coefficients ? "stick_slip" : "one_coefficient";
  s.title = two_coefficients ? "Stick-slip of a block on a spring" : "The same block with one coefficient of friction";
  s.parameters = std::string("2 kg, 0.1 m, 400 N/m, 0.0642 m/s, ") +
                 (two_coefficients ? "mu0 0.265, mu 0.160; peers with mu" : "mu0 = mu = 0.160");
  s.reference = "rigid: harmonic while it slips, still while it sticks";
  s.seconds = 2;
  s.bodies = {1};
  s.stiffness = S::kStiffness;
  const double mu0 = two_coefficients ? S::kStatic : S::kDynamic;
  s.make = [mu0](const Choice& choice) {
    WorldDef def = S::scene(settingsOf(choice));
    ContactMaterial& m = def.settings.default_material;
    const double scale = choice.stiffness > 0 ? choice.stiffness / S::kStiffness : 1;
    m.stiffness *= scale;
    m.tangential_stiffness *= scale;
    m.damping *= std::sqrt(scale);
    m.tangential_damping *= std::sqrt(scale);
    m.mu_static = mu0;
    def.articulations[1].X_WA.p.z() = 0.05 - S::kMass * kGravity / (m.stiffness * 0.01);
    return def;
  };
  s.exact = [mu0](double t) {
    const S::Motion m = S::motion(t, mu0);
    return std::vector<BodyState>{
        {Pose(Vector3(m.position, 0, 0.05)), Twist{Vector3::Zero(), Vector3(m.velocity, 0, 0)}}};
  };
  HandSpring hand;
  hand.link = 1;
  hand.stiffness = S::kSpring;
  hand.path = [](double t) {
    return BodyState{Pose(Vector3(S::kSpeed * t, 0, 0.05)), Twist{Vector3::Zero(), Vector3(S::kSpeed, 0, 0)}};
  };
  s.hands = {hand};
  return s;
}

/// A tool on the hand's spring, pressed on the floor and pulled along it; friction holds, so the rigid tool stays and
/// the hand feels its own path times the spring.
Scene press() {
  static constexpr double kStiffness = 2000, kDamping = 2, kDepth = 0.01, kAside = 0.002, kPeriod = 0.5;  // SI
  Scene s;
  s.name = "press";
  s.title = "A hand presses a tool on the floor";
  s.parameters = "tool 50 mm, 0.1 kg, mu 0.5; hand 2000 N/m, 2 N s/m, 10 mm down and 2 mm aside, 2 Hz";
  s.reference = "rigid: the tool stays, the hand feels its spring";
  s.seconds = 1;
  s.bodies = {1};
  s.size = 0.05;
  s.stiffness = 1e8;
  s.make = [](const Choice& choice) {
    CubeParameters c;
    c.size = 0.05;
    c.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e8;
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth());
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = kStiffness;
    hand.coupling.damping = kDamping;
    hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
    def.pointers.push_back(hand);
    return def;
  };
  s.exact = [](double) { return std::vector<BodyState>{{Pose(Vector3(0, 0, 0.025)), Twist{}}}; };
  HandSpring hand;
  hand.link = 1;
  hand.stiffness = kStiffness;
  hand.damping = kDamping;
  hand.path = [](double t) {
    const double w = 2 * M_PI / kPeriod, share = 0.5 * (1 - std::cos(w * t)), rate = 0.5 * w * std::sin(w * t);
    const Vector3 way(kAside, 0, -kDepth);
    return BodyState{Pose(Vector3(Vector3(0, 0, 0.025) + share * way)), Twist{Vector3::Zero(), Vector3(rate * way)}};
  };
  s.hands = {hand};
  return s;
}

}  // namespace

std::vector<Scene> frictionScenes() {
  return {slope(false), slope(true), drawnBlock(true), drawnBlock(false), press()};
}

}  // namespace haptic::report
