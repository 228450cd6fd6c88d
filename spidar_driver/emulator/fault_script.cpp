#include "spidar_driver/emulator/fault_script.h"

#include <algorithm>
#include <random>
#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {

const char* const kOrderHelp =
    "orders, bytes:   drop N, corrupt N, duplicate N, insert N; rate_drop P, rate_corrupt P, rate_duplicate P,\n"
    "                 rate_insert P (of each byte); with board_ in front: on the way to the boards\n"
    "orders, answers: delay N MS, lose N, double N, swap N, replay N (cycles late);\n"
    "                 latency MS, drift MS_PER_S, burst MS (0: none)\n"
    "orders, boards:  kill ID, revive ID, reset ID (brown-out), forget ID (and its counters at 0), stuck ID, moving ID,\n"
    "                 deaf ID, table ID COMMAND LENGTH, disobey ID, obey ID, mode ID MODE (0: free)\n"
    "orders, strings: slack S METRES, slip S COUNTS, jump S COUNTS, freeze S, snap S, mend S\n"
    "orders, others:  unplug, plug, hand NAME, drive (says whether a motor has current), quit\n";

namespace {

constexpr int kDeafLength = 255;  // longest length that a byte of a table can hold

struct Order {
  std::string verb;
  double a = 0, b = 0, c = 0;
  int numbers = 0;
  int i() const { return static_cast<int>(a); }
};

/// drop, corrupt, duplicate, insert, and their rates.
bool byteFault(const Order& o, ByteFaults& faults) {
  if (o.verb == "drop") return faults.drop(o.i()), true;
  if (o.verb == "corrupt") return faults.corrupt(o.i()), true;
  if (o.verb == "duplicate") return faults.duplicate(o.i()), true;
  if (o.verb == "insert") return faults.insert(o.i()), true;
  if (o.verb == "rate_drop") return faults.rates.drop = o.a, true;
  if (o.verb == "rate_corrupt") return faults.rates.corrupt = o.a, true;
  if (o.verb == "rate_duplicate") return faults.rates.duplicate = o.a, true;
  if (o.verb == "rate_insert") return faults.rates.insert = o.a, true;
  return false;
}

bool stringFault(const Order& o, TwinPlant& plant) {
  if (o.verb == "slack") return plant.slacken(o.i(), o.b), true;
  if (o.verb == "slip" || o.verb == "jump") return plant.slip(o.i(), static_cast<int>(o.b)), true;
  if (o.verb == "freeze") return plant.freeze(o.i()), true;
  if (o.verb == "snap") return plant.snap(o.i()), true;
  if (o.verb == "mend") return plant.mend(o.i()), true;
  return false;
}

bool answerFault(const Order& o, BoardBusEmulator& bus) {
  const auto ns = [](double ms) { return static_cast<std::int64_t>(ms * 1e6); };
  AdapterDelay adapter = bus.adapter();
  if (o.verb == "delay") return bus.delayReplies(o.i(), ns(o.b)), true;
  if (o.verb == "lose") return bus.loseReplies(o.i()), true;
  if (o.verb == "double") return bus.doubleReplies(o.i()), true;
  if (o.verb == "swap") return bus.swapReplies(o.i()), true;
  if (o.verb == "replay") return bus.replayReplies(std::max(0, o.i())), true;
  if (o.verb == "latency") return adapter.constant_ns = ns(o.a), adapter.drift = 0, bus.setAdapter(adapter), true;
  if (o.verb == "drift") return adapter.drift = o.a * 1e-3, bus.setAdapter(adapter), true;
  if (o.verb == "burst") return adapter.burst_ns = ns(o.a), bus.setAdapter(adapter), true;
  return false;
}

bool boardFault(const Order& o, EmulatedBoard& board) {
  if (o.verb == "kill" || o.verb == "revive") return board.setPower(o.verb == "revive"), true;
  if (o.verb == "reset" || o.verb == "forget") return board.reset(o.verb == "forget"), true;
  if (o.verb == "stuck" || o.verb == "moving") return board.setStuck(o.verb == "stuck"), true;
  if (o.verb == "disobey" || o.verb == "obey") return board.setObeys(o.verb == "obey"), true;
  if (o.verb == "mode") return board.holdMode(static_cast<int>(o.b)), true;
  if (o.verb == "deaf") return board.spoilTable(board.id(), BoardCommand::kCurrent, kDeafLength), true;
  if (o.verb != "table" || o.b < 1 || o.b >= kBoardCommands) return false;
  return board.spoilTable(board.id(), static_cast<BoardCommand>(static_cast<int>(o.b)), static_cast<int>(o.c)), true;
}

std::string boardOrder(const Order& o, const std::string& text, BoardBusEmulator& bus) {
  static const char* const verbs[] = {"kill",  "revive",  "reset", "forget", "stuck",
                                      "moving", "disobey", "obey",  "deaf",   "table", "mode"};
  if (std::find(std::begin(verbs), std::end(verbs), o.verb) == std::end(verbs)) return "'" + text + "': unknown order";
  EmulatedBoard* board = bus.board(o.i());
  if (!board) return "'" + text + "': no board has this id";
  return boardFault(o, *board) ? "" : "'" + text + "': unknown, or lacks a number";
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
  Order o;
  in >> o.verb;
  const std::string to_boards = "board_";
  if (o.verb == "quit") return stop = true, "";
  if (o.verb == "drive") {
    std::printf("drive %s\n", bus.allCurrentsZero() ? "off" : "on");
    std::fflush(stdout);
    return "";
  }
  if (o.verb == "hand") {
    std::string name;
    in >> name;
    try {
      return plant.setHand(handPath(name)), "";
    } catch (const SetupError& error) {
      return error.what();
    }
  }
  if (o.verb == "unplug" || o.verb == "plug") {
    if (!line) return o.verb + ": this line has no plug";
    return o.verb == "plug" ? line->plug() : line->unplug(), "";
  }
  for (double* number : {&o.a, &o.b, &o.c}) o.numbers += static_cast<bool>(in >> *number);
  if (o.numbers == 0) return "'" + order + "': unknown, or lacks a number";
  if (o.verb.rfind(to_boards, 0) == 0) {
    o.verb.erase(0, to_boards.size());
    return byteFault(o, bus.to_boards) ? "" : "'" + order + "': unknown order";
  }
  if (byteFault(o, bus.to_host) || stringFault(o, plant) || answerFault(o, bus)) return "";
  return boardOrder(o, order, bus);
}

std::vector<TimedFault> randomFaults(unsigned seed, int count, double seconds, int strings,
                                     const std::vector<int>& boards) {
  constexpr double kUndoneAfter = 0.3;  // [s]
  std::mt19937 random(seed);
  const auto pick = [&random](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<TimedFault> faults;
  for (int k = 0; k < count; ++k) {
    const double time = seconds * (1e-6 * pick(1000000));
    const std::string n = " " + std::to_string(1 + pick(4)), s = " " + std::to_string(pick(strings));
    const std::string id = " " + std::to_string(boards[static_cast<std::size_t>(pick(static_cast<int>(boards.size())))]);
    const std::string jump = s + " " + std::to_string(pick(60000) - 30000), ms = " " + std::to_string(0.1 * pick(60));
    const std::pair<std::string, std::string> kinds[] = {
        {"drop" + n, ""},        {"corrupt" + n, ""},       {"duplicate" + n, ""},   {"insert" + n, ""},
        {"board_drop" + n, ""},  {"board_corrupt" + n, ""}, {"board_insert" + n, ""}, {"delay" + n + ms, ""},
        {"lose" + n, ""},        {"double" + n, ""},        {"swap" + n, ""},        {"latency" + ms, "latency 0"},
        {"burst" + ms, "burst 0"}, {"kill" + id, "revive" + id}, {"reset" + id, ""}, {"forget" + id, ""},
        {"stuck" + id, "moving" + id}, {"deaf" + id, ""},   {"jump" + jump, ""},     {"freeze" + s, "mend" + s},
        {"table" + id + " " + std::to_string(1 + pick(11)) + " " + std::to_string(pick(256)), ""}};
    const auto& kind = kinds[pick(static_cast<int>(std::size(kinds)))];
    faults.push_back({time, kind.first});
    if (!kind.second.empty()) faults.push_back({time + kUndoneAfter, kind.second});
  }
  std::stable_sort(faults.begin(), faults.end(),
                   [](const TimedFault& a, const TimedFault& b) { return a.time < b.time; });
  return faults;
}

}  // namespace haptic
