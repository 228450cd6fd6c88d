// The field's own benchmarks beside those of balls: Gazebo's boxes, a tower of blocks, a heap of capsules,
// predictability.
#include "benchmark_scenes.h"

#include "../scenes/blocks.h"
#include "../scenes/offsets.h"
#include "exact_motion.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

/// scpeters/benchmark: one box in free flight.
Scene gazeboBox(bool complex) {
  const Vector3 v0 = complex ? Vector3(-2, 2, 8) : Vector3(-0.9, 0.4, 0.1);
  const Vector3 omega0 = complex ? Vector3(0.1, 5, 0.1) : Vector3(0.5, 0, 0), g(0, 0, complex ? -9.8 : 0);
  const Vector3 inertia(0.80833333, 0.68333333, 0.14166667);
  Scene s;
  s.name = complex ? "boxes_complex" : "boxes_simple";
  s.title = std::string("Gazebo's boxes: a box that ") +
            (complex ? "flies and tumbles" : "drifts and turns about one axis");
  s.parameters = std::string("0.1 x 0.4 x 0.9 m, 10 kg, ") +
                 (complex ? "v (-2, 2, 8) m/s, omega (0.1, 5, 0.1) rad/s, g 9.8"
                          : "v (-0.9, 0.4, 0.1) m/s, omega (0.5, 0, 0) rad/s, no gravity");
  s.reference = "rigid: parabola and Euler's equations (Runge-Kutta in long double)";
  s.benchmark =
      "Peters, Hsu: Comparison of rigid body dynamic simulators for robotic simulation in Gazebo, 2014 "
      "(scpeters/benchmark). Published for an earlier variant at 1 ms: position 0.049 m for ODE, Bullet, "
      "DART and 0.0245 for "
      "Simbody; angular momentum 1.3e-3, 1.4e-3, 1.9, 6.7e-4.";
  s.seconds = 10;
  s.samples = 100;
  s.size = 0.9;
  s.bodies = {0};
  s.stiffer_is_truer = false;
  s.make = [=](const Choice& choice) {
    WorldDef def;
    def.name = "box";
    def.settings = settingsOf(choice);
    def.settings.gravity = g;
    def.articulations.push_back(
        scenes::freeBody("box", nullptr, 10, inertia.asDiagonal(), Pose(), {omega0, v0}));
    return def;
  };
  s.exact = [=](double t) {
    const FreeRotation r = FreeRotation::at(t, inertia, omega0);
    return std::vector<BodyState>{{Pose(r.R_WB, v0 * t + 0.5 * t * t * g), Twist{r.omega_W, v0 + t * g}}};
  };
  const Vector3 L0 = inertia.cwiseProduct(omega0);
  s.measures = {worst("angular_momentum_rel",
                      [=](const Sample& now) {
                        const BodyState& b = now.bodies[0];
                        const Vector3 L =
                            b.X_WL.R * inertia.cwiseProduct(b.X_WL.R.transpose() * b.V_WL.angular);
                        return (L - L0).norm() / L0.norm();
                      }),
                {"energy_rel", [](const std::vector<Sample>& samples) {
                   double most = 0;
                   for (const Sample& sample : samples)
                     most = std::max(most, std::abs(sample.energy - samples[0].energy));
                   return most / samples[0].energy;
                 }}};
  return s;
}

