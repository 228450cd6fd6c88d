#include "spidar_driver/transport/board_promise.h"

#include <cmath>
#include <cstdio>

#include "spidar_driver/transport/board_lesson.h"
#include "spidar_driver/transport/board_model.h"

namespace haptic {
namespace {

constexpr double kWaits = 2e-3;  // [s]: a lesson waits for the answers of two exchanges at most

}  // namespace

BoardPromise boardPromise(const DeviceDef& device) {
  BoardPromise promise;
  promise.table_s = device.boards.empty() ? 0 : 1e-9 * static_cast<double>(BoardLesson::kEveryNs) + kWaits;
  std::string before;
  for (const std::string& name : device.boards) {
    const BoardShape* shape = findBoardModel(name);
    const bool tells = shape && shape->currents > 0;
    promise.tells_currents = promise.tells_currents && tells;
    if (name == before) continue;
    before = name;
    char text[240];
    std::snprintf(text, sizeof text,
                  "%s: a spoilt length table keeps it from its currents for %ld ms at most, unsaid; %s\n", name.c_str(),
                  std::lround(1e3 * promise.table_s),
                  tells ? "that it ignores currents which change it tells within 0.2 s"
                        : "it cannot tell that it ignores its currents: watch the grip");
    promise.text += text;
  }
  return promise;
}

}  // namespace haptic
