#include "fault_campaign.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

namespace haptic::bench {
namespace {

constexpr double kHarmlessPose = 1e-3, kHarmlessForce = 0.2;  // [m], [N], of figures.md
constexpr double kLongestStale = 0.02;                        // [s], likewise

int pick(std::mt19937& r, int n) { return static_cast<int>(r() % static_cast<unsigned>(n)); }
std::string text(double value) {
  char number[32];
  std::snprintf(number, sizeof number, " %.4g", value);
  return number;
}
std::string some(std::mt19937& r) { return " " + std::to_string(1 + pick(r, 3)); }
std::string board(std::mt19937& r, const FaultRig& rig) {
  return " " + std::to_string(1 + pick(r, static_cast<int>(rig.device.boards.size())));
}
std::string string(std::mt19937& r, const FaultRig& rig) {
  return " " + std::to_string(pick(r, static_cast<int>(rig.device.strings.size())));
}
std::string counts(std::mt19937& r, const FaultRig& rig, double least, double most) {
  const double metres = (least + (most - least) * 1e-4 * pick(r, 10000)) * (pick(r, 2) ? 1 : -1);
  return " " + std::to_string(std::lround(metres / std::abs(rig.device.strings[0].length_per_count)));
}
using Random = std::mt19937;
using Rig = FaultRig;

}  // namespace

const std::vector<FaultKind>& faultKinds() {
  static const std::vector<FaultKind> kinds = {
      {"drop", [](Random& r, const Rig&) { return "drop" + some(r); }},
      {"corrupt", [](Random& r, const Rig&) { return "corrupt" + some(r); }},
      {"duplicate", [](Random& r, const Rig&) { return "duplicate" + some(r); }},
      {"insert", [](Random& r, const Rig&) { return "insert" + some(r); }},
      {"corrupt .001", [](Random&, const Rig&) { return std::string("rate_corrupt 0.001"); }, "rate_corrupt"},
      {"drop .001", [](Random&, const Rig&) { return std::string("rate_drop 0.001"); }, "rate_drop"},
      {"command drop", [](Random& r, const Rig&) { return "board_drop" + some(r); }, "", 300, true},
      {"command corrupt", [](Random& r, const Rig&) { return "board_corrupt" + some(r); }, "", 300, true},
      {"command insert", [](Random& r, const Rig&) { return "board_insert" + some(r); }, "", 300, true},
      {"inside a command",
       [](Random& r, const Rig&) {
         static const char* const verbs[] = {"board_drop", "board_corrupt", "board_insert"};
         return verbs[pick(r, 3)] + some(r);
       },
       "", 300, true, true},
      {"delay", [](Random& r, const Rig&) { return "delay" + some(r) + text(0.5 + 0.1 * pick(r, 60)); }},
      {"lost answers", [](Random& r, const Rig&) { return "lose" + text(1 + pick(r, 30)); }},
      {"doubled answers", [](Random& r, const Rig&) { return "double" + text(1 + pick(r, 30)); }},
      {"swapped answers", [](Random& r, const Rig&) { return "swap" + text(1 + pick(r, 30)); }},
      {"latency", [](Random& r, const Rig&) { return "latency" + text(0.2 + 0.1 * pick(r, 150)); }, "latency"},
      {"bursts", [](Random& r, const Rig&) { return "burst" + text(1 + pick(r, 16)); }, "burst"},
      {"board off", [](Random& r, const Rig& rig) { return "kill" + board(r, rig); }, "revive"},
      {"brown-out", [](Random& r, const Rig& rig) { return "reset" + board(r, rig); }},
      {"brown-out to 0", [](Random& r, const Rig& rig) { return "forget" + board(r, rig); }},
      {"counters stuck", [](Random& r, const Rig& rig) { return "stuck" + board(r, rig); }, "moving", 1000},
      {"deaf board", [](Random& r, const Rig& rig) { return "deaf" + board(r, rig); }, "", 300, true},
      {"spoilt table",
       [](Random& r, const Rig& rig) { return "table" + board(r, rig) + text(1 + pick(r, 11)) + text(pick(r, 256)); }, "",
       300, true},
      {"counter jumps", [](Random& r, const Rig& rig) { return "jump" + string(r, rig) + counts(r, rig, 0.002, 0.3); }},
      {"counter jumps 2^16",
       [](Random& r, const Rig& rig) { return "jump" + string(r, rig) + (pick(r, 2) ? " 65536" : " -65536"); }},
      {"slip", [](Random& r, const Rig& rig) { return "slip" + string(r, rig) + counts(r, rig, 0.003, 0.02); }},
      {"slack", [](Random& r, const Rig& rig) { return "slack" + string(r, rig) + text(0.008 + 0.001 * pick(r, 20)); }},
      {"stuck string", [](Random& r, const Rig& rig) { return "freeze" + string(r, rig); }, "mend", 1000},
      {"broken string", [](Random& r, const Rig& rig) { return "snap" + string(r, rig); }},
      {"unplugged", [](Random&, const Rig&) { return std::string("unplug"); }, "plug", 40}};
  return kinds;
}

HandPath hardUse(unsigned seed, double seconds) {
  std::mt19937 random(seed);
  const auto unit = [&random] { return 2e-6 * pick(random, 1000000) - 1; };
  HandPath path;
  double time = 0;
  path.keys.push_back({0, Vector3::Zero(), Vector3::Zero(), 0});
  Vector3 last = Vector3::Zero();
  while (time < seconds) {
    const Vector3 p = 0.03 * Vector3(unit(), unit(), unit());
    time += std::max(0.1 + 0.2 * std::fabs(unit()), (p - last).norm() * 1.875 / 1.0);  // quintic: peak 1.875 of the mean
    path.keys.push_back({time, p, 0.25 * Vector3(unit(), unit(), unit()), 0});
    last = p;
  }
  path.keys.push_back({time + 0.3, Vector3::Zero(), Vector3::Zero(), 0});  // the next path begins at home
  return path;
}

Wrench hardCommand(double time) {
  Wrench F;
  const double knock = std::fmod(time, 0.7) < 0.05 ? 2 : 0.5;
  F.force = knock * Vector3(std::sin(9 * time), std::sin(7 * time), std::sin(5 * time));
  F.torque = 0.02 * Vector3(std::sin(4 * time), std::sin(6 * time), std::sin(8 * time));
  return F;
}

FaultTally FaultCampaign::inject(const FaultKind& kind) {
  FaultTally tally;
  if (!rig_.enabled() && !rig_.bringUp()) {
    tally.idle = 1;
    return tally;
  }
  rig_.setHand(hardUse(random_(), 3));
  const int lead = 150 + pick(random_, 200);
  const auto move = [&](int k) { rig_.command = hardCommand(FaultRig::kPeriod * k), rig_.command_age = 0, rig_.tick(); };
  rig_.startMeasuring();
  for (int k = 0; k < lead; ++k) move(k);
  const double usual_force = rig_.effect().force_error, usual_pose = rig_.effect().pose_error;
  if (!rig_.enabled()) {
    tally.idle = 1;
    return tally;
  }
  const std::string order = kind.order(random_, rig_);
  rig_.bus.to_host.after(pick(random_, 82));
  if (kind.inside) rig_.bus.to_boards.after(pick(random_, 74));
  rig_.boards_may_misread = kind.misread;
  rig_.startMeasuring();
  rig_.order(order);
  tally.injected = 1;
  int noticed = -1;
  for (int k = 0; k < kind.patience; ++k) {
    move(lead + k);
    if (noticed < 0 && rig_.alarmed()) noticed = k;
  }
  const FaultEffect effect = rig_.effect();
  const bool effective = effect.pose_error >= kHarmlessPose + usual_pose || effect.force_error >= kHarmlessForce + usual_force;
  tally.detected = noticed >= 0;
  tally.harmless = noticed < 0 && !effective;
  tally.missed = noticed < 0 && effective;
  // Over a cut wire nobody can send a zero, nor to a board whose length table cuts all that would turn it off: they hold their
  // currents until they are switched off.
  bool cut = kind.name == std::string("unplugged");
  for (const auto& board : rig_.bus.boards()) cut = cut || !board->reachable();
  const bool stale = !cut && effect.stale_force > kLongestStale;
  if (tally.missed || stale)
    std::printf("# %s: %s on %s: pose %.2f mm (%.2f before), force %.2f N (%.2f before), %.1f ms on stale counts\n",
                stale ? "stale" : "missed", order.c_str(), rig_.device.name.c_str(), 1e3 * effect.pose_error, 1e3 * usual_pose,
                effect.force_error, usual_force, 1e3 * effect.stale_force);
  if (noticed >= 0) tally.detect_ms.push_back(noticed + 1);
  (cut ? tally.cut_force : tally.stale_force) = effect.stale_force;
  tally.energy = effect.energy;
  tally.pose_error = effect.pose_error;
  if (kind.undo[0] != '\0') {
    const std::size_t target = order.find(' ');
    const bool rate = std::string(kind.undo) == order.substr(0, target);  // latency, burst, rates: back to none
    rig_.order(kind.undo + (rate ? " 0" : target == std::string::npos ? "" : order.substr(target)));
  }
  rig_.order("rate_corrupt 0");
  for (const char* string : {"0", "1", "2", "3", "4", "5", "6", "7"}) rig_.order(std::string("mend ") + string);
  if (kind.name == std::string("unplugged")) {
    // The recovery thread lives on the machine's clock, not on the line's.
    for (int k = 0; k < 100 && rig_.sample.status == LinkStatus::kDisconnected; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      rig_.tick();
    }
  }
  rig_.command = Wrench{};
  rig_.run(200);
  rig_.boards_may_misread = false;
  // A disturbance that the device rode out needs no bring-up; whatever left its mark does.
  tally.recovered = (rig_.enabled() && rig_.poseError() < kHarmlessPose) || rig_.bringUp();
  return tally;
}

}  // namespace haptic::bench
