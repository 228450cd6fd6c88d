// Two hands take a loose cube between them, lift it and hold it: two god objects on a body that is stepped
// for them, and two of our hands.
#include <algorithm>
#include <cmath>

#include "../scenes/touch.h"
#include "figure.h"
#include "god_object.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "peers_figures.h"

namespace haptic::bench {
namespace {

constexpr double kStep = 1e-3, kK = 1000, kRadius = 0.005, kSize = 0.04, kMass = 0.1, kMu = 0.8;  // SI
constexpr double kGrip =
    0.006;  // each hand goes this far into its face [m]: friction of both carries ten times the weight
constexpr double kLift = 0.05, kSeconds = 4;
constexpr double kAside = 0.004;  // of the cube's middle [m]: hung from two points it swings, and only torque
                                  // of the patches stills it

/// Centre of a hand: it closes within .5 s, lifts within the next second, and holds. `side`: −1 or 1.
Vector3 handAt(double t, int side) {
  const auto smooth = [](double x) { return 0.5 - 0.5 * std::cos(M_PI * std::clamp(x, 0.0, 1.0)); };
  const double open = kSize / 2 + kRadius + 1e-3;
  return {side * (open - (kGrip + 1e-3) * smooth(t / 0.5)), kAside,
          kSize / 2 + 0.005 + kLift * smooth(t - 0.6)};
}

/// Where the cube is, over its place in the hands: the largest distance in the last two seconds [m], and the
/// largest turn [rad].
struct Held {
  double away = 0, turn = 0;
  void look(const Pose& X, double t) {
    if (t < kSeconds - 2) return;
    away = std::max(away, (X.p - Vector3(0, 0, kSize / 2 + kLift)).norm());
    turn = std::max(turn, std::acos(std::clamp(0.5 * (X.R.trace() - 1), -1.0, 1.0)));
  }
};

/// The cube is stepped by symplectic Euler under weight, floor and the reactions of both god objects at their
/// proxies.
Held byGodObjects() {
  const TriangleMesh mesh = makeBox(Vector3::Constant(kSize)).triangles();
  Pose X(Vector3(0, 0, kSize / 2));
  const double inertia = kMass * kSize * kSize / 6;
  Vector3 v = Vector3::Zero(), omega = Vector3::Zero();
  GodObject hands[] = {{{kK, kRadius, kMu, kMu}, handAt(0, -1)}, {{kK, kRadius, kMu, kMu}, handAt(0, 1)}};
  for (GodObject& hand : hands) hand.addMesh(mesh, X);
  Held held;
  for (int i = 1; i * kStep <= kSeconds; ++i) {
    Vector3 F(0, 0, -kMass * scenes::kGravity), T = Vector3::Zero();
    for (int h = 0; h < 2; ++h) {
      hands[h].moveMesh(0, X);
      const Vector3 force = -hands[h].tick(handAt(i * kStep, 2 * h - 1));
      if (hands[h].constraints() == 0) continue;
      F += force;
      T += (hands[h].proxy() - kRadius * hands[h].normal(0) - X.p).cross(force);
    }
    v += kStep / kMass * F, omega += kStep / inertia * T;
    if (X.p.z() <= kSize / 2 && v.z() < 0) v.z() = 0;  // the floor
    X.p += kStep * v;
    X.R = rotationFromVector(kStep * omega).toRotationMatrix() * X.R;
    held.look(X, i * kStep);
  }
  return held;
}

Held byOurs(PointerCoupling::Mode mode) {
  WorldDef def;
  def.name = "two hands";
  def.settings.step = kStep;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = 1e10;
  m.mu_static = m.mu_dynamic = kMu;
  def.articulations.push_back(scenes::floorBox());
  def.articulations.push_back(
      scenes::freeBox("cube", Vector3::Constant(kSize), kMass, Pose(Vector3(0, 0, kSize / 2))));
  for (const int side : {-1, 1}) {
    def.articulations.push_back(scenes::freeBody("tool" + std::to_string(side),
                                                 std::make_shared<Ball>(kRadius), 0.05,
                                                 1e-4 * Matrix3::Identity(), Pose(handAt(0, side))));
    scenes::addPointer(def, static_cast<int>(def.articulations.size()) - 1);
    PointerCoupling& coupling = def.pointers.back().coupling;
    coupling.mode = mode;
    coupling.stiffness = kK, coupling.damping = 2;
  }
  World world(def);
  PointerBound bound;
  if (mode == PointerCoupling::Mode::kDirect) bound.stiffness = kK, bound.force = 20;
  Held held;
  for (int i = 1; i * kStep <= kSeconds; ++i) {
    for (int h = 0; h < 2; ++h) {
      const Vector3 now = handAt(i * kStep, 2 * h - 1), before = handAt((i - 1) * kStep, 2 * h - 1);
      world.setPointerBound(h, bound);
      world.setPointerTarget(h, Pose(now), {Vector3::Zero(), (now - before) / kStep});
    }
    world.step();
    held.look(world.linkPose(1), i * kStep);
  }
  return held;
}

}  // namespace

void measureTwoHands() {
  const auto print = [](const std::string& name, const Held& held) {
    figure(name + ".two_hands_away_mm", 1e3 * held.away, "mm");
    figure(name + ".two_hands_turn_rad", held.turn, "rad");
  };
  print("god", byGodObjects());
  print("ours", byOurs(PointerCoupling::Mode::kVirtual));
  print("ours_direct", byOurs(PointerCoupling::Mode::kDirect));
}

}  // namespace haptic::bench
