/// Every shipped scene as it is shipped, with a twin's hand on each of its pointers, paced by the clock at 1 kHz; and the busy
/// ones for a minute, beside the same hand in a loop at a tenth of the period.
///
/// Compute time is CPU time of the ticking thread (exchange with the twin and HapticLoop::tick): what other processes do to
/// it is lateness, another number. A tick misses when its compute time exceeds the period.
///
/// Force errors compare what the twin's strings do to the grip with the wrench that they were last asked for, rms over all
/// ticks after the first second: a tick's command reaches the motors in the next exchange. Beside it stands the same against
/// the tick's own new command, which is the period's delay too. A scene rings when the force above 50 Hz is more than a third
/// of all of it in some second in which the hand feels anything (0.2 N). `given` is the least share of its contact's stiffness
/// that a hand was given (world/hand_bound.h).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "energy_gain.h"
#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/loop/realtime.h"
#include "loop_rig.h"
#include "scenes_ticks.h"

namespace haptic::bench {
namespace {

constexpr double kPeriod = 1e-3;         // [s]
constexpr int kSmoothed = 20;            // ticks: what varies faster than 50 Hz is above them
constexpr double kFelt = 0.2;            // [N]
constexpr double kRingingShare = 1.0 / 3;

/// Share of a force that is above 50 Hz, the largest of any second.
class Ringing {
 public:
  void look(const Vector3& F) {
    mean_ += (F - mean_) / kSmoothed;
    fast_ += (F - mean_).squaredNorm();
    all_ += F.squaredNorm();
    if (++ticks_ < 1000) return;
    if (all_ > ticks_ * kFelt * kFelt) worst_ = std::max(worst_, std::sqrt(fast_ / all_));
    fast_ = all_ = ticks_ = 0;
  }
  double worst() const { return worst_; }

