/// Dampers and friction take: 500 bodies of all forms are dropped, most of them lighter to turn than any solid of their form.
///
/// In each step and of each contact: energy that its damper, and energy that its friction gave to the bodies, by the mean wrench that
/// moved them and the mean velocity of the step, both as the state remembers them; the ledger is not read. Of what friction took, its
/// springs hold a part. Of a step in parts the state remembers the last: such steps are counted apart.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "../scenes/blocks.h"
#include "figure.h"
#include "haptic_core/world/state.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

constexpr int kDrops = 500;
constexpr double kStep = 5e-5, kStiffness = 1e8, kDissipation = 10, kFriction = 0.5;  // [s], [N/m³], [s/m], [1]
constexpr double kSpeed = 2.42, kSeconds = 0.1;  // [m/s]: of a fall of .3 m; [s]

class Random {
 public:
  explicit Random(int seed) : random_(static_cast<unsigned>(seed)) {}
  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  double logUniform(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
  Vector3 inCube(double a) { return {uniform(-a, a), uniform(-a, a), uniform(-a, a)}; }

 private:
  std::mt19937 random_;
};

/// Moments of a solid box times 1e-2…1 each, as far as there is a body with them.
Matrix3 lightened(Random& random, const Vector3& size, double mass) {
  Vector3 I = boxInertia(size, mass).diagonal();
  for (int k = 0; k < 3; ++k) I[k] *= random.logUniform(1e-2, 1);
  for (int k = 0; k < 3; ++k) I[k] = std::min(I[k], 0.999 * (I.sum() - I[k]));
  return I.asDiagonal();
}

/// A box, a rod, a plate or a prism, which is about to meet the floor.
WorldDef drop(int seed) {
  Random random(seed);
  WorldDef def;
  def.name = "drop";
  def.settings.step = kStep;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kStiffness;
  m.dissipation = kDissipation;
  m.mu_static = m.mu_dynamic = kFriction;
  def.articulations.push_back(floorBox());
  const double aspect = random.logUniform(1, 30), width = random.logUniform(5e-3, 3e-2), mass = random.logUniform(0.1, 10);
  const int kind = seed % 4;
  Vector3 size(width, width * random.uniform(1, aspect), width * aspect);
  if (kind == 1 || kind == 3) size = Vector3(width, width, width * aspect);
  if (kind == 2) size = Vector3(width, width, width / aspect);
  std::shared_ptr<const ConvexPolyhedron> shape = box(size);
  if (kind == 3) {
    const int sides = 3 + static_cast<int>(random.uniform(0, 6));
    shape = std::make_shared<ConvexPolyhedron>(makeCylinder(0.5 * width, size.z(), sides));
  }
  const Matrix3 R = rotationFromRpy(random.inCube(M_PI));
  const Matrix3 I = lightened(random, size, mass);
  const double height = 0.5 * size.norm() + 1e-3;
  const Twist V{random.inCube(3), Vector3(random.uniform(-1, 1), random.uniform(-1, 1), -kSpeed)};
  def.articulations.push_back(freeBody("body", shape, mass, I, Pose(R, Vector3(0, 0, height)), V));
  return def;
}

/// Energy that a contact's damper and its friction gave in a step [J].
struct Given {
  double damper = 0, friction = 0;
  double sum() const { return damper + friction; }
};

/// By the mean wrench that moved the body and the mean twist, both about W's origin. `held`: what friction's springs have gained.
Given givenBy(const ContactMeans& means, const Pose& X_WP, double held) {
  const Matrix3 R_PW = X_WP.R.transpose();
  const Wrench rest = (means.done - means.elastic).shifted(X_WP.p).rotated(R_PW);
  const Twist V = means.V.shifted(X_WP.p).rotated(R_PW);
  const double normal = rest.force.z() * V.linear.z() + rest.torque.head<2>().dot(V.angular.head<2>());
  const double along = rest.force.head<2>().dot(V.linear.head<2>()) + rest.torque.z() * V.angular.z();
  return {std::max(0.0, kStep * normal), std::max(0.0, kStep * along + held)};
}

struct Run {
  Given worst, sum;           ///< in the worst step; in all [J]
  double exchanged = 0;       ///< [J]
  double unsaid = 0;          ///< in the worst step that does not flag it [J]
  int steps = 0, parted = 0, flagged = 0;  ///< parted: of more parts than one
  bool finite = true;
};

Run run(const WorldDef& def) {
  World world(def);
  Run out;
  const LinkDef& body = def.articulations[1].links[0];
  const auto energies = [&] {
    const Pose X = world.linkPose(1);
    const Twist V = world.linkTwist(1);
    const Vector3 omega_L = X.R.transpose() * V.angular;
    return std::array<double, 2>{0.5 * (body.inertia.mass * V.linear.squaredNorm() + omega_L.dot(body.inertia.I_C * omega_L)),
                                 body.inertia.mass * kGravity * X.p.z()};
  };
  const auto first = energies();
  double held = 0;
  for (double t = 0; t < kSeconds && out.finite; t += kStep) {
    world.step();
    ++out.steps;
    out.finite = world.report().finite;
    const auto now = energies();
    for (int k = 0; k < 2; ++k) out.exchanged = std::max(out.exchanged, std::abs(now[k] - first[k]));
    const State& state = world.state();
    if (state.pairs.awake().empty()) continue;
    const ActivePair& pair = state.pairs[state.pairs.awake()[0]];
    const double held_before = held;
    held = pair.friction.energy;
    if (world.contactCount() == 0) continue;
    if (world.report().parts > 1) {
      ++out.parted;
      continue;
    }
    const Given given = givenBy(pair.means, world.contact(0).X_WP, held - held_before);
    if (world.report().flags & kDissipationGave) {
      ++out.flagged;
    } else {
      out.unsaid = std::max(out.unsaid, given.sum());
    }
    if (given.sum() > out.worst.sum()) out.worst = given;
    out.sum.damper += given.damper;
    out.sum.friction += given.friction;
  }
  return out;
}

}  // namespace

void runPower() {
  double worst = 0, damper = 0, friction = 0, damper_run = 0, friction_run = 0;
  double unsaid = 0;
  long steps = 0, parted = 0, flagged = 0, stopped = 0;
  for (int i = 0; i < kDrops; ++i) {
    const Run r = run(drop(i));
    worst = std::max(worst, r.worst.sum() / r.exchanged);
    damper = std::max(damper, r.worst.damper / r.exchanged);
    friction = std::max(friction, r.worst.friction / r.exchanged);
    damper_run = std::max(damper_run, r.sum.damper / r.exchanged);
    friction_run = std::max(friction_run, r.sum.friction / r.exchanged);
    unsaid = std::max(unsaid, r.unsaid / r.exchanged);
    steps += r.steps, parted += r.parted, flagged += r.flagged, stopped += !r.finite;
  }
  figure("power.given_rel", unsaid, "1");
  figure("power.flagged_given_rel", worst, "1");
  figure("power.flagged_pct", 100.0 * static_cast<double>(flagged) / static_cast<double>(steps), "%");
  figure("power.damper_given_rel", damper, "1");
  figure("power.friction_given_rel", friction, "1");
  figure("power.damper_given_run_rel", damper_run, "1");
  figure("power.friction_given_run_rel", friction_run, "1");
  figure("power.parted_pct", 100.0 * static_cast<double>(parted) / static_cast<double>(steps), "%");
  figure("power.stopped", static_cast<double>(stopped), "1");
}

}  // namespace haptic::bench
