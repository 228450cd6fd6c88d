#include "spidar_driver/transport/line_recovery.h"

#include <chrono>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr int kPollMs = 20;  // how often the thread looks for a lost line

}  // namespace

LineRecovery::~LineRecovery() {
  stop();
  delete guard_.load();
  delete dead_guard_.load();
  delete lost_.load();
  delete opened_.load();
}

std::unique_ptr<Connection> LineRecovery::connect(std::unique_ptr<ByteLink> link,
                                                  const std::vector<std::uint8_t>& zero_drive) {
  auto connection = std::make_unique<Connection>();
  connection->link = std::move(link);
  if (!connection->link->write(zero_drive.data(), zero_drive.size()))
    throw SetupError(where_, "the port does not take bytes", "check the adapter");
  if (auto* port = dynamic_cast<SerialPort*>(connection->link.get()); port && settings_.guard)
    connection->guard = makeGuard(port->descriptor(), zero_drive);
  return connection;
}

std::unique_ptr<DriveGuard> LineRecovery::makeGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive) const {
  return std::make_unique<DriveGuard>(descriptor, zero_drive, zeroForAnyTable(), settings_.rate_hz);
}

void LineRecovery::start(const std::vector<FoundBoard>& boards, const std::vector<std::uint8_t>& zero_drive) {
  boards_ = boards;
  zero_drive_ = zero_drive;
  thread_ = std::thread([this] { run(); });
}

void LineRecovery::stop() {
  {
    std::lock_guard<std::mutex> lock(stop_mutex_);
    stop_ = true;
  }
  stop_signal_.notify_all();
  if (thread_.joinable()) thread_.join();
}

bool LineRecovery::reopen() {
  try {
    std::unique_ptr<ByteLink> link = open_();
    const std::vector<FoundBoard> found = matchBoards(scanBus(*link), device_, where_);
    if (found != boards_)
      throw SetupError(where_,
                       "other boards than before answer: " + listed(found) + " instead of " + listed(boards_),
                       "plug the right adapter in, or restart the driver");
    opened_.store(connect(std::move(link), zero_drive_).release(), std::memory_order_release);
    story_.say("");
    return true;
  } catch (const std::exception& error) {
    story_.say(error.what());  // still unplugged, or the boards are not up yet; the next attempt follows
    return false;
  }
}

bool LineRecovery::guardAnew(int descriptor) {
  try {
    guard_.store(makeGuard(descriptor, zero_drive_).release(), std::memory_order_release);
    story_.say("");
    return true;
  } catch (const std::exception& error) {
    story_.say(error.what());
    return false;
  }
}

void LineRecovery::run() {
  std::unique_lock<std::mutex> lock(stop_mutex_);
  const auto stopped = [this] { return stop_; };
  bool lost = false;
  while (!stop_signal_.wait_for(lock, std::chrono::milliseconds(kPollMs), stopped)) {
    if (Connection* dead = lost_.exchange(nullptr, std::memory_order_acquire)) {
      // With the line goes the guard that was asked for it: only this thread closes lines and makes guards.
      unguarded_.store(kGuarded, std::memory_order_relaxed);
      delete guard_.exchange(nullptr, std::memory_order_acquire);
      delete dead;
      lost = true;
    }
    delete dead_guard_.exchange(nullptr, std::memory_order_acquire);
    const int unguarded = lost ? kGuarded : unguarded_.exchange(kGuarded, std::memory_order_acquire);
    if (!lost && unguarded == kGuarded) continue;
    lock.unlock();
    const bool done = lost ? reopen() : guardAnew(unguarded);
    lock.lock();
    lost = lost && !done;
    if (!done && !lost) unguarded_.store(unguarded, std::memory_order_relaxed);
    if (!done) stop_signal_.wait_for(lock, std::chrono::duration<double>(settings_.reopen_s), stopped);
  }
}

}  // namespace haptic
