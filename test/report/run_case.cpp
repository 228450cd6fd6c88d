#include "run_case.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "haptic_core/base/cpu_time.h"
#include "../benchmark/allocation_count.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"
#include "scene/stiffness_choice.h"

namespace haptic::report {
namespace {

/// Factor on the friction of a scene: its change is measured once.
class Friction {
 public:
  explicit Friction(const Scene& scene) : scene_(scene) {}
  double at(double time, const Simulator& simulator) {
    if (!scene_.friction) return 1;
    if (time < scene_.friction->time * (1 - 1e-9)) return scene_.friction->before;
    if (std::isnan(after_)) after_ = scene_.friction->after([&simulator](int link) { return simulator.body(link); });
    return after_;
  }

 private:
  const Scene& scene_;
  double after_ = std::numeric_limits<double>::quiet_NaN();
};

class OurSimulator : public Simulator {
 public:
  OurSimulator(const Scene& scene, const WorldDef& def) : scene_(scene), friction_(scene), world_(def) {}
  void step() override {
    const double t = world_.time() + world_.settings().step;
    const double factor = friction_.at(world_.time(), *this);
    if (factor != world_.tuning().friction_scale) {
      WorldTuning tuning = world_.tuning();
      tuning.friction_scale = factor;
      world_.tune(tuning);
    }
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
  Friction friction_;
  World world_;
};

class PeerSimulator : public Simulator {
 public:
  PeerSimulator(const Scene& scene, const WorldDef& def, peers::PeerSettings settings)
      : scene_(scene), friction_(scene), step_(settings.step), peer_(peers::makePeer(def, settings)) {}
  void step() override {
    const double factor = friction_.at(time_, *this);
    if (scene_.friction) peer_->scaleFriction(factor);
    for (const HandSpring& hand : scene_.hands) pull(hand);
    pulls_.clear();
    for (const HandSpring& hand : scene_.peer_hands) pulls_.push_back(pull(hand));
    peer_->step();
    time_ = step_ * static_cast<double>(++steps_);
  }
  BodyState body(int link) const override { return {peer_->linkPose(link), peer_->linkTwist(link)}; }
  Wrench onHand(int i) const override {
    return static_cast<std::size_t>(i) < pulls_.size() ? -pulls_[static_cast<std::size_t>(i)] : Wrench{};
  }

 private:
  /// The spring's wrench on its link, about the link's origin, in the next step. A torque comes as a couple of forces.
  Wrench pull(const HandSpring& hand) {
    const BodyState target = hand.path(time_), now = body(hand.link);
    const Vector3 turn = vectorFromRotation(Quaternion(Matrix3(target.X_WL.R * now.X_WL.R.transpose())));
    const Wrench F{hand.rotational_stiffness * turn + hand.rotational_damping * (target.V_WL.angular - now.V_WL.angular),
                   hand.stiffness * (target.X_WL.p - now.X_WL.p) + hand.damping * (target.V_WL.linear - now.V_WL.linear)};
    peer_->applyForce(hand.link, F.force, now.X_WL.p);
    if (!(F.torque.norm() > 0)) return F;
    const Vector3 arm = 0.01 * F.torque.unitOrthogonal(), push = F.torque.cross(arm) / (2 * arm.squaredNorm());
    peer_->applyForce(hand.link, push, now.X_WL.p + arm);
    peer_->applyForce(hand.link, -push, now.X_WL.p - arm);
    return F;
  }

