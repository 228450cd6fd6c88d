// Faults injected into a whole emulated device and into the twin alone: what is noticed, how soon, and what
// the strings do meanwhile. How true the measured delay of a wire is. The UART cycle byte by byte, its highest rate, and
// the fuzz target on a bounded corpus.
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <random>
#include <thread>

#include "checked_link.h"
#include "fault_campaign.h"
#include "fault_rig.h"
#include "fault_tally.h"
#include "figure.h"
#include "haptic_core/spidar/device_check.h"
#include "protocol_fuzz.h"

namespace haptic::bench {
namespace {

constexpr int kTrials = 90;      // per kind and device
constexpr int kUnplugged = 15;    // of which few: reopening lives on the machine's clock
constexpr double kWireHours = 0.25; // of the undisturbed run on emulated boards, per device; the rest on the twin

std::string file(const char* device) {
  return std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + device + ".yaml";
}

/// An alarm is a row of ticks in which the device is not enabled, or says that something is wrong.
FaultTally undisturbed(const char* device, double hours) {
  FaultTally tally;
  FaultRig rig(loadDevice(file(device)));
  rig.bringUp();
  bool before = false;
  const long ticks = std::lround(hours * 3600 / FaultRig::kPeriod);
  constexpr long kPath = 20000;
  for (long k = 0; k < ticks; ++k) {
    if (k % kPath == 0) rig.setHand(hardUse(static_cast<unsigned>(k / kPath + 1), kPath * FaultRig::kPeriod - 1));
    rig.command = hardCommand(static_cast<double>(k) * FaultRig::kPeriod);
    rig.tick();
    const bool now = rig.alarmed() || !rig.enabled();
    tally.alarms += now && !before;
    before = now;
  }
  tally.quiet_hours = hours;
  tally.out_of_bounds = static_cast<long>(rig.outOfBounds());
  return tally;
}

struct DeviceRun {
  std::map<std::string, FaultTally> by_kind;
  FaultTally quiet;
  long out_of_bounds = 0;
};

DeviceRun runDevice(const char* device, unsigned seed) {
  DeviceRun run;
  {
    FaultRig rig(loadDevice(file(device)));
    FaultCampaign campaign(rig, seed);
    for (const FaultKind& kind : faultKinds()) {
      const int trials = kind.name == std::string("unplugged") ? kUnplugged : kTrials;
      for (int n = 0; n < trials; ++n) run.by_kind[kind.name].add(campaign.inject(kind));
    }
    run.out_of_bounds = static_cast<long>(rig.outOfBounds());
    run.quiet.power_cycles = rig.power_cycles;
  }
  const int power_cycles = run.quiet.power_cycles;
  run.quiet = undisturbed(device, kWireHours);
  run.quiet.power_cycles = power_cycles;
  return run;
}

void printTable(const std::map<std::string, FaultTally>& by_kind) {
  std::printf("# %-20s %8s %8s %8s %6s %5s %9s %8s %8s %8s %8s\n", "fault", "injected", "detected", "harmless", "missed",
              "idle", "recovered", "worst ms", "stale ms", "pose mm", "mJ");
  for (const auto& [name, t] : by_kind) {
    const double worst = t.detect_ms.empty() ? 0 : *std::max_element(t.detect_ms.begin(), t.detect_ms.end());
    std::printf("# %-20s %8d %8d %8d %6d %5d %9d %8.0f %8.1f %8.1f %8.1f\n", name.c_str(), t.injected, t.detected, t.harmless,
                t.missed, t.idle, t.recovered, worst, 1e3 * t.stale_force, 1e3 * t.pose_error, 1e3 * t.energy);
  }
}

void faults() {
  const char* devices[] = {"spidar_g6x5r", "spidar_g6x4"};
  DeviceRun runs[2];
  std::thread other([&] { runs[1] = runDevice(devices[1], 2); });
  runs[0] = runDevice(devices[0], 1);
  other.join();
  std::map<std::string, FaultTally> by_kind;
  FaultTally all;
  for (const DeviceRun& run : runs) {
    for (const auto& [name, tally] : run.by_kind) by_kind[name].add(tally);
    all.add(run.quiet);
    all.out_of_bounds += run.out_of_bounds;
  }
  printTable(by_kind);
  for (const auto& [name, tally] : by_kind) all.add(tally);
  all.add(twinFaults());
  std::sort(all.detect_ms.begin(), all.detect_ms.end());
  const int counted = all.injected - all.harmless;
  figure("faults.injected", all.injected, "1");
  figure("faults.kinds", static_cast<double>(by_kind.size()), "1");
  figure("faults.detected_pct", 100.0 * all.detected / std::max(counted, 1), "%");
  figure("faults.missed", all.missed, "1");
  figure("faults.harmless", all.harmless, "1");
  figure("faults.idle", all.idle, "1");
  figure("faults.recovered_pct", 100.0 * all.recovered / std::max(all.injected, 1), "%");
  figure("faults.detect_ms_p50", median(all.detect_ms), "ms");
  figure("faults.detect_ms_p99", all.detect_ms.empty() ? NAN : all.detect_ms[all.detect_ms.size() * 99 / 100],
         "ms");
  figure("faults.force_on_stale_ms_max", 1e3 * all.stale_force, "ms");
  figure("faults.force_on_cut_wire_ms_max", 1e3 * all.cut_force, "ms");
  figure("faults.power_cycles", all.power_cycles, "1");
  figure("faults.energy_mj_max", 1e3 * all.energy, "mJ");
  figure("faults.energy_bound_mj", 1e3 * faultEnergy(loadDevice(file(devices[0]))), "mJ");
  figure("faults.quiet_hours", all.quiet_hours, "h");
  figure("faults.false_alarms_per_h", static_cast<double>(all.alarms) / all.quiet_hours, "1/h");
  figure("faults.out_of_bounds", static_cast<double>(all.out_of_bounds), "1");
}

/// What the driver says of wires whose delay is known, at opening and after a second of use [µs].
void latency() {
  double worst = 0;
  for (const char* device : {"spidar_g6x5r", "spidar_g6x4"}) {
    const DeviceDef def = loadDevice(file(device));
    for (int tenths = 2; tenths <= 50; ++tenths) {
      TwinPlant plant(def, {});
      BoardBusEmulator bus(plant);
      int id = 1;
      for (const std::string& model : def.boards) bus.addBoard(model, id++);
      const double delay_us = 100.0 * tenths;
      bus.setAdapter({static_cast<std::int64_t>(1e3 * delay_us), 0, 0});
      MemoryLine line(bus);
      UartBoards driver(def, {}, "memory", [&line] { return std::make_unique<MemoryLink>(line); });
      worst = std::max(worst, std::fabs(driver.linkReport().delay_us - delay_us));
      const std::int64_t start = line.now_ns;
      for (int k = 1; k <= 1000; ++k) {
        line.now_ns = std::max<std::int64_t>(line.now_ns, start + k * 1000000ll);
        driver.exchange({});
      }
      worst = std::max(worst, std::fabs(driver.linkReport().delay_us - delay_us));
    }
  }
  figure("latency.measured_error_us_max", worst, "us");
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
  haptic::bench::latency();
  haptic::bench::faults();
  return 0;
}
