/// What steps say of their own error, beside the true one; and whether asking for less error gives less.
///
/// Error of a step: the largest over bodies of |Δx| + r_gyration |Δθ| after it, of the same start stepped at h/64. Every step of the
/// first second of every shipped scene, hands on their scripted paths. Below a picometre and a nanonewton nothing is compared: rounding.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "../scenes/shipped_scenes.h"
#include "../scenes/step_motions.h"
#include "figure.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"
#include "step_figures.h"

namespace haptic::bench {
namespace {

using scenes::ShippedScene;
using scenes::StepMotion;

constexpr int kFine = 64;
constexpr double kSeconds = 1, kLeastWay = 1e-12, kLeastForce = 1e-9;  ///< [s], [m], [N]
constexpr double kMost = 3;  ///< a step that errs by more than so many times what it says is not honest

const std::string kScenes = std::string(HAPTIC_SOURCE_DIR) + "/urdf/scenes/";

/// Of what no hand holds [m].
double distance(const World& A, const World& B) {
  double most = 0;
  for (int l = 0; l < A.linkCount(); ++l) {
    const ModelLink& link = A.model().links[l];
    if (!link.moves || A.work().hands.held_by[l] >= 0) continue;
    const LinkModel& body = A.model().trees[link.articulation].model->link(link.local);
    const double gyration = body.mass > 0 ? std::sqrt(body.I_O.trace() / 2 / body.mass) : 0;
    const Pose X = A.linkPose(l), Y = B.linkPose(l);
    const double turn = vectorFromRotation(Quaternion(Matrix3(X.R.transpose() * Y.R))).norm();
    most = std::max(most, (X.p - Y.p).norm() + gyration * turn);
  }
  return most;
}

/// Of steps that are told apart from rounding.
struct Honesty {
  int steps = 0, above = 0;
  std::vector<double> ratio;  ///< true over estimate
  void add(double truth, double estimate, double least) {
    ++steps;
    above += truth > least && truth > kMost * estimate;
    if (truth > least && estimate > least) ratio.push_back(truth / estimate);
  }
  void add(const Honesty& other) {
    steps += other.steps, above += other.above;
    ratio.insert(ratio.end(), other.ratio.begin(), other.ratio.end());
  }
  double share() const { return static_cast<double>(above) / std::max(1, steps); }
};

void aim(const ShippedScene& scene, double t, World& world) {
  for (const HandDef& hand : scene.def.hands) {
    const WorkspaceMap map = mapOnPath(hand, t);
    world.setPointerTarget(hand.pointer, map.X_WP(), map.V_WP());
  }
}

void compare(const ShippedScene& scene, Honesty& way, Honesty& force) {
  const double h = scene.def.world.settings.step;
  WorldDef finer = scene.def.world;
  finer.settings.step = h / kFine;
  World world(scene.def.world), fine(finer);
  const int pointers = world.pointerCount();
  for (int i = 0; i < std::lround(kSeconds / h); ++i) {
    State state = world.state();
    state.step *= kFine;
    fine.restore(state.pack());
    aim(scene, (i + 1) * h, world);
    world.step();
    std::vector<Vector3> F(pointers, Vector3::Zero());
    for (int j = 1; j <= kFine; ++j) {
      aim(scene, (i + static_cast<double>(j) / kFine) * h, fine);
      fine.step();
      for (int p = 0; p < pointers; ++p) F[p] += fine.pointerWrench(p).force / kFine;
    }
    way.add(distance(world, fine), world.report().position_error, kLeastWay);
    for (int p = 0; p < pointers; ++p) {
      force.add((world.pointerWrench(p).force - F[p]).norm(), world.pointerForceError(p), kLeastForce);
    }
  }
}

/// Slope of the logarithm of the error at the end over that of the accuracy that was asked for.
double order(const StepMotion& motion) {
  constexpr double kEnd = 0.5, kStep = 1e-3;
  constexpr double kAccuracies[] = {0.3, 0.1, 0.03, 0.01, 0.003};
  const auto run = [&](const WorldSettings& settings) {
    auto world = std::make_unique<World>(motion.make(settings));
    while (world->time() < kEnd - 0.5 * settings.step) {
      motion.aim(*world);
      world->step();
    }
    return world;
  };
  const auto exact = run(verletSettings(kStep / motion.fine));
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const double accuracy : kAccuracies) {
    WorldSettings settings = stepSettings();
    settings.accuracy = accuracy;
    const double error = std::max(kLeastWay, distance(*run(settings), *exact)), lx = std::log(accuracy), ly = std::log(error);
    std::printf("%s: A %g, %.4g um at the end\n", motion.name.c_str(), accuracy, 1e6 * error);
    const double n = std::size(kAccuracies);
    x += lx / n, y += ly / n, xx += lx * lx / n, xy += lx * ly / n;
  }
  return (xy - x * y) / (xx - x * x);
}

}  // namespace

void runAccuracy() {
  Honesty way, force;
  for (const ShippedScene& scene : scenes::shippedScenes(kScenes)) {
    Honesty w, f;
    compare(scene, w, f);
    std::printf("%s: %d steps, %.3g %% err by more than three times, median %.3g; force %.3g %%, median %.3g\n", scene.name.c_str(),
                w.steps, 100 * w.share(), w.ratio.empty() ? 0 : median(w.ratio), 100 * f.share(), f.ratio.empty() ? 0 : median(f.ratio));
    way.add(w), force.add(f);
  }
  figure("accuracy.honest", way.share(), "1");
  figure("accuracy.median_true_over_estimate", median(way.ratio), "1");
  figure("hand.force_error_est.above_share", force.share(), "1");
  figure("hand.force_error_est.median_true_over_estimate", force.ratio.empty() ? 0 : median(force.ratio), "1");
  double sum = 0;
  int count = 0;
  for (const StepMotion& motion : scenes::stepMotions()) {
    if (motion.name != "slide_1e8" && motion.name != "spin_1e8" && motion.name != "push_1e8" && motion.name != "press_1e8" &&
        motion.name != "rock_1e8") {
      continue;
    }
    const double slope = order(motion);
    figure("accuracy.order." + motion.name, slope, "1");
    sum += slope, ++count;
  }
  figure("accuracy.order", sum / std::max(1, count), "1");
}

}  // namespace haptic::bench
