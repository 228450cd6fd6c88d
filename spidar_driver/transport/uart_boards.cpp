#include "spidar_driver/transport/uart_boards.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/drive_limits.h"

namespace haptic {
namespace {

constexpr int kBitsPerByte = 10;  // 8N1
constexpr int kZeroLead = 90;     // ends any packet a board in step may be inside of
constexpr std::int64_t kSpareNs = 100000;  // least wait beyond the cycle's wire time: the adapter's latency
constexpr double kWaitShare = 0.8;         // of the period; the rest is left to the tick
// A disturbed command can reach a board as SET_CMDLEN and spoil its length table. What costs answers is healed by a
// restart; what does not, by a lesson so often. Not oftener: a board that is out of step takes the end of a lesson for
// another one and is spoilt by it, so zeros go ahead, as many as the period has room for.
constexpr std::int64_t kLessonEveryNs = 1000000000;
constexpr int kLessonLead = 90;
constexpr std::int64_t kMarkEveryNs = 16000000;  // the ledger is settled so often at least; 0.8 % of the wire
constexpr std::int64_t kMarkPauseNs = 2500000;   // after a mark's answer: a doubled one has come by then
// A board that falls out of step again and again within such a time keeps nothing of what it is taught: its table may cut
// SET_CMDLEN itself short. Only power helps; until then it is asked so seldom.
constexpr std::int64_t kProbationNs = 1000000000;
constexpr int kRelapses = 3;
constexpr std::int64_t kRestNs = 1000000000;
constexpr int kOpeningSteps = 3000;              // of at most 1 ms each
constexpr std::int64_t kOpeningStepNs = 1000000;

/// The nearest current whose low byte is none of them: one digit less for each board on the bus at most, 0.01 N each; more
/// where less would be below `least`.
int harmlessDigit(int digit, int least, const std::vector<FoundBoard>& boards) {
  const int away = digit > 0 ? 1 : -1;
  int smaller = digit, greater = digit;
  for (int i = 0; i < kMaxBoards && spoilsBoards(smaller & 0xFF, boards); ++i) smaller -= away;
  for (int i = 0; i < kMaxBoards && spoilsBoards(greater & 0xFF, boards); ++i) greater += away;
  return std::abs(smaller) >= std::abs(least) ? smaller : greater;
}

}  // namespace

UartBoards::UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where,
                       OpenLink open)
    : device_(device), settings_(settings), where_(where), recovery_(device_, settings, where, std::move(open), story_) {
  if (device_.strings.empty() || device_.strings.size() > kMaxStrings)
    throw SetupError(device_.file, "has no strings, or more than " + std::to_string(kMaxStrings),
                     "correct `strings`");
  std::unique_ptr<ByteLink> link = recovery_.open();
  boards_ = matchBoards(scanBus(*link), device_, where_);
  layOutCycle();
  if (!(settings_.rate_hz > 0) || settings_.rate_hz > max_rate_hz_) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.0f Hz asked, but the wire carries at most %.0f Hz (%zu bytes a cycle, %d baud)",
                  settings_.rate_hz, max_rate_hz_, cycle_bytes_, settings_.baud);
    throw SetupError(device_.name, text, "set the rate to at most that");
  }
  period_ns_ = static_cast<std::int64_t>(1e9 / settings_.rate_hz);
  silent_ns_ = static_cast<std::int64_t>(1e9 * settings_.silent_after_s);
  const double wait_s = settings_.reply_wait_s > 0 ? settings_.reply_wait_s : kWaitShare / settings_.rate_hz;
  wait_ns_ = std::max(static_cast<std::int64_t>(wait_s * 1e9), cycle_ns_ + kSpareNs);
  lesson_ = lengthLesson(boards_);
  const std::int64_t room = (period_ns_ - slot_ns_) / byte_ns_ - static_cast<std::int64_t>(lesson_.size());
  lesson_.insert(lesson_.begin(), static_cast<std::size_t>(std::clamp<std::int64_t>(room, 0, kLessonLead)), 0);
  connection_ = recovery_.connect(std::move(link), zero_cycle_);
  awaitBoards();
  recovery_.start(boards_, zero_cycle_);
}

UartBoards::~UartBoards() {
  recovery_.stop();
  adoptConnection();
  zeroDrive();
}