 private:
  Vector3 mean_ = Vector3::Zero();
  double fast_ = 0, all_ = 0, worst_ = 0;
  int ticks_ = 0;
};

struct Run {
  int missed = 0;
  double p50_us = 0, p999_us = 0, worst_us = 0;
  double gain = 0, gain_of_run = 0;  ///< of energy, relative: see EnergyGain
  double force_error = 0, force_error_inside = 0;  ///< relative, of all hands
  double delayed_force_error = 0;                  ///< the same against the command of the tick itself
  double force = 0;             ///< rms on the hands [N]
  double ringing = 0;
  double given = 1;             ///< least share of a contact's stiffness that a hand was given
  bool finite = true;
};

Run run(SceneDef scene, double seconds, double period, bool paced) {
  scene.world.settings.step = period;
  Rig rig(scene, {});
  Run out;
  std::vector<double> cpu_us;
  const int ticks = static_cast<int>(std::lround(seconds / period));
  cpu_us.reserve(static_cast<std::size_t>(ticks));
  EnergyGain gain;
  std::vector<Ringing> ringing(rig.twin.size());
  double wrong = 0, asked = 0, wrong_inside = 0, asked_inside = 0, wrong_now = 0, asked_now = 0, felt = 0;
  PeriodicWake wake(1 / period);
  if (paced) wake.start();
  for (int i = 0; i < ticks; ++i) {
    if (paced) wake.wait();
    const double before = cpuSeconds();
    rig.exchange();
    const double exchanged = cpuSeconds();
    const std::array<HandReport, kMaxHands> presented = rig.loop->report().hand;  // what the motors now do
    const double resumed = cpuSeconds();
    rig.tick();
    cpu_us.push_back(1e6 * (cpuSeconds() - resumed + exchanged - before));
    if (rig.world.settings().energy_ledger) gain.look(rig.world.report().energy);
    for (std::size_t h = 0; h < rig.twin.size(); ++h) {
      const HandReport& hand = presented[h];
      const Vector3 F = rig.twin[h]->stringWrench().force;
      ringing[h].look(F);
      out.given = std::min(out.given, hand.stiffness_share);
      felt += F.squaredNorm();
      if (i * period < 1) continue;
      wrong += (F - hand.F_asked_B.force).squaredNorm();
      asked += hand.F_asked_B.force.squaredNorm();
      const Vector3 F_asked_now = rig.loop->report().hand[h].F_asked_B.force;
      wrong_now += (F - F_asked_now).squaredNorm();
      asked_now += F_asked_now.squaredNorm();
      if ((hand.F_achieved_B.force - hand.F_asked_B.force).norm() > 0.03 * hand.F_asked_B.force.norm()) continue;
      wrong_inside += (F - hand.F_asked_B.force).squaredNorm();
      asked_inside += hand.F_asked_B.force.squaredNorm();
    }
  }
  std::sort(cpu_us.begin(), cpu_us.end());
  const auto at = [&](double share) { return cpu_us[static_cast<std::size_t>(share * static_cast<double>(cpu_us.size() - 1))]; };
  out.missed = static_cast<int>(cpu_us.end() - std::upper_bound(cpu_us.begin(), cpu_us.end(), 1e6 * period));
  out.p50_us = at(0.5), out.p999_us = at(0.999), out.worst_us = cpu_us.back();
  out.gain = gain.worst(), out.gain_of_run = gain.worstOfRun();
  out.force_error = asked > 0 ? std::sqrt(wrong / asked) : 0;
  out.force_error_inside = asked_inside > 0 ? std::sqrt(wrong_inside / asked_inside) : 0;
  out.delayed_force_error = asked_now > 0 ? std::sqrt(wrong_now / asked_now) : 0;
  out.force = std::sqrt(felt / ticks);
  for (const Ringing& r : ringing) out.ringing = std::max(out.ringing, r.worst());
  out.finite = rig.world.report().finite;
  return out;
}

void runScenes() {
  int scenes = 0, missed = 0, rings = 0, stopped = 0, softened = 0;
  Run worst;
  std::printf("%-18s %8s %8s %8s %7s %9s %9s %8s %8s %7s\n", "scene", "p50_us", "p999_us", "worst_us", "missed", "energy", "force_%",
              "inside_%", "ringing", "given");
  for (const std::string& file : loadableScenes()) {
    const SceneDef scene = loadScene(file);
    const Run r = run(scene, 10, kPeriod, true);
    std::printf("%-18s %8.1f %8.1f %8.1f %7d %9.2e %9.2f %8.2f %8.2f %7.2f\n", scene.world.name.c_str(), r.p50_us, r.p999_us,
                r.worst_us, r.missed, r.gain, 100 * r.force_error, 100 * r.force_error_inside, r.ringing, r.given);
    std::fflush(stdout);
    ++scenes;
    missed += r.missed > 0;
    rings += r.ringing > kRingingShare;
    softened += r.given < 1;
    stopped += !r.finite;
    worst.p999_us = std::max(worst.p999_us, r.p999_us);
    worst.gain = std::max(worst.gain, r.gain);
    worst.gain_of_run = std::max(worst.gain_of_run, r.gain_of_run);
    worst.force_error = std::max(worst.force_error, r.force_error);
    worst.delayed_force_error = std::max(worst.delayed_force_error, r.delayed_force_error);
    worst.force_error_inside = std::max(worst.force_error_inside, r.force_error_inside);
  }
  figure("scenes.count", scenes, "1");
  figure("scenes.missed", missed, "1");
  figure("scenes.stopped", stopped, "1");
  figure("scenes.tick_us_p999_max", worst.p999_us, "us");
  figure("scenes.energy_gain_max", worst.gain, "1");
  figure("scenes.energy_gain_of_run_max", worst.gain_of_run, "1");
  figure("scenes.force_err_pct_max", 100 * worst.force_error, "%");
  figure("scenes.delayed_force_err_pct_max", 100 * worst.delayed_force_error, "%");
  figure("scenes.force_err_inside_pct_max", 100 * worst.force_error_inside, "%");
  figure("scenes.rings", rings, "1");
  figure("scenes.softened", softened, "1");
}

void runBusy() {
  int missed = 0;
  double p999 = 0, worst_us = 0, difference = 0;
  for (const char* name : {"c_bin.urdf", "b_stack.urdf", "d_two_hands.urdf", "allegro_grasp.yaml"}) {
    SceneDef scene;
    try {
      scene = loadScene(repositoryFile(std::string("urdf/scenes/") + name));
    } catch (const std::exception& error) {
      std::printf("scene left out: %s\n", error.what());
      continue;
    }
    scene.world.settings.attempts = Attempts::kAll;
    const Run r = run(scene, 60, kPeriod, true), fine = run(scene, 60, kPeriod / 10, false);
    const double off = fine.force > 0 ? std::abs(r.force / fine.force - 1) : 0;
    std::printf("%-18s p50 %.1f us, p99.9 %.1f us, worst %.1f us, missed %d; %.3f N rms on the hand, at a tenth of the period %.3f\n",
                name, r.p50_us, r.p999_us, r.worst_us, r.missed, r.force, fine.force);
    std::fflush(stdout);
    missed += r.missed;
    p999 = std::max(p999, r.p999_us);
    worst_us = std::max(worst_us, r.worst_us);
    difference = std::max(difference, off);
  }
  figure("bin.compute_missed", missed, "1");
  figure("bin.tick_us_p999", p999, "us");
  figure("bin.tick_us_worst", worst_us, "us");
  figure("bin.force_over_10khz_pct", 100 * difference, "%");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  if (argc == 4 && std::strcmp(argv[1], "ticks") == 0) {
    countTicks(argv[2], argv[3]);
    return 0;
  }
  if (argc < 2 || std::strcmp(argv[1], "scenes") == 0) runScenes();
  if (argc < 2 || std::strcmp(argv[1], "bin") == 0) runBusy();
  if (argc < 2 || std::strcmp(argv[1], "ticks") == 0) measureTicks();
  return 0;
}
