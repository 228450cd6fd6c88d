// Faults injected into a whole emulated device and into the twin alone: what is noticed, how soon, and what
// the strings do meanwhile. The UART cycle byte by byte, its highest rate, and the fuzz target on a bounded
// corpus.
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>

#include "checked_link.h"
#include "fault_rig.h"
#include "fault_tally.h"
#include "figure.h"
#include "protocol_fuzz.h"

namespace haptic::bench {
namespace {

constexpr double kHarmless = 1e-3;         // an effect below this on pose or length is none [m]
constexpr double kEffective = 5e-3;        // a fault that grows counts from this length error on [m]
constexpr int kPatience = 100;             // ticks within which an effective fault must be noticed
constexpr int kGrowthPatience = 3000;      // ticks for a stuck string to matter while the hand moves
constexpr int kCampaigns = 60;             // faults per kind and device
constexpr int kUndisturbedTicks = 600000;  // 10 minutes of 1 kHz

std::string file(const char* device) {
  return std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + device + ".yaml";
}

enum class Fault {
  kDrop,
  kCorrupt,
  kDuplicate,
  kInsert,
  kDelay,
  kKill,
  kUnplug,
  kSlack,
  kSlip,
  kFreeze,
  kSnap,
  kNotFinite,
  kHuge,
  kAlternating,
  kStaleCommand,
  kCount
};
constexpr const char* kNames[] = {
    "drop",         "corrupt", "duplicate", "insert", "delay",       "kill board",   "unplug",
    "slack",        "slip",    "freeze",    "snap",   "command NaN", "command 1e30", "command alternating",
    "command stale"};

class Campaign {
 public:
  Campaign(FaultRig& rig, unsigned seed) : rig_(rig), random_(seed) {}
  FaultTally inject(Fault fault);

 private:
  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool start(Fault fault);
  void keepUp(Fault fault, int tick);
  void mend(Fault fault);
  bool watch(Fault fault, FaultTally& tally);

