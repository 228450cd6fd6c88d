// SimBenchmark's scenes of balls (Kang, Hwangbo, ETH Zürich 2018, leggedrobotics/SimBenchmark), g = 9.81.
// True balls; peers have a plane under them, ours a box.
#include "../scenes/blocks.h"
#include "benchmark_scenes.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

constexpr double kG = 9.81, kRadius = 0.1;  // [m/s²], [m]

ArticulationDef ball(const std::string& name, const std::shared_ptr<const ConvexShape>& shape,
                     double mass, const Vector3& p) {
  return scenes::freeBody(name, shape, mass, 0.4 * mass * kRadius * kRadius * Matrix3::Identity(), Pose(p));
}

/// `balls` true balls for peers, from link `first` on, over a plane.
std::vector<peers::PeerShape> trueBalls(int first, int balls) {
  std::vector<peers::PeerShape> shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}};
  for (int i = 0; i < balls; ++i) shapes.push_back({first + i, peers::PeerShape::Kind::kSphere, kRadius, 0});
  return shapes;
}

/// Centre distance of a ball that carries its weight on k: k π R d² = m g.
double restDepth(double mass, double k) {
  return std::sqrt(mass * kG / (k * M_PI * kRadius));
}

struct Rolling {
  static constexpr double kForce = 150, kBox = 10, kBall = 1, kBoxSize = 20,
                          kHeight = 0.1;  // [N], [kg], [kg], [m], [m]
  static constexpr int kSide = 5, kBalls = kSide * kSide;
  static constexpr double kPitch = 2;      // [m]
  static constexpr double kGround = 5e-6;  // of k: the box's face has 400 m²
  Vector3 direction;

  double ballForce() const {
    const double f1 = 0.4 * (kBox + kBalls * kBall) * kG;
    return (kForce - f1) / kBox / (3.5 / kBall + kBalls / kBox);
  }
  double boxAcceleration() const {
    return (kForce - 0.4 * (kBox + kBalls * kBall) * kG - kBalls * ballForce()) / kBox;
  }
  static Vector3 place(int i) {
    return {(i % kSide - 0.5 * (kSide - 1)) * kPitch, (i / kSide - 0.5 * (kSide - 1)) * kPitch,
            kHeight + kRadius};
  }

  WorldDef make(const Choice& choice) const {
    const double k = choice.stiffness > 0 ? choice.stiffness : 1e8;
    WorldDef def;
    def.name = "rolling";
    def.settings = settingsOf(choice);
    def.settings.gravity = Vector3(0, 0, -kG);
    ContactMaterial material;
    material.stiffness = k;
    material.dissipation = 0;  // a damper over a patch resists rolling, which rigid balls do not know
    material.mu_static = material.mu_dynamic = 0.8;
    ContactMaterial ground = material;
    ground.stiffness = kGround * k;
    ground.dissipation = 10;
    ground.mu_static = ground.mu_dynamic = 0.2;  // 0.4 with the box: the geometric mean
    const auto put = [&def](ArticulationDef body, const ContactMaterial& m) {
      body.links[0].collisions[0].material = m;
      def.articulations.push_back(std::move(body));
    };
    put(scenes::floorBox(60, 1), ground);
    const double pair = 2 * kGround / (1 + kGround) * k;
    const double sink = (kBox + kBalls * kBall) * kG / (pair * kBoxSize * kBoxSize);
    put(scenes::freeBox("box", Vector3(kBoxSize, kBoxSize, kHeight), kBox,
                        Pose(Vector3(0, 0, 0.5 * kHeight - sink))),
        material);
    const auto shape = ballShape(kRadius, choice);
    for (int i = 0; i < kBalls; ++i) {
      put(ball("ball" + std::to_string(i), shape, kBall,
               place(i) - Vector3(0, 0, sink + restDepth(kBall, k))),
          material);
    }
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    hand.coupling.mode = PointerCoupling::Mode::kVirtual;
    hand.coupling.stiffness = hand.coupling.rotational_stiffness = hand.coupling.rotational_damping = 0;
    hand.coupling.damping = kPull;
    def.pointers.push_back(hand);
    return def;
  }

