#include "spidar_driver/device_answer.h"

#include <thread>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

// Ten ticks of the slowest rate are 0.1 s; boards that come back need half a second. Longer is a hang to who
// waits.
constexpr std::chrono::milliseconds kPatience{1000}, kPoll{1};

}  // namespace

DeviceAnswer askDevice(DevicePort& port, PortOffer& offer, const DeviceRequests& requests) {
  DeviceAnswer answer;
  if (offer.holder().empty()) {
    answer.message = "nothing was done: nobody runs the device; start a bridge, or set ~alone";
    return answer;
  }
  const LoopCommand command{AskDevice{requests}};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  std::string refusal = "the device does not tick";
  bool again = true;
  while (!answer.done && again) {
    again = std::chrono::steady_clock::now() < deadline;
    try {
      answer.done = offer.send(port, Tell{&command}, kPatience);
      again = false;
    } catch (const SetupError& error) {
      refusal = error.what();
      std::this_thread::sleep_for(kPoll);
    }
  }
  // Carried out in a later tick: the one that did what was asked is over by then.
  const bool read = offer.send(port, DevicePort::Copy{&answer.after}, kPatience);
  const std::string state = !read ? "the device does not tick"
                                  : stateName(answer.after.record) + (": " + standing(answer.after.record, port.device.def().name));
  answer.message = answer.done ? state : "nothing was done, " + refusal + "; " + state;
  answer.done = answer.done && read;
  return answer;
}

}  // namespace haptic
