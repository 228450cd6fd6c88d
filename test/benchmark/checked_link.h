/// The UART cycle compared byte for byte with layouts written out here, apart from the driver's own.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/spidar/device_def.h"

namespace haptic::bench {

struct CycleCheck {
  long ok = 0, wrong = 0;
  long marks = 0;  ///< cycles with BOARD_INFO behind them
};

/// `cycles` exchanges with changing currents and positions on boards of these models. A cycle is ok when
/// every byte sent and every byte received is the layout's, and the counts and currents arrive.
CycleCheck checkCycles(const std::vector<std::string>& models, long cycles);

/// Exchanges per second of the line's clock when they are asked for without a pause [Hz].
double highestRate(const DeviceDef& device);

}  // namespace haptic::bench