  FaultRig& rig_;
  std::mt19937 random_;
  int string_ = 0, board_ = 1;
};

void move(FaultRig& rig, int tick) {
  const double t = tick * FaultRig::kPeriod;
  rig.command.force = 2 * Vector3(std::sin(9 * t), std::sin(7 * t), std::sin(5 * t));
  rig.command.torque = 0.02 * Vector3(std::sin(4 * t), std::sin(6 * t), std::sin(8 * t));
  rig.command_age = 0;
}

/// False when the fault has its effect at once, true when it grows.
bool Campaign::start(Fault fault) {
  string_ = pick(static_cast<int>(rig_.device.strings.size()));
  board_ = 1 + pick(static_cast<int>(rig_.bus.boards().size()));
  const int reply = replyBytes(*findBoardModel(rig_.device.boards[0]), BoardCommand::kCurrent);
  const int sign = pick(2) ? 1 : -1;
  rig_.bus.to_host.after(pick(reply * static_cast<int>(rig_.bus.boards().size())));
  switch (fault) {
    case Fault::kDrop:
      rig_.bus.to_host.drop(1 + pick(3));
      break;
    case Fault::kCorrupt:
      rig_.bus.to_host.corrupt(1 + pick(3));
      break;
    case Fault::kDuplicate:
      rig_.bus.to_host.duplicate(1 + pick(3));
      break;
    case Fault::kInsert:
      rig_.bus.to_host.insert(1 + pick(3));
      break;
    case Fault::kDelay:
      rig_.bus.delayReplies(2, 900000 + 1000 * pick(4000));
      break;
    case Fault::kKill:
      rig_.bus.board(board_)->setPower(false);
      break;
    case Fault::kUnplug:
      rig_.line.plugged = false;
      break;
    case Fault::kSlack:
      rig_.plant.slacken(string_, 0.008 + 0.001 * pick(20));
      break;
    case Fault::kSlip:
      rig_.plant.slip(string_,
                      sign * static_cast<int>((0.012 + 0.001 * pick(50)) /
                                              std::abs(rig_.device.strings[string_].length_per_count)));
      break;
    case Fault::kFreeze:
      rig_.plant.freeze(string_);
      return true;
    case Fault::kSnap:
      rig_.plant.snap(string_);
      return true;
    default:
      break;
  }
  return false;
}

/// Faults of the command, which last while the device is watched.
void Campaign::keepUp(Fault fault, int tick) {
  move(rig_, tick);
  if (fault == Fault::kNotFinite) rig_.command.force[tick % 3] = tick % 2 ? std::nan("") : HUGE_VAL;
  if (fault == Fault::kHuge) rig_.command.force[tick % 3] = 1e30;
  if (fault == Fault::kAlternating) rig_.command.torque[0] = rig_.command.force[0] = tick % 2 ? 1e3 : -1e3;
  if (fault == Fault::kStaleCommand) rig_.command_age = tick * FaultRig::kPeriod;
}

bool commandFault(Fault fault) {
  return fault >= Fault::kNotFinite;
}

/// The device must notice, or the fault must be without effect.
bool Campaign::watch(Fault fault, FaultTally& tally) {
  const bool grows = start(fault);
  int effective_since = grows ? -1 : 0;
  double worst = 0;
  for (int k = 0; k < (grows ? kGrowthPatience : kPatience); ++k) {
    keepUp(fault, k);
    rig_.tick();
    if (effective_since < 0 && rig_.countError(string_) > kEffective) effective_since = k;
    worst = std::max(worst, rig_.poseError());
    const bool limited = rig_.spidar.flags() & (kForceClamped | kTorqueClamped | kCommandStale);
    if (!(rig_.alarmed() || (commandFault(fault) && limited))) continue;
    tally.detect_ms.push_back(effective_since < 0 ? 0 : k - effective_since + 1);
    return true;
  }
  if (worst < kHarmless || effective_since < 0) ++tally.harmless;
  return false;
}

void Campaign::mend(Fault fault) {
  rig_.command = Wrench{};
  rig_.command_age = 0;
  if (fault == Fault::kKill) rig_.bus.board(board_)->setPower(true);
  rig_.plant.mend(string_);
  if (fault == Fault::kUnplug) {
    rig_.line.plugged = true;
    // The recovery thread lives on the machine's clock, not on the line's.
    for (int k = 0; k < 400 && rig_.sample.status == LinkStatus::kDisconnected; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      rig_.tick();
    }
  }
  rig_.run(50);
}

FaultTally Campaign::inject(Fault fault) {
  FaultTally tally;
  if (!rig_.enabled() && !rig_.bringUp()) return tally;
  rig_.setHand("wave");
  const int lead = 1500 + pick(1500);
  for (int k = 0; k < lead; ++k) {
    move(rig_, k);
    rig_.tick();
  }
  tally.detected = watch(fault, tally);
  tally.injected = 1 - tally.harmless;
  if (fault == Fault::kKill || fault == Fault::kUnplug) rig_.run(pick(60));
  mend(fault);
  // A disturbance that the device rode out needs no bring-up; whatever left its mark does.
  const bool rode_out = rig_.enabled() && rig_.poseError() < kHarmless;
  tally.recovered = tally.injected && (rode_out || rig_.bringUp());
  if (tally.injected == 0 && !rode_out) rig_.bringUp();
  return tally;
}

std::uint64_t runCampaigns(const char* device, unsigned seed, std::map<Fault, FaultTally>& tallies) {
  FaultRig rig(loadDevice(file(device)));
  rig.bringUp();
  Campaign campaign(rig, seed);
  for (int n = 0; n < kCampaigns; ++n)
    for (int f = 0; f < static_cast<int>(Fault::kCount); ++f)
      tallies[static_cast<Fault>(f)].add(campaign.inject(static_cast<Fault>(f)));
  return rig.outOfBounds();
}

FaultTally wireFaults() {
  std::map<Fault, FaultTally> tallies;
  FaultTally all;
  for (const char* device : {"spidar_g6x5r", "spidar_g6x4"})
    all.out_of_bounds += static_cast<long>(runCampaigns(device, 1, tallies));
  std::printf("# %-20s %8s %8s %8s %9s %8s\n", "fault", "injected", "detected", "harmless", "recovered",
              "worst ms");
  for (const auto& [fault, t] : tallies) {
    const double worst = t.detect_ms.empty() ? 0 : *std::max_element(t.detect_ms.begin(), t.detect_ms.end());
    std::printf("# %-20s %8d %8d %8d %9d %8.0f\n", kNames[static_cast<int>(fault)], t.injected, t.detected,
                t.harmless, t.recovered, worst);
    all.add(t);
  }
  return all;
}

/// An alarm is a row of ticks with one.
FaultTally undisturbed() {
  FaultTally tally;
  FaultRig rig(loadDevice(file("spidar_g6x5r")));
  rig.bringUp();
  bool before = false;
  for (int k = 0; k < kUndisturbedTicks; ++k) {
    if (k % 20000 == 0) rig.setHand("wave");
    move(rig, k);
    rig.tick();
    const bool now = rig.alarmed() || !rig.enabled();
    tally.alarms += now && !before;
    before = now;
  }
  tally.quiet_hours = kUndisturbedTicks * FaultRig::kPeriod / 3600;
  tally.out_of_bounds = static_cast<long>(rig.outOfBounds());
  return tally;
}

void faults() {
  FaultTally all = wireFaults();
  all.add(undisturbed());
  all.add(twinFaults());
  std::sort(all.detect_ms.begin(), all.detect_ms.end());
  figure("faults.injected", all.injected, "1");
  figure("faults.detected", all.detected, "1");
  figure("faults.recovered", all.recovered, "1");
  figure("faults.harmless", all.harmless, "1");
  figure("faults.detect_ms_p50", median(all.detect_ms), "ms");
  figure("faults.detect_ms_p99", all.detect_ms.empty() ? NAN : all.detect_ms[all.detect_ms.size() * 99 / 100],
         "ms");
  figure("faults.false_alarms", all.alarms / all.quiet_hours, "1/h");
  figure("faults.tension_out_of_bounds", static_cast<double>(all.out_of_bounds), "1");
}

void uart() {
  const CycleCheck b5m = checkCycles({"B5M"}, 50000), b3m = checkCycles({"B3M", "B3M"}, 50000);
  figure("uart.cycles_ok", static_cast<double>(b5m.ok + b3m.ok), "1");
  figure("uart.cycles_wrong", static_cast<double>(b5m.wrong + b3m.wrong), "1");
  figure("uart.rate_hz_b5m", highestRate(loadDevice(file("spidar_g6x5r"))), "Hz");
  figure("uart.rate_hz_2xb3m", highestRate(loadDevice(file("spidar_g6x4"))), "Hz");
}

/// Random bytes, and true packets with a few bytes changed.
void fuzz() {
  std::mt19937 random(1);
  constexpr int kRuns = 200000;
  std::vector<std::uint8_t> bytes;
  for (int n = 0; n < kRuns; ++n) {
    bytes.resize(2 + random() % 200);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
    if (n % 2) {
      const BoardShape& shape = *findBoardModel(1 + bytes[0] % 7);
      for (std::size_t at = 2; at + kMaxReplyBytes < bytes.size(); at += 1 + random() % 60)
        encodePacket(shape, 1, CurrentReply{}, bytes.data() + at, bytes.size() - at);
    }
    fuzzOne(bytes.data(), bytes.size());
  }
  figure("fuzz.execs", kRuns, "1");
}

}  // namespace
}  // namespace haptic::bench

int main() {
  haptic::bench::uart();
  haptic::bench::fuzz();
  haptic::bench::faults();
  return 0;
}
