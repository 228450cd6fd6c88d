// Grasp, cradle, gyroscope and pyramid: the report's own scenes, ours with the scene's stiffness and rigid, and all settings of all peers.
// Which of both counts is said by the report's list (pareto_cells.csv); the other has a name of its own.
#include <algorithm>
#include <cmath>
#include <functional>

#include "../scenes/grasp.h"
#include "benchmark_scenes.h"
#include "figure.h"
#include "haptic_core/base/error.h"
#include "peer_rivals.h"
#include "peers_figures.h"

namespace haptic::bench {
namespace {

using report::Method;
using report::Scene;
using report::Simulator;
using scenes::Cradle;
using scenes::Grasp;

constexpr double kStep = 1e-3, kDropped = 5e-3;  // [s], [m]: MotrixSim's bound

const Scene& sceneNamed(const std::vector<Scene>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const Scene& s) { return s.name == name; });
  if (found == all.end()) throw SetupError("scene '" + name + "'", "is not in the list", "see report_run --list");
  return *found;
}

struct Held {
  double slip = 0;         ///< largest within 5 s after friction was lowered [m]
  double jitter = 0;       ///< of the force on the cube: standard deviation of its change in a step, over m g
};

/// Force on the cube of every simulator by its change of momentum, m (Δv/h + g): who integrates how does not matter. Throws SetupError.
Held hold(const Scene& scene, const Method& method) {
  Held out;
  WorldDef def;
  const auto world = report::makeSimulator(scene, method, kStep, def);
  const int lowered = static_cast<int>(std::lround(Grasp::kLowered / kStep)), steps = lowered + 5000;
  const auto height = [&](int link) { return world->body(link).X_WL.p.z(); };
  double first[3] = {0, 0, 0}, speed = 0, force = 0, sum = 0, squares = 0;
  int count = 0;
  for (int i = 0; i < steps && out.slip <= kDropped; ++i) {
    world->step();
    const double v = world->body(Grasp::kCube).V_WL.linear.z(), F = Grasp::kMass * ((v - speed) / kStep + Grasp::kG);
    if (i + 1 == lowered) {
      for (int link = 0; link < 3; ++link) first[link] = height(link);
    }
    if (i + 1 > lowered) {
      const std::function<double(int)> now = height, before = [&](int link) { return first[link]; };
      out.slip = std::max(out.slip, std::abs(scenes::slipBetween(now, before)));
      const double change = F - force;
      sum += change, squares += change * change, ++count;
    }
    speed = v, force = F;
  }
  if (!world->finite() || !std::isfinite(out.slip)) out.slip = infinite();
  const double mean = sum / count;
  out.jitter = std::sqrt(std::max(0.0, squares / count - mean * mean)) / (Grasp::kMass * Grasp::kG);
  return out;
}

}  // namespace

void measureGrasp() {
  const std::vector<Scene> all = report::publishedScenes();
  struct Case {
    const char* name;
    bool holds;
  };
  const Case cases[] = {{"grasp_090", false}, {"grasp_098", false}, {"grasp_100", true}, {"grasp_102", true}, {"grasp_110", true}};
  for (const Rival& rival : rivals()) {
    try {
      double held = 0, jitter = 0;
      int released = 0;
      std::string line;
      for (const Case& each : cases) {
        const Held h = hold(sceneNamed(all, each.name), rival.method);
        released += !each.holds && h.slip > kDropped;
        if (each.holds) held = std::max(held, h.slip), jitter = std::max(jitter, h.jitter);
        char text[64];
        std::snprintf(text, sizeof text, " %10.4g", 1e3 * h.slip);
        line += h.slip > kDropped ? "    dropped" : text;
      }
      const Held shaken = hold(sceneNamed(all, "grasp_shake"), rival.method);
      std::printf("peers grasp %-20s slip [mm] at f .90 .98 1.00 1.02 1.10:%s; shaken %.4g mm%s; jitter %.3g\n", rival.name.c_str(),
                  line.c_str(), 1e3 * shaken.slip, shaken.slip > kDropped ? " (dropped)" : "", jitter);
      if (!rival.ours()) continue;
      const std::string tail = rival.method.choice.rigid ? "" : "_said";  // the rule of the report's list: rigid
      figure("grasp.held_mm_max" + tail, 1e3 * held, "mm");
      figure("grasp.released" + tail, released, "1");
      figure("grasp.force_jitter_rel" + tail, jitter, "1");
      figure("grasp.shaken_mm" + tail, 1e3 * shaken.slip, "mm");
    } catch (const SetupError& error) {
      tellRefusal("grasp", rival, error.what());
    }
  }
}

void measureCradle() {
  const std::vector<Scene> all = report::publishedScenes();
  const Scene& scene = sceneNamed(all, "cradle");
  double best_peer = 0;
  for (const Rival& rival : rivals()) {
    try {
      WorldDef def;
      const auto world = report::makeSimulator(scene, rival.method, kStep, def);
      for (int i = 0; i < static_cast<int>(std::lround(scene.seconds / kStep)); ++i) world->step();
      double energy = 0;
      std::string line;
      for (int ball = 0; ball < Cradle::kBalls; ++ball) {
        const double v = world->body(ball).V_WL.linear.x() / Cradle::kSpeed;
        energy += v * v;
        char text[32];
        std::snprintf(text, sizeof text, " %.4f", v);
        line += text;
      }
      const double last = world->body(Cradle::kBalls - 1).V_WL.linear.x() / Cradle::kSpeed;
      std::printf("peers cradle %-20s speeds%s, energy %.4f\n", rival.name.c_str(), line.c_str(), energy);
      const std::string tail = rival.method.choice.rigid ? "_rigid" : "";  // the rule: as the scene says, for it is elastic
      if (rival.ours()) figure("cradle.last_ball_share" + tail, last, "1");
      if (!rival.ours() && energy < 1.01) best_peer = std::max(best_peer, last);
    } catch (const SetupError& error) {
      tellRefusal("cradle", rival, error.what());
    }
  }
  figure("cradle.last_ball_share_best_peer", best_peer, "1");
}

