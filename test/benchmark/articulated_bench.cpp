/// Trees of bodies: speed of forward dynamics, drift of chains, joints and rings; KDL, MuJoCo and Bullet
/// beside.
#include <Eigen/Dense>
#include <cstdio>
#include <functional>
#include <limits>

#include "../core/dynamics/chain.h"
#include "../core/dynamics/four_bar.h"
#include "../core/dynamics/random_tree.h"
#include "allocation_count.h"
#include "articulated_peers.h"
#include "articulated_robots.h"
#include "dense_oracle.h"
#include "figure.h"
#include "haptic_core/dynamics/articulated_body.h"
#include "haptic_core/dynamics/runge_kutta.h"
#include "haptic_core/dynamics/tree_motion.h"

namespace haptic::bench {
namespace {

using test::chain;
const Vector3 kGravity(0, 0, -9.8);

/// Median of many short blocks [s].
double typical(const std::function<void()>& work, int calls) {
  constexpr int kBlocks = 60;
  return secondsPerCall([&](int) { work(); }, calls, kBlocks);
}

struct Chain {
  explicit Chain(const TreeDef& def)
      : tree(def),
        work(tree.linkCount()),
        q(tree.nq()),
        v(tree.nv()),
        v_dot(tree.nv()),
        scratch(rungeKuttaScratch(tree)) {
    tree.initialState(q.data(), v.data());
  }
  void bend() {
    for (int i = 0; i < tree.nv(); ++i) {
      q[i] = 0.3 * std::sin(1.7 * i);
      v[i] = std::cos(2.3 * i);
    }
  }
  void evaluate() {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    accelerations(tree, kGravity, nullptr, nullptr, work.data(), v_dot.data());
  }
  void step(double h, const Vector3& gravity = kGravity) {
    stepRungeKutta(tree, gravity, h, q.data(), v.data(), work.data(), scratch.data());
  }
  double energy() {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    return kineticEnergy(tree, work.data()) + potentialEnergy(tree, work.data(), kGravity);
  }
  Articulation tree;
  std::vector<LinkWork> work;
  std::vector<double> q, v, v_dot, scratch;
};

double energyScale(int n) {
  return test::kChainMass * 9.8 * test::kChainLength * n * n / 2;
}

/// Largest |E − E(0)| over `seconds` from the horizontal, of m g L n²/2; 1e9 when it leaves all bounds.
double drift(int n, double h, double seconds,
             const std::function<void(std::vector<double>&, std::vector<double>&)>& step) {
  Chain probe(chain(n));
  const double start = probe.energy();
  double worst = 0;
  for (int i = 0; i < std::lround(seconds / h); ++i) {
    step(probe.q, probe.v);
    const double error = std::abs(probe.energy() - start) / energyScale(n);
    if (!(error < 1e3)) return 1e9;
    worst = std::max(worst, error);
  }
  return worst;
}

double ownDrift(int n, double h) {
  Chain own(chain(n));
  return drift(n, h, 5, [&](std::vector<double>& q, std::vector<double>& v) {
    own.step(h);
    q = own.q;
    v = own.v;
  });
}

double peerDrift(PeerChain& peer, int n, double h) {
  const std::vector<double> zero(n, 0);
  peer.setState(zero.data(), zero.data());
  peer.setStep(h);
  return drift(n, h, 5, [&](std::vector<double>& q, std::vector<double>& v) {
    peer.step();
    peer.getState(q.data(), v.data());
  });
}

/// Time of one evaluation; checks that the peer computes what we do.
double peerEvaluation(const char* name, PeerChain& peer, int n) {
  Chain own(chain(n));
  own.bend();
  own.evaluate();
  peer.setState(own.q.data(), own.v.data());
  std::vector<double> v_dot(n);
  peer.evaluate(v_dot.data());
  double apart = 0, size = 0;
  for (int i = 0; i < n; ++i) {
    apart += std::pow(v_dot[i] - own.v_dot[i], 2);
    size += std::pow(own.v_dot[i], 2);
  }
  figure(std::string("aba.difference_to_") + name + "_n" + std::to_string(n), std::sqrt(apart / size), "1");
  return typical([&] { peer.evaluate(v_dot.data()); }, 500);
}

void evaluations() {
  for (int n : {10, 50}) {
    Chain own(chain(n));
    own.bend();
    const double seconds = typical([&] { own.evaluate(); }, 10000 / n);
    const std::string size = "_n" + std::to_string(n);
    figure("aba.ns_per_link" + size, seconds / n * 1e9, "ns");
    figure("aba.speedup_vs_kdl" + size, peerEvaluation("kdl", *kdlChain(chain(n)), n) / seconds, "1");
    figure("aba.speedup_vs_mujoco" + size,
           peerEvaluation("mujoco", *mujocoChain(chain(n), false), n) / seconds, "1");
    figure("aba.speedup_vs_bullet" + size, peerEvaluation("bullet", *bulletChain(chain(n)), n) / seconds,
           "1");
  }
}

void steps() {
  const double h = 1e-3;
  const auto own_step = [&](int n) {
    Chain own(chain(n));
    own.bend();
    const Chain start = own;
    return typical(
        [&] {
          own.q = start.q;  // the same state every time; chains of 50 would otherwise whip
          own.v = start.v;
          own.step(h);
        },
        2000 / n);
  };
  const auto peer_step = [&](PeerChain& peer, int n) {
    Chain own(chain(n));
    own.bend();
    peer.setStep(h);
    return typical(
        [&] {
          peer.setState(own.q.data(), own.v.data());
          peer.step();
        },
        2000 / n);
  };
  figure("chain10.energy_drift", ownDrift(10, h), "1");
  figure("chain10.energy_drift_mujoco_rk4", peerDrift(*mujocoChain(chain(10), true), 10, h), "1");
  figure("chain10.energy_drift_mujoco_euler", peerDrift(*mujocoChain(chain(10), false), 10, h), "1");
  figure("chain10.energy_drift_bullet", peerDrift(*bulletChain(chain(10)), 10, h), "1");
  const double drift3 = ownDrift(10, 1. / 300);
  figure("chain10.energy_drift_3ms", drift3, "1");
  figure("chain10.bounded_3ms", drift3 < 0.01, "1");
  const double own10 = own_step(10);
  figure("chain10.step_us", own10 * 1e6, "us");
  figure("chain10.step_speedup_vs_mujoco_rk4", peer_step(*mujocoChain(chain(10), true), 10) / own10, "1");
  figure("chain10.step_speedup_vs_mujoco_euler", peer_step(*mujocoChain(chain(10), false), 10) / own10, "1");
  figure("chain10.step_speedup_vs_bullet", peer_step(*bulletChain(chain(10)), 10) / own10, "1");
  figure("chain50.step_us", own_step(50) * 1e6, "us");

  // Slope of log time over log n by least squares.
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const std::vector<int> sizes = {10, 20, 50, 100, 200};
  for (int n : sizes) {
    const double x = std::log(n), y = std::log(own_step(n));
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  const double count = static_cast<double>(sizes.size());
  figure("chain.time_exponent", (count * sxy - sx * sy) / (count * sxx - sx * sx), "1");
}

void exactness() {
  // Any earlier link may be the parent; then trees as deep as they get (one of the last four), whose M has a
  // condition of up to 1e7: there the error is that times eps, whatever the algorithm.
  for (bool deep : {false, true}) {
    test::Random generator(100);
    AccelerationError worst;
    for (int trial = 0; trial < (deep ? 200 : 1000); ++trial) {
      Chain tree(test::randomTree(generator, 1 + trial % 60, trial % 2, deep ? 4 : 60));
      test::randomState(generator, tree.tree, tree.q, tree.v);
      tree.evaluate();
      const AccelerationError error =
          relativeError(tree.tree, tree.work.data(), kGravity, tree.v_dot.data(), tree.v.data());
      worst.plain = std::max(worst.plain, error.plain);
      worst.energy = std::max(worst.energy, error.energy);
    }
    figure(deep ? "aba.err_vs_crba_deep_trees" : "aba.err_vs_crba_max", worst.plain, "1");
    figure(deep ? "aba.err_vs_crba_deep_trees_energy_norm" : "aba.err_vs_crba_energy_norm", worst.energy, "1");
  }

  Chain base(chain(10, true));
  test::Random generator(101);
  for (double& v : base.v) v = test::uniform(generator, -1, 1);
  base.energy();
  const Wrench start = momentum(base.tree, base.work.data(), Vector3::Zero());
  for (int i = 0; i < 5000; ++i) base.step(1e-3, Vector3::Zero());
  base.energy();
  const Wrench end = momentum(base.tree, base.work.data(), Vector3::Zero());
  figure("freebase.momentum_drift",
         std::max((end.torque - start.torque).norm() / start.torque.norm(),
                  (end.force - start.force).norm() / start.force.norm()),
         "1");
}

struct Jointed {
  explicit Jointed(const TreeDef& def, std::vector<RingDef> rings = {})
      : body(def), motion(body.tree, std::move(rings)) {
    for (const BodyDef& link : def.links) commands.push_back(initialCommand(link.joint));
  }
  const JointReport& step(double h, const Vector3& gravity = kGravity) {
    forwardKinematics(body.tree, body.q.data(), body.v.data(), body.work.data());
    return motion.step(gravity, h, commands.data(), body.q.data(), body.v.data(), body.work.data());
  }
  Chain body;
  TreeMotion motion;
  std::vector<JointCommand> commands;
};

void joints() {
  // A pendulum thrown against its limits without gravity: what a step that a limit acts in adds to ½ I v².
  TreeDef limited = chain(1);
  limited.links[0].joint.lower = -0.4;
  limited.links[0].joint.upper = 0.3;
  double gain = -std::numeric_limits<double>::infinity();
  for (double speed : {1., 10., 100.}) {
    for (double h : {1e-4, 1e-3, 1e-2}) {
      Jointed s(limited);
      s.body.v[0] = speed;
      const double inertia = s.body.tree.link(0).I_O(1, 1);
      for (int i = 0; i < 5000; ++i) {
        const double before = 0.5 * inertia * s.body.v[0] * s.body.v[0];
        if (s.step(h, Vector3::Zero()).friction != 0)
          gain = std::max(gain, 0.5 * inertia * s.body.v[0] * s.body.v[0] - before);
      }
    }
  }
  figure("limit.energy_gain_j", gain, "J");

  TreeDef stuck = chain(1);
  stuck.links[0].joint.friction = 2 * test::kChainMass * 9.8 * test::kChainLength / 2;  // half the limit
  Jointed holding(stuck);
  for (int i = 0; i < 10000; ++i) holding.step(1e-3);
  figure("joint_friction.creep", std::abs(holding.body.q[0]), "rad");

  Jointed ring(test::fourBar(), test::fourBarRing());
  ring.body.q = {0.8, -0.8, 0.8};
  ring.motion.close(ring.body.q.data(), ring.body.v.data(), ring.body.work.data());
  double closure = 0;
  for (int i = 0; i < 5000; ++i) closure = std::max(closure, ring.step(1e-3).closure);
  figure("fourbar.closure_um", closure * 1e6, "um");
  figure("fourbar.step_us", typical([&] { ring.step(1e-3); }, 200) * 1e6, "us");
}

void allocations() {
  Chain own(chain(10));
  TreeDef robot = chain(10);
  for (BodyDef& body : robot.links) {
    body.joint.friction = 0.02;
    body.joint.damping = 0.01;
    body.joint.lower = -0.5;
    body.joint.upper = 0.5;
    body.joint.drive = JointDef::Drive::kPosition;
    body.joint.drive_stiffness = 10;
    body.joint.max_effort = 0.1;
  }
  Jointed jointed(robot), ring(test::fourBar(), test::fourBarRing());
  const long before = allocationCount();
  for (int i = 0; i < 1000; ++i) {
    own.step(1e-3);
    jointed.step(1e-3);
    ring.step(1e-3);
  }
  figure("allocations.articulated", static_cast<double>(allocationCount() - before), "1");
  figure("robot10.step_us", typical([&] { jointed.step(1e-3); }, 200) * 1e6, "us");
}

}  // namespace
}  // namespace haptic::bench

int main() {
  haptic::bench::evaluations();
  haptic::bench::steps();
  haptic::bench::exactness();
  haptic::bench::joints();
  haptic::bench::allocations();
  haptic::bench::measureRobots();
}