/// SimBenchmark's round tower: rings of twelve blocks, each ring turned by half a block.
Scene kapla() {
  static constexpr int kFloors = 8, kBlocks = 12;
  static constexpr double kRadius = 0.42,
                          kSeconds = 30;  // [m]: neighbours on a ring do not touch; [s], theirs: 600
  const Vector3 size(0.05, 0.2, 0.1);
  Scene s;
  s.name = "kapla";
  s.title = "SimBenchmark kapla: a round tower of 96 blocks, 30 s";
  s.parameters =
      "0.2 x 0.05 x 0.1 m, 0.5 kg, eight floors of twelve, mu 0.5; falls when its highest block has sunk by "
      "half a floor";
  s.benchmark =
      "SimBenchmark, kapla (Kang, Hwangbo 2018): how long the tower stands, at 10 ms. They run 600 s, the "
      "report 30 s.";
  s.seconds = kSeconds;
  s.samples = 60;
  s.size = 0.2;
  s.stiffness = 1e7;
  s.chaotic = true;
  s.smallest_step = 1e-2 / 3;
  for (int i = 0; i < kFloors * kBlocks; ++i) s.bodies.push_back(1 + i);
  s.make = [size](const Choice& choice) {
    WorldDef def;
    def.name = "kapla";
    def.settings = settingsOf(choice);
    def.settings.gravity = Vector3(0, 0, -9.81);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e7;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = 0.5;
    def.articulations.push_back(scenes::floorBox());
    for (int i = 0; i < kFloors * kBlocks; ++i) {
      const double angle = 2 * M_PI / kBlocks * (i % kBlocks + 0.5 * (i / kBlocks % 2));
      const Matrix3 R = Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
      def.articulations.push_back(
          scenes::freeBox("block" + std::to_string(i), size, 0.5,
                          Pose(R, R * Vector3(kRadius, 0, 0.05 + 0.1 * (i / kBlocks)))));
    }
    return def;
  };
  s.measures = {{"fallen", [](const std::vector<Sample>& samples) {
                   for (const Sample& sample : samples) {
                     double lowest = 1e9;  // of the highest floor
                     for (std::size_t i = (kFloors - 1) * kBlocks; i < sample.bodies.size(); ++i) {
                       lowest = std::min(lowest, sample.bodies[i].X_WL.p.z());
                     }
                     if (lowest < 0.05 + 0.1 * (kFloors - 1) - 0.05) return kSeconds - sample.time;
                   }
                   return 0.0;
                 }}};
  return s;
}

/// A true capsule, or its hull where facets are chosen.
std::shared_ptr<const ConvexShape> capsule(double radius, double length, int facets) {
  if (facets == 0) return std::make_shared<Rod>(radius, length, Rod::Ends::kRound);
  const ConvexPolyhedron sphere = makeSphere(radius, facets, RoundFit::kEqualVolume);
  std::vector<Vector3> points;
  for (const Vector3& v : sphere.vertices()) {
    points.push_back(v + Vector3(0, 0, v.z() >= 0 ? 0.5 * length : -0.5 * length));
  }
  return std::make_shared<ConvexPolyhedron>(ConvexPolyhedron::hull(points));
}

/// Erez, Tassa, Todorov: 27 capsules that meet one another and the ground; the state after 0.1 s.
Scene capsules() {
  static constexpr double kRadius = 0.05, kLength = 0.1, kMass = 0.5;  // [m], [m], [kg]
  Scene s;
  s.name = "capsules";
  s.title = "Consistency (Erez, Tassa, Todorov): 27 capsules that meet, the state after 0.1 s";
  s.parameters =
      "R 0.05 m, 0.1 m between centres, 0.5 kg, 3 x 3 x 3 in turned orientations, fall at 2 m/s, mu 0.5; "
      "all capsules; peers: plane";
  s.benchmark =
      "Erez, Tassa, Todorov: Simulation tools for model-based robotics, ICRA 2015: difference of the state "
      "after 0.1 s from "
      "the same engine's own at 1/64 ms. Here: the numerical error.";
  s.seconds = 0.1;
  s.samples = 1;
  s.size = 2 * kRadius + kLength;
  s.stiffness = 1e8;
  s.stiffer_is_truer = false;
  s.peer_shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}};
  for (int i = 0; i < 27; ++i) {
    s.bodies.push_back(1 + i);
    s.peer_shapes.push_back({1 + i, peers::PeerShape::Kind::kCapsule, kRadius, kLength});
  }
  s.make = [](const Choice& choice) {
    WorldDef def;
    def.name = "capsules";
    def.settings = settingsOf(choice);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e8;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = 0.5;
    def.articulations.push_back(scenes::floorBox());
    const auto shape = capsule(kRadius, kLength, choice.facets);
    const Rod solid(kRadius, kLength, Rod::Ends::kRound);
    const Matrix3 inertia = solid.massProperties(kMass / solid.volume()).I_com;
    scenes::Offsets turn;
    for (int i = 0; i < 27; ++i) {
      const Matrix3 R = (Eigen::AngleAxisd(3 * turn.next(), Vector3::UnitZ()) *
                         Eigen::AngleAxisd(1.2 * turn.next(), Vector3::UnitX()))
                            .toRotationMatrix();
      const Vector3 p((i % 3 - 1) * 0.19, (i / 3 % 3 - 1) * 0.19, 0.11 + 0.19 * (i / 9));
      def.articulations.push_back(scenes::freeBody("capsule" + std::to_string(i), shape, kMass, inertia, Pose(R, p),
                                                   {Vector3::Zero(), Vector3(0, 0, -2)}));
    }
    return def;
  };
  return s;
}

