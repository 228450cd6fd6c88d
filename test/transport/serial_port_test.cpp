// Serial ports on pseudo-terminals: set-up, errors, hang-up, and the guard that outlives its process.
#include "spidar_driver/transport/serial_port.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "emulated_device.h"
#include "spidar_driver/emulator/pty_line.h"
#include "spidar_driver/transport/open_transport.h"

namespace haptic {
namespace serial_port_test {

template <class Action>
std::string messageOf(Action&& action) {
  try {
    action();
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

/// A B5M with placed shafts on a pseudo-terminal, served by a thread.
struct PtyBoard {
  PtyBoard() : bus(plant), line((bus.addBoard("B5M", 1), bus), "", false), thread(line) {}
  bool currentsZero() {
    bool zero = false;
    thread.with([&] { zero = bus.allCurrentsZero(); });
    return zero;
  }
  bool becomesZero() {
    for (int k = 0; k < 500; ++k) {
      if (currentsZero()) return true;
      ::usleep(10000);
    }
    return false;
  }
  PlacedPlant plant;
  BoardBusEmulator bus;
  PtyLine line;
  PtyThread thread;
};

DriveCommand halfVolt() {
  DriveCommand command;
  for (int i = 0; i < 8; ++i) command.voltage[i] = i % 2 ? -0.2 : 0.2;
  return command;
}

TEST(SerialPort, ErrorsNameThePortAndTheRemedy) {
  EXPECT_NE(messageOf([] { SerialPort("/dev/ttyNONE", 2000000); }).find("/dev/ttyNONE: no such port"),
            std::string::npos);
  char name[] = "/tmp/serial_port_testXXXXXX";
  ::close(::mkstemp(name));
  EXPECT_NE(messageOf([&] { SerialPort(name, 2000000); }).find("is no serial port"), std::string::npos);
  ::unlink(name);
}

TEST(SerialPort, PermissionIsNamed) {
  char name[] = "/tmp/serial_port_testXXXXXX";
  ::close(::mkstemp(name));
  ::chmod(name, 0);
  // Root may open everything: another user tries.
  const pid_t child = ::fork();
  if (child == 0) {
    if (::getuid() == 0 && ::setuid(65534) != 0) ::_exit(2);
    const std::string message = messageOf([&] { SerialPort(name, 2000000); });
    ::_exit(message.find("no permission") != std::string::npos && message.find("dialout") != std::string::npos
                ? 0
                : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::unlink(name);
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(SerialPort, ASecondDriverIsRefused) {
  PtyBoard board;
  SerialPort first(board.line.path(), 2000000);
  EXPECT_NE(messageOf([&] {
              SerialPort second(board.line.path(), 2000000);
            }).find("another program holds the port"),
            std::string::npos);
}

TEST(SerialPort, BytesPassUnchangedAndHangUpIsSeen) {
  PlacedPlant plant;
  BoardBusEmulator bus(plant);
  PtyLine line(bus, "", false);
  SerialPort port(line.path(), 2000000);
  const int master_sees = 3 * 256;
  std::vector<std::uint8_t> out(master_sees), in(64);
  for (int i = 0; i < master_sees; ++i) out[i] = static_cast<std::uint8_t>(i);
  ASSERT_TRUE(port.write(out.data(), out.size()));
  line.serve(5);
  EXPECT_EQ(line.bytesReceived(), out.size());
  const std::int64_t before = port.now();
  EXPECT_EQ(port.read(in.data(), in.size(), before + 2000000), 0);
  EXPECT_GE(port.now(), before + 2000000);
  line.unplug();
  EXPECT_EQ(port.read(in.data(), in.size(), port.now() + 50000000), -1);
  EXPECT_FALSE(port.write(out.data(), out.size()));
}

TEST(OpenTransport, DrivesBoardsOnATerminal) {
  PtyBoard board;
  const DeviceDef device = plainDevice({"B5M"}, 8);
  TransportSettings settings;
  settings.port = board.line.path();
  settings.reply_wait_s = 0.2;  // whatever else the machine does
  const auto transport = openTransport(device, settings);
  board.thread.with([&] { board.plant.positions[3] = 200; });
  DeviceSample s;
  for (int k = 0; k < 2000; ++k) {
    s = transport->exchange(halfVolt());
    if (k >= 20 && s.status == LinkStatus::kOk) break;
  }
  EXPECT_EQ(s.status, LinkStatus::kOk);
  EXPECT_EQ(s.counts[3], 200);
  EXPECT_FALSE(board.currentsZero());
  transport->zeroDrive();
  EXPECT_TRUE(board.becomesZero());
  EXPECT_NE(dynamic_cast<LinkReporter*>(transport.get()), nullptr);
}

TEST(OpenTransport, UnknownNamesAndRatesAreRefused) {
  DeviceDef device = plainDevice({"B5M"}, 8);
  TransportSettings settings;
  settings.port = "/dev/ttyNONE";
  EXPECT_NE(messageOf([&] { openTransport(device, settings); }).find("no such port"), std::string::npos);
  device.transport = "carrier_pigeon";
  EXPECT_NE(messageOf([&] { openTransport(device, settings); }).find("twin, uart, usb_sh4, usb_simple"),
            std::string::npos);
  settings.rate_hz = 0;
  EXPECT_NE(messageOf([&] { openTransport(device, settings); }).find("rate"), std::string::npos);
}

/// A process drives the motors, then ends in the given way without a chance to say goodbye.
void driveAndEnd(const std::string& port, int signal) {
  const pid_t child = ::fork();
  if (child == 0) {
    TransportSettings settings;
    settings.port = port;
    settings.reply_wait_s = 0.2;
    auto transport = openTransport(plainDevice({"B5M"}, 8), settings);
    for (int k = 0; k < 20; ++k) transport->exchange(halfVolt());
    ::raise(signal);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

TEST(DriveGuard, AProcessThatDiesLeavesNoCurrent) {
  PtyBoard board;
  for (const int signal : {SIGKILL, SIGSEGV}) {
    driveAndEnd(board.line.path(), signal);
    EXPECT_TRUE(board.becomesZero()) << signal;
    board.thread.with([&] {
      for (int i = 0; i < 8; ++i) EXPECT_EQ(board.plant.digits[i], 0);
      EXPECT_GT(board.bus.board(1)->executed(BoardCommand::kCurrent), 20u);
    });
    ::usleep(50000);  // the guard lets go of the port
  }
}

TEST(DriveGuard, AProcessThatStandsStillLeavesNoCurrent) {
  PtyBoard board;
  const DeviceDef device = plainDevice({"B5M"}, 8);
  TransportSettings settings;
  settings.port = board.line.path();
  settings.reply_wait_s = 0.2;
  auto transport = openTransport(device, settings);
  for (int k = 0; k < 2000 && board.currentsZero(); ++k) transport->exchange(halfVolt());
  ASSERT_FALSE(board.currentsZero());
  EXPECT_TRUE(board.becomesZero());  // nobody calls exchange: the loop hangs
  // It goes on when the loop does.
  DeviceSample s;
  for (int k = 0; k < 2000; ++k) {
    s = transport->exchange(halfVolt());
    if (k >= 20 && s.status == LinkStatus::kOk) break;
  }
  EXPECT_EQ(s.status, LinkStatus::kOk);
}

/// Guards that this process has started: its own descriptors' peers have no names, so by the port that they hold open.
std::vector<pid_t> guardsOf(const std::string& port) {
  std::vector<pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::string name;
    std::getline(std::ifstream(entry.path() / "comm"), name);
    std::error_code none;
    if (name == "motor_guard" && std::filesystem::read_symlink(entry.path() / "fd/3", none) == port)
      found.push_back(std::stoi(entry.path().filename()));
  }
  return found;
}

/// A driver with current on, and its guard.
struct GuardedDriver {
  GuardedDriver() {
    settings.port = board.line.path();
    settings.reply_wait_s = 0.2;  // whatever else the machine does
    transport = openTransport(plainDevice({"B5M"}, 8), settings);
    reaches(LinkStatus::kOk);
  }
  /// Drives until an exchange has this status, with current in the boards or without as it asks.
  bool reaches(LinkStatus status) {
    for (int k = 0; k < 20000; ++k) {
      last = transport->exchange(halfVolt());
      if (last.status == status && board.currentsZero() == (status != LinkStatus::kOk)) return true;
      ::usleep(500);
    }
    return false;
  }
  pid_t guard() const { return guardsOf(board.line.path()).at(0); }
  PtyBoard board;
  TransportSettings settings;
  std::unique_ptr<Transport> transport;
  DeviceSample last;
};

TEST(DriveGuard, ADriverWithoutItsGuardHasNoCurrentUntilAnotherOneWatches) {
  GuardedDriver d;
  ASSERT_EQ(d.last.status, LinkStatus::kOk);
  const auto* wire = dynamic_cast<LinkReporter*>(d.transport.get());
  for (unsigned round = 1; round <= 3; ++round) {
    const pid_t guard = d.guard();
    ::kill(guard, SIGKILL);
    EXPECT_TRUE(d.reaches(LinkStatus::kUnguarded)) << round;
    EXPECT_TRUE(d.reaches(LinkStatus::kOk)) << round;
    EXPECT_NE(d.guard(), guard);
    EXPECT_EQ(guardsOf(d.board.line.path()).size(), 1u);
    EXPECT_EQ(wire->linkReport().unguarded, round);
  }
  d.transport.reset();
  EXPECT_TRUE(d.board.becomesZero());
}

TEST(DriveGuard, AGuardThatStandsStillGuardsNobody) {
  GuardedDriver d;
  ASSERT_EQ(d.last.status, LinkStatus::kOk);
  const pid_t guard = d.guard();
  ::kill(guard, SIGSTOP);
  EXPECT_TRUE(d.reaches(LinkStatus::kUnguarded));
  ::kill(guard, SIGCONT);
  EXPECT_TRUE(d.reaches(LinkStatus::kOk));
  EXPECT_EQ(d.guard(), guard) << "it goes on";
}

/// One of them is killed, then the other, before the boards have lost their current on behalf of the first.
TEST(DriveGuard, GuardThenDriverAndDriverThenGuardLeaveNoCurrent) {
  for (const bool guard_first : {true, false}) {
    PtyBoard board;
    const pid_t child = ::fork();
    if (child == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that fails leaves nothing behind
      TransportSettings settings;
      settings.port = board.line.path();
      settings.reply_wait_s = 0.2;
      auto transport = openTransport(plainDevice({"B5M"}, 8), settings);
      for (;;) transport->exchange(halfVolt());
    }
    for (int k = 0; k < 2000 && board.currentsZero(); ++k) ::usleep(1000);
    ASSERT_FALSE(board.currentsZero());
    const pid_t guard = guardsOf(board.line.path()).at(0);
    ::kill(guard_first ? guard : child, SIGKILL);
    EXPECT_TRUE(board.becomesZero()) << guard_first;
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    for (const pid_t other : guardsOf(board.line.path())) ::kill(other, SIGKILL);
    EXPECT_TRUE(board.becomesZero()) << guard_first;
  }
}

}  // namespace serial_port_test
}  // namespace haptic
