// ContactBench's residuals of the rigid law beside errors against exact solutions: ours as the scenes say and rigid, and the peers.
#include <algorithm>
#include <cmath>
#include <map>

#include "contactbench_scenes.h"
#include "figure.h"
#include "haptic_core/base/error.h"
#include "peer_rivals.h"
#include "peers_figures.h"
#include "rigid_law.h"

namespace haptic::bench {
namespace {

using report::BodyState;
using report::RigidResiduals;
using report::RuledContact;
using report::RuledScene;

constexpr double kStep = 1e-3;  // [s]

/// Values of a column over a run.
struct Column {
  std::vector<double> values;
  void add(double x) { values.push_back(std::isfinite(x) ? std::abs(x) : infinite()); }
  double worst() const { return *std::max_element(values.begin(), values.end()); }
  double rms() const {
    double squares = 0;
    for (const double x : values) squares += x * x;
    return std::sqrt(squares / static_cast<double>(values.size()));
  }
};
using Row = std::map<std::string, Column>;

const std::map<std::string, const char*> kUnits = {{"signorini", "W"},   {"gap_work", "J"},  {"coulomb", "N"},      {"dissipation", "W"},
                                                   {"force_err", "1"},   {"depth", "m"},     {"position_err", "m"}, {"step", "us"}};

/// Of a time the median, of all else the root of the mean square.
double typical(const std::string& name, const Column& column) { return name == "step" ? median(column.values) : column.rms(); }

std::vector<LinkInertia> inertiasOf(const WorldDef& def) {
  std::vector<LinkInertia> all;
  for (const ArticulationDef& tree : def.articulations) {
    for (const LinkDef& link : tree.links) all.push_back(link.inertia);
  }
  return all;
}

/// Mean force of a hand in a step, at the link's origin. Peers are pushed by the force at the start of a step; our hands follow the body
/// within it: the mean of both ends.
Vector3 handForce(const report::HandSpring& hand, bool ours, double t, const BodyState& before, const BodyState& after) {
  const auto at = [&hand](double time, const BodyState& s) {
    const BodyState target = hand.path(time);
    return Vector3(hand.stiffness * (target.X_WL.p - s.X_WL.p) + hand.damping * (target.V_WL.linear - s.V_WL.linear));
  };
  return ours ? Vector3(0.5 * (at(t, before) + at(t + kStep, after))) : at(t, before);
}

/// The mean wrench of a step through a contact, on the bodies that it carries, about W's origin.
Wrench through(const RuledContact& contact, const RuledScene& ruled, const std::vector<LinkInertia>& inertia, bool ours, double t,
               const Vector3& gravity, const std::vector<BodyState>& before, const std::vector<BodyState>& after) {
  Wrench F;
  for (const int link : contact.carried) {
    F += report::beyondWeight(inertia[link], before[link], after[link], gravity, kStep);
    for (const report::HandSpring& hand : ruled.scene.hands) {
      if (hand.link != link) continue;
      const Vector3 f = handForce(hand, ours, t, before[link], after[link]);
      F = F - Wrench{(0.5 * (before[link].X_WL.p + after[link].X_WL.p)).cross(f), f};
    }
  }
  return F;
}

/// One run, every step of it. Throws SetupError where a simulator is not installed.
Row judge(const RuledScene& ruled, const Rival& rival) {
  constexpr double kLeast = 1e-6;  // [1] of the weight: a smaller force has no place
  WorldDef def;
  const auto world = report::makeSimulator(ruled.scene, rival.method, kStep, def);
  const std::vector<LinkInertia> inertia = inertiasOf(def);
  const auto states = [&] {
    std::vector<BodyState> all;
    for (int link = 0; link < static_cast<int>(inertia.size()); ++link) all.push_back(world->body(link));
    return all;
  };
  double weight = 0;
  for (const int link : ruled.scene.bodies) weight += inertia[link].mass * def.settings.gravity.norm();
  Row row;
  std::vector<BodyState> before = states();
  for (int i = 0; i < static_cast<int>(std::lround(ruled.scene.seconds / kStep)); ++i) {
    const double start = cpuSeconds();
    world->step();
    row["step"].add(1e6 * (cpuSeconds() - start));
    const std::vector<BodyState> after = states();
    for (const RuledContact& contact : ruled.contacts) {
      const BodyState& lower = after[contact.lower];
      const Vector3 n = lower.X_WL.R.col(2), deepest = contact.deepest(after[contact.upper], n);
      const double gap = n.dot(deepest - lower.X_WL.p) - contact.face;
      const Wrench F = through(contact, ruled, inertia, rival.ours(), i * kStep, def.settings.gravity, before, after);
      const Vector3 place = report::centreOfPush(F, n, deepest, kLeast * weight);
      const Vector3 v = report::velocityAt(after[contact.upper], place) - report::velocityAt(lower, place);
      const RigidResiduals r = report::rigidResiduals(n, F.force, v, gap, contact.mu);
      row["signorini"].add(r.signorini);
      row["gap_work"].add(r.gap_work);
      row["coulomb"].add(r.coulomb);
      row["dissipation"].add(r.dissipation);
      row["depth"].add(std::max(0.0, -gap));
      if (contact.force > 0) row["force_err"].add(n.dot(F.force) / contact.force - 1);
    }
    const std::vector<BodyState> exact = ruled.scene.exact((i + 1) * kStep);
    double off = 0;
    for (std::size_t b = 0; b < exact.size(); ++b) {
      off = std::max(off, (after[ruled.scene.bodies[b]].X_WL.p - exact[b].X_WL.p).norm());
    }
    row["position_err"].add(off);
    before = after;
  }
  return row;
}

}  // namespace

void measureContactbench() {
  for (const RuledScene& ruled : report::contactbenchScenes()) {
    const std::string& name = ruled.scene.name;
    const std::string prefix = "contactbench." + name.substr(name.find('_') + 1) + ".";
    std::map<std::string, double> best;  // of the peers, column by column: seldom one and the same setting
    for (const Rival& rival : rivals()) {
      if (rival.wasm()) continue;
      try {
        const Row row = judge(ruled, rival);
        std::printf("peers %s %-20s", name.c_str(), rival.name.c_str());
        const std::string tail = rival.method.choice.rigid ? "" : "_said";  // the rule of the report's list: rigid
        for (const auto& [column, values] : row) {
          const double value = typical(column, values);
          std::printf(" %s %.3g (%.3g)", column.c_str(), value, values.worst());
          double& least = best.emplace(column, infinite()).first->second;
          if (!rival.ours()) least = std::min(least, value);
        }
        std::printf("\n");
        for (const auto& [column, values] : row) {
          if (!rival.ours()) continue;
          figure(prefix + column + tail, typical(column, values), kUnits.at(column));
          figure(prefix + column + "_max" + tail, values.worst(), kUnits.at(column));
        }
      } catch (const SetupError& error) {
        tellRefusal(name.c_str(), rival, error.what());
      }
    }
    for (const auto& [column, value] : best) {
      if (std::isfinite(value)) figure(prefix + column + "_best_peer", value, kUnits.at(column));
    }
  }
}

}  // namespace haptic::bench
