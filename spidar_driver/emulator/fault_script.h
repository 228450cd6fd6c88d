/// Faults by name, for the command line and the control pipe of the board emulator. kOrderHelp lists them.
#pragma once
#include <string>
#include <vector>

#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/emulator/twin_plant.h"

namespace haptic {

struct TimedFault {
  double time = 0;  ///< [s] after the start
  std::string order;
};

extern const char* const kOrderHelp;  ///< every order with what it does, one line each

/// `count` faults of all kinds at random instants within `seconds`; the same `seed` gives the same ones. What would last
/// for ever is undone 0.3 s later. `strings` and `boards` (ids) are those of the device.
std::vector<TimedFault> randomFaults(unsigned seed, int count, double seconds, int strings,
                                     const std::vector<int>& boards);

/// "2.5 kill 1". Throws SetupError when there is no time or no order.
TimedFault parseTimedFault(const std::string& line);

/// Empty when the order was carried out, else what is wrong with it. `quit` sets `stop`.
std::string carryOut(const std::string& order, BoardBusEmulator& bus, TwinPlant& plant, PtyLine* line,
                     bool& stop);

}  // namespace haptic
