// Heaps of all kinds, beside Bullet and ODE.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "heap_kinds.h"
#include "heap_runs.h"

namespace haptic::bench {
namespace {

using peers::Peer;
using scenes::HeapKind;

constexpr double kSeconds = 2;
constexpr int kRuns = 5;  ///< the median of the largest step is over so many
/// The last one shows only what does not converge.
constexpr std::pair<const char*, double> kStiffness[] = {{"k1e7", 1e7}, {"k1e8", 1e8}, {"k1e10", 1e10}, {"k1e12", 1e12}};
constexpr int kTimed = 3;  ///< of them compared with peers, in all runs

/// The largest depth of any two bodies at these poses [m], of the true shapes, by the table of pairs: one measure for all simulators.
double deepest(const WorldDef& def, const std::vector<Pose>& poses) {
  const auto shapeOf = [&](std::size_t i) -> const ConvexShape& { return *def.articulations[i].links[0].collisions[0].shape; };
  ContactWorkspace workspace;
  double most = 0;
  for (std::size_t j = scenes::kFirstOfHeap; j < poses.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const ConvexShape &A = shapeOf(i), &B = shapeOf(j);
      if ((poses[i].p - poses[j].p).norm() > A.boundingRadius() + B.boundingRadius()) continue;
      workspace.reserve(A, B);
      PairCache cache;
      ContactVolume out;
      contactVolume(A, B, relativePose(poses[i], poses[j]), cache, workspace, out);
      if (out.status == ContactVolume::Status::kOverlap) most = std::max(most, out.depth);
    }
  }
  return most;
}

/// Of all that moves [kg].
double massOf(const WorldDef& def) {
  double mass = 0;
  for (std::size_t i = scenes::kFirstOfHeap; i < def.articulations.size(); ++i) mass += def.articulations[i].links[0].inertia.mass;
  return mass;
}

/// Of one simulator over the runs.
struct Row {
  std::vector<double> mean, worst;  ///< [µs], by run
  double depth = 0, fastest = 0;    ///< at the end [m], [m/s]
  std::optional<Tally> tally;       ///< of the first run; none: a peer
};

const char* nameOf(HeapKind kind) {
  static const char* const names[] = {"cubes", "hulls", "rods", "plates", "mixed", "ratio", "round", "tubes"};
  return names[static_cast<int>(kind)];
}

}  // namespace

void KindFigures::add(const KindFigures& other) {
  mean = std::max(mean, other.mean);
  worst = std::max(worst, other.worst);
  unconverged_share = std::max(unconverged_share, other.unconverged_share);
  wrench_share = std::max(wrench_share, other.wrench_share);
  budget_used = std::max(budget_used, other.budget_used);
}

KindFigures measureHeapOf(HeapKind kind, int count) {
  const std::string name = "heap" + std::to_string(count) + "." + nameOf(kind);
  std::map<std::string, Row> rows;
  std::vector<std::unique_ptr<Runner>> runners;
  for (int run = 0; run < kRuns; ++run) {
    runners.clear();
    for (int i = 0; i < (run == 0 ? static_cast<int>(std::size(kStiffness)) : kTimed); ++i) {
      runners.push_back(std::make_unique<Ours>(scenes::heapOf(kind, count, kStiffness[i].second), kStiffness[i].first));
    }
    for (const auto& [peer, iterations] : {std::pair{Peer::kBullet, 50}, {Peer::kOdeQuick, 20}}) {
      peers::PeerSettings settings;
      settings.peer = peer;
      settings.iterations = iterations;
      runners.push_back(std::make_unique<Theirs>(scenes::heapOf(kind, count, 1e8), settings));
    }
    takeTurns(runners, static_cast<int>(std::lround(kSeconds / 1e-3)));
    for (const auto& runner : runners) {
      Row& row = rows[runner->name];
      row.mean.push_back(runner->times.mean());
      row.worst.push_back(runner->times.worst());
      if (run > 0) continue;
      row.fastest = runner->fastest();
      row.depth = deepest(scenes::heapOf(kind, count, 1e8), runner->poses());
      if (const Ours* ours = dynamic_cast<const Ours*>(runner.get())) row.tally = ours->tally;
    }
  }
  const Row& bullet = rows.at("bullet50");
  const double weight = scenes::kGravity * massOf(scenes::heapOf(kind, count, 1e8));
  KindFigures all;
  for (const auto& [label, row] : rows) {
    const std::string prefix = name + "." + label;
    figure(prefix + ".mean_us", median(row.mean), "us");
    figure(prefix + ".worst_us", median(row.worst), "us");
    figure(prefix + ".depth_at_end_um", 1e6 * row.depth, "um");
    figure(prefix + ".v_at_end", row.fastest, "m/s");
    if (!row.tally) continue;
    const Tally& t = *row.tally;
    KindFigures one;
    one.unconverged_share = static_cast<double>(t.unconverged) / std::max(1, t.touching);
    one.wrench_share = t.wrench_error / weight;
    one.budget_used = t.budget_used;
    const bool timed = static_cast<int>(row.mean.size()) == kRuns;
    one.mean = timed ? median(row.mean) / median(bullet.mean) : 0;
    one.worst = timed ? median(row.worst) / median(bullet.worst) : 0;
    if (timed) {
      figure(prefix + ".mean_vs_bullet50", one.mean, "1");
      figure(prefix + ".worst_vs_bullet50_worst", one.worst, "1");
      all.mean_us[label] = median(row.mean);
    }
    figure(prefix + ".evaluations_mean", t.evaluations / t.steps, "1");
    figure(prefix + ".factorisations_mean", t.factorisations / t.steps, "1");
    figure(prefix + ".unconverged_share", one.unconverged_share, "1");
    figure(prefix + ".wrench_error_over_weight", one.wrench_share, "1");
    figure(prefix + ".budget_used_max", one.budget_used, "1");
    figure(prefix + ".energy_gain_rel", t.gain / t.exchanged, "1");
    all.add(one);
  }
  figure(name + ".mean_vs_bullet50", all.mean, "1");
  figure(name + ".worst_vs_bullet50_worst", all.worst, "1");
  return all;
}

}  // namespace haptic::bench
