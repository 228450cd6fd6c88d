// CENIC's scenes: error over CPU time of ours by accuracy at 1 ms, and of the peers by step.
#include <algorithm>
#include <cmath>

#include "cenic_scenes.h"
#include "figure.h"
#include "peer_rivals.h"
#include "peers_figures.h"

namespace haptic::bench {
namespace {

using report::CenicScene;
using report::Method;
using report::RunResult;
using report::Sample;

constexpr double kStep = 1e-3, kTiny = 1e-3 / 32;  // [s]: of ours; of the references, which are held against half of it

/// Of the marked points, of the worst body: rms over the samples [m].
double distance(const CenicScene& c, const std::vector<Sample>& a, const std::vector<Sample>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    double worst = 0;
    for (std::size_t body = 0; body < a[i].bodies.size(); ++body) {
      worst = std::max(worst, (a[i].bodies[body].X_WL * c.mark - b[i].bodies[body].X_WL * c.mark).squaredNorm());
    }
    squares += worst;
  }
  return std::sqrt(squares / static_cast<double>(a.size()));
}

RunResult run(const CenicScene& c, Method method, double step, double budget) {
  method.choice.step = step;
  return report::runCase(c.scene, method, budget);
}

/// A run at a tiny step, and by how much half of it moves that. Empty where one of both failed.
struct Reference {
  std::vector<Sample> samples;
  double moves = 0;  ///< [m]
};
Reference referenceOf(const CenicScene& c, const Method& method) {
  const RunResult tiny = run(c, method, kTiny, 0), half = run(c, method, 0.5 * kTiny, 0);
  if (tiny.status != "ok" || half.status != "ok") return {};
  return {half.samples, distance(c, tiny.samples, half.samples)};
}

struct Point {
  double error = infinite(), cpu = infinite();  ///< [m], [s] per simulated second
};

/// Runs one setting at one step and prints its row.
Point measure(const CenicScene& c, const std::string& name, const Method& method, double step, const Reference& reference, RunResult& out) {
  out = run(c, method, step, 0.1);
  Point point;
  if (out.status != "ok") {
    std::printf("peers %s %-24s step %.3g ms: %s, %s\n", c.scene.name.c_str(), name.c_str(), 1e3 * step, out.status.c_str(),
                out.reason.c_str());
    return point;
  }
  point.cpu = median(out.cpu_s) / c.scene.seconds;
  if (!reference.samples.empty()) point.error = distance(c, out.samples, reference.samples);
  std::printf("peers %s %-24s step %.3g ms: %.3g ms a second", c.scene.name.c_str(), name.c_str(), 1e3 * step, 1e3 * point.cpu);
  if (std::isfinite(point.error)) std::printf(", error %.3g m (reference moves by %.2g)", point.error, reference.moves);
  for (const auto& [measure, value] : out.measures) std::printf(", %s %.3g", measure.c_str(), value);
  if (!method.peer) std::printf(", ledger gains %.3g, unconverged %ld of %ld", out.energy_gain, out.unconverged, out.steps);
  std::printf("\n");
  return point;
}

void tellOurs(const std::string& prefix, const std::string& tail, const Point& point, const RunResult& result) {
  if (std::isfinite(point.error)) figure(prefix + "err" + tail, point.error, "m");
  figure(prefix + "ms_per_s" + tail, 1e3 * point.cpu, "ms");
  for (const auto& [measure, value] : result.measures) {
    const char* unit = measure == "overlap" ? "m" : measure == "energy_gain" ? "J" : measure == "jellett" ? "1" : "rad";
    figure(prefix + measure + tail, value, unit);
  }
  figure(prefix + "ledger_gain" + tail, result.energy_gain, "1");
  figure(prefix + "unconverged" + tail, static_cast<double>(result.unconverged), "1");
}

}  // namespace

void measureCenic() {
  for (const CenicScene& c : report::cenicScenes()) {
    const std::string prefix = "cenic." + c.scene.name.substr(c.scene.name.find('_') + 1) + ".";
    if (!c.scene.not_for_peers.empty()) std::printf("peers %s: ours alone, %s\n", c.scene.name.c_str(), c.scene.not_for_peers.c_str());
    std::vector<Point> peers;
    RunResult result;
    for (const Rival& rival : rivals()) {
      if (rival.ours() || rival.wasm() || !c.scene.not_for_peers.empty()) continue;
      const Reference reference = c.scene.chaotic ? Reference{} : referenceOf(c, rival.method);
      for (const double step : {4e-3, 1e-3, 2.5e-4}) {
        peers.push_back(measure(c, rival.name, rival.method, step, reference, result));
        if (result.status == "refused") break;
      }
    }
    for (const Rival& rival : rivals()) {
      // Soft surfaces and rigid ones are two scenes; elsewhere surfaces are as the scene says.
      if (!rival.ours() || (rival.method.choice.rigid && c.scene.name != "cenic_clutter_stiff")) continue;
      Method method = rival.method;
      method.choice.accuracy = 0.003;
      const Reference reference = c.scene.chaotic ? Reference{} : referenceOf(c, method);
      const std::string kind = rival.method.choice.rigid ? "_rigid" : "";
      if (!reference.samples.empty()) figure(prefix + "reference_moves" + kind, reference.moves, "m");
      for (const char* accuracy : {"0.1", "0.03", "0.01", "0.003"}) {
        method.choice.accuracy = std::stod(accuracy);
        const Point ours = measure(c, rival.name + " " + accuracy, method, kStep, reference, result);
        if (result.status != "ok") continue;
        const std::string tail = kind + "_a" + accuracy;
        tellOurs(prefix, tail, ours, result);
        double best = infinite();  // of the peers that take no more time, at any of their steps
        for (const Point& peer : peers) {
          if (peer.cpu <= ours.cpu) best = std::min(best, peer.error);
        }
        if (std::isfinite(best)) figure(prefix + "err_best_peer" + tail, best, "m");
      }
    }
  }
}

}  // namespace haptic::bench
