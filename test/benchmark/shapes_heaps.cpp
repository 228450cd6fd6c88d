// Heaps of cylinders, and of balls, capsules and cylinders, beside Bullet and ODE.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "heap_runs.h"
#include "shapes_figures.h"

namespace haptic::bench {
namespace {

using peers::Peer;
using scenes::RoundHeap;

constexpr double kSeconds = 2;
constexpr int kRuns = 5;  ///< the median of the largest step is over so many
constexpr std::pair<const char*, double> kStiffness[] = {{"k1e7", 1e7}, {"k1e8", 1e8}, {"k1e10", 1e10}};

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

/// Of one simulator over the runs.
struct Row {
  std::vector<double> mean, worst;  ///< [µs], by run
  double depth = 0, fastest = 0;    ///< at the end [m], [m/s]
  const Ours* ours = nullptr;       ///< of the last run; null: a peer
};

void measureHeap(RoundHeap kind, int count) {
  const std::string name = "heap" + std::to_string(count) + (kind == RoundHeap::kTubes ? ".tubes" : ".round");
  std::map<std::string, Row> rows;
  std::vector<std::unique_ptr<Runner>> runners;
  for (int run = 0; run < kRuns; ++run) {
    runners.clear();
    for (const auto& [label, k] : kStiffness) runners.push_back(std::make_unique<Ours>(scenes::roundHeap(kind, count, k), label));
    for (const auto& [peer, iterations] : {std::pair{Peer::kBullet, 50}, {Peer::kOdeQuick, 20}}) {
      peers::PeerSettings settings;
      settings.peer = peer;
      settings.iterations = iterations;
      runners.push_back(std::make_unique<Theirs>(scenes::roundHeap(kind, count, 1e8), settings));
    }
    takeTurns(runners, static_cast<int>(std::lround(kSeconds / 1e-3)));
    for (const auto& runner : runners) {
      Row& row = rows[runner->name];
      row.mean.push_back(runner->times.mean());
      row.worst.push_back(runner->times.worst());
      row.ours = dynamic_cast<const Ours*>(runner.get());
      row.fastest = runner->fastest();
      if (run == 0) row.depth = deepest(scenes::roundHeap(kind, count, 1e8), runner->poses());
    }
  }
  const Row& bullet = rows.at("bullet50");
  double mean = 0, worst = 0;
  for (const auto& [label, row] : rows) {
    const std::string prefix = name + "." + label;
    figure(prefix + ".mean_us", median(row.mean), "us");
    figure(prefix + ".worst_us", median(row.worst), "us");
    figure(prefix + ".depth_at_end_um", 1e6 * row.depth, "um");
    figure(prefix + ".v_at_end", row.fastest, "m/s");
    if (!row.ours) continue;
    const Tally& t = row.ours->tally;
    const double of_mean = median(row.mean) / median(bullet.mean), of_worst = median(row.worst) / median(bullet.worst);
    figure(prefix + ".mean_vs_bullet50", of_mean, "");
    figure(prefix + ".worst_vs_bullet50_worst", of_worst, "");
    figure(prefix + ".unconverged_share", static_cast<double>(t.unconverged) / std::max(1, t.touching), "");
    figure(prefix + ".energy_gain_rel", t.gain / t.exchanged, "");
    mean = std::max(mean, of_mean), worst = std::max(worst, of_worst);
  }
  figure(name + ".mean_vs_bullet50", mean, "");
  figure(name + ".worst_vs_bullet50_worst", worst, "");
}

}  // namespace

void measureHeaps() {
  for (const RoundHeap kind : {RoundHeap::kTubes, RoundHeap::kRound}) {
    for (const int count : {10, 100}) measureHeap(kind, count);
  }
}

}  // namespace haptic::bench