  const Scene& scene_;
  Friction friction_;
  double step_, time_ = 0;
  long steps_ = 0;
  std::unique_ptr<peers::PeerWorld> peer_;
  std::vector<Wrench> pulls_;  ///< of `peer_hands` in the last step
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

}  // namespace

/// The largest k of any pair of a rigid scene [N/m³].
static double largestRigid(const WorldDef& def) {
  const Model model(def);
  double most = 0;
  const int count = static_cast<int>(model.shapes.size());
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      if (model.mayCollide(a, b)) most = std::fmax(most, model.law(a, b, false, false).material.stiffness);
    }
  }
  return most;
}

/// Ours keeps its energy ledger, as it does by default; no peer has one.
std::unique_ptr<Simulator> makeSimulator(const Scene& scene, const Method& method, double h, WorldDef& def) {
  Choice choice = method.choice;
  choice.step = h;
  if (method.peer) {
    if (!scene.not_for_peers.empty()) throw SetupError(peers::name(*method.peer), scene.not_for_peers, "none");
    // Peers have their own contact parameters and start touching, so k is as good as rigid for them: feet of 0.03 m and 35 N start 6e-12 m
    // deep. With 1e13 that was 6 µm, which no step takes from their errors.
    if (scene.stiffer_is_truer) choice.stiffness = 1e25;
    def = scene.make(choice);
    def.pointers.clear();  // their hand is a force from outside
    peers::PeerSettings settings = *method.peer;
    settings.step = h;
    settings.restitution = scene.restitution;
    settings.shapes = scene.peer_shapes;
    return std::make_unique<PeerSimulator>(scene, def, settings);
  }
  def = scene.make(choice);
  if (choice.rigid) {
    // Scenes start at the depth that carries the bodies: made again for the k that the rigid ones have.
    makeRigid(def);
    choice.stiffness = largestRigid(def);
    def = scene.make(choice);
    makeRigid(def);
  }
  return std::make_unique<OurSimulator>(scene, def);
}

namespace {

bool isLost(const BodyState& b) {
  constexpr double kFar = 1e3;  // [m, m/s]: no scene here is that large or fast
  return !(b.X_WL.p.norm() < kFar && b.V_WL.linear.norm() < kFar && b.V_WL.angular.allFinite());
}

/// Share of a scene's size and of the energy of motion at the start: lifting the bodies by the one and speeding them up by the other is
/// the least energy that a gain is compared with.
constexpr double kLeastShare = 1e-6;

/// What the ledger gained without a source. `least_lift`: what counts as exchanged at least, beside a share of the energy of motion, for
/// at rest and in flight nothing is but rounding.
struct LedgerWatch {
  explicit LedgerWatch(double least_lift) : exchanged(least_lift) {}
  EnergyLedger first;
  double gained = 0, exchanged = 0;
  bool begun = false;
  void see(const World& world) {
    const EnergyLedger& e = world.report().energy;
    if (!begun) first = e, exchanged += kLeastShare * e.kinetic, begun = true;
    const double lost = e.damping + e.friction - first.damping - first.friction, work = e.external - first.external;
    gained = std::max(gained, e.total() - first.total() - work + lost);
    exchanged = std::max({exchanged, std::abs(e.kinetic - first.kinetic), std::abs(e.potential - first.potential),
                          std::abs(e.elastic - first.elastic), std::abs(e.tangential - first.tangential), std::abs(work),
                          std::abs(lost)});
  }
  double relative() const { return exchanged > 0 ? gained / exchanged : std::nan(""); }
};

double quantile(const std::vector<double>& sorted, double q) {
  return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return quantile(values, 0.5);
}

/// What reading the clock adds to a step [s]: a call to the system, as long as a step of one cube.
double clockCost() {
  std::vector<double> costs(101);
  for (double& cost : costs) {
    const double before = cpuSeconds();
    cost = cpuSeconds() - before;
  }
  return median(std::move(costs));
}

/// Times of the steps of one repetition.
struct StepTimes {
  double sum = 0, p50 = 0, p99 = 0, p999 = 0, most = 0;  ///< [s]
  double touching_p50 = 0;                               ///< of the steps that computed a contact [s]
  StepTimes(std::vector<double> times, const std::vector<bool>& touching) {
    for (const double t : times) sum += t;
    std::vector<double> busy;
    for (std::size_t i = 1; i < times.size(); ++i) {
      if (touching[i]) busy.push_back(times[i]);
    }
    if (!busy.empty()) touching_p50 = median(std::move(busy));
    if (times.size() > 1) times.erase(times.begin());  // the first fills caches
    std::sort(times.begin(), times.end());
    p50 = quantile(times, 0.5);
    p99 = quantile(times, 0.99);
    p999 = quantile(times, 0.999);
    most = times.back();
  }
};

class Runner {
 public:
  Runner(const Scene& scene, const Method& method, double limit_s) : scene_(scene), method_(method), limit_(limit_s) {
    per_sample_ = std::max(1L, std::lround(scene.seconds / scene.samples / method.choice.step));
    h_ = scene.seconds / scene.samples / static_cast<double>(per_sample_);
  }