/// Chung, Pollard: a hundred bodies dropped side by side, each from a slightly different pose; how far the
/// ends spread.
Scene predictable(bool cylinder) {
  static constexpr int kSide = 10;
  static constexpr double kPitch = 2, kMass = 1, kRadius = 0.05, kLength = 0.2;  // [m], [kg], [m], [m]
  const Vector3 size(0.1, 0.15, 0.2);
  Scene s;
  s.name = cylinder ? "predictable_cylinder" : "predictable_box";
  s.title = std::string("Predictability (Chung, Pollard): a hundred starts of a ") +
            (cylinder ? "cylinder on its rim" : "box on its corner");
  s.parameters = std::string(cylinder ? "R 0.05 m, 0.2 m long, 1 kg, tilted 0.5 rad"
                                      : "0.1 x 0.15 x 0.2 m, 1 kg, on a corner") +
                 ", falls 0.1 m, mu 0.5, orientations 1e-3 rad apart";
  s.benchmark =
      "Chung, Pollard: Predictable behavior during contact simulation, 2016: spread of the end poses over "
      "100 starts that differ "
      "slightly. No value is the right one; less is more predictable.";
  s.seconds = 1.5;
  s.samples = 30;
  s.size = 0.2;
  s.stiffness = 1e8;
  s.chaotic = true;
  s.smallest_step = 1e-3;
  s.peer_shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}};
  const auto place = [](int i) { return Vector3((i % kSide - 4.5) * kPitch, (i / kSide - 4.5) * kPitch, 0); };
  for (int i = 0; i < kSide * kSide; ++i) {
    s.bodies.push_back(1 + i);
    if (cylinder) s.peer_shapes.push_back({1 + i, peers::PeerShape::Kind::kCylinder, kRadius, kLength});
  }
  s.make = [=](const Choice& choice) {
    WorldDef def;
    def.name = "predictability";
    def.settings = settingsOf(choice);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e8;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = 0.5;
    def.articulations.push_back(scenes::floorBox(40));
    const auto shape =
        cylinder ? std::make_shared<ConvexPolyhedron>(makeCylinder(kRadius, kLength)) : scenes::box(size);
    const double across = kMass * (3 * kRadius * kRadius + kLength * kLength) / 12;
    const Matrix3 inertia =
        cylinder ? Matrix3(Vector3(across, across, 0.5 * kMass * kRadius * kRadius).asDiagonal())
                 : scenes::boxInertia(size, kMass);
    scenes::Offsets offsets;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double x = (cylinder ? 0.5 : 0.6) + 1e-3 * offsets.next(),
                   y = (cylinder ? 0 : 0.7) + 1e-3 * offsets.next();
      const Matrix3 R = (Eigen::AngleAxisd(x, Vector3::UnitX()) * Eigen::AngleAxisd(y, Vector3::UnitY()))
                            .toRotationMatrix();
      double low = 0;
      for (const Vector3& v : shape->vertices()) low = std::min(low, (R * v).z());
      def.articulations.push_back(scenes::freeBody("body" + std::to_string(i), shape, kMass, inertia,
                                                   Pose(R, place(i) + Vector3(0, 0, 0.1 - low))));
    }
    return def;
  };
  s.measures = {{"spread", [place](const std::vector<Sample>& samples) {
                   const std::vector<BodyState>& end = samples.back().bodies;
                   Vector3 middle = Vector3::Zero();
                   for (int i = 0; i < kSide * kSide; ++i)
                     middle += (end[i].X_WL.p - place(i)) / (kSide * kSide);
                   double sum = 0;
                   for (int i = 0; i < kSide * kSide; ++i)
                     sum += (end[i].X_WL.p - place(i) - middle).squaredNorm();
                   return std::sqrt(sum / (kSide * kSide));
                 }}};
  s.escaped = [place](const Sample& sample) -> std::string {
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vector3 p = sample.bodies[i].X_WL.p - place(i);
      if (p.z() < 0) return "a body went through the ground";
      if (p.z() > 0.5) return "a body was launched";
    }
    return "";
  };
  return s;
}

}  // namespace

std::vector<Scene> benchmarkScenes() {
  std::vector<Scene> scenes = ballScenes();
  for (Scene& scene : publishedScenes()) scenes.push_back(std::move(scene));
  for (Scene& scene : std::vector<Scene>{gazeboBox(false), gazeboBox(true), kapla(), capsules(),
                                         predictable(false), predictable(true)}) {
    scenes.push_back(std::move(scene));
  }
  return scenes;
}

}  // namespace haptic::report