void UartBoards::layOutCycle() {
  byte_ns_ = static_cast<std::int64_t>(1e9 * kBitsPerByte / settings_.baud);
  int channel = 0;
  std::size_t longest_mark = 0;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    cycle_offset_[b] = static_cast<int>(cycle_bytes_);
    first_channel_[b] = channel;
    for (int m = 0; m < shape.motors && channel < static_cast<int>(device_.strings.size()); ++m, ++channel) {
      const double per_count = std::max(std::abs(device_.strings[channel].length_per_count), 1e-9);
      counter_[channel] =
          CountUnwrapper({settings_.max_string_speed / per_count, settings_.max_string_acceleration / per_count});
    }
    cycle_bytes_ += commandBytes(shape, BoardCommand::kCurrent) + paddingBytes(shape, BoardCommand::kCurrent);
    mark_[b] = infoQuestion(boards_[b].id, 0);
    for (int k = 0; k < 2; ++k) memory_mark_[b][k] = paramQuestion(boards_[b], BoardMemory::kParams[k]);
    longest_mark = std::max({longest_mark, mark_[b].size(), memory_mark_[b][0].size()});
    stream_.know(headerByte(BoardCommand::kGetParam, boards_[b].id), replyBytes(shape, BoardCommand::kGetParam));
    stream_.know(headerByte(BoardCommand::kCurrent, boards_[b].id), replyBytes(shape, BoardCommand::kCurrent));
    stream_.know(headerByte(BoardCommand::kBoardInfo, boards_[b].id), kInfoBytes);
  }
  cycle_.assign(cycle_bytes_ + longest_mark, 0);
  encodeCycle(DriveCommand{}, false);
  zero_cycle_.assign(kZeroLead, 0);
  zero_cycle_.insert(zero_cycle_.end(), cycle_.begin(), cycle_.begin() + static_cast<std::ptrdiff_t>(cycle_bytes_));
  restart_.prepare(boards_, zero_cycle_, byte_ns_);
  cycle_ns_ = static_cast<std::int64_t>(cycle_bytes_) * byte_ns_;
  mark_wire_ns_ = static_cast<std::int64_t>(longest_mark) * byte_ns_;
  max_rate_hz_ = std::min(1e9 / static_cast<double>(cycle_ns_), device_.max_rate_hz);
  slot_ns_ = static_cast<std::int64_t>(std::ceil(1e9 / max_rate_hz_ - 1e-3));
}

/// Set-up: waits until the boards are in step. The scan has heard all of them: one that is late now is asked again.
void UartBoards::awaitBoards() {
  restart(Cause::kOpened);
  for (int i = 0; i < kOpeningSteps && restarting_ && restart_.trouble() != BusRestart::Trouble::kOtherBoard; ++i)
    if (stepRestart(kOpeningStepNs) == Line::kGone)
      throw SetupError(where_, "the port was lost while it was opened", "check the cable and the adapter");
  if (!restarting_) return;
  throw SetupError(where_, trouble().empty() ? "the boards do not come into step" : trouble(),
                   "check power and cable, then start again");
}

DeviceSample UartBoards::exchange(const DriveCommand& command) noexcept {
  ++exchanges_;
  lost_now_ = 0;
  adoptConnection();
  if (!connection_) return sample();
  Line line = Line::kFine;
  if (restarting_) {
    line = stepRestart(wait_ns_);
  } else {
    waitForWire();
    line = drain();
    if (line == Line::kFine && pending_ == Cause::kNone) line = send(command);
    if (line == Line::kFine && pending_ == Cause::kNone) line = collect();
    if (line == Line::kFine) judge();
  }
  if (line == Line::kGone) disconnect();
  return sample();
}

void UartBoards::adoptConnection() noexcept {
  Connection* fresh = recovery_.takeOpened();
  if (!fresh) return;
  connection_.reset(fresh);  // empty since disconnect: nothing is freed here
  story_.count(LinkStory::kReconnects);
  restart(Cause::kOpened);
}

void UartBoards::disconnect() noexcept {
  armed_ = false;
  if (connection_) recovery_.replace(std::move(connection_));
}

/// The boards are not, or may not be, in step: no current, and no command until they are.
void UartBoards::restart(Cause cause) noexcept {
  pending_ = Cause::kNone;
  restarting_ = true;
  const std::int64_t now = connection_->link->now();
  const bool lapse = cause == Cause::kLossy || cause == Cause::kSilent || cause == Cause::kDisobeys;
  relapses_ = lapse && now - ready_ns_ < kProbationNs ? relapses_ + 1 : 0;
  if (cause != Cause::kOpened) story_.setCause(cause);
  zeroDrive();
  if (relapses_ < kRelapses)
    restart_.begin();
  else
    restart_.beginAfter(now + kRestNs, story_.blamed());
}

/// Boards that stayed in step have got over it.
void UartBoards::endProbation(std::int64_t now_ns) noexcept {
  if (relapses_ == 0 || now_ns - ready_ns_ < kProbationNs) return;
  relapses_ = 0;
  story_.setTrouble(BusRestart::Trouble::kNone, -1);
}

