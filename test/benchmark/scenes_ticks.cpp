/// Instructions of a tick of every shipped scene, beside those of a dated commit: unlike times they are the same on a busy machine.
///
/// Counted by callgrind inside HapticLoop::tick, the twin's exchange apart, from tick 1000 to 2000 of the scene's own hand path, at 1 and
/// at 10 kHz, with the core's library for any processor.
#include "scenes_ticks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "instruction_count.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

constexpr int kFirst = 1000, kCounted = 1000;  // ticks
constexpr double kRates[] = {1000, 10000};     // [Hz]

/// Instructions a tick at f0ac9ad (28 November 2026), by gcc 12.2, with the library for any processor, at the two rates.
struct Dated {
  const char* scene;
  double instructions[2];
};
constexpr Dated kDated[] = {
    {"a_cube", {78141, 22981}},
    {"b_stack", {282603, 32337}},
    {"blocks", {231452, 29964}},
    {"bounce", {31692, 24261}},
    {"box_on_floor", {79988, 22981}},
    {"c_bin", {776650, 494594}},
    {"chain", {138163, 112817}},
    {"conveyor", {161178, 95257}},
    {"d_two_hands", {443681, 201073}},
    {"daruma", {54703, 35124}},
    {"door", {35545, 24676}},
    {"double_pendulum", {37661, 37932}},
    {"drawer", {35248, 24895}},
    {"eccentric", {83352, 43945}},
    {"four_bar", {82474, 43209}},
    {"free_body", {22756, 23059}},
    {"gear", {35429, 20322}},
    {"gimbal_top", {213836, 46556}},
    {"grasped_block", {26808, 25087}},
    {"pyramid15", {1155122, 820914}},
    {"ramp", {235878, 39365}},
    {"resting", {81930, 22981}},
    {"seam", {32896, 65147}},
    {"spinning_box", {221689, 55690}},
    {"stack15", {772013, 56513}},
    {"stick_slip", {51144, 45341}},
    {"table_block", {24866, 54067}},
    {"terrain", {2518797, 1844473}},
    {"tilt", {27541, 44128}},
    {"top", {647511, 263068}},
    {"touch_cube", {81881, 31973}}};

/// Geometric mean and largest of ratios.
struct Ratios {
  double logarithms = 0, largest = 0;
  int count = 0;
  void add(double ratio) {
    logarithms += std::log(ratio);
    largest = std::max(largest, ratio);
    ++count;
  }
};

}  // namespace

void countTicks(const char* name, const char* rate) {
  RigSettings settings;
  settings.rate = std::atof(rate);
  Rig rig(sceneNamed(name, settings.rate), settings);
  rig.run(kFirst);
  for (int i = 0; i < kCounted; ++i) {
    rig.exchange();
    countedPass([&] { rig.tick(); });
  }
}

void measureTicks() {
  setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2", 1);  // the loader then takes that library
  for (int r = 0; r < 2; ++r) {
    const std::string rate = std::to_string(static_cast<int>(kRates[r]));
    Ratios ratios;
    for (const Dated& dated : kDated) {
      const double now = instructionsOf(std::string("ticks ") + dated.scene + " " + rate) / kCounted;
      if (!std::isfinite(now)) continue;
      std::printf("%-16s %s Hz: %.1f thousand instructions a tick, %.3f of the dated\n", dated.scene, rate.c_str(), 1e-3 * now,
                  now / dated.instructions[r]);
      std::fflush(stdout);
      ratios.add(now / dated.instructions[r]);
    }
    if (ratios.count == 0) continue;
    const std::string name = std::string("scenes.tick_instructions_ratio") + (r == 0 ? "" : "_10k");
    figure(name, std::exp(ratios.logarithms / ratios.count), "1");
    figure(name + "_max", ratios.largest, "1");
  }
}

}  // namespace haptic::bench
