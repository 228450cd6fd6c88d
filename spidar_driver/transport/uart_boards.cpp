#include "spidar_driver/transport/uart_boards.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/drive_limits.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr int kBitsPerByte = 10;               // 8N1
constexpr int kZeroLead = 90;                  // ends any packet a board may be inside of, see board_bus
constexpr std::int64_t kReplyDelayNs = 25000;  // of the firmware, from header to reply
constexpr std::int64_t kSpareNs = 100000;  // least wait beyond the cycle's wire time: the adapter's latency
constexpr double kWaitShare = 0.8;         // of the period; the rest is left to the tick
// A disturbed command can reach a board as SET_CMDLEN and spoil its length table: it then answers and no
// longer obeys, which the host cannot see. The lesson is given again after disturbances, not more often than
// kLessonGap exchanges, and every kLessonEvery exchanges without any.
constexpr std::uint64_t kLessonGap = 16, kLessonEvery = 1000;
constexpr int kRecoveryPollMs = 20;  // how often the recovery thread looks for a lost line

}  // namespace

UartBoards::UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where,
                       OpenLink open)
    : device_(device), settings_(settings), where_(where), open_(std::move(open)) {
  if (device_.strings.empty() || device_.strings.size() > kMaxStrings)
    throw SetupError(device_.file, "has no strings, or more than " + std::to_string(kMaxStrings),
                     "correct `strings`");
  std::unique_ptr<ByteLink> link = open_();
  boards_ = matchBoards(scanBus(*link), device_, where_);
  layOutCycle();
  if (!(settings_.rate_hz > 0) || settings_.rate_hz > max_rate_hz_) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.0f Hz asked, but the wire carries at most %.0f Hz (%zu bytes a cycle, %d baud)",
                  settings_.rate_hz, max_rate_hz_, cycle_.size(), settings_.baud);
    throw SetupError(device_.name, text, "set the rate to at most that");
  }
  const double wait_s = settings_.reply_wait_s > 0 ? settings_.reply_wait_s : kWaitShare / settings_.rate_hz;
  wait_ns_ = std::max(static_cast<std::int64_t>(wait_s * 1e9), cycle_ns_ + kSpareNs);
  connection_ = connect(std::move(link));
  wire_free_ns_ = connection_->link->now() + static_cast<std::int64_t>(lesson_.size()) * byte_ns_;
  zeroDrive();
  recovery_ = std::thread([this] { recover(); });
}

UartBoards::~UartBoards() {
  {
    std::lock_guard<std::mutex> lock(stop_mutex_);
    stop_ = true;
  }
  stop_signal_.notify_all();
  recovery_.join();
  adoptConnection();
  zeroDrive();
  delete outgoing_.load();
}

/// Teaches the boards on a line each other's lengths and starts the guard.
std::unique_ptr<UartBoards::Connection> UartBoards::connect(std::unique_ptr<ByteLink> link) {
  auto connection = std::make_unique<Connection>();
  connection->link = std::move(link);
  if (!teachLengths(*connection->link, boards_))
    throw SetupError(where_, "the port does not take bytes", "check the adapter");
  if (auto* port = dynamic_cast<SerialPort*>(connection->link.get()); port && settings_.guard)
    connection->guard = std::make_unique<DriveGuard>(port->descriptor(), zero_cycle_, settings_.rate_hz);
  return connection;
}

