// Single bodies whose rigid motion is known exactly.
#include "../scenes/motions.h"
#include "exact_motion.h"
#include "report_scene.h"

namespace haptic::report {
namespace {

using namespace scenes;

BodyState at(const Vector3& p, const Matrix3& R = Matrix3::Identity(), const Vector3& omega = Vector3::Zero(),
             const Vector3& v = Vector3::Zero()) {
  return {Pose(R, p), Twist{omega, v}};
}

CubeParameters cubeWith(const Choice& choice, double k) {
  CubeParameters c;
  c.stiffness = choice.stiffness > 0 ? choice.stiffness : k;
  return c;
}

Scene still() {
  Scene s;
  s.samples = 20;
  s.bodies = {1};
  s.stiffness = 1e6;
  return s;
}

Scene rest() {
  Scene s = still();
  s.name = "rest";
  s.title = "Cube set down on the floor";
  s.parameters = "0.1 m, 0.1 kg, mu 0.5, released touching";
  s.reference = "rigid: it stays";
  s.seconds = 1;
  s.make = [](const Choice& choice) {
    const CubeParameters c = cubeWith(choice, 1e6);
    return cubeOnFloor(c, settingsOf(choice), c.restDepth());
  };
  s.exact = [](double) { return std::vector<BodyState>{at(Vector3(0, 0, 0.05))}; };
  return s;
}

Scene eccentric() {
  Scene s = rest();
  s.name = "eccentric";
  s.title = "Cube whose centre of mass lies 2 cm off its middle";
  s.parameters = "0.1 m, 0.1 kg, mu 0.5, centre of mass at x = 20 mm, released touching";
  s.make = [](const Choice& choice) {
    const CubeParameters c = cubeWith(choice, 1e6);
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth());
    def.articulations[1].links[0].inertia.p_LC = Vector3(0.02, 0, 0);
    return def;
  };
  return s;
}

Scene bounce() {
  Scene s = still();
  s.name = "bounce";
  s.title = "Cube that falls flat and bounces without loss";
  s.parameters = "0.1 m, 0.1 kg, falls 50 mm, no damping; peers with restitution 1";
  s.reference = "rigid: parabolas, speed reversed at each touch";
  s.seconds = 1;
  s.restitution = 1;
  s.make = [](const Choice& choice) {
    const CubeParameters c = cubeWith(choice, 1e6);
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth() + 0.05);
    def.settings.default_material.dissipation = def.settings.default_material.damping = 0;
    return def;
  };
  s.exact = [](double t) {
    const double fall = std::sqrt(2 * 0.05 / kGravity);
    const double since = std::remainder(t, 2 * fall);  // from the last or to the next apex
    return std::vector<BodyState>{at(Vector3(0, 0, 0.1 - 0.5 * kGravity * since * since), Matrix3::Identity(),
                                     Vector3::Zero(), Vector3(0, 0, -kGravity * since))};
  };
  return s;
}

Scene tilt() {
  Scene s = still();
  s.name = "tilt";
  s.title = "Tilted cube that falls back on its face, until just before it touches";
  s.parameters = "2 m, 1 kg, 0.1 rad, mu 10, the edge starts as deep as it carries 6.855 N";
  s.reference = "rigid: falls about its edge (Runge-Kutta in long double)";
  s.seconds = 0.23;
  s.size = 2;
  s.samples = 23;
  s.stiffness = 4e4;
  s.make = [](const Choice& choice) {
    return tiltedCube(settingsOf(choice), choice.stiffness > 0 ? choice.stiffness : 4e4);
  };
  s.exact = [](double t) {
    const FallingCube f = FallingCube::at(t, 2, 0.1, kGravity);
    const Matrix3 R = rotationY(-f.angle);
    // The lower edge stays where the definition puts it, on the floor.
    const Vector3 edge_L(-1, 0, -1), omega(0, -f.speed, 0), arm = R * Vector3(-edge_L);
    return std::vector<BodyState>{at(arm + Vector3(0, 0, 0), R, omega, omega.cross(arm))};
  };
  return s;
}

Scene slide() {
  Scene s = still();
  s.name = "slide";
  s.title = "Cube that slides to a stop";
  s.parameters = "0.1 m, 0.1 kg, mu 0.5, starts at 1 m/s, stops after 0.204 s";
  s.reference = "rigid: decelerates by mu g, then stays";
  s.seconds = 0.4;
  s.make = [](const Choice& choice) {
    const CubeParameters c = cubeWith(choice, 1e6);
    WorldDef def = cubeOnFloor(c, settingsOf(choice), c.restDepth());
    def.articulations[1].V_WA.linear.x() = 1;
    return def;
  };
  s.exact = [](double t) {
    const double a = 0.5 * kGravity, stop = 1 / a, run = std::min(t, stop);
    return std::vector<BodyState>{at(Vector3(run - 0.5 * a * run * run, 0, 0.05), Matrix3::Identity(),
                                     Vector3::Zero(), Vector3(1 - a * run, 0, 0))};
  };
  return s;
}

