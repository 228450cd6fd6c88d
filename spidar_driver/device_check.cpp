// device_check FILE: what an arrangement of strings can do, what is wrong with it, and its first-motion test.
#include <cstdio>
#include <exception>

#include "haptic_core/base/program_version.h"
#include "haptic_core/spidar/device_check.h"
#include "spidar_driver/transport/board_promise.h"
#include "spidar_driver/transport/last_command.h"

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "device_check")) return 0;
  if (argc != 2) {
    std::fputs("usage: device_check FILE\nexit code: 0 nothing wrong, 1 problems found, 2 refused\n", stderr);
    return 2;
  }
  try {
    const haptic::DeviceDef def = haptic::loadDevice(argv[1]);
    const haptic::DeviceReport report = haptic::examineDevice(def);
    std::fputs(haptic::checkDevice(def).c_str(), stdout);
    const haptic::LastCommand last = haptic::lastCommand(def);
    const haptic::BoardPromise promise = haptic::boardPromise(def);
    if (!promise.text.empty()) std::printf("boards that do not obey:\n%s", promise.text.c_str());
    std::printf("when driver and motor guard end at once, or the host does:\n%s", last.text.c_str());
    std::printf("figure check.strings %zu 1\n", def.strings.size());
    std::printf("figure check.presentable_force_n %.6g N\n", report.presentable_force);
    std::printf("figure check.presentable_torque_nm %.6g N·m\n", report.presentable_torque);
    std::printf("figure check.fault_energy_mj %.6g mJ\n", 1e3 * haptic::faultEnergy(def));
    std::printf("figure check.table_unseen_ms %.6g ms\n", 1e3 * promise.table_s);
    std::printf("figure check.silence_is_zero %d 1\n", last.ends ? 1 : 0);
    std::printf("figure check.feasible_share %.6g 1\n", report.feasible_share);
    std::printf("figure check.problems %zu 1\n", report.problems.size());
    return report.problems.empty() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "device_check: %s\n", error.what());
    return 2;
  }
}
