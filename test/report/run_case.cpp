#include "run_case.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "../benchmark/allocation_count.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "haptic_core/world/world.h"

namespace haptic::report {
namespace {

double cpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What the report needs of a simulator: ours and the peers'.
class Simulator {
 public:
  virtual ~Simulator() = default;
  virtual void step() = 0;
  virtual BodyState body(int link) const = 0;
  virtual Wrench onHand(int i) const = 0;
  virtual bool finite() const { return true; }
  virtual const World* world() const { return nullptr; }
};

class OurSimulator : public Simulator {
 public:
  OurSimulator(const Scene& scene, const WorldDef& def) : scene_(scene), world_(def) {}
  void step() override {
    const double t = world_.time() + world_.settings().step;
    for (int i = 0; i < world_.pointerCount(); ++i) {
      if (i < static_cast<int>(scene_.hands.size())) {
        const BodyState s = scene_.hands[i].path(t);
        world_.setPointerTarget(i, s.X_WL, s.V_WL);
      } else if (scene_.held) {
        const BodyState s = scene_.held(i, t);
        world_.setPointerTarget(i, s.X_WL, s.V_WL);
      }
    }
    world_.step();
  }
  BodyState body(int link) const override { return {world_.linkPose(link), world_.linkTwist(link)}; }
  Wrench onHand(int i) const override { return world_.pointerWrench(i); }
  bool finite() const override { return world_.report().finite; }
  const World* world() const override { return &world_; }

 private:
  const Scene& scene_;
  World world_;
};

class PeerSimulator : public Simulator {
 public:
  PeerSimulator(const Scene& scene, const WorldDef& def, peers::PeerSettings settings)
      : scene_(scene), step_(settings.step), peer_(peers::makePeer(def, settings)) {}
  void step() override {
    for (const HandSpring& hand : scene_.hands) {
      const BodyState target = hand.path(time_), now = body(hand.link);
      peer_->applyForce(hand.link,
                        hand.stiffness * (target.X_WL.p - now.X_WL.p) +
                            hand.damping * (target.V_WL.linear - now.V_WL.linear),
                        now.X_WL.p);
    }
    peer_->step();
    time_ = step_ * static_cast<double>(++steps_);
  }
  BodyState body(int link) const override { return {peer_->linkPose(link), peer_->linkTwist(link)}; }
  Wrench onHand(int) const override { return {}; }

 private:
  const Scene& scene_;
  double step_, time_ = 0;
  long steps_ = 0;
  std::unique_ptr<peers::PeerWorld> peer_;
};

/// Mass properties of the compared bodies, in the order of `Scene::bodies`.
std::vector<LinkInertia> inertias(const Scene& scene, const WorldDef& def) {
  std::vector<LinkInertia> all, chosen;
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) all.push_back(link.inertia);
  }
  for (const int link : scene.bodies) chosen.push_back(all[link]);
  return chosen;
}

void addUp(Sample& sample, const std::vector<LinkInertia>& inertia, const Vector3& gravity) {
  for (std::size_t i = 0; i < inertia.size(); ++i) {
    const BodyState& b = sample.bodies[i];
    const LinkInertia& m = inertia[i];
    const Vector3 arm = b.X_WL.R * m.p_LC, p_WC = b.X_WL.p + arm;
    const Vector3 v_C = b.V_WL.linear + b.V_WL.angular.cross(arm);
    const Vector3 L_C = b.X_WL.R * (m.I_C * (b.X_WL.R.transpose() * b.V_WL.angular));
    sample.energy += 0.5 * m.mass * v_C.squaredNorm() + 0.5 * L_C.dot(b.V_WL.angular) - m.mass * gravity.dot(p_WC);
    sample.momentum += m.mass * v_C;
    sample.angular_momentum += L_C + m.mass * p_WC.cross(v_C);
  }
}

/// The coupling's wrench on the hand where the scene defines the spring: the same formula for every simulator.
Wrench springOnHand(const HandSpring& hand, double t, const BodyState& link) {
  const BodyState target = hand.path(t);
  Wrench F;
  F.force = -(hand.stiffness * (target.X_WL.p - link.X_WL.p) +
              hand.damping * (target.V_WL.linear - link.V_WL.linear));
  return F;
}

/// `ledger`: ours keeps its energy ledger. No peer has one, so runs that are timed do without.
std::unique_ptr<Simulator> make(const Scene& scene, const Method& method, double h, bool ledger, WorldDef& def) {
  Choice choice = method.choice;
  choice.step = h;
  if (method.peer) {
    if (!scene.not_for_peers.empty()) throw SetupError(peers::name(*method.peer), scene.not_for_peers, "none");
    // Peers have their own contact parameters and start touching, so k is as good as rigid for them.
    if (scene.stiffer_is_truer) choice.stiffness = 1e13;
    def = scene.make(choice);
    def.pointers.clear();  // their hand is a force from outside
    peers::PeerSettings settings = *method.peer;
    settings.step = h;
    settings.restitution = scene.restitution;
    return std::make_unique<PeerSimulator>(scene, def, settings);
  }
  def = scene.make(choice);
  def.settings.energy_ledger = ledger;
  return std::make_unique<OurSimulator>(scene, def);
}

bool isLost(const BodyState& b) {
  constexpr double kFar = 1e3;  // [m, m/s]: no scene here is that large or fast
  return !(b.X_WL.p.norm() < kFar && b.V_WL.linear.norm() < kFar && b.V_WL.angular.allFinite());
}

