/// Opens a lost line again, on a thread of its own: what blocks or allocates never meets the exchange.
#pragma once
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "spidar_driver/transport/board_bus.h"
#include "spidar_driver/transport/drive_guard.h"
#include "spidar_driver/transport/link_story.h"
#include "spidar_driver/transport/uart_settings.h"

namespace haptic {

using OpenLink = std::function<std::unique_ptr<ByteLink>()>;  ///< throws SetupError

/// An open line, and the process that turns the motors off when this one dies.
struct Connection {
  std::unique_ptr<ByteLink> link;
  std::unique_ptr<DriveGuard> guard;
};

class LineRecovery {
 public:
  /// `where` names the port in messages. `device` and `story` must outlive this.
  LineRecovery(const DeviceDef& device, const UartSettings& settings, std::string where, OpenLink open,
               LinkStory& story)
      : device_(device),
        settings_(settings),
        where_(std::move(where)),
        open_(std::move(open)),
        story_(story) {}
  ~LineRecovery();

  std::unique_ptr<ByteLink> open() { return open_(); }  ///< set-up; throws SetupError
  /// Set-up: the line with its guard, drive off. `zero_drive`: bytes that turn the motors off. Throws
  /// SetupError.
  std::unique_ptr<Connection> connect(std::unique_ptr<ByteLink> link,
                                      const std::vector<std::uint8_t>& zero_drive);
  void start(const std::vector<FoundBoard>& boards,
             const std::vector<std::uint8_t>& zero_drive);  ///< set-up: the thread
  void stop();

  /// (in realtime) Asks for another guard of the line with this descriptor; the motors stay off meanwhile.
  void wantGuard(int descriptor) noexcept { unguarded_.store(descriptor, std::memory_order_release); }
  /// (in realtime) It, once it watches; nullptr: not yet.
  DriveGuard* takeGuard() noexcept { return guard_.exchange(nullptr, std::memory_order_acquire); }
  /// (in realtime) A guard that is no longer needed, to be freed. One at a time: it comes back from `takeGuard` first.
  void bury(DriveGuard* dead) noexcept { dead_guard_.store(dead, std::memory_order_release); }
  /// (in realtime) A line that was opened again; nullptr: none.
  Connection* takeOpened() noexcept { return opened_.exchange(nullptr, std::memory_order_acquire); }
  /// (in realtime) A line that is gone, to be freed and replaced.
  void replace(std::unique_ptr<Connection> lost) noexcept {
    lost_.store(lost.release(), std::memory_order_release);
  }

 private:
  void run();
  bool reopen();
  std::unique_ptr<DriveGuard> makeGuard(int descriptor, const std::vector<std::uint8_t>& zero_drive) const;
  bool guardAnew(int descriptor);

  const DeviceDef& device_;
  const UartSettings settings_;
  const std::string where_;
  const OpenLink open_;
  LinkStory& story_;
  std::vector<FoundBoard> boards_;
  std::vector<std::uint8_t> zero_drive_;
  std::atomic<Connection*> lost_{nullptr}, opened_{nullptr};
  static constexpr int kGuarded = -1;
  std::atomic<int> unguarded_{kGuarded};  ///< descriptor of a line whose guard has ended
  std::atomic<DriveGuard*> guard_{nullptr}, dead_guard_{nullptr};
  std::mutex stop_mutex_;
  std::condition_variable stop_signal_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace haptic
