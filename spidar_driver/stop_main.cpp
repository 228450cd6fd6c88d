// spidar_stop [DEVICE]: STOP to the devices of this user on this machine, all or one, without a master.
#include <cstdio>
#include <cstring>

#include "haptic_core/base/program_version.h"
#include "haptic_core/loop/stop_channel.h"

namespace {

// A device answers after two ticks; one that does not has lost its current to the motor guard, or needs its power cut.
constexpr std::chrono::milliseconds kPatience{1000};

}  // namespace

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "spidar_stop")) return 0;
  if (argc > 2 || (argc == 2 && argv[1][0] == '-')) {
    std::fputs("usage: spidar_stop [DEVICE]\nexit code: 0 the motors are off, 1 a device does not answer, 2 no device runs\n", stderr);
    return 2;
  }
  const auto stopped = haptic::sayStop(haptic::stopSockets(argc == 2 ? argv[1] : ""), kPatience);
  bool off = true;
  for (const haptic::Stopped& device : stopped) {
    off = off && device.answer.off;
    std::fprintf(device.answer.off ? stdout : stderr, "%s%s\n", device.answer.off ? "" : (device.socket + ": ").c_str(),
                 device.answer.message.c_str());
  }
  if (stopped.empty()) {
    std::fprintf(stderr, "stop: no device%s%s of this user runs on this machine; if motors pull, cut their power\n", argc == 2 ? " " : "",
                 argc == 2 ? argv[1] : "");
    return 2;
  }
  return off ? 0 : 1;
}
