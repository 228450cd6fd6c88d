/// Heaps (test/scenes/heap.h) of ours and of peers that are stepped in turns, every step timed.
#pragma once
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "../peers/peer_world.h"
#include "../scenes/heap.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/world/world.h"

namespace haptic::bench {

constexpr double kActive = 1e-3;  ///< speed above which something moves [m/s]
constexpr int kChunk = 20;        ///< steps of one world before the next has its turn

struct Times {
  std::vector<double> all, active;  ///< [µs]
  double mean() const {
    double sum = 0;
    for (double t : all) sum += t;
    return sum / static_cast<double>(all.size());
  }
  double worst() const { return *std::max_element(all.begin(), all.end()); }
  double quantile(double share) const {
    std::vector<double> sorted = all;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  }
};

/// Sums and extremes over the steps of one of our worlds.
struct Tally {
  double iterations = 0, worst_iterations = 0, evaluations = 0, worst_evaluations = 0, factorisations = 0,
         worst_factorisations = 0, budget_used = 0;
  int steps = 0, touching = 0, unconverged = 0;  ///< steps: all, with contacts, and those that did not converge
  double wrench_error = 0;                       ///< [N]
  double gain = 0, exchanged = 0;                ///< [J]
  double depth = 0;                              ///< [m]
};

/// A heap in a simulator: its bodies are links scenes::kFirstOfHeap, …
class Runner {
 public:
  explicit Runner(const WorldDef& def) : links_(static_cast<int>(def.articulations.size())) {}
  virtual ~Runner() = default;
  Times times;
  std::string name;
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      const double start = cpuSeconds();
      step();
      const double us = 1e6 * (cpuSeconds() - start);
      if (done_++ == 0) continue;
      times.all.push_back(us);
      if (fastest() > kActive) times.active.push_back(us);
      look();
    }
  }
  /// Of all bodies [m/s].
  double fastest() const {
    double speed = 0;
    for (int i = scenes::kFirstOfHeap; i < links_; ++i) speed = std::max(speed, twist(i).linear.norm());
    return speed;
  }
  std::vector<Pose> poses() const {  ///< of all links
    std::vector<Pose> out;
    for (int i = 0; i < links_; ++i) out.push_back(pose(i));
    return out;
  }

 protected:
  virtual void step() = 0;
  virtual Pose pose(int link) const = 0;
  virtual Twist twist(int link) const = 0;
  virtual void look() {}

 private:
  int links_, done_ = 0;
};

class Ours : public Runner {
 public:
  Ours(const WorldDef& def, const std::string& label) : Runner(def), world_(def) { name = label; }
  Tally tally;

 protected:
  void step() override { world_.step(); }
  Pose pose(int link) const override { return world_.linkPose(link); }
  Twist twist(int link) const override { return world_.linkTwist(link); }
  void look() override {
    const StepReport& r = world_.report();
    const EnergyLedger& e = r.energy;
    if (tally.steps++ == 0) first_ = e;
    tally.touching += world_.contactCount() > 0;
    tally.iterations += r.iterations;
    tally.worst_iterations = std::max<double>(tally.worst_iterations, r.iterations);
    tally.evaluations += r.evaluations;
    tally.worst_evaluations = std::max<double>(tally.worst_evaluations, r.evaluations);
    tally.factorisations += r.factorisations;
    tally.budget_used = std::max(tally.budget_used, r.budget_used);
    tally.worst_factorisations = std::max<double>(tally.worst_factorisations, r.factorisations);
    if (r.flags & kNotConverged) {
      ++tally.unconverged;
      tally.wrench_error = std::max(tally.wrench_error, r.wrench_error);
    }
    const double lost = e.damping + e.friction - first_.damping - first_.friction;
    tally.exchanged = std::max({tally.exchanged, std::abs(e.kinetic - first_.kinetic), std::abs(lost),
                                std::abs(e.potential - first_.potential), std::abs(e.elastic - first_.elastic),
                                std::abs(e.tangential - first_.tangential)});
    tally.gain = std::max(tally.gain, e.total() - first_.total() + lost);
    for (int i = 0; i < world_.contactCount(); ++i) tally.depth = std::max(tally.depth, world_.contact(i).depth);
  }

 private:
  World world_;
  EnergyLedger first_;
};

class Theirs : public Runner {
 public:
  Theirs(const WorldDef& def, const peers::PeerSettings& settings) : Runner(def), world_(peers::makePeer(def, settings)) {
    name = peers::name(settings);
  }

 protected:
  void step() override { world_->step(); }
  Pose pose(int link) const override { return world_->linkPose(link); }
  Twist twist(int link) const override { return world_->linkTwist(link); }

 private:
  std::unique_ptr<peers::PeerWorld> world_;
};

/// A busy machine disturbs all of them alike.
inline void takeTurns(const std::vector<std::unique_ptr<Runner>>& runners, int steps) {
  for (int done = 0; done < steps; done += kChunk) {
    for (auto& r : runners) r->run(std::min(kChunk, steps - done));
  }
}

}  // namespace haptic::bench