void UartBoards::layOutCycle() {
  byte_ns_ = static_cast<std::int64_t>(1e9 * kBitsPerByte / settings_.baud);
  int channel = 0;
  std::size_t bytes = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    cycle_offset_[b] = static_cast<int>(bytes);
    first_channel_[b] = channel;
    for (int m = 0; m < shape.motors && channel < static_cast<int>(device_.strings.size()); ++m, ++channel) {
      const double per_count = std::max(std::abs(device_.strings[channel].length_per_count), 1e-9);
      counter_[channel] = CountUnwrapper(settings_.max_string_speed / per_count);
    }
    latch_ns_ += (static_cast<std::int64_t>(bytes) * byte_ns_ + kReplyDelayNs) /
                 static_cast<std::int64_t>(boards_.size());
    bytes += commandBytes(shape, BoardCommand::kCurrent) + paddingBytes(shape, BoardCommand::kCurrent);
  }
  cycle_.assign(bytes, 0);
  for (std::size_t b = 0; b < boards_.size(); ++b)
    encodePacket(*boards_[b].shape, boards_[b].id, CurrentCommand{}, cycle_.data() + cycle_offset_[b],
                 cycle_.size() - cycle_offset_[b]);
  zero_cycle_.assign(kZeroLead, 0);
  zero_cycle_.insert(zero_cycle_.end(), cycle_.begin(), cycle_.end());
  lesson_ = lengthLesson(boards_);
  cycle_ns_ = static_cast<std::int64_t>(bytes) * byte_ns_;
  max_rate_hz_ = std::min(1e9 / static_cast<double>(cycle_ns_), device_.max_rate_hz);
  slot_ns_ = static_cast<std::int64_t>(std::ceil(1e9 / max_rate_hz_ - 1e-3));
}

DeviceSample UartBoards::exchange(const DriveCommand& command) noexcept {
  ++exchanges_;
  adoptConnection();
  if (connection_) waitForWire();
  const bool alive = connection_ && drain();
  for (std::size_t b = 0; b < boards_.size(); ++b) ++age_[b];
  if (!alive || !send(command) || !collect()) {
    disconnect();
    return sample();
  }
  takeReplies(false);
  return sample();
}

void UartBoards::adoptConnection() noexcept {
  Connection* fresh = incoming_.exchange(nullptr, std::memory_order_acquire);
  if (!fresh) return;
  connection_.reset(fresh);  // empty since disconnect: nothing is freed here
  collector_.begin();
  owes_.fill(false);
  judged_ = true;
  wire_free_ns_ = connection_->link->now() + static_cast<std::int64_t>(lesson_.size()) * byte_ns_;
  count(kReconnects);
}

void UartBoards::disconnect() noexcept {
  armed_ = false;
  if (connection_) outgoing_.store(connection_.release(), std::memory_order_release);
}

void UartBoards::waitForWire() noexcept {
  if (connection_->link->now() >= wire_free_ns_) return;
  count(kOverRate);
  connection_->link->waitUntil(wire_free_ns_);
}

/// Takes in what came since the last exchange: answers that were late, bytes that belong to nothing.
bool UartBoards::drain() noexcept {
  std::array<std::uint8_t, 512> in;
  const int surplus_before = collector_.surplus();
  for (;;) {
    const int got = connection_->link->read(in.data(), in.size(), 0);
    if (got < 0) return false;
    if (got == 0) break;
    collector_.feed(in.data(), static_cast<std::size_t>(got));
  }
  if (!judged_) takeReplies(true);
  count(kForeign, collector_.foreign() + collector_.surplus());
  if (surplus_before == 0 && collector_.surplus() > 0) count(kUnsound);
  return true;
}

