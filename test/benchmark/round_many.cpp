// Many balls: SimBenchmark's rolling against its closed form, and its 666 beside ODE.
#include <ctime>

#include "../scenes/balls.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "peer_world.h"
#include "round_figures.h"

namespace haptic::bench {
namespace {

WorldSettings byDefault() {
  WorldSettings settings;
  settings.step = 1e-3;
  return settings;
}

}  // namespace

/// The default method at 1 ms. What friction springs yield before they slip is the error: k is as stiff as the bound needs.
void measureRollingBalls() {
  constexpr double kStiffness = 1e12, kSeconds = 4;
  for (const bool diagonal : {true, false}) {
    const scenes::RollingBalls r{diagonal ? Vector3(0.5, std::sqrt(0.75), 0) : Vector3(Vector3::UnitY())};
    World world(r.make(byDefault(), kStiffness, std::make_shared<Ball>(scenes::kBallRadius)));
    const int steps = static_cast<int>(std::lround(kSeconds / byDefault().step));
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      world.setPointerTarget(0, Pose(), r.handTwist());
      world.step();
      sum += r.squaredError((i + 1) * byDefault().step, [&](int body) { return world.linkTwist(2 + body).linear; }) / steps;
    }
    if (diagonal) figure("rolling.stiffness", kStiffness, "N/m3");
    figure(diagonal ? "rolling.velocity_err" : "rolling.velocity_err_y", sum, "m2/s2");
  }
}

namespace {

struct Course {
  std::vector<double> us;  ///< of the steps after the first
  double overlap = 0;      ///< mean over time of the sum of squares [m²]
  double mean() const {
    double sum = 0;
    for (const double t : us) sum += t / static_cast<double>(us.size());
    return sum;
  }
};

/// One step of either; both take turns, so that a busy machine disturbs them alike.
template <class Simulator>
void advance(Simulator& world, int balls, int steps, Course& course) {
  const double start = cpuSeconds();
  world.step();
  course.us.push_back(1e6 * (cpuSeconds() - start));
  std::vector<Vector3> centres;
  for (int i = 0; i < balls; ++i) centres.push_back(world.linkPose(1 + i).p);
  course.overlap += scenes::squaredOverlaps(centres) / steps;
}

}  // namespace

void measureSix() {
  constexpr double kStiffness = 5e11, kSeconds = 2;  // as little overlap as ODE's
  scenes::BallGrid grid;
  grid.stiffness = kStiffness;
  const auto ball = std::make_shared<Ball>(scenes::kBallRadius);
  const WorldDef def = grid.make(byDefault(), ball);
  peers::PeerSettings settings;
  settings.peer = peers::Peer::kOdeQuick;
  settings.iterations = 20;
  settings.step = byDefault().step;
  settings.shapes = {{0, peers::PeerShape::Kind::kPlane, 0, 0}};
  World world(def);
  const auto peer = peers::makePeer(def, settings);
  const int steps = static_cast<int>(std::lround(kSeconds / settings.step));
  Course ours, theirs;
  int unconverged = 0;
  for (int i = 0; i < steps; ++i) {
    advance(world, grid.count(), steps, ours);
    unconverged += (world.report().flags & kNotConverged) != 0;
    advance(*peer, grid.count(), steps, theirs);
  }
  figure("six.stiffness", kStiffness, "N/m3");
  for (const auto& [name, course] : {std::pair{"six", &ours}, {"six.ode_quick20", &theirs}}) {
    const std::string prefix = std::string(name) + ".";
    figure(prefix + "mean_us", course->mean(), "us");
    figure(prefix + "median_us", median(course->us), "us");
    figure(prefix + "worst_us", *std::max_element(course->us.begin() + 1, course->us.end()), "us");
    figure(prefix + "overlap", course->overlap, "m2");
  }
  figure("six.unconverged", unconverged, "");
  figure("six.mean_vs_ode_quick", ours.mean() / theirs.mean(), "");
  figure("six.overlap_vs_ode", ours.overlap / theirs.overlap, "");
  figure("six.worst_over_median", *std::max_element(ours.us.begin() + 1, ours.us.end()) / median(ours.us), "");
}

}  // namespace haptic::bench