  std::vector<BodyState> exact(double t) const {
    const double a = boxAcceleration(), b = ballForce() / kBall;
    std::vector<BodyState> states = {
        {Pose(Vector3(0.5 * a * t * t * direction + Vector3(0, 0, 0.5 * kHeight))),
         Twist{Vector3::Zero(), a * t * direction}}};
    const Vector3 axis = -Vector3::UnitZ().cross(direction);
    const double turn = ballForce() / (0.4 * kBall * kRadius);  // [rad/s²]
    for (int i = 0; i < kBalls; ++i) {
      const Matrix3 R = Eigen::AngleAxisd(0.5 * turn * t * t, axis).toRotationMatrix();
      states.push_back(
          {Pose(R, place(i) + 0.5 * b * t * t * direction), Twist{turn * t * axis, b * t * direction}});
    }
    return states;
  }

  /// A hand that pulls with a constant force: a damper so weak, led so fast, that the box's own speed changes
  /// it by 1e-8.
  static constexpr double kPull = 1e-6;  // [N s/m]
  HandSpring hand() const {
    HandSpring h;
    h.link = 1;
    h.damping = kPull;
    const Vector3 v = kForce / kPull * direction;
    h.path = [v](double) { return BodyState{Pose(), Twist{Vector3::Zero(), v}}; };
    return h;
  }
};

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
  s.make = [r](const Choice& choice) { return r.make(choice); };
  s.exact = [r](double t) { return r.exact(t); };
  s.hands = {r.hand()};
  s.measures = {mean("velocity_squared", [r](const Sample& now) {
    const std::vector<BodyState> exact = r.exact(now.time);
    double sum = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double error = (now.bodies[i].V_WL.linear - exact[i].V_WL.linear).squaredNorm();
      sum += i == 0 ? error : error / Rolling::kBalls;
    }
    return sum;
  })};
  return s;
}

/// Balls of 10 kg in a grid over the ground.
WorldDef ballGrid(const Choice& choice, int side, int layers, double pitch, double lowest, double jitter,
                  double mu, bool elastic) {
  WorldDef def;
  def.name = "balls";
  def.settings = settingsOf(choice);
  def.settings.gravity = Vector3(0, 0, -kG);
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = choice.stiffness > 0 ? choice.stiffness : 1e9;
  m.dissipation = elastic ? 0 : 10;
  if (elastic) m.damping = 0;
  m.mu_static = m.mu_dynamic = mu;
  def.articulations.push_back(scenes::floorBox(40, 1));
  const auto shape = ballShape(kRadius, choice);
  Offsets offsets;
  for (int i = 0; i < side * side * layers; ++i) {
    const double dx = jitter * offsets.next(), dy = jitter * offsets.next();
    const Vector3 p((i % side - 0.5 * (side - 1)) * pitch + dx,
                    (i / side % side - 0.5 * (side - 1)) * pitch + dy, lowest + i / (side * side) * pitch);
    def.articulations.push_back(ball("ball" + std::to_string(i), shape, 10, p));
  }
  return def;
}

/// Sum of the squared overlaps of true balls with one another and with the ground [m²].
double overlap(const Sample& s) {
  double sum = 0;
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    const Vector3& p = s.bodies[i].X_WL.p;
    sum += std::pow(std::max(0.0, kRadius - p.z()), 2);
    for (std::size_t j = 0; j < i; ++j) {
      const double distance = (p - s.bodies[j].X_WL.p).norm();
      if (distance < 2 * kRadius) sum += std::pow(2 * kRadius - distance, 2);
    }
  }
  return sum;
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
  s.make = [](const Choice& choice) { return ballGrid(choice, 7, 1, 2, kRadius + 5, 0, 0, true); };
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
    return ballGrid(choice, 6, 6, 0.21, lowest, 1e-3, elastic ? 0 : 0.5, elastic);
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