bool UartBoards::send(const DriveCommand& command) noexcept {
  const int strings = static_cast<int>(device_.strings.size());
  const bool finite = finiteDrive(device_, command);
  const bool usable = finite && !silent();
  if (!finite) count(kBadCommands);
  armed_ = false;
  collector_.begin();
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    CurrentCommand packet;
    for (int m = 0; m < shape.motors && usable; ++m) {
      const int channel = first_channel_[b] + m;
      if (channel >= strings) break;
      bool clamped = false;
      packet.current[m] =
          driveDigit(shape, allowedVoltage(device_.strings[channel], command.voltage[channel], clamped));
      if (clamped) count(kClamped);
      armed_ = armed_ || packet.current[m] != 0;
    }
    encodePacket(shape, boards_[b].id, packet, cycle_.data() + cycle_offset_[b],
                 cycle_.size() - cycle_offset_[b]);
    collector_.expect(headerByte(BoardCommand::kCurrent, boards_[b].id),
                      replyBytes(shape, BoardCommand::kCurrent), owes_[b] ? 2 : 1);
  }
  if (connection_->guard && armed_) connection_->guard->arm();
  sent_ns_ = connection_->link->now();
  const std::uint64_t since = exchanges_ - last_lesson_;
  if (since >= kLessonEvery || (lesson_due_ && since >= kLessonGap)) {
    if (!connection_->link->write(lesson_.data(), lesson_.size())) return false;
    sent_ns_ += static_cast<std::int64_t>(lesson_.size()) * byte_ns_;
    last_lesson_ = exchanges_;
    lesson_due_ = false;
  }
  if (!connection_->link->write(cycle_.data(), cycle_.size())) return false;
  if (connection_->guard) connection_->guard->beat(armed_);
  wire_free_ns_ = sent_ns_ + slot_ns_;
  judged_ = false;
  count(kCycles);
  return true;
}

bool UartBoards::collect() noexcept {
  std::array<std::uint8_t, 512> in;
  // A board known to be silent is given its slot, not the patience for a busy adapter.
  const std::int64_t wait = silent() ? std::min(wait_ns_, cycle_ns_ + 2 * kSpareNs) : wait_ns_;
  const std::int64_t deadline = sent_ns_ + wait;
  while (!collector_.complete()) {
    const int got = connection_->link->read(in.data(), in.size(), deadline);
    if (got < 0) return false;
    if (got == 0) return true;
    collector_.feed(in.data(), static_cast<std::size_t>(got));
  }
  const int got = connection_->link->read(in.data(), in.size(), 0);  // an extra byte makes the cycle unsound
  if (got > 0) collector_.feed(in.data(), static_cast<std::size_t>(got));
  return got >= 0;
}

/// Judges the cycle and takes its counts. Late: called before the next cycle, with what came in between.
void UartBoards::takeReplies(bool late) noexcept {
  if (!late && !collector_.complete()) {
    bool partly = false;
    for (int b = 0; b < collector_.size(); ++b) partly = partly || collector_[b].received > 0;
    // Nothing, or a reply under way: wait for the rest until the next exchange.
    if (!partly || !collector_.sound()) return;
  }
  judged_ = true;
  if (!collector_.sound()) {
    count(kUnsound);
    owes_.fill(false);
    return;
  }
  for (int b = 0; b < collector_.size(); ++b) {
    const ReplyCollector::Expected& e = collector_[b];
    // One of two that may come has come: it is the older one, or the older one was lost. Nothing tells which,
    // so the counts are given the greater age.
    const bool certain = e.received == e.allowed;
    owes_[b] = e.received == 0;
    if (late && e.received > 0) count(kLate);
    if (e.received == 0 || !takePositions(b, e.reply.data(), e.bytes)) continue;
    age_[b] = certain ? 0 : 1;
  }
  stamp_ns_ = sent_ns_ + latch_ns_;
}

bool UartBoards::takePositions(int board, const std::uint8_t* reply, int size) noexcept {
  CurrentReply packet;
  if (!decodePacket(*boards_[board].shape, boards_[board].id, reply, static_cast<std::size_t>(size), packet))
    return false;
  bool believed = true;
  const int strings = static_cast<int>(device_.strings.size());
  for (int m = 0; m < boards_[board].shape->motors && first_channel_[board] + m < strings; ++m) {
    const auto result = counter_[first_channel_[board] + m].accept(packet.position[m], sent_ns_);
    if (result == CountUnwrapper::Result::kRestarted) count(kRestarts);
    if (result == CountUnwrapper::Result::kRefused) {
      count(kRefused);
      believed = false;
    }
  }
  return believed;
}