/// How far the ledger's balance strays.
struct BalanceWatch {
  double first = std::nan(""), away = 0, largest = 0;
  void see(const World& world) {
    const EnergyLedger& e = world.report().energy;
    if (std::isnan(first)) first = e.balance();
    away = std::max(away, std::abs(e.balance() - first));
    largest = std::max({largest, e.kinetic, e.elastic, std::abs(e.external), e.damping, e.friction});
  }
  double relative() const { return largest > 0 ? away / largest : std::nan(""); }
};

class Runner {
 public:
  Runner(const Scene& scene, const Method& method) : scene_(scene), method_(method) {
    per_sample_ = std::max(1L, std::lround(scene.seconds / scene.samples / method.choice.step));
    h_ = scene.seconds / scene.samples / static_cast<double>(per_sample_);
  }

  /// Once, with states, step times and allocations.
  void sampleAll(RunResult& out) {
    const double start = cpuSeconds();
    WorldDef def;
    const auto simulator = make(scene_, method_, h_, false, def);
    const auto inertia = inertias(scene_, def);
    out.setup_s = cpuSeconds() - start;
    std::vector<double> times;
    times.reserve(static_cast<std::size_t>(per_sample_) * scene_.samples);
    double cpu = 0;
    for (int s = 1; s <= scene_.samples && out.status == "ok"; ++s) {
      const double before = cpuSeconds();
      for (long i = 0; i < per_sample_; ++i) {
        const long allocated = bench::allocationCount();
        const auto begin = std::chrono::steady_clock::now();
        simulator->step();
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
        out.allocations += bench::allocationCount() - allocated;
        if (const World* world = simulator->world()) {
          out.iterations += world->report().iterations;
          out.unconverged += (world->report().flags & kNotConverged) != 0;
        }
        ++out.steps;
      }
      cpu += cpuSeconds() - before;
      take(*simulator, s, inertia, def.settings.gravity, out);
    }
    out.cpu_s.push_back(cpu);
    std::sort(times.begin(), times.end());
    const auto quantile = [&times](double q) { return times[static_cast<std::size_t>(q * (times.size() - 1))]; };
    out.step_p50 = quantile(0.5);
    out.step_p99 = quantile(0.99);
    out.step_max = times.back();
  }

  /// How far the ledger strays in the same run; NaN for peers.
  double balance() {
    WorldDef def;
    const auto simulator = make(scene_, method_, h_, true, def);
    BalanceWatch watch;
    for (long i = 0; i < per_sample_ * scene_.samples && simulator->world(); ++i) {
      simulator->step();
      watch.see(*simulator->world());
    }
    return watch.relative();
  }

  /// CPU time of the same run without anything else.
  double timeAll() {
    WorldDef def;
    const auto simulator = make(scene_, method_, h_, false, def);
    const long steps = per_sample_ * scene_.samples;
    const double start = cpuSeconds();
    for (long i = 0; i < steps; ++i) simulator->step();
    return cpuSeconds() - start;
  }

 private:
  void take(const Simulator& simulator, int s, const std::vector<LinkInertia>& inertia, const Vector3& gravity,
            RunResult& out) {
    Sample sample;
    sample.time = scene_.seconds * s / scene_.samples;
    out.time_reached = sample.time;
    for (const int link : scene_.bodies) sample.bodies.push_back(simulator.body(link));
    if (!simulator.finite() || std::any_of(sample.bodies.begin(), sample.bodies.end(), isLost)) {
      out.status = "diverged";
      out.reason = simulator.finite() ? "a body left the scene" : "the state is not finite";
      return;
    }
    addUp(sample, inertia, gravity);
    for (const HandSpring& hand : scene_.hands) {
      sample.hands.push_back(springOnHand(hand, sample.time, simulator.body(hand.link)));
    }
    const World* world = simulator.world();
    if (world && scene_.hands.empty()) {
      for (int i = 0; i < world->pointerCount(); ++i) sample.hands.push_back(simulator.onHand(i));
    }
    out.samples.push_back(std::move(sample));
  }

  const Scene& scene_;
  const Method& method_;
  long per_sample_;
  double h_;
};

}  // namespace

RunResult runCase(const Scene& scene, const Method& method, double budget_s) {
  RunResult out;
  try {
    Runner runner(scene, method);
    runner.sampleAll(out);
    constexpr std::size_t kMost = 9;
    double used = out.cpu_s[0];
    // The first repetition reads clocks at every step: it counts only when no other fits into the budget.
    std::vector<double> plain;
    while (out.status == "ok" && plain.size() < kMost && used + out.cpu_s[0] < budget_s) {
      plain.push_back(runner.timeAll());
      used += plain.back();
    }
    if (!plain.empty()) out.cpu_s = plain;
    if (out.status == "ok" && out.cpu_s[0] < budget_s) out.energy_balance = runner.balance();
  } catch (const std::exception& error) {
    out.status = "refused";
    out.reason = error.what();
  }
  return out;
}

std::vector<Sample> exactSamples(const Scene& scene) {
  std::vector<Sample> samples;
  const WorldDef def = scene.make(Choice{});
  const auto inertia = inertias(scene, def);
  for (int s = 1; s <= scene.samples; ++s) {
    Sample sample;
    sample.time = scene.seconds * s / scene.samples;
    sample.bodies = scene.exact(sample.time);
    addUp(sample, inertia, def.settings.gravity);
    for (const HandSpring& hand : scene.hands) {
      const auto held = std::find(scene.bodies.begin(), scene.bodies.end(), hand.link);
      sample.hands.push_back(springOnHand(hand, sample.time, sample.bodies[held - scene.bodies.begin()]));
    }
    samples.push_back(std::move(sample));
  }
  return samples;
}

}  // namespace haptic::report