/// The report's top at all its steps: error of the axis's direction, and CPU time. A peer counts at a step where it takes no more time.
void measureGyroscope() {
  const std::vector<Scene> all = report::motionScenes();
  const Scene& scene = sceneNamed(all, "top");
  const std::vector<report::Sample> exact = report::exactSamples(scene);
  struct Point {
    std::string name;
    double step, error, cpu;
    bool ours, rigid;
  };
  std::vector<Point> points;
  for (const Rival& rival : rivals()) {
    for (const double step : {1e-4, 1e-3 / 3, 1e-3, 1e-2 / 3, 1e-2}) {
      Method method = rival.method;
      method.choice.step = step;
      const report::RunResult run = report::runCase(scene, method, 0.1);
      if (run.status == "refused") {
        tellRefusal("gyro", rival, run.reason);
        break;
      }
      double worst = run.status == "ok" ? 0 : infinite();
      for (std::size_t i = 0; i < run.samples.size() && run.status == "ok"; ++i) {
        const Vector3 now = run.samples[i].bodies[0].X_WL.R.col(2), right = exact[i].bodies[0].X_WL.R.col(2);
        // Precession: the angle of the axis about the vertical.
        const double turn = std::atan2(now.y(), now.x()) - std::atan2(right.y(), right.x());
        worst = std::max(worst, std::abs(std::remainder(turn, 2 * M_PI)));
      }
      std::vector<double> times = run.cpu_s;
      const double cpu = rival.wasm() ? infinite() : median(times) / scene.seconds;
      points.push_back({rival.name, step, worst, cpu, rival.ours(), method.choice.rigid});
      std::printf("peers gyro %-20s step %.3g ms: precession errs by %.3g rad, %.3g ms of CPU time a second\n", rival.name.c_str(),
                  1e3 * step, worst, 1e3 * points.back().cpu);
    }
  }
  double ratio = 0;
  for (const Point& ours : points) {
    if (!ours.ours || !ours.rigid) continue;  // the rule: rigid
    double best = infinite();
    for (const Point& peer : points) {
      if (!peer.ours && peer.cpu <= ours.cpu) best = std::min(best, peer.error);
    }
    const double share = std::isfinite(best) ? ours.error / best : 0;  // nobody is as fast
    std::printf("peers gyro at %.3g ms a second: ours errs by %.3g rad, the best peer by %.3g\n", 1e3 * ours.cpu, ours.error, best);
    if (ours.step == kStep) figure("gyro.err_vs_best_peer", share, "1");
    ratio = std::max(ratio, share);
  }
  figure("gyro.err_vs_best_peer_any_step", ratio, "1");
}

/// 200 steps of each, or as many as it takes in kPatience of CPU time. Rigid surfaces only where there are few boxes: k follows the weight
/// of all that moves.
void measurePyramid(int rows) {
  constexpr int kSteps = 200, kFew = 500;
  constexpr double kPatience = 200;  // [s]
  const Scene scene = report::pyramidScene(rows);
  const int boxes = static_cast<int>(scene.bodies.size());
  const scenes::CubePyramid pyramid{rows};
  const std::string prefix = "pyramid" + std::to_string(boxes) + ".";
  const std::vector<std::string> wanted = {"ours", "ours_rigid", "bullet10", "bullet50", "ode_quick20"};
  for (const Rival& rival : rivals()) {
    if (std::find(wanted.begin(), wanted.end(), rival.name) == wanted.end()) continue;
    if (rival.method.choice.rigid && boxes > kFew) continue;
    try {
      WorldDef def;
      const auto world = report::makeSimulator(scene, rival.method, kStep, def);
      std::vector<double> us;
      double spent = 0;
      int unconverged = 0;
      while (static_cast<int>(us.size()) < kSteps && spent < kPatience) {
        const double before = cpuSeconds();
        world->step();
        const double seconds = cpuSeconds() - before;
        spent += seconds;
        us.push_back(1e6 * seconds / boxes);
        if (world->world()) unconverged += (world->world()->report().flags & kNotConverged) != 0;
      }
      const int steps = static_cast<int>(us.size());
      const Vector3 off = pyramid.place(boxes - 1) - world->body(scene.bodies.back()).X_WL.p;
      const double sink = off.z() / scenes::CubePyramid::kSize, aside = off.head<2>().norm() / scenes::CubePyramid::kSize;
      std::printf("peers pyramid %-12s %d steps, %.3g us a box and step (median %.3g, worst %.3g), unconverged %d\n", rival.name.c_str(),
                  steps, 1e6 * spent / boxes / steps, median(us), *std::max_element(us.begin(), us.end()), unconverged);
      std::printf("peers pyramid %-12s the top sinks by %.3g of a box, and moves aside by %.3g\n", rival.name.c_str(), sink, aside);
      const std::string name = rival.ours() ? (rival.method.choice.rigid ? "rigid." : "") : rival.name + ".";
      figure(prefix + name + "us_per_box_step", 1e6 * spent / boxes / steps, "us");
      figure(prefix + name + "sink_share", sink, "1");
      figure(prefix + name + "steps", steps, "1");
      if (rival.ours()) figure(prefix + name + "unconverged", unconverged, "1");
    } catch (const std::exception& error) {
      tellRefusal("pyramid", rival, error.what());
    }
  }
}

}  // namespace haptic::bench
