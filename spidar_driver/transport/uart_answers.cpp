// What comes back from the boards: bytes → replies → questions → counts, and what the line has to say about itself.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "spidar_driver/transport/uart_boards.h"

namespace haptic {
namespace {

constexpr std::int64_t kReplyDelayNs = 25000;    // of the firmware, from header to reply
constexpr std::int64_t kSplitNs = 3000000;       // an adapter may deliver a reply in two parts so far apart
constexpr int kDrainReads = 16, kCollectReads = 64;  // of 512 bytes: 8 kB are 20 ms of a full wire
constexpr std::int64_t kMarkSpareNs = 300000;    // a mark is waited for no longer than it should take, and so much
constexpr double kLossWindow = 50;               // questions over which a board's losses are averaged
constexpr double kLossLimit = 0.2;               // of them lost: the board is out of step, or its table is spoilt

}  // namespace

int UartBoards::boardOf(int id) const noexcept {
  for (std::size_t b = 0; b < boards_.size(); ++b)
    if (boards_[b].id == id) return static_cast<int>(b);
  return -1;
}

/// One read, until `deadline_ns` at most. Returns the bytes that came; -1: the line is gone.
int UartBoards::hear(std::int64_t deadline_ns) noexcept {
  std::array<std::uint8_t, 512> in;
  ByteLink& link = *connection_->link;
  const std::int64_t before = link.now();
  const int got = link.read(in.data(), in.size(), deadline_ns);
  const std::int64_t now = link.now();
  const auto take = [this](const std::uint8_t* bytes, int size) { takeReply(bytes, size); };
  if (got > 0) {
    heard_ns_ = now;
    waited_ = now > before && deadline_ns > before;
    stream_.feed(in.data(), static_cast<std::size_t>(got), take);
  } else if (got == 0) {
    stream_.settle(take);
    looked_ns_ = now;
  }
  return got;
}

/// Takes in what came since the last exchange.
UartBoards::Line UartBoards::drain() noexcept {
  int got = 1;
  for (int i = 0; i < kDrainReads && got > 0; ++i) got = hear(0);
  if (got < 0) return Line::kGone;
  if (got > 0) pending_ = Cause::kFlood;
  if (stream_.pending() > 0 && connection_->link->now() - heard_ns_ > kSplitNs) stream_.abandon();
  const std::uint64_t foreign = stream_.foreign();
  story_.count(LinkStory::kForeign, foreign - foreign_seen_);
  foreign_seen_ = foreign;
  return Line::kFine;
}

/// Waits for this exchange's answers; on a wire whose delay exceeds the wait, for some answer of every board. Then for the
/// mark's, when it is due within the wait: who does not watch the line when it comes does not know the delay.
UartBoards::Line UartBoards::collect() noexcept {
  const std::int64_t deadline = sent_ns_ + wait_ns_;
  const std::int64_t due =
      ledger_.markSent() + BusRestart::questionTime(byte_ns_, mark_reply_bytes_) + delay_ns_ + kMarkSpareNs;
  const bool own = fastest_ns_ + cycle_ns_ + mark_wire_ns_ <= wait_ns_;
  const std::int64_t mark_deadline = own ? std::min(due, deadline) : due <= deadline ? due : 0;
  const auto answered = [&] { return own ? ledger_.owed() == 0 : allFresh(); };
  const auto done = [&] { return answered() && (!ledger_.marked() || connection_->link->now() >= mark_deadline); };
  for (int i = 0; i < kCollectReads; ++i) {
    const bool look = stream_.complete() || done();  // only silence proves the last reply
    const int got = hear(look ? 0 : answered() ? mark_deadline : deadline);
    if (got < 0) return Line::kGone;
    if (got == 0 && (!look || done())) break;
  }
  return Line::kFine;
}

void UartBoards::takeReply(const std::uint8_t* bytes, int size) noexcept {
  const int board = boardOf(bytes[0] & 7);
  if (board < 0) return;
  if (bytes[0] == headerByte(BoardCommand::kCurrent, boards_[board].id))
    takeAnswer(board, bytes, size);
  else
    takeMark(board, bytes, size);
}

void UartBoards::takeAnswer(int board, const std::uint8_t* bytes, int size) noexcept {
  const AnswerLedger::Credit question = ledger_.answer(board);
  if (!question.owed) return story_.count(LinkStory::kDoubled);
  if (question.exchange != exchanges_) story_.count(LinkStory::kLate);
  const std::int64_t stamp = question.sent_ns + cycle_offset_[board] * byte_ns_ + kReplyDelayNs;
  if (!takePositions(board, bytes, size, stamp)) return;
  board_[board].exchange = question.exchange;
  board_[board].stamp_ns = stamp;
  board_[board].fresh = true;
}

void UartBoards::takeMark(int board, const std::uint8_t* bytes, int size) noexcept {
  InfoReply info;
  ParamReply param;
  const BoardShape& shape = *boards_[board].shape;
  const bool memory = bytes[0] == headerByte(BoardCommand::kGetParam, boards_[board].id);
  if (memory ? !decodePacket(shape, boards_[board].id, bytes, static_cast<std::size_t>(size), param)
             : !decodeInfo(bytes, size, boards_[board].id, info))
    return;
  if (!ledger_.marked() || ledger_.markBoard() != board || memory != (mark_param_ >= 0)) return story_.count(LinkStory::kDoubled);
  if (memory) {
    const BoardMemory::Verdict verdict = board_[board].memory.take(mark_param_, param.type);
    const bool power_lost = verdict == BoardMemory::Verdict::kPowerLost;
    counters_restarted_ = counters_restarted_ || power_lost;  // whether its counters went on nobody can know
    if (verdict != BoardMemory::Verdict::kFine) {
      pending_ = power_lost ? Cause::kPowerLost : Cause::kDisobeys;
      story_.blame(boards_[board].id);
    }
  }
  if (!memory && info.model != static_cast<int>(shape.model)) {
    pending_ = Cause::kOtherBoard;
    story_.blame(boards_[board].id);
  }
  const std::int64_t trip = BusRestart::questionTime(byte_ns_, mark_reply_bytes_) + ledger_.markSent();
  const std::int64_t delay = std::max<std::int64_t>(0, heard_ns_ - trip);
  // It came just now, or at some time since somebody looked.
  const std::int64_t least = waited_ ? delay : std::clamp<std::int64_t>(looked_ns_ - trip, 0, delay);
  delay_ns_ = waited_ ? delay_ns_ + (delay - delay_ns_) / 4 : std::clamp(delay_ns_, least, delay);
  fastest_ns_ = std::min(least, fastest_ns_ + (least - fastest_ns_) / 4);
  story_.setDelay(delay_ns_);
  last_mark_ns_ = heard_ns_;
  const AnswerLedger::Settled settled = ledger_.settle();
  story_.count(LinkStory::kDoubled, static_cast<std::uint64_t>(settled.doubled));
  const double cycles = static_cast<double>(std::max<std::uint64_t>(settled.cycles, 1));
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    const int lost = settled.lost[b];
    story_.count(LinkStory::kLost, static_cast<std::uint64_t>(lost));
    lost_now_ = std::max(lost_now_, lost);
    BoardState& state = board_[b];
    state.lost += std::min(1.0, cycles / kLossWindow) * (lost / cycles - state.lost);
    if (state.lost <= kLossLimit) continue;
    pending_ = Cause::kLossy;
    story_.blame(boards_[b].id);
  }
}

