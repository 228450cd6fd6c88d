// device_check FILE: what an arrangement of strings can do, what is wrong with it, and its first-motion test.
// device_check FILE --report [FORCE [TORQUE]]: what its page shows, as JSON.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "haptic_core/base/program_version.h"
#include "haptic_core/spidar/device_check.h"
#include "spidar_driver/report/device_report.h"
#include "spidar_driver/transport/board_promise.h"
#include "spidar_driver/transport/last_command.h"

namespace {

/// A wrench that is required, in words of the command line: negative or no number: NaN.
double required(const char* word) {
  char* end = nullptr;
  const double value = std::strtod(word, &end);
  return *end == 0 && end != word && value >= 0 && std::isfinite(value) ? value : std::nan("");
}

int report(const haptic::DeviceDef& def, int words, char** word) {
  haptic::RequiredWrench wanted = haptic::leastFeedback(def);
  if (words > 0) wanted.force = required(word[0]);
  if (words > 0 && def.dof >= 6) wanted.torque = wanted.force * haptic::StringKinematics(def).knotRadius();
  if (words > 1) wanted.torque = required(word[1]);
  if (!(wanted.force >= 0 && wanted.torque >= 0)) {
    std::fputs("device_check: force [N] and torque [N·m] are numbers of at least 0\n", stderr);
    return 2;
  }
  if (def.dof == 3 && wanted.torque > 0) {
    std::fprintf(stderr, "device_check: %s has a point grip, which presents no torque; ask for a force alone\n", def.name.c_str());
    return 2;
  }
  std::fputs(haptic::deviceReport(def, wanted).c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "device_check")) return 0;
  const bool wants_report = argc > 2 && argc <= 5 && argv[2] == std::string("--report");
  if (argc != 2 && !wants_report) {
    std::fputs("usage: device_check FILE [--report [FORCE [TORQUE]]]\nexit code: 0 nothing wrong, 1 problems found, 2 refused\n", stderr);
    return 2;
  }
  try {
    const haptic::DeviceDef def = haptic::loadDevice(argv[1]);
    if (wants_report) return report(def, argc - 3, argv + 3);
    const haptic::DeviceReport found = haptic::examineDevice(def);
    std::fputs(haptic::checkDevice(def).c_str(), stdout);
    const haptic::LastCommand last = haptic::lastCommand(def);
    const haptic::BoardPromise promise = haptic::boardPromise(def);
    if (!promise.text.empty()) std::printf("boards that do not obey:\n%s", promise.text.c_str());
    std::printf("when driver and motor guard end at once, or the host does:\n%s", last.text.c_str());
    std::printf("figure check.strings %zu 1\n", def.strings.size());
    std::printf("figure check.presentable_force_n %.6g N\n", found.presentable_force);
    std::printf("figure check.presentable_torque_nm %.6g N·m\n", found.presentable_torque);
    std::printf("figure check.fault_energy_mj %.6g mJ\n", 1e3 * haptic::faultEnergy(def));
    std::printf("figure check.table_unseen_ms %.6g ms\n", 1e3 * promise.table_s);
    std::printf("figure check.silence_is_zero %d 1\n", last.ends ? 1 : 0);
    std::printf("figure check.feasible_share %.6g 1\n", found.feasible_share);
    std::printf("figure check.problems %zu 1\n", found.problems.size());
    return found.problems.empty() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "device_check: %s\n", error.what());
    return 2;
  }
}
