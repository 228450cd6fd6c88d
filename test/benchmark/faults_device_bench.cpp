// Faults of the second round, on whole emulated devices: boards that do not obey, counters that stand still, what a fault leaves on
// the hand, whether the right cause is named while this machine is late, and starts on a busy machine.
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "fault_campaign.h"
#include "fault_rig.h"
#include "figure.h"
#include "haptic_core/spidar/device_record.h"
#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/transport/open_transport.h"

namespace haptic::bench {
namespace {

constexpr int kTrials = 12;      // per fault, board and device
constexpr int kTableTrials = 3;  // of them for each of 17 lengths
constexpr int kPatience = 2000;  // ticks
const char* const kDevices[] = {"spidar_g6x5r", "spidar_g6x4"};

DeviceDef load(const std::string& name) { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml"); }

/// A device in hard use; every fault begins with it enabled.
struct Session {
  Session(const char* device, unsigned seed) : rig(load(device)), random(seed) {}
  bool prepare() {
    for (const auto& board : rig.bus.boards()) board->replace(), board->setObeys(true), board->setStuck(false);
    rig.bus.replayReplies(0);
    if (!rig.bringUp()) return false;
    rig.setHand(hardUse(random(), 4));
    ticks = 0;
    const int lead = 200 + static_cast<int>(random() % 300);
    for (int k = 0; k < lead; ++k) move();
    return rig.enabled();
  }
  void move() {
    rig.command = hardCommand(FaultRig::kPeriod * ++ticks);
    rig.tick();
  }
  /// Ticks until the device is not enabled; kPatience: never.
  int unseen() {
    return unseen([] { return true; });
  }
  /// Likewise, and no more than the fault lasts.
  template <class Lasts>
  int unseen(Lasts&& lasts) {
    for (int k = 1; k <= kPatience; ++k)
      if (move(); !rig.enabled() || !lasts()) return k;
    return kPatience;
  }
  Vector3 grip() const { return rig.plant.twin().pose().X_BG.p; }
  /// Of the tensions that were told, on the true pose [N].
  double netForce() const {
    const GripPose& pose = rig.plant.twin().pose();
    return (rig.spidar.kinematics().structure(pose).leftCols(3).transpose() * rig.spidar.toldTension()).norm();
  }
  FaultRig rig;
  std::mt19937 random;
  int ticks = 0;
};

void obedience() {
  double table = 0, mode = 0, current = 0;
  int tables = 0, skipped = 0, healed = 0, healed_after = 0;
  for (const char* name : kDevices) {
    Session s(name, 1);
    const int boards = static_cast<int>(s.rig.bus.boards().size());
    double current_here = 0;
    for (int n = 0; n < kTrials * boards; ++n) {
      const int id = 1 + n % boards;
      for (int row = 1; row <= boards && n < kTableTrials * boards; ++row)
        for (int length = 0; length <= 16; ++length) {
          EmulatedBoard& board = *s.rig.bus.board(id);
          if (length == commandBytes(s.rig.bus.board(row)->shape(), BoardCommand::kCurrent)) continue;  // it is right
          if (!s.prepare()) { ++skipped; continue; }
          board.spoilTable(row, BoardCommand::kCurrent, length);
          const int unseen = s.unseen([&] { return board.tableLength(row, BoardCommand::kCurrent) == length; });
          if (s.rig.enabled() && unseen < kPatience) {  // a lesson went out, by itself, and taught the board right again
            ++healed;
            healed_after = std::max(healed_after, unseen);
          }
          if (unseen > 50) std::printf("%s: board %d cuts CURRENT of board %d to %d bytes: %d ms\n", name, id, row, length, unseen);
          table = std::max(table, static_cast<double>(unseen));
          ++tables;
        }
      if (s.prepare()) {
        s.rig.bus.board(id)->holdMode(static_cast<int>(BoardMode::kDirect));
        mode = std::max(mode, static_cast<double>(s.unseen()));
        s.rig.bus.board(id)->holdMode(0);
      } else {
        ++skipped;
      }
      if (s.prepare()) {
        s.rig.bus.board(id)->setObeys(false);
        current_here = std::max(current_here, static_cast<double>(s.unseen()));
      } else {
        ++skipped;
      }
    }
    figure((std::string("obey.current_unseen_ms_max_") + (boards == 1 ? "b5m" : "b3m")).c_str(), current_here, "ms");
    if (s.rig.bus.boards().front()->shape().currents > 0) current = std::max(current, current_here);  // it can tell
  }
  figure("obey.tables", tables, "1");
  figure("obey.tables_healed", healed, "1");
  figure("obey.healed_after_ms_max", healed_after, "ms");
  figure("obey.skipped", skipped, "1");
  figure("obey.mode_unseen_ms_max", mode, "ms");
  figure("obey.table_unseen_ms_max", std::max(table, mode), "ms");
  figure("obey.current_unseen_ms_max", current, "ms");
}

/// From the first old reply with the grip at 20 mm/s, or the force changing by 1 N/s, to a state other than ENABLED.
void replayed() {
  double unseen = 0;
  int trials = 0, at_rest = 0;
  for (const char* name : kDevices) {
    Session s(name, 4);
    for (int n = 0; n < 2 * kTrials; ++n)
      for (const int cycles : {1, 2, 5, 20, 50, 200}) {
        if (!s.prepare()) continue;
        s.rig.bus.replayReplies(cycles);
        int since = 0;
        Vector3 force = s.rig.spidar.achievedWrench().force;
        for (int k = 1; k <= kPatience && s.rig.enabled(); ++k) {
          s.move();
          const Vector3 change = s.rig.spidar.achievedWrench().force - force;
          force += change;
          const bool tells = s.rig.plant.twin().twist().linear.norm() >= 0.02 || change.norm() >= 1 * FaultRig::kPeriod;
          since += since > 0 || tells;
        }
        ++trials;
        at_rest += since == 0;
        if (since > 100) std::printf("%s: replies of %d cycles ago: %d ms\n", name, cycles, since);
        unseen = std::max(unseen, static_cast<double>(since));
      }
  }
  figure("replayed.trials", trials, "1");
  figure("replayed.at_rest", at_rest, "1");
  figure("replayed.unseen_ms_max", unseen, "ms");
}

/// Shafts at the home pose that remember the largest wrench of the tensions that no plain cycle would have made.
class WrenchPlant : public MotorPlant {
 public:
  explicit WrenchPlant(const DeviceDef& def) : def_(def), A_(StringKinematics(def).structure(GripPose{})) {}
  void advance(std::int64_t) override {}
  std::int32_t position(int) const override { return 0; }
  void drive(int channel, std::int16_t digit) override { digits[static_cast<std::size_t>(channel)] = digit; }
  /// Net force of what acts minus what is asked [N], both as digits.
  double offForce(const BoardCycle& cycle) const {
    Vector3 off = Vector3::Zero();
    for (std::size_t i = 0; i < def_.strings.size(); ++i) {
      const double tension = (digits[i] - cycle.digit(static_cast<int>(i))) * (3.3 / 4096) / def_.strings[i].volt_per_newton;
      off += tension * A_.row(static_cast<Eigen::Index>(i)).head<3>().transpose();
    }
    return off.norm();
  }
  std::array<std::int16_t, 64> digits{};

 private:
  DeviceDef def_;
  StructureMatrix A_;
};

/// Every device file on the boards that carry its strings, at tensions that change all the time: what is felt of lessons and questions.
void canaries() {
  double worst = 0;
  int devices = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices")) {
    if (entry.path().extension() != ".yaml") continue;
    for (const char* model : {"B5M", "B3M"}) {
      DeviceDef def = loadDevice(entry.path().string());
      const std::size_t motors = model[1] == '5' ? 8 : 4;
      def.boards.assign((def.strings.size() + motors - 1) / motors, model);
      def.transport = "uart";
      WrenchPlant plant(def);
      BoardBusEmulator bus(plant);
      std::vector<FoundBoard> found;
      for (const std::string& board : def.boards) {
        found.push_back({static_cast<int>(found.size()) + 1, findBoardModel(board)});
        bus.addBoard(board, found.back().id);
      }
      MemoryLine line(bus);
      UartBoards driver(def, {}, "memory", [&line] { return std::make_unique<MemoryLink>(line); });
      BoardCycle plain(def, {}, found);
      const std::int64_t start = line.now_ns;
      for (int k = 1; k <= 3000; ++k) {
        line.now_ns = std::max<std::int64_t>(line.now_ns, start + k * 1000000ll);
        DriveCommand command;
        for (std::size_t i = 0; i < def.strings.size(); ++i) {
          const StringDef& string = def.strings[i];
          const double share = 0.5 + 0.5 * std::sin(1e-3 * k * (3 + static_cast<double>(i)));
          command.voltage[i] = string.volt_per_newton * (string.min_tension + share * share * (string.max_tension - string.min_tension));
        }
        driver.exchange(command);
        plain.encode(command, true);
        if (k > 10) worst = std::max(worst, plant.offForce(plain));
      }
      ++devices;
    }
  }
  figure("canary.devices", devices, "1");
  figure("canary.net_force_n_max", worst, "N");
}

/// Only trials in which the grip went 5 mm and more within 100 ms: a grip that rests looks alike.
void frozen() {
  double unseen = 0;
  int trials = 0;
  for (const char* name : kDevices) {
    Session s(name, 2);
    const int boards = static_cast<int>(s.rig.bus.boards().size());
    for (int n = 0; n < 8 * kTrials; ++n) {
      if (!s.prepare()) continue;
      const Vector3 from = s.grip();
      const unsigned mask = boards == 1 ? 1 : 1 + static_cast<unsigned>(n) % 3;  // a board, the other, both
      for (int id = 1; id <= boards; ++id) s.rig.bus.board(id)->setStuck(mask >> (id - 1) & 1u);
      int seen = 0;
      double way = 0;
      for (int k = 1; k <= 100 || (!seen && way >= 5e-3 && k < kPatience); ++k) {
        s.move();
        if (k <= 100) way = std::max(way, (s.grip() - from).norm());
        if (!seen && !s.rig.enabled()) seen = k;
      }
      for (int id = 1; id <= boards; ++id) s.rig.bus.board(id)->setStuck(false);
      if (way < 5e-3) continue;
      ++trials;
      if (!seen || seen > 100)
        std::printf("%s: boards %x repeat their counts: %d ms, %.1f mm in 100 ms\n", name, mask, seen, 1e3 * way);
      unseen = std::max(unseen, seen ? static_cast<double>(seen) : kPatience);
    }
  }
  figure("frozen.trials", trials, "1");
  figure("frozen.unseen_ms_max", unseen, "ms");
}

/// Causes that are right for a kind of fault. A board that takes in one command in five may be called by each of these names.
const std::set<DeviceCause>& rightNames(const std::string& kind) {
  using C = DeviceCause;
  static const std::map<std::string, std::set<C>> names = {
      {"board off", {C::kBoardSilent}},
      {"brown-out", {C::kPowerLost, C::kBoardRestarted}},
      {"brown-out to 0", {C::kPowerLost, C::kBoardRestarted}},
      {"counters stuck", {C::kBoardRepeats, C::kCountersFrozen, C::kCountersStill}},
      {"deaf board", {C::kAnswersLost, C::kTableSpoilt, C::kBoardSilent, C::kCurrentsIgnored}},
      {"spoilt table", {C::kAnswersLost, C::kTableSpoilt, C::kBoardSilent, C::kForgets}},
      {"counter jumps", {C::kCounterJumped, C::kStringWrong, C::kStringDoubtful}},
      {"slip", {C::kCounterJumped, C::kStringWrong, C::kStringDoubtful}},
      {"slack", {C::kStringWrong, C::kStringDoubtful, C::kCounterJumped}},
      {"stuck string", {C::kStringWrong, C::kStringDoubtful, C::kCounterJumped}},
      {"broken string", {C::kStringWrong, C::kStringDoubtful, C::kCounterJumped}},
      {"unplugged", {C::kUnplugged}},
      {"latency", {C::kWireSlow, C::kBoardSilent}},
      {"late machine", {C::kLoopLate}},
      {"wrong mode", {C::kWrongMode}},
      {"disobeys", {C::kCurrentsIgnored}},
      {"old replies", {C::kCountsOld}}};
  static const std::set<C> none;
  const auto found = names.find(kind);
  return found == names.end() ? none : found->second;
}

struct Names {
  int right = 0, wrong = 0, unsaid = 0;
  double net_force = 0;
};

/// One fault, with or without load: ticks that come up to 4 ms late, and once in a while the machine stands still for 15 to 120 ms.
void nameOne(Session& s, const FaultKind& kind, bool load, Names& names) {
  if (!s.prepare()) return;
  const std::string order = kind.order(s.random, s.rig);
  s.rig.order(order);
  DeviceCause first = DeviceCause::kNone;
  int fault_ticks = 0;
  for (int k = 0; k < std::max(kind.patience, 900); ++k) {
    if (load && s.random() % 20 == 0) s.rig.stall(1e-3 * static_cast<double>(s.random() % 4));
    if (load && s.random() % 150 == 0) s.rig.stall(15e-3 + 1e-3 * static_cast<double>(s.random() % 105));
    s.move();
    const DeviceState state = s.rig.spidar.state();
    if (first == DeviceCause::kNone && s.rig.seriouslyAlarmed()) first = s.rig.spidar.cause();
    fault_ticks = state == DeviceState::kFault ? fault_ticks + 1 : 0;
    if (fault_ticks > 50) names.net_force = std::max(names.net_force, s.netForce());
  }
  if (kind.undo[0] != '\0') {
    const std::size_t target = order.find(' ');
    const bool rate = std::string(kind.undo) == order.substr(0, target);
    s.rig.order(kind.undo + (rate ? " 0" : target == std::string::npos ? "" : order.substr(target)));
  }
  for (int i = 0; i < 8; ++i) s.rig.order("mend " + std::to_string(i));
  if (first == DeviceCause::kNone) {
    ++names.unsaid;
    return;
  }
  const bool right = rightNames(kind.name).count(first) > 0;
  names.right += right;
  names.wrong += !right;
  if (!right) std::printf("# %s%s on %s: named \"%s\"\n", kind.name, load ? " under load" : "", s.rig.device.name.c_str(), toString(first));
}

void names() {
  Names all;
  std::map<std::string, std::pair<int, int>> by_kind;
  for (const char* name : kDevices) {
    Session s(name, 3);
    std::vector<FaultKind> kinds;
    for (const FaultKind& kind : faultKinds())
      if (!rightNames(kind.name).empty() && kind.name != std::string("unplugged")) kinds.push_back(kind);
    kinds.push_back({"late machine", [](std::mt19937&, const FaultRig&) { return std::string("hand wave"); }});
    kinds.push_back({"wrong mode", [](std::mt19937&, const FaultRig&) { return std::string("mode 1 2"); }, ""});
    kinds.push_back({"old replies", [](std::mt19937& r, const FaultRig&) { return "replay " + std::to_string(1 + r() % 20); }, ""});
    for (const FaultKind& kind : kinds)
      for (int n = 0; n < 2 * kTrials; ++n) {
        Names one;
        nameOne(s, kind, n % 2 == 1, one);
        s.rig.order("mode 1 0");
        s.rig.order("replay 0");
        all.right += one.right, all.wrong += one.wrong, all.unsaid += one.unsaid;
        all.net_force = std::max(all.net_force, one.net_force);
        by_kind[kind.name].first += one.right, by_kind[kind.name].second += one.wrong;
      }
  }
  for (const auto& [kind, count] : by_kind) std::printf("# %-18s right %d, wrong %d\n", kind.c_str(), count.first, count.second);
  figure("names.said", all.right + all.wrong, "1");
  figure("names.right_pct", 100.0 * all.right / std::max(1, all.right + all.wrong), "%");
  figure("fault.net_force_n_max", all.net_force, "N");
}

/// Four busy loops a core while it lives.
class BusyLoops {
 public:
  BusyLoops() {
    const int loops = 4 * static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    for (int i = 0; i < loops; ++i) {
      const pid_t child = ::fork();
      if (child == 0)
        for (volatile unsigned n = 0; ::getppid() != 1; ++n) continue;
      children_.push_back(child);
    }
  }
  ~BusyLoops() {
    for (const pid_t child : children_) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
  }