/// False: a reading that no motor can have made; nothing of this answer is taken for new.
bool UartBoards::takePositions(int board, const std::uint8_t* bytes, int size, std::int64_t stamp_ns) noexcept {
  CurrentReply packet;
  if (!decodePacket(*boards_[board].shape, boards_[board].id, bytes, static_cast<std::size_t>(size), packet))
    return false;
  bool believed = true;
  const int strings = static_cast<int>(device_.strings.size());
  for (int m = 0; m < boards_[board].shape->motors && first_channel_[board] + m < strings; ++m) {
    const auto result = counter_[first_channel_[board] + m].accept(packet.position[m], stamp_ns);
    believed = believed && result == CountUnwrapper::Result::kAccepted;
    if (result == CountUnwrapper::Result::kRefused) story_.count(LinkStory::kRefused);
    if (result != CountUnwrapper::Result::kRestarted) continue;
    story_.count(LinkStory::kRestarts);
    counters_restarted_ = true;
    pending_ = Cause::kRestarted;  // a board that lost power lost its length table as well
    story_.blame(boards_[board].id);
  }
  return believed;
}

/// How old a board's counts may become: less while it may hold more than the least tension, until it has answered what came
/// after the last such command.
std::int64_t UartBoards::patience(const BoardState& board) const noexcept {
  const bool may_pull = last_pull_ns_ > 0 && board.stamp_ns - period_ns_ <= last_pull_ns_;
  return static_cast<std::int64_t>(1e9 * (may_pull ? settings_.zero_after_s : settings_.silent_after_s));
}

/// What this exchange found out about the boards.
void UartBoards::judge() noexcept {
  const std::int64_t now = connection_->link->now();
  endProbation(now);
  std::uint32_t mute = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    if (now - std::max(board_[b].stamp_ns, ready_ns_) < patience(board_[b])) continue;
    mute |= 1u << boards_[b].id;
    story_.blame(boards_[b].id);
  }
  if (mute && pending_ == Cause::kNone) pending_ = Cause::kSilent;
  if (pending_ == Cause::kNone) return;
  story_.setSilentBoards(mute);
  restart(pending_);
}

bool UartBoards::allFresh() const noexcept {
  return std::all_of(board_.begin(), board_.begin() + static_cast<std::ptrdiff_t>(boards_.size()),
                     [](const BoardState& b) { return b.fresh; });
}

std::string UartBoards::describe() const {
  char text[160];
  std::snprintf(text, sizeof text, ", %.0f us a cycle, at most %.0f Hz, wire delay %u us (spread %u us)",
                1e6 * cycleSeconds(), max_rate_hz_, story_.delayUs(), story_.jitterUs());
  return where_ + ": " + listed(boards_) + text;
}

}  // namespace haptic