  /// Once, with states, allocations and counts.
  StepTimes sampleAll(RunResult& out) {
    const double start = cpuSeconds();
    WorldDef def;
    const auto simulator = makeSimulator(scene_, method_, h_, def);
    const auto inertia = inertias(scene_, def);
    out.setup_s = cpuSeconds() - start;
    const Sample first = sampleOf(*simulator, 0, inertia, def.settings.gravity);
    double weight = 0;
    for (const LinkInertia& body : inertia) weight += body.mass * def.settings.gravity.norm();
    LedgerWatch ledger(kLeastShare * weight * scene_.size);
    const double clock = clockCost();
    std::vector<double> times;
    times.reserve(static_cast<std::size_t>(per_sample_) * scene_.samples);
    for (int s = 1; s <= scene_.samples && out.status == "ok"; ++s) {
      for (long i = 0; i < per_sample_; ++i) {
        const long allocated = bench::allocationCount();
        const double before = cpuSeconds();
        simulator->step();
        times.push_back(std::max(0.0, cpuSeconds() - before - clock));
        out.allocations += bench::allocationCount() - allocated;
        const World* world = simulator->world();
        if (world) look(*world, ledger, out);
        touching_.push_back(world && computedContact(*world));
        ++out.steps;
      }
      take(*simulator, s, inertia, def.settings.gravity, out);
      stopHopeless(cpuSeconds() - start, static_cast<double>(s) / scene_.samples, out);
    }
    if (simulator->world()) out.energy_gain = ledger.relative();
    if (out.status == "ok") measure(first, out);
    return StepTimes(std::move(times), touching_);
  }

  /// The same run again without anything else, the time of each step read.
  StepTimes timeSteps() {
    WorldDef def;
    const auto simulator = makeSimulator(scene_, method_, h_, def);
    std::vector<double> times(static_cast<std::size_t>(per_sample_ * scene_.samples));
    const double clock = clockCost();
    for (double& time : times) {
      const double before = cpuSeconds();
      simulator->step();
      time = std::max(0.0, cpuSeconds() - before - clock);
    }
    return StepTimes(std::move(times), touching_);
  }

  /// The same run again, read once: CPU time of all steps [s].
  double timeAll() {
    WorldDef def;
    const auto simulator = makeSimulator(scene_, method_, h_, def);
    const long steps = per_sample_ * scene_.samples;
    const double start = cpuSeconds();
    for (long i = 0; i < steps; ++i) simulator->step();
    return cpuSeconds() - start;
  }

 private:
  /// Implicit islands that stand report their contacts without a look at them.
  static bool computedContact(const World& world) {
    const StepReport& r = world.report();
    return r.contacts > 0 && (r.evaluations > 0 || r.implicit_islands == 0);
  }
  static void look(const World& world, LedgerWatch& ledger, RunResult& out) {
    const StepReport& r = world.report();
    ledger.see(world);
    out.iterations += r.iterations;
    out.iterations_worst = std::max(out.iterations_worst, r.iterations);
    out.evaluations_worst = std::max(out.evaluations_worst, r.evaluations);
    out.unconverged += (r.flags & (kNotConverged | kJointsNotConverged)) != 0;
  }

  /// A failed run counts for no side, so that a run which is sure to fail need not be waited for.
  void stopHopeless(double used, double done, RunResult& out) const {
    if (out.status != "ok" || !(limit_ > 0) || used < 0.1 * limit_ || used < 2 * limit_ * done) return;
    char reason[96];
    std::snprintf(reason, sizeof reason, "would take %.0f s of CPU time, more than %g s", used / done, limit_);
    out.status = "failed";
    out.reason = reason;
  }