 private:
  std::vector<pid_t> children_;
};

/// A sound device on a pseudo-terminal: opened, calibrated, force on, for half a second and the ramp.
int falseFaults(int starts) {
  int faults = 0;
  const BusyLoops busy;
  const DeviceDef def = load(kDevices[0]);
  for (int n = 0; n < starts; ++n) {
    TwinPlant plant(def, {});
    BoardBusEmulator bus(plant);
    bus.addBoard("B5M", 1);
    PtyLine line(bus, "", false);
    PtyThread boards(line);
    TransportSettings settings;
    settings.port = line.path();
    std::unique_ptr<Transport> wire;
    try {
      wire = openTransport(def, settings);
    } catch (const std::exception& error) {
      std::printf("# start %d: %s\n", n, error.what());
      ++faults;
      continue;
    }
    Spidar device(def);
    device.calibrateAtHome();
    device.setForceEnabled(true);
    timespec due{};
    ::clock_gettime(CLOCK_MONOTONIC, &due);
    bool fault = false;
    for (int k = 0; k < 1000 && !fault; ++k) {
      const DeviceSample sample = wire->exchange(device.drive());
      device.sense(sample, 1e-3);
      device.actuate(Wrench{}, 0, 1e-3);
      fault = device.state() == DeviceState::kFault;
      if (fault) std::printf("# start %d, tick %d: %s\n", n, k, advice(recordOf(device, 0, 0, sample), "device").c_str());
      due.tv_nsec += 1000000;
      if (due.tv_nsec >= 1000000000) due.tv_nsec -= 1000000000, ++due.tv_sec;
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    }
    faults += fault;
    wire->zeroDrive();
  }
  return faults;
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const int starts = argc > 1 ? std::max(0, std::atoi(argv[1])) : 200;
  if (argc > 2) {  // these alone: bench_faults_device 20 starts
    figure("start.false_faults", falseFaults(starts), "1");
    return 0;
  }
  obedience();
  replayed();
  canaries();
  frozen();
  names();
  if (starts > 0) figure("start.false_faults", falseFaults(starts), "1");
  return 0;
}
