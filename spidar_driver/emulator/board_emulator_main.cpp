// spidar_board_emulator: motor boards with a SPIDAR's twin behind them, on a pseudo-terminal.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/program_version.h"
#include "spidar_driver/emulator/fault_script.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr char kUsage[] =
    "usage: spidar_board_emulator --device FILE [OPTIONS]\n"
    "  --device FILE     device description; its `boards` are emulated, with ids 1, 2, ...\n"
    "  --boards LIST     other boards or ids: B3M:1,B3M:4\n"
    "  --link PATH       symbolic link to the pseudo-terminal, removed at the end\n"
    "  --hand NAME       motion of the twin's hand from the first drive on: rest, press, touch_cube, wave\n"
    "  --wire-time       deliver replies when a 2 Mbaud line would, not at once\n"
    "  --fault 'T ORDER' carry out an order T seconds after the start (may be repeated), e.g. '2.5 kill 1'\n"
    "  --script FILE     such lines from a file, # starts a comment\n"
    "  --control PATH    make a named pipe and carry out the orders written to it, one per line\n"
    "  --seconds N       end after N seconds\n"
    "  --random N,SEED   N faults of all kinds at random instants within --seconds (60)\n";

volatile sig_atomic_t g_interrupted = 0;  // the one thing a signal handler may touch
void interrupted(int) {
  g_interrupted = 1;
}

struct Options {
  std::string device, boards, link, hand = "rest", control;
  std::vector<TimedFault> faults;
  double seconds = 0;  // 0: until it is stopped
  int random = 0;      // faults
  unsigned seed = 1;
  bool wire_time = false, help = false;
};

void readScript(const std::string& path, Options& options) {
  std::ifstream file(path);
  if (!file) throw SetupError(path, "cannot be read", "check --script");
  for (std::string line; std::getline(file, line);) {
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t") != std::string::npos) options.faults.push_back(parseTimedFault(line));
  }
}

void readRandom(const std::string& value, Options& options) {
  if (std::sscanf(value.c_str(), "%d,%u", &options.random, &options.seed) < 1 || options.random < 1)
    throw SetupError("--random", "'" + value + "' is no number of faults", "write N or N,SEED");
}

Options parse(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--wire-time") {
      o.wire_time = true;
      continue;
    }
    if (name == "--help" || name == "-h") {
      o.help = true;
      continue;
    }
    if (i + 1 == argc) throw SetupError(name, "unknown option, or its value is missing", "see --help");
    const std::string value = argv[++i];
    if (name == "--device")
      o.device = value;
    else if (name == "--boards")
      o.boards = value;
    else if (name == "--link")
      o.link = value;
    else if (name == "--hand")
      o.hand = value;
    else if (name == "--control")
      o.control = value;
    else if (name == "--fault")
      o.faults.push_back(parseTimedFault(value));
    else if (name == "--script")
      readScript(value, o);
    else if (name == "--random")
      readRandom(value, o);
    else if (name == "--seconds")
      o.seconds = std::atof(value.c_str());
    else
      throw SetupError(name, "unknown option", "see --help");
  }
  if (o.device.empty() && !o.help)
    throw SetupError("--device", "is missing", "give a device description, see --help");
  std::stable_sort(o.faults.begin(), o.faults.end(),
                   [](const TimedFault& a, const TimedFault& b) { return a.time < b.time; });
  return o;
}

void addBoards(const Options& options, const DeviceDef& device, BoardBusEmulator& bus) {
  if (options.boards.empty()) {
    if (device.boards.empty())
      throw SetupError(device.file, "names no boards", "give them with --boards, as B5M:1");
    int id = 1;
    for (const std::string& model : device.boards) bus.addBoard(model, id++);
    return;
  }
  for (std::size_t at = 0; at < options.boards.size();) {
    const std::size_t end = std::min(options.boards.find(',', at), options.boards.size());
    const std::string item = options.boards.substr(at, end - at);
    const std::size_t colon = item.find(':');
    if (colon == std::string::npos)
      throw SetupError("--boards", "'" + item + "' has no id", "write MODEL:ID");
    bus.addBoard(item.substr(0, colon), std::atoi(item.c_str() + colon + 1));
    at = end + 1;
  }
}