UartBoards::Line UartBoards::stepRestart(std::int64_t patience_ns) noexcept {
  ByteLink& link = *connection_->link;
  const BusRestart::Step step = restart_.step(link, link.now() + patience_ns);
  if (connection_->guard) connection_->guard->beat(false);
  story_.setTrouble(restart_.trouble(), restart_.troubleBoard());
  if (restart_.trouble() == BusRestart::Trouble::kSilentBoard)
    story_.setSilentBoards(1u << restart_.troubleBoard());
  if (step == BusRestart::Step::kGone) return Line::kGone;
  if (step == BusRestart::Step::kWorking) return Line::kFine;
  restarting_ = false;
  if (relapses_ >= kRelapses)  // in step for now: the advice stands until they have stayed so
    story_.setTrouble(BusRestart::Trouble::kForgets, story_.blamed());
  story_.setSilentBoards(0);
  ready_ns_ = looked_ns_ = heard_ns_ = last_mark_ns_ = link.now();
  wire_free_ns_ = ready_ns_;
  last_pull_ns_ = 0;
  ledger_.begin(static_cast<int>(boards_.size()));
  stream_.forget();
  for (BoardState& b : board_) b.lost = 0, b.memory.begin();
  delay_ns_ = fastest_ns_ = restart_.delay();
  story_.setDelay(delay_ns_);
  story_.setJitter(restart_.jitter());
  story_.count(LinkStory::kRetaught);
  return Line::kFine;
}

void UartBoards::waitForWire() noexcept {
  if (connection_->link->now() >= wire_free_ns_) return;
  story_.count(LinkStory::kOverRate);
  connection_->link->waitUntil(wire_free_ns_);
}

/// True when the counts of some board are, at that instant, older than force may act on, or older than the last restart; or
/// when a board that can show it has not shown yet that it takes in what it is told.
bool UartBoards::expired(std::int64_t at_ns) const noexcept {
  for (std::size_t b = 0; b < boards_.size(); ++b)
    if (board_[b].stamp_ns < ready_ns_ || at_ns - board_[b].stamp_ns > silent_ns_ ||
        board_[b].memory.unproven())
      return true;
  return false;
}

/// The next mark's bytes: GET_PARAM where the board answers it and the period has room, else BOARD_INFO.
const std::vector<std::uint8_t>& UartBoards::chooseMark() noexcept {
  next_mark_ = (next_mark_ + 1) % static_cast<int>(boards_.size());
  const BoardMemory& state = board_[next_mark_].memory;
  const std::vector<std::uint8_t>& memory = memory_mark_[next_mark_][state.next()];
  const bool room = slot_ns_ + static_cast<std::int64_t>(memory.size()) * byte_ns_ < period_ns_;
  const bool asks_memory = room && state.answers();
  const std::vector<std::uint8_t>& mark = asks_memory ? memory : mark_[next_mark_];
  mark_param_ = asks_memory ? memory[1] : -1;
  mark_reply_bytes_ = asks_memory ? replyBytes(*boards_[next_mark_].shape, BoardCommand::kGetParam) : kInfoBytes;
  mark_wire_ns_ = static_cast<std::int64_t>(mark.size()) * byte_ns_;
  return mark;
}

/// The mark's answer will not come; what its board took in is not known.
void UartBoards::dropMark() noexcept {
  if (mark_param_ >= 0) board_[ledger_.markBoard()].memory.lose();
  ledger_.dropMark();
}

bool UartBoards::markDue() const noexcept {
  if (ledger_.marked()) return false;
  if (sent_ns_ - last_mark_ns_ >= kMarkEveryNs) return true;
  const bool idle = sent_ns_ - wire_free_ns_ >= mark_wire_ns_;
  const bool unproven = expired(sent_ns_);
  return (ledger_.owed() > 0 || unproven) && idle && sent_ns_ - last_mark_ns_ >= std::max(period_ns_, kMarkPauseNs);
}

void UartBoards::encodeCycle(const DriveCommand& command, bool usable) noexcept {
  const int strings = static_cast<int>(device_.strings.size());
  armed_ = false;
  for (std::size_t b = 0; b < boards_.size(); ++b) {
    const BoardShape& shape = *boards_[b].shape;
    CurrentCommand packet;
    for (int m = 0; m < shape.motors && usable; ++m) {
      const int channel = first_channel_[b] + m;
      if (channel >= strings) break;
      bool clamped = false;
      const StringDef& string = device_.strings[channel];
      const int digit = driveDigit(shape, allowedVoltage(string, command.voltage[channel], clamped));
      const int least = driveDigit(shape, string.min_tension * string.volt_per_newton);
      packet.current[m] = static_cast<std::int16_t>(harmlessDigit(digit, std::abs(digit) < std::abs(least) ? 0 : least, boards_));
      if (clamped) story_.count(LinkStory::kClamped);
      if (std::abs(digit) > std::abs(least)) last_pull_ns_ = sent_ns_;
      armed_ = armed_ || packet.current[m] != 0;
    }
    encodePacket(shape, boards_[b].id, packet, cycle_.data() + cycle_offset_[b], cycle_bytes_ - cycle_offset_[b]);
  }
}

