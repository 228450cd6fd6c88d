#include "spidar_driver/transport/last_command.h"

#include <algorithm>
#include <cstdio>

#include "spidar_driver/transport/board_model.h"

namespace haptic {
namespace {

/// B5M: its current mode passes by both limits. Others: the factory's heat model, which flash may hold otherwise.
std::string ofBoard(const std::string& name) {
  const BoardShape* shape = findBoardModel(name);
  if (!shape) return name + " is not known";
  if (shape->model == BoardModel::kB5M) return "B5M keeps its last current for ever; its torque limit and heat model do not bind it";
  return name + " keeps its last current; its heat model limits full current after 20 s as the factory sets it, and never ends it";
}

double strongest(const DeviceDef& device) {
  double tension = 0;
  for (const StringDef& string : device.strings) tension = std::max(tension, string.max_tension);
  return tension;
}

}  // namespace

LastCommand lastCommand(const DeviceDef& device) {
  if (device.transport == "twin") return {true, "the device is simulated: it ends with its program\n"};
  std::string text;
  std::string before;
  for (const std::string& board : device.boards) {
    if (board != before) text += ofBoard(board) + "\n";
    before = board;
  }
  if (device.transport == "usb_sh4" || device.transport == "usb_simple")
    text = "the USB amplifier keeps its last voltage, as far as is known, and no motor guard holds it\n";
  else if (text.empty())
    text = "the file names no boards: every known one keeps its last current\n";
  char bound[160];
  std::snprintf(bound, sizeof bound,
                "then a string pulls with up to %.1f N until the motors' supply is cut: keep a switch for it in reach\n",
                strongest(device));
  return {false, text + bound};
}

}  // namespace haptic