void addRandomFaults(const DeviceDef& device, const BoardBusEmulator& bus, Options& options) {
  if (options.random == 0) return;
  constexpr double kSeconds = 60;
  std::vector<int> ids;
  for (const auto& b : bus.boards()) ids.push_back(b->id());
  const auto faults = randomFaults(options.seed, options.random, options.seconds > 0 ? options.seconds : kSeconds,
                                   static_cast<int>(device.strings.size()), ids);
  options.faults.insert(options.faults.end(), faults.begin(), faults.end());
  std::stable_sort(options.faults.begin(), options.faults.end(),
                   [](const TimedFault& a, const TimedFault& b) { return a.time < b.time; });
}

/// A named pipe to which anyone may write orders; it is removed at the end.
class ControlPipe {
 public:
  explicit ControlPipe(const std::string& path) : path_(path) {
    if (path.empty()) return;
    ::unlink(path.c_str());
    // Opened for writing as well: it then has no end of file when a writer leaves.
    if (::mkfifo(path.c_str(), 0600) != 0 ||
        (fd_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) < 0)
      throw SetupError(path, std::strerror(errno), "give another path to --control");
  }
  ~ControlPipe() {
    if (fd_ < 0) return;
    ::close(fd_);
    ::unlink(path_.c_str());
  }
  int descriptor() const { return fd_; }
  /// The complete lines that came.
  std::vector<std::string> lines() {
    char in[512];
    for (ssize_t got; fd_ >= 0 && (got = ::read(fd_, in, sizeof in)) > 0;)
      text_.append(in, static_cast<std::size_t>(got));
    std::vector<std::string> complete;
    for (std::size_t end; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1))
      complete.push_back(text_.substr(0, end));
    return complete;
  }

 private:
  std::string path_, text_;
  int fd_ = -1;
};

void serve(const Options& options, BoardBusEmulator& bus, TwinPlant& plant, PtyLine& line) {
  ControlPipe control(options.control);
  std::printf("port %s\n", line.path().c_str());
  std::fflush(stdout);
  const std::int64_t start = steadyNanoseconds();
  std::size_t next = 0;
  bool stop = false;
  const auto order = [&](const std::string& text) {
    const std::string error = carryOut(text, bus, plant, &line, stop);
    std::fprintf(stderr, "%s%s\n",
                 error.empty() ? "did " : "error: ", error.empty() ? text.c_str() : error.c_str());
  };
  while (!stop && !g_interrupted) {
    const double time = static_cast<double>(steadyNanoseconds() - start) * 1e-9;
    if (options.seconds > 0 && time >= options.seconds) break;
    for (; next < options.faults.size() && options.faults[next].time <= time; ++next)
      order(options.faults[next].order);
    line.serve(5, control.descriptor());
    for (const std::string& text : control.lines()) order(text);
  }
}

void printSummary(const BoardBusEmulator& bus, const PtyLine& line) {
  std::printf("received %llu bytes, %llu collisions\n", static_cast<unsigned long long>(line.bytesReceived()),
              static_cast<unsigned long long>(bus.collisions()));
  for (const auto& b : bus.boards())
    std::printf("board %d %s: %llu CURRENT commands\n", b->id(), b->shape().name,
                static_cast<unsigned long long>(b->executed(BoardCommand::kCurrent)));
  std::printf("currents at the end: %s\n", bus.allCurrentsZero() ? "zero" : "NOT zero");
}

int run(int argc, char** argv) {
  Options options = parse(argc, argv);
  if (options.help) return std::fputs(kUsage, stdout), std::fputs(kOrderHelp, stdout), 0;
  const DeviceDef device = loadDevice(options.device);
  TwinSettings twin;
  twin.path = handPath(options.hand);
  TwinPlant plant(device, twin);
  BoardBusEmulator bus(plant);
  addBoards(options, device, bus);
  addRandomFaults(device, bus, options);
  struct sigaction action {};
  action.sa_handler = interrupted;
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(s, &action, nullptr);
  PtyLine line(bus, options.link, options.wire_time);
  serve(options, bus, plant, line);
  printSummary(bus, line);
  return 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "spidar_board_emulator")) return 0;
  try {
    return haptic::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "spidar_board_emulator: %s\n", error.what());
    return 1;
  }
}