UartBoards::Line UartBoards::send(const DriveCommand& command) noexcept {
  const bool finite = finiteDrive(device_, command);
  if (!finite) story_.count(LinkStory::kBadCommands);
  ByteLink& link = *connection_->link;
  sent_ns_ = link.now();
  // What is sent now acts until the next exchange.
  encodeCycle(command, finite && !expired(sent_ns_ + period_ns_));
  if (connection_->guard && armed_) connection_->guard->arm();  // before the motors have the current
  // Lengths are bytes like headers: a board that may be inside of a packet must not wake in the middle of a lesson.
  const bool own = fastest_ns_ + cycle_ns_ + mark_wire_ns_ <= wait_ns_;
  const bool teaches = sent_ns_ - last_lesson_ns_ >= kLessonEveryNs && !(own && ledger_.owed() > 0);
  if (teaches) {
    last_lesson_ns_ = sent_ns_;
    if (!link.write(lesson_.data(), lesson_.size())) return Line::kGone;
    sent_ns_ += static_cast<std::int64_t>(lesson_.size()) * byte_ns_;
  }
  const bool mark_lost = ledger_.overtaken() || sent_ns_ - ledger_.markSent() > silent_ns_;
  if (ledger_.marked() && mark_lost) dropMark();
  const bool marks = !teaches && markDue();
  if (!ledger_.ask(sent_ns_, exchanges_)) pending_ = Cause::kSilent;
  std::size_t bytes = cycle_bytes_;
  if (marks) {
    const std::vector<std::uint8_t>& mark = chooseMark();
    std::copy(mark.begin(), mark.end(), cycle_.begin() + static_cast<std::ptrdiff_t>(bytes));
    ledger_.mark(next_mark_, sent_ns_ + cycle_ns_);
    last_mark_ns_ = sent_ns_;
    bytes += mark.size();
  }
  if (!link.write(cycle_.data(), bytes)) return Line::kGone;
  if (connection_->guard) {
    connection_->guard->beat(armed_);
    story_.setGuardStalls(connection_->guard->stalls());
  }
  wire_free_ns_ = sent_ns_ + slot_ns_ + (bytes > cycle_bytes_ ? mark_wire_ns_ : 0);
  story_.count(LinkStory::kCycles);
  return Line::kFine;
}

DeviceSample UartBoards::sample() noexcept {
  DeviceSample s;
  s.stamp_ns = board_[0].stamp_ns;
  std::uint64_t oldest = board_[0].exchange;
  for (std::size_t b = 1; b < boards_.size(); ++b) {
    s.stamp_ns = std::min(s.stamp_ns, board_[b].stamp_ns);
    oldest = std::min(oldest, board_[b].exchange);
  }
  for (std::size_t i = 0; i < device_.strings.size(); ++i) s.counts[i] = counter_[i].countAt(s.stamp_ns);
  s.age_ticks = static_cast<std::uint32_t>(exchanges_ - oldest);
  const std::int64_t age_ns = connection_ ? connection_->link->now() - s.stamp_ns : s.age_ticks * period_ns_;
  s.age_us = static_cast<std::uint32_t>(std::clamp<std::int64_t>(age_ns / 1000, 0, UINT32_MAX));
  s.lost = static_cast<std::uint16_t>(lost_now_);
  if (!connection_) {
    s.status = LinkStatus::kDisconnected;
  } else if (counters_restarted_) {
    s.status = LinkStatus::kRestarted;
    counters_restarted_ = false;
  } else if (restarting_) {
    s.status = LinkStatus::kSilent;
  } else if (allFresh()) {
    for (BoardState& b : board_) b.fresh = false;
  } else {
    s.status = LinkStatus::kStale;
  }
  if (s.status != LinkStatus::kOk) story_.count(LinkStory::kStale);
  return s;
}

void UartBoards::zeroDrive() noexcept {
  if (!connection_) return;
  const std::int64_t start = std::max(connection_->link->now(), wire_free_ns_);
  connection_->link->write(zero_cycle_.data(), zero_cycle_.size());
  ledger_.ask(start + kZeroLead * byte_ns_, exchanges_);
  if (connection_->guard) connection_->guard->beat(false);
  armed_ = false;
  wire_free_ns_ = start + static_cast<std::int64_t>(zero_cycle_.size()) * byte_ns_;
}

}  // namespace haptic