bool UartBoards::silent() const noexcept {
  return std::any_of(
      age_.begin(), age_.begin() + static_cast<std::ptrdiff_t>(boards_.size()),
      [this](std::uint32_t age) { return age >= static_cast<std::uint32_t>(settings_.silent_after); });
}

DeviceSample UartBoards::sample() noexcept {
  DeviceSample s;
  for (std::size_t i = 0; i < device_.strings.size(); ++i) s.counts[i] = counter_[i].count();
  s.stamp_ns = stamp_ns_;
  std::uint32_t mute = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    s.age_ticks = std::max(s.age_ticks, age_[b]);
    if (age_[b] >= static_cast<std::uint32_t>(settings_.silent_after)) mute |= 1u << boards_[b].id;
  }
  silent_boards_.store(mute, std::memory_order_relaxed);
  if (s.age_ticks > 0) {
    count(kLost);
    lesson_due_ = true;
  }
  s.status = !connection_      ? LinkStatus::kDisconnected
             : mute            ? LinkStatus::kSilent
             : s.age_ticks > 0 ? LinkStatus::kStale
                               : LinkStatus::kOk;
  return s;
}

void UartBoards::zeroDrive() noexcept {
  if (!connection_) return;
  const std::int64_t start = std::max(connection_->link->now(), wire_free_ns_);
  connection_->link->write(zero_cycle_.data(), zero_cycle_.size());
  if (connection_->guard) connection_->guard->beat(false);
  armed_ = false;
  wire_free_ns_ = start + static_cast<std::int64_t>(zero_cycle_.size()) * byte_ns_;
}

LinkReport UartBoards::linkReport() const noexcept {
  const auto read = [this](Counter c) { return counters_[c].load(std::memory_order_relaxed); };
  LinkReport r;
  r.cycles = read(kCycles);
  r.lost = read(kLost);
  r.late = read(kLate);
  r.unsound = read(kUnsound);
  r.foreign_bytes = read(kForeign);
  r.refused_counts = read(kRefused);
  r.restarts = read(kRestarts);
  r.reconnects = read(kReconnects);
  r.over_rate = read(kOverRate);
  r.bad_commands = read(kBadCommands);
  r.clamped = read(kClamped);
  r.silent_boards = silent_boards_.load(std::memory_order_relaxed);
  return r;
}

std::string UartBoards::describe() const {
  std::string text = where_ + ":";
  for (const FoundBoard& b : boards_)
    text += " " + std::string(b.shape->name) + " (id " + std::to_string(b.id) + ")";
  char rate[64];
  std::snprintf(rate, sizeof rate, ", %.0f us a cycle, at most %.0f Hz", 1e6 * cycleSeconds(), max_rate_hz_);
  return text + rate;
}

/// Thread: frees lost lines and opens new ones; never touches what exchange uses.
void UartBoards::recover() {
  std::unique_lock<std::mutex> lock(stop_mutex_);
  bool lost = false;
  while (!stop_signal_.wait_for(lock, std::chrono::milliseconds(kRecoveryPollMs), [this] { return stop_; })) {
    if (Connection* dead = outgoing_.exchange(nullptr, std::memory_order_acquire)) {
      delete dead;
      lost = true;
    }
    if (!lost) continue;
    lock.unlock();
    try {
      std::unique_ptr<ByteLink> link = open_();
      if (matchBoards(scanBus(*link), device_, where_) != boards_)
        throw SetupError(where_, "other boards than before answer", "restart the driver");
      incoming_.store(connect(std::move(link)).release(), std::memory_order_release);
      lost = false;
    } catch (const std::exception&) {
      // Still unplugged, or the boards are not up yet: the state is in the samples, the next attempt follows.
    }
    lock.lock();
    if (lost)
      stop_signal_.wait_for(lock, std::chrono::duration<double>(settings_.reopen_s),
                            [this] { return stop_; });
  }
}

}  // namespace haptic
