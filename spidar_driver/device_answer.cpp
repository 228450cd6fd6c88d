#include "spidar_driver/device_answer.h"

#include <thread>

namespace haptic {
namespace {

// Ten ticks of the slowest rate are 0.1 s; boards that come back need half a second. Longer is a hang to who
// waits.
constexpr std::chrono::milliseconds kPatience{1000}, kPoll{1};

}  // namespace

DeviceAnswer askDevice(Spidar& device, PortOffer& offer, const std::function<void(Spidar&)>& request) {
  DeviceAnswer answer;
  if (offer.holder().empty()) {
    answer.message = "nothing was done: nobody runs the device; start a bridge, or set ~alone";
    return answer;
  }
  request(device);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (device.requestsPending() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(kPoll);
  const bool withdrawn = device.withdrawRequests();
  // Served between two ticks: the tick that took the request up is over by then.
  const bool read = offer.runBetweenTicks([&] { answer.after = recordOf(device, 0, 0, {}); });
  const std::string state =
      !read ? "the device does not tick"
            : toString(answer.after.state) + (": " + standing(answer.after, device.def().name));
  answer.done = read && !withdrawn;
  answer.message = withdrawn ? "nothing was done, no fresh counts came within a second; " + state : state;
  return answer;
}

}  // namespace haptic
