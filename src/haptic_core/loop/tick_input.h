/// Everything that one tick of the loop depends on beside its own memory: what a recording keeps and a replay gives back.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/spidar/device_requests.h"
#include "haptic_core/spidar/transport.h"

namespace haptic {

inline constexpr int kMaxHands = 4;

/// How the workspace map takes up a difference between the grip's place and the pointer's.
enum class Rebase : unsigned char {
  kNone,
  kKeep,   ///< the pointer stays where it is and moves on from there (a body was grabbed)
  kGlide,  ///< the pointer starts where it is and glides to the grip's place (reset, restore, load)
};

/// What other threads asked of one hand.
struct HandRequests {
  bool clutch = false;      ///< held: the pointer stands, the grip moves freely
  bool soft_start = false;  ///< the force fades in anew
  Rebase rebase = Rebase::kNone;
};

struct HandInput {
  DeviceSample sample;
  DeviceRequests device;
  HandRequests hand;
};

struct TickInput {
  std::uint64_t tick = 0;  ///< index since the start
  int lost_periods = 0;    ///< ticks that were lost before this one: simulated time has waited
  bool paused = false;     ///< the world stands, the devices live on at minimum tension
  int hands = 0;
  std::array<HandInput, kMaxHands> hand;
};

}  // namespace haptic
