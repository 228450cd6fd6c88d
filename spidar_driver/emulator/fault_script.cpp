#include "spidar_driver/emulator/fault_script.h"

#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// drop, corrupt, duplicate, insert.
bool byteFault(const std::string& verb, int bytes, ByteFaults& faults) {
  if (verb == "drop") return faults.drop(bytes), true;
  if (verb == "corrupt") return faults.corrupt(bytes), true;
  if (verb == "duplicate") return faults.duplicate(bytes), true;
  if (verb == "insert") return faults.insert(bytes), true;
  return false;
}

bool stringFault(const std::string& verb, int string, double value, TwinPlant& plant) {
  if (verb == "slack") return plant.slacken(string, value), true;
  if (verb == "slip") return plant.slip(string, static_cast<int>(value)), true;
  if (verb == "freeze") return plant.freeze(string), true;
  if (verb == "snap") return plant.snap(string), true;
  if (verb == "mend") return plant.mend(string), true;
  return false;
}

}  // namespace

TimedFault parseTimedFault(const std::string& line) {
  std::istringstream in(line);
  TimedFault fault;
  if (!(in >> fault.time) || !std::getline(in >> std::ws, fault.order) || fault.order.empty())
    throw SetupError("fault '" + line + "'", "is not a time and an order", "write it as '2.5 kill 1'");
  return fault;
}

std::string carryOut(const std::string& order, BoardBusEmulator& bus, TwinPlant& plant, PtyLine* line,
                     bool& stop) {
  std::istringstream in(order);
  std::string verb, word;
  in >> verb >> word;
  const double first = std::atof(word.c_str());
  double second = 0;
  in >> second;
  const int number = static_cast<int>(first);
  const std::string to_boards = "board_";
  if (verb == "quit") return stop = true, "";
  if (verb == "drive") {
    std::printf("drive %s\n", bus.allCurrentsZero() ? "off" : "on");
    std::fflush(stdout);
    return "";
  }
  if (verb == "hand") {
    try {
      return plant.setHand(handPath(word)), "";
    } catch (const SetupError& error) {
      return error.what();
    }
  }
  if (verb == "unplug" || verb == "plug") {
    if (!line) return verb + ": this line has no plug";
    return verb == "plug" ? line->plug() : line->unplug(), "";
  }
  if (word.empty()) return "'" + order + "': unknown, or lacks a number";
  if (verb == "kill" || verb == "revive") {
    EmulatedBoard* board = bus.board(number);
    if (!board) return "'" + order + "': no board has this id";
    return board->setPower(verb == "revive"), "";
  }
  if (verb == "delay") return bus.delayReplies(number, static_cast<std::int64_t>(second * 1e6)), "";
  if (byteFault(verb, number, bus.to_host) || stringFault(verb, number, second, plant)) return "";
  if (verb.rfind(to_boards, 0) == 0 && byteFault(verb.substr(to_boards.size()), number, bus.to_boards))
    return "";
  return "'" + order + "': unknown order";
}

}  // namespace haptic