  void measure(const Sample& first, RunResult& out) {
    std::vector<Sample> samples = out.samples;
    samples.insert(samples.begin(), first);
    for (const Measure& measure : scene_.measures) out.measures.emplace_back(measure.name, measure.of(samples));
  }

  Sample sampleOf(const Simulator& simulator, double time, const std::vector<LinkInertia>& inertia, const Vector3& gravity) {
    Sample sample;
    sample.time = time;
    for (const int link : scene_.bodies) sample.bodies.push_back(simulator.body(link));
    addUp(sample, inertia, gravity);
    return sample;
  }

  void take(const Simulator& simulator, int s, const std::vector<LinkInertia>& inertia, const Vector3& gravity,
            RunResult& out) {
    Sample sample = sampleOf(simulator, scene_.seconds * s / scene_.samples, inertia, gravity);
    out.time_reached = sample.time;
    if (!simulator.finite() || std::any_of(sample.bodies.begin(), sample.bodies.end(), isLost)) {
      out.status = "diverged";
      out.reason = simulator.finite() ? "a body left the scene" : "the state is not finite, or the world stopped";
      return;
    }
    if (scene_.escaped) out.reason = scene_.escaped(sample);
    if (!out.reason.empty()) {
      out.status = "diverged";
      return;
    }
    for (const HandSpring& hand : scene_.hands) {
      sample.hands.push_back(springOnHand(hand, sample.time, simulator.body(hand.link)));
    }
    const World* world = simulator.world();
    const int hands = world ? world->pointerCount() : static_cast<int>(scene_.peer_hands.size());
    for (int i = 0; scene_.hands.empty() && i < hands; ++i) sample.hands.push_back(simulator.onHand(i));
    out.samples.push_back(std::move(sample));
  }

  const Scene& scene_;
  const Method& method_;
  double limit_;  ///< [s] of CPU time
  long per_sample_;
  double h_;
  std::vector<bool> touching_;  ///< by step
};

/// Repeats the run: five times while that takes less than `kPatience`, then until the budget, each as a whole; three times
/// for the times of its steps. A run that is longer counts as it was sampled.
void timeRun(Runner& runner, const StepTimes& first, double budget_s, RunResult& out) {
  constexpr std::size_t kMost = 9, kLeast = 5, kStepRuns = 3;
  constexpr double kPatience = 2;  // [s] of CPU time
  const double patience = std::min(kPatience, 20 * budget_s);
  std::vector<StepTimes> steps = {first};
  double used = first.sum;
  while (out.cpu_s.size() < kMost && used + first.sum < (out.cpu_s.size() < kLeast ? patience : budget_s)) {
    out.cpu_s.push_back(runner.timeAll());
    used += out.cpu_s.back();
    if (steps.size() < kStepRuns) steps.push_back(runner.timeSteps());
  }
  if (out.cpu_s.empty()) out.cpu_s.push_back(first.sum);
  const auto middle = [&steps](double StepTimes::*member) {
    std::vector<double> values;
    for (const StepTimes& t : steps) values.push_back(t.*member);
    return median(std::move(values));
  };
  out.step_p50 = middle(&StepTimes::p50);
  out.step_p99 = middle(&StepTimes::p99);
  out.step_p999 = middle(&StepTimes::p999);
  out.step_max = middle(&StepTimes::most);
  out.step_touching_p50 = middle(&StepTimes::touching_p50);
}

}  // namespace

RunResult runCase(const Scene& scene, const Method& method, double budget_s, double limit_s) {
  RunResult out;
  try {
    Runner runner(scene, method, limit_s);
    const StepTimes first = runner.sampleAll(out);
    if (out.status == "ok") {
      timeRun(runner, first, budget_s, out);
    } else {
      out.cpu_s.push_back(first.sum);
    }
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
