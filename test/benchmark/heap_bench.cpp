/// `./run bench heap`: cubes that fall into a bin (test/scenes/heap.h), the implicit step in motion and peers, interleaved.
///
/// CPU time of the stepping thread, every step timed, the first left out; the ledger is on. Peers have plain boxes with
/// margins of 1 mm, and the same step. An argument runs only the groups whose name contains it: heap1, heap10, heap100,
/// heap300, heap_ratio, heap_4ms; kinds (or kinds10, kinds100, kinds300) are heaps of every kind of body by the default method.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../scenes/heap.h"
#include "figure.h"
#include "heap_kinds.h"
#include "heap_runs.h"

namespace haptic::bench {
namespace {

using scenes::HeapParameters;
using peers::Peer;

constexpr double kRestTime = 4;     ///< after which a heap lies [s]

struct Method {
  const char* name;
  Attempts attempts;
};
constexpr Method kMethods[] = {
    {"euler", Attempts::kImplicitEuler}, {"sdirk2", Attempts::kSdirk2}, {"automatic", Attempts::kAll}};
constexpr std::pair<const char*, double> kStiffness[] = {{"k1e7", 1e7}, {"k1e8", 1e8}, {"k1e10", 1e10}, {"k1e12", 1e12}};

/// What must hold over all cells, worst of each.
struct Overall {
  double unconverged = 0, evaluations = 0, factorisations = 0, gain_rel = 0, rest_v = 0;
};

void printTimes(const std::string& name, const Times& t) {
  figure(name + ".mean_us", t.mean(), "us");
  figure(name + ".p999_us", t.quantile(0.999), "us");
  figure(name + ".worst_us", t.worst(), "us");
  if (!t.active.empty()) figure(name + ".active_median_us", median(t.active), "us");
  std::vector<double> last(t.all.end() - static_cast<std::ptrdiff_t>(t.all.size() / 4), t.all.end());
  figure(name + ".median_us", median(last), "us");
}

struct Group {
  std::string name;
  HeapParameters heap;
  double step = 1e-3, seconds = 2;
  bool mujoco = true, rests = true;
};

/// One heap: all stiffnesses and methods and the peers take turns. Returns the mean by cell, for the exponent.
std::map<std::string, double> measure(const Group& g, Overall& overall) {
  std::vector<std::unique_ptr<Runner>> runners;
  std::vector<Ours*> ours;
  for (const auto& [label, k] : kStiffness) {
    for (const Method& m : kMethods) {
      HeapParameters heap = g.heap;
      heap.stiffness = k;
      WorldSettings of_method;
      of_method.attempts = m.attempts;
      of_method.step = g.step;
      auto one = std::make_unique<Ours>(scenes::heap(heap, of_method), g.name + "." + label + "." + m.name);
      ours.push_back(one.get());
      runners.push_back(std::move(one));
    }
  }
  peers::PeerSettings settings;
  settings.step = g.step;
  std::map<std::string, Runner*> peer;
  for (const auto& [kind, iterations] : {std::pair{Peer::kBullet, 10}, {Peer::kBullet, 50}, {Peer::kOdeQuick, 20},
                                         {Peer::kMujocoEuler, 20}}) {
    if (kind == Peer::kMujocoEuler && !g.mujoco) continue;
    settings.peer = kind;
    settings.iterations = iterations;
    runners.push_back(std::make_unique<Theirs>(scenes::heap(g.heap, {}), settings));
    peer[runners.back()->name] = runners.back().get();
  }
  const int steps = static_cast<int>(std::lround(g.seconds / g.step));
  takeTurns(runners, steps);
  for (const auto& [name, r] : peer) printTimes(g.name + "." + name, r->times);
  const Times& bullet = peer.at("bullet50")->times;
  std::map<std::string, double> means;
  for (Ours* o : ours) {
    const Tally& t = o->tally;
    printTimes(o->name, o->times);
    figure(o->name + ".mean_vs_bullet50", o->times.mean() / bullet.mean(), "1");
    figure(o->name + ".worst_vs_bullet50_worst", o->times.worst() / bullet.worst(), "1");
    if (!o->times.active.empty()) {
      figure(o->name + ".worst_over_active_median", o->times.worst() / median(o->times.active), "1");
    }
    figure(o->name + ".newton_mean", t.iterations / t.steps, "1");
    figure(o->name + ".newton_worst", t.worst_iterations, "1");
    figure(o->name + ".evaluations_mean", t.evaluations / t.steps, "1");
    figure(o->name + ".evaluations_worst", t.worst_evaluations, "1");
    figure(o->name + ".factorisations_worst", t.worst_factorisations, "1");
    figure(o->name + ".unconverged", t.unconverged, "1");
    figure(o->name + ".unconverged_wrench", t.wrench_error, "N");
    figure(o->name + ".energy_gain_rel", t.gain / t.exchanged, "1");
    figure(o->name + ".depth_max", t.depth, "m");
    means[o->name.substr(g.name.size() + 1)] = o->times.mean();
    overall.unconverged += t.unconverged;
    overall.evaluations = std::max(overall.evaluations, t.worst_evaluations);
    overall.factorisations = std::max(overall.factorisations, t.worst_factorisations);
    overall.gain_rel = std::max(overall.gain_rel, t.gain / t.exchanged);
  }
  // The headline: over the stiffnesses of each class, by method; Euler's without a suffix.
  for (std::size_t m = 0; m < std::size(kMethods); ++m) {
    const std::string tail = m == 0 ? "" : std::string("_") + kMethods[m].name;
    double mean[3] = {0, 0, 0}, worst[3] = {0, 0, 0}, over = 0;
    for (std::size_t k = 0; k < std::size(kStiffness); ++k) {
      const Times& t = ours[k * std::size(kMethods) + m]->times;
      const std::size_t group = k <= 1 ? 0 : k - 1;
      mean[group] = std::max(mean[group], t.mean() / bullet.mean());
      worst[group] = std::max(worst[group], t.worst() / bullet.worst());
      if (!t.active.empty()) over = std::max(over, t.worst() / median(t.active));
    }
    const char* groups[3] = {"", "_k1e10", "_k1e12"};
    for (int i = 0; i < 3; ++i) {
      figure(g.name + ".mean_vs_bullet50" + groups[i] + tail, mean[i], "1");
      figure(g.name + ".worst_vs_bullet50_worst" + groups[i] + tail, worst[i], "1");
    }
    figure(g.name + ".worst_over_active_median" + tail, over, "1");
  }
  if (!g.rests) return means;
  const int rest = static_cast<int>(std::lround(kRestTime / g.step)) - steps;
  for (Ours* o : ours) {
    o->run(rest);
    figure(o->name + ".rest_v", o->fastest(), "m/s");
    overall.rest_v = std::max(overall.rest_v, o->fastest());
  }
  const double theirs[] = {peer.at("bullet50")->fastest(), peer.at("ode_quick20")->fastest()};
  figure(g.name + ".bullet50.v_at_end", theirs[0], "m/s");
  figure(g.name + ".ode_quick20.v_at_end", theirs[1], "m/s");
  return means;
}

/// Slope of log mean over log N, the least squares of all N; of one stiffness.
double timeExponent(const std::map<int, double>& mean_us) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const double n = static_cast<double>(mean_us.size());
  for (const auto& [count, us] : mean_us) {
    const double lx = std::log(count), ly = std::log(us);
    x += lx / n, y += ly / n, xx += lx * lx / n, xy += lx * ly / n;
  }
  return (xy - x * y) / (xx - x * x);
}

/// Every kind with 10 and 100 bodies, cubes also with 300.
void measureKinds(const char* filter) {
  using scenes::HeapKind;
  KindFigures others, all;
  std::map<std::string, std::map<int, double>> cubes_us;  // by stiffness, by count
  for (const int count : {10, 100, 300}) {
    if (filter && filter != "kinds" + std::to_string(count) && std::strcmp(filter, "kinds") != 0) continue;
    for (const HeapKind kind : {HeapKind::kCubes, HeapKind::kHulls, HeapKind::kRods, HeapKind::kPlates, HeapKind::kMixed,
                                HeapKind::kRatio, HeapKind::kRound, HeapKind::kTubes}) {
      if (count == 300 && kind != HeapKind::kCubes) continue;
      const KindFigures one = measureHeapOf(kind, count);
      all.add(one);
      if (kind == HeapKind::kCubes) {
        for (const auto& [label, us] : one.mean_us) cubes_us[label][count] = us;
      } else if (kind != HeapKind::kRound && kind != HeapKind::kTubes) {
        others.add(one);
      }
    }
  }
  if (all.mean == 0) return;
  figure("heap.kinds.mean_vs_bullet50", others.mean, "1");
  figure("heap.worst_vs_bullet50_worst", all.worst, "1");
  figure("heap.unconverged_share", all.unconverged_share, "1");
  figure("heap.unconverged_wrench_over_weight", all.wrench_share, "1");
  figure("heap.budget_used_max", all.budget_used, "1");
  double exponent = 0;
  for (const auto& [label, us] : cubes_us) {
    if (us.size() == 3) exponent = std::max(exponent, timeExponent(us));
  }
  if (exponent > 0) figure("heap.time_exponent", exponent, "1");
}

int run(const char* filter) {
  std::vector<Group> groups;
  for (int n : {1, 10, 100, 300}) {
    Group g;
    g.name = "heap" + std::to_string(n);
    g.heap.count = n;
    // 300: the cubes that fall last have landed after 0.6 s; MuJoCo would take minutes.
    if (n == 300) g.seconds = 1, g.mujoco = g.rests = false;
    groups.push_back(g);
  }
  Group ratio;
  ratio.name = "heap_ratio";  // ten cubes, every second one a thousand times as heavy
  ratio.heap.mass_ratio = 1000;
  groups.push_back(ratio);
  Group coarse;
  coarse.name = "heap_4ms";
  coarse.step = 4e-3;
  groups.push_back(coarse);
  measureKinds(filter);
  Overall overall;
  std::map<std::string, std::map<std::string, double>> means;
  for (const Group& g : groups) {
    if (filter && g.name.find(filter) == std::string::npos) continue;
    means[g.name] = measure(g, overall);
  }
  if (means.empty()) return 0;
  figure("heap.unconverged", overall.unconverged, "1");
  figure("heap.evaluations_worst", overall.evaluations, "1");
  figure("heap.factorisations_worst", overall.factorisations, "1");
  figure("heap.energy_gain_rel", overall.gain_rel, "1");
  figure("heap.rest_v", overall.rest_v, "m/s");
  if (means.count("heap10") && means.count("heap300")) {
    for (const auto& [cell, small] : means["heap10"]) {
      figure("heap." + cell + ".time_exponent", std::log(means["heap300"].at(cell) / small) / std::log(30.0), "1");
    }
  }
  return 0;
}

}  // namespace
}  // namespace haptic::bench

int main(int count, char** arguments) {
  return haptic::bench::run(count > 1 ? arguments[1] : nullptr);
}
