#include "scene/step_cost.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "haptic_core/loop/realtime.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr int kTimedSteps = 101, kLooks = 50;  // the median of so many; a pair takes 0.1 to 100 µs
constexpr std::size_t kMostShares = 5;         // more fill a screen and tell nothing

double secondsOf(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

/// Time of one look at pair i, from a copy of what it remembers [s].
double secondsOfPair(const World& world, int index, Seams& seams, ContactWorkspace& workspace, const std::vector<int>& held_by) {
  const Placement& placement = world.work().placement;
  const ContactPlaces places{placement.link.data(), placement.X_WS.data(), held_by.data(), nullptr};
  ContactEvaluation out;
  std::vector<std::int64_t> times;
  for (int look = 0; look < kLooks; ++look) {
    ActivePair pair = world.state().pairs[index];
    const std::int64_t begin = steadyNow();
    locateContact(world.model(), seams, index, pair, places, workspace, out);
    times.push_back(steadyNow() - begin);
  }
  std::nth_element(times.begin(), times.begin() + kLooks / 2, times.end());
  return secondsOf(times[kLooks / 2]);
}

}  // namespace

StepCost stepCost(const WorldDef& def, double seconds) {
  WorldDef copy = def;
  copy.settings.history_steps = 0;
  World world(copy);
  const int steps = static_cast<int>(std::lround(seconds / def.settings.step));
  for (int i = 0; i < steps && world.report().finite; ++i) world.step();
  std::vector<std::int64_t> times;
  for (int i = 0; i < kTimedSteps; ++i) {
    const std::int64_t begin = steadyNow();
    world.step();
    times.push_back(steadyNow() - begin);
  }
  std::nth_element(times.begin(), times.begin() + kTimedSteps / 2, times.end());
  StepCost cost;
  cost.seconds = secondsOf(times[kTimedSteps / 2]);
  const Model& model = world.model();
  ContactWorkspace workspace;
  model.reserve(workspace);
  Seams seams(model);
  const std::vector<int> held_by(model.links.size(), -1);
  std::map<int, StepCost::Share> shares;
  world.state().pairs.each([&](int i) {
    const double time = secondsOfPair(world, i, seams, workspace, held_by);
    const ActivePair& pair = world.state().pairs[i];
    for (const int shape : {pair.shapeA(), pair.shapeB()}) {
      StepCost::Share& share = shares[shape];
      share.name = model.shapes[static_cast<std::size_t>(shape)].name;
      ++share.pairs;
      share.seconds += 0.5 * time;
    }
  });
  for (const auto& [shape, share] : shares) cost.of.push_back(share);
  std::stable_sort(cost.of.begin(), cost.of.end(), [](const auto& a, const auto& b) { return a.seconds > b.seconds; });
  return cost;
}

std::vector<std::string> costLines(const StepCost& cost) {
  std::vector<std::string> lines;
  const auto microseconds = [](double seconds) {
    std::ostringstream text;
    text.precision(seconds < 1e-5 ? 2 : 3);
    text << 1e6 * seconds << " µs";
    return text.str();
  };
  double all = 0;
  for (const StepCost::Share& share : cost.of) all += share.seconds;
  lines.push_back(microseconds(cost.seconds) + " a step here" +
                  (cost.of.empty() ? ", no collisions near each other" : "; one look at its pairs: " + microseconds(all)));
  for (std::size_t i = 0; i < cost.of.size() && i < kMostShares; ++i) {
    const StepCost::Share& share = cost.of[i];
    lines.push_back("'" + share.name + "': " + microseconds(share.seconds) + " in " + std::to_string(share.pairs) +
                    (share.pairs == 1 ? " pair" : " pairs"));
  }
  if (cost.of.size() > kMostShares) lines.push_back("and " + std::to_string(cost.of.size() - kMostShares) + " collisions that cost less");
  return lines;
}

}  // namespace haptic
