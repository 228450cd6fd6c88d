/// Faults by name, for the command line and the control pipe of the board emulator.
///
///   drop N · corrupt N · duplicate N · insert N     bytes on the way to the host (`board_` before it: to the
///   boards) delay N MS                                      the next N replies come that much later kill ID
///   · revive ID                             power of one board unplug · plug the cable slack S METRES · slip
///   S COUNTS · freeze S · snap S · mend S      one string hand NAME starts a motion of the hand (rest,
///   press, touch_cube, wave) drive (says whether a motor has current: 'drive on') quit
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

/// "2.5 kill 1". Throws SetupError when there is no time or no order.
TimedFault parseTimedFault(const std::string& line);

/// Empty when the order was carried out, else what is wrong with it. `quit` sets `stop`.
std::string carryOut(const std::string& order, BoardBusEmulator& bus, TwinPlant& plant, PtyLine* line,
                     bool& stop);

}  // namespace haptic
