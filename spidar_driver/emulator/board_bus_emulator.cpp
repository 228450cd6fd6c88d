#include "spidar_driver/emulator/board_bus_emulator.h"

#include <algorithm>
#include <limits>

#include "haptic_core/base/error.h"

namespace haptic {

BoardBusEmulator::BoardBusEmulator(MotorPlant& plant, const BusEmulatorSettings& settings)
    : plant_(plant), settings_(settings), byte_ns_(10 * 1000000000ll / settings.baud) {}

void BoardBusEmulator::addBoard(const std::string& model, int id) {
  const BoardShape* shape = findBoardModel(model);
  if (!shape)
    throw SetupError("board '" + model + "'", "is no known model", "use one of " + boardModelNames());
  if (id < 0 || id >= kMaxBoards || board(id))
    throw SetupError("board id " + std::to_string(id), "is taken or not in 0-7",
                     "give each board an id of its own");
  boards_.push_back(std::make_unique<EmulatedBoard>(id, *shape, channels_, plant_));
  channels_ += shape->motors;
}

EmulatedBoard* BoardBusEmulator::board(int id) {
  for (const auto& b : boards_)
    if (b->id() == id) return b.get();
  return nullptr;
}

void BoardBusEmulator::receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns) {
  line_ns_ = std::max(line_ns_, now_ns);
  handed_ns_ = now_ns;
  for (std::size_t i = 0; i < size; ++i) to_boards.apply(bytes[i], [this](std::uint8_t byte) { hear(byte); });
}

void BoardBusEmulator::hear(std::uint8_t byte) {
  line_ns_ += byte_ns_;
  fifo_.push_back(byte);
  if (static_cast<int>(fifo_.size()) < settings_.fifo_trigger) return;
  for (const std::uint8_t b : fifo_)
    for (const auto& board : boards_)
      if (const int size = board->receive(b, line_ns_)) reply(*board, size);
  fifo_.clear();
}

const std::uint8_t* BoardBusEmulator::bytesOf(const EmulatedBoard& board, int size) {
  constexpr std::size_t kLongestReplay = 200;
  if (board.reply()[0] != headerByte(BoardCommand::kCurrent, board.id())) return board.reply();
  std::deque<Reply>& past = past_[static_cast<std::size_t>(board.id())];
  past.emplace_front();
  std::copy_n(board.reply(), size, past.front().begin());
  if (past.size() > kLongestReplay + 1) past.pop_back();
  return past[std::min(static_cast<std::size_t>(replay_), past.size() - 1)].data();
}

void BoardBusEmulator::reply(const EmulatedBoard& board, int size) {
  const std::uint8_t* bytes = bytesOf(board, size);
  constexpr std::int64_t kCopyNs = 300000;  // behind the reply: the rest of a cycle has passed by then
  const std::int64_t at = line_ns_ + settings_.reply_delay_ns;
  const std::int64_t delay = adapterDelay() + (late_replies_ > 0 ? late_ns_ : 0);
  late_replies_ -= late_replies_ > 0;
  if (lose_ > 0) {
    --lose_;
    return;
  }
  if (swap_ > 0 && held_.empty()) {
    held_.assign(bytes, bytes + size);
    return;
  }
  transmit(bytes, size, at, delay);
  if (!held_.empty()) {
    transmit(held_.data(), static_cast<int>(held_.size()), at + kCopyNs, delay);
    held_.clear();
    --swap_;
  }
  if (double_ == 0) return;
  --double_;
  transmit(bytes, size, at + kCopyNs, delay);
}

std::int64_t BoardBusEmulator::adapterDelay() const {
  const double drifted = adapter_.drift * static_cast<double>(line_ns_ - drift_start_ns_);
  const double most = 10.0 * static_cast<double>(adapter_.constant_ns);
  return static_cast<std::int64_t>(std::clamp(static_cast<double>(adapter_.constant_ns) + drifted, 0.0, most));
}

void BoardBusEmulator::transmit(const std::uint8_t* bytes, int size, std::int64_t at, std::int64_t delay) {
  for (int i = 0; i < size; ++i)
    to_host.apply(bytes[i], [this, &at, delay](std::uint8_t byte) { put(at += byte_ns_, delay, byte); });
}

/// Sorts a byte in; one that overlaps another on the line garbles it.
void BoardBusEmulator::put(std::int64_t at, std::int64_t delay, std::uint8_t byte) {
  auto place = out_.end();
  while (place != out_.begin() && std::prev(place)->at > at) --place;
  for (auto near : {place, place == out_.begin() ? out_.end() : std::prev(place)})
    if (near != out_.end() && std::abs(near->at - at) < byte_ns_) {
      near->byte = static_cast<std::uint8_t>(near->byte & byte);
      ++collisions_;
      return;
    }
  const std::int64_t before = place == out_.begin() ? 0 : std::prev(place)->due;
  // A wire that keeps bytes back has carried them first: its delay is what comes on top of their own time.
  std::int64_t due = instant_ && delay == 0 ? handed_ns_ : at + delay;
  if (adapter_.burst_ns > 0) due = (due / adapter_.burst_ns + 1) * adapter_.burst_ns;
  out_.insert(place, {at, std::max(due, before), byte});
}

std::size_t BoardBusEmulator::take(std::uint8_t* bytes, std::size_t capacity, std::int64_t now_ns) {
  std::size_t taken = 0;
  while (taken < capacity && !out_.empty() && out_.front().due <= now_ns) {
    bytes[taken++] = out_.front().byte;
    out_.pop_front();
  }
  return taken;
}

std::int64_t BoardBusEmulator::nextByteAt() const {
  return out_.empty() ? std::numeric_limits<std::int64_t>::max() : out_.front().due;
}

std::int64_t BoardBusEmulator::quietAt() const {
  if (out_.empty()) return std::numeric_limits<std::int64_t>::max();
  auto last = out_.begin();
  for (auto next = std::next(last); next != out_.end() && next->due - last->due <= 2 * byte_ns_; ++next)
    last = next;
  return last->due;
}

void BoardBusEmulator::clearLine() {
  out_.clear();
  fifo_.clear();
  held_.clear();
}

bool BoardBusEmulator::allCurrentsZero() const {
  for (const auto& b : boards_)
    for (int m = 0; m < b->shape().motors; ++m)
      if (b->digit(m) != 0) return false;
  return true;
}

}  // namespace haptic