Scene top() {
  Scene s = still();
  s.name = "top";
  s.title = "Top in slow steady precession on an apex that friction holds";
  s.parameters = "cone, base r 0.1 m, height 0.05 m, 0.1 kg, tilt 0.2 rad, 50 rad/s about its axis, no torsional friction; "
                 "peers: plane, Bullet a cone";
  s.reference = "rigid: precesses at 2.5805277 rad/s, the tilt stays";
  s.seconds = 2;
  s.stiffness = 1e13;
  s.round = true;
  s.peer_shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0},
                   {1, peers::PeerShape::Kind::kCone, Top::kRadius, Top::kHeight}};
  s.make = [](const Choice& choice) {
    return Top::scene(settingsOf(choice), choice.stiffness > 0 ? choice.stiffness : 1e13, 10,
                      choice.facets > 0 ? 8 << choice.facets : Top::kFacets);
  };
  s.exact = [](double t) {
    // Axis and spin as the definition starts them; the rotation is precession times spin about the axis.
    const Matrix3 start = rotationY(Top::kTilt);
    const double spin = Top::kSpin - Top::kExact * std::cos(Top::kTilt);  // about the axis, relative to the precession
    const Matrix3 R = Eigen::AngleAxisd(Top::kExact * t, Vector3::UnitZ()).toRotationMatrix() * start *
                      Eigen::AngleAxisd(spin * t, Vector3::UnitZ()).toRotationMatrix();
    const Vector3 axis = R.col(2), apex(-Top::kArm * start.col(2).x(), 0, 0);
    const Vector3 omega = spin * axis + Vector3(0, 0, Top::kExact);
    const Vector3 arm = Top::kArm * axis;
    return std::vector<BodyState>{at(apex + arm, R, omega, omega.cross(arm))};
  };
  return s;
}

Scene freeBody() {
  Scene s;
  s.name = "free";
  s.title = "Torque-free body that flips about its middle axis";
  s.parameters = "inertia (1, 2, 2.5) kg m^2, starts at (0.01, 5, 0.01) rad/s";
  s.reference = "Euler's equations (Runge-Kutta in long double)";
  s.seconds = 10;
  s.samples = 20;
  s.bodies = {0};
  s.stiffer_is_truer = false;
  s.make = [](const Choice& choice) { return tumblingBody(settingsOf(choice)); };
  s.exact = [](double t) {
    const FreeRotation r = FreeRotation::at(t, Vector3(1, 2, 2.5), Vector3(0.01, 5, 0.01));
    return std::vector<BodyState>{at(Vector3::Zero(), r.R_WB, r.omega_W)};
  };
  return s;
}

Scene rollingBall() {
  static constexpr double kRadius = 0.05, kSlope = 0.3, kMass = 0.1;  // [m], [rad], [kg]
  Scene s = still();
  s.name = "roll";
  s.title = "Ball that rolls down a slope";
  s.parameters =
      "radius 50 mm, 0.1 kg, solid, slope 0.3 rad, mu 0.5; true ball; 42, 162, 642 vertices at 1, 2, 3 facets; peers: sphere, plane";
  s.reference = "rigid sphere: 5/7 g sin(slope)";
  s.seconds = 0.5;
  s.stiffness = 1e8;
  s.round = true;
  s.peer_shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}, {1, peers::PeerShape::Kind::kSphere, kRadius, 0}};
  s.make = [](const Choice& choice) {
    WorldDef def;
    def.name = "rolling ball";
    def.settings = settingsOf(choice);
    def.settings.gravity = kGravity * Vector3(std::sin(kSlope), 0, -std::cos(kSlope));
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e8;
    m.dissipation = 1;
    m.mu_static = m.mu_dynamic = 0.5;
    def.articulations.push_back(floorBox());
    def.articulations.push_back(scenes::freeBody("ball", ballShape(kRadius, choice), kMass,
                                                 0.4 * kMass * kRadius * kRadius * Matrix3::Identity(),
                                                 Pose(Vector3(0, 0, kRadius))));
    return def;
  };
  s.exact = [](double t) {
    const double a = 5.0 / 7.0 * kGravity * std::sin(kSlope), x = 0.5 * a * t * t;
    return std::vector<BodyState>{at(Vector3(x, 0, kRadius), rotationY(x / kRadius), Vector3(0, a * t / kRadius, 0),
                                     Vector3(a * t, 0, 0))};
  };
  return s;
}

}  // namespace

std::vector<Scene> motionScenes() {
  return {rest(), eccentric(), bounce(), tilt(), slide(), rollingBall(), top(), freeBody()};
}

}  // namespace haptic::report
