#include "spidar_driver/transport/board_answers.h"

#include <algorithm>
#include <cmath>

#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/bus_restart.h"

namespace haptic {
namespace {

constexpr std::int64_t kReplyDelayNs = 25000;  // of the firmware, from header to reply
constexpr std::int64_t kSplitNs = 3000000;     // an adapter may deliver a reply in two parts so far apart
// 16 kB are 80 ms of a full wire: what a busy machine has kept back comes at once, in as many pieces as there were answers.
constexpr int kDrainBytes = 16384, kDrainReads = 1024;
constexpr int kCollectReads = 64;  // of 512 bytes
constexpr std::int64_t kMarkSpareNs =
    300000;  // a mark is waited for no longer than it should take, and so much
constexpr std::int64_t kMarkEveryNs = 16000000;  // the ledger is settled so often at least; 0.8 % of the wire
constexpr std::int64_t kMarkPauseNs = 2500000;   // after a mark's answer: a doubled one has come by then
constexpr double kLossWindow = 50;               // questions over which a board's losses are averaged
// Each board is asked for its mode and currents once in such a time: a wrong mode is seen within it and one exchange more. States and
// memory together cost 3 % of a full wire.
constexpr std::int64_t kExamineNs = 30000000;
// In the idle time of the wire some board is asked as often as this, at uneven times, as a string that moves evenly shows the same part
// of a count each time: currents that change by 1 N/s are compared, and counts of a grip at
// 20 mm/s, so often that what contradicts them is seen within 0.1 and 0.2 s. 11 % of the wire at most, which nobody else wants.
constexpr std::int64_t kCompareNs = 4000000;
constexpr int kTurn = 1024;                      // counts: a board that starts anew keeps the fraction of a turn
constexpr int kOffLine = 40;                     // [counts]; so exactly, with the motion of three readings
constexpr std::int64_t kTogetherNs = 6000000;    // counters that jump within so long jump together
constexpr int kWild = 6;  // readings in a row that no motor can have made: twice as many as confirm a counter that jumped
constexpr double kLossLimit = 0.2;  // of them lost: the board is out of step, or its table is spoilt

}  // namespace

BoardAnswers::BoardAnswers(const DeviceDef& device, const UartSettings& settings, const BoardCycle& cycle,
                           LinkStory& story)
    : device_(device), settings_(settings), cycle_(cycle), story_(story) {
  silent_ns_ = static_cast<std::int64_t>(1e9 * settings_.silent_after_s);
  mark_wire_ns_ = cycle_.longest_mark_ns;
  for (std::size_t i = 0; i < device_.strings.size(); ++i) {
    const double per_count = std::max(std::abs(device_.strings[i].length_per_count), 1e-9);
    counter_[i] = CountUnwrapper(
        {settings_.max_string_speed / per_count, settings_.max_string_acceleration / per_count});
  }
  for (const FoundBoard& b : cycle_.boards())
    for (const BoardCommand command :
         {BoardCommand::kGetParam, BoardCommand::kCurrent, BoardCommand::kBoardInfo, BoardCommand::kAll})
      stream_.know(headerByte(command, b.id), replyBytes(*b.shape, command));
}

void BoardAnswers::begin(std::int64_t now_ns, std::int64_t delay_ns) noexcept {
  ready_ns_ = looked_ns_ = heard_ns_ = last_mark_ns_ = now_ns;
  ledger_.begin(cycle_.boardCount());
  stream_.forget();
  for (BoardState& b : board_) {
    b.lost = 0;
    b.unanswered_ns = 0;
    b.fresh = false;  // what came in the exchange that ended in a restart is old by now
    b.memory.begin();
    b.obedience.begin();
    b.lesson.begin();
    b.age.begin(1e-9 * static_cast<double>(cycle_.period_ns));
    b.jumped = 0;
    b.refused = 0;
  }
  exam_ = Exam{};
  age_ = PageTest{};
  exam_.taught_ns = state_ns_ = plain_ns_ = now_ns;
  delay_ns_ = fastest_ns_ = delay_ns;
  trouble_ = Cause::kNone;
  story_.setDelay(delay_ns_);
}

/// One read, until `deadline_ns` at most. Returns the bytes that came; -1: the line is gone.
int BoardAnswers::hear(ByteLink& link, std::uint64_t exchange, std::int64_t deadline_ns) noexcept {
  std::array<std::uint8_t, 512> in;
  const std::int64_t before = link.now();
  const int got = link.read(in.data(), in.size(), deadline_ns);
  const std::int64_t now = link.now();
  const auto take = [this, exchange](const std::uint8_t* bytes, int size) {
    takeReply(bytes, size, exchange);
  };
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

bool BoardAnswers::drain(ByteLink& link, std::uint64_t exchange) noexcept {
  int got = 1, bytes = 0;
  for (int i = 0; i < kDrainReads && got > 0 && bytes < kDrainBytes; ++i) bytes += got = hear(link, exchange, 0);
  if (got < 0) return false;
  if (got > 0) trouble_ = Cause::kNoise;
  if (stream_.pending() > 0 && link.now() - heard_ns_ > kSplitNs) stream_.abandon();
  const std::uint64_t foreign = stream_.foreign();
  story_.count(LinkStory::kForeign, foreign - foreign_seen_);
  foreign_seen_ = foreign;
  return true;
}

/// The mark is waited for too, when it is due within the wait: who does not watch the line when it comes does
/// not know the delay.
bool BoardAnswers::collect(ByteLink& link, std::uint64_t exchange, std::int64_t sent_ns) noexcept {
  const std::int64_t deadline = sent_ns + cycle_.wait_ns;
  const std::int64_t due = ledger_.markSent() + BusRestart::questionTime(cycle_.byte_ns, mark_reply_bytes_) +
                           delay_ns_ + kMarkSpareNs;
  const bool own = ownAnswers();
  const bool timed = mark_ != Mark::kState && mark_ != Mark::kExam;  // their answers may come while the tick computes
  const std::int64_t mark_deadline = !timed ? 0 : own ? std::min(due, deadline) : due <= deadline ? due : 0;
  const auto answered = [&] { return own ? ledger_.owed() == 0 : allFresh(); };
  const auto done = [&] { return answered() && (!ledger_.marked() || link.now() >= mark_deadline); };
  for (int i = 0; i < kCollectReads; ++i) {
    const bool look = stream_.complete() || done();  // only silence proves the last reply
    const int got = hear(link, exchange, look ? 0 : answered() ? mark_deadline : deadline);
    if (got < 0) return false;
    if (got == 0 && (!look || done())) break;
  }
  return true;
}

void BoardAnswers::suspect(Cause cause, int board) noexcept {
  trouble_ = cause;
  story_.blame(cycle_.boards()[board].id);
}

void BoardAnswers::takeReply(const std::uint8_t* bytes, int size, std::uint64_t exchange) noexcept {
  const int board = cycle_.boardOf(bytes[0] & 7);
  if (board < 0) return;
  if (bytes[0] == headerByte(BoardCommand::kCurrent, cycle_.boards()[board].id))
    takeAnswer(board, bytes, size, exchange);
  else
    takeMark(board, bytes, size);
}

void BoardAnswers::takeAnswer(int board, const std::uint8_t* bytes, int size,
                              std::uint64_t exchange) noexcept {
  const AnswerLedger::Credit question = ledger_.answer(board);
  if (!question.owed) return story_.count(LinkStory::kDoubled);
  if (question.exchange != exchange) story_.count(LinkStory::kLate);
  const std::int64_t stamp = question.sent_ns + cycle_.offsetNs(board) + kReplyDelayNs;
  board_[board].heard_ns = stamp;
  const bool believed = takePositions(board, bytes, size, stamp);
  board_[board].refused = believed ? 0 : board_[board].refused + 1;
  if (!believed) return;
  board_[board].exchange = question.exchange;
  board_[board].stamp_ns = stamp;
  board_[board].unanswered_ns = 0;
  board_[board].fresh = true;
}

/// False: a reading that no motor can have made; nothing of this answer is taken for new.
bool BoardAnswers::takePositions(int board, const std::uint8_t* bytes, int size,
                                 std::int64_t stamp_ns) noexcept {
  const FoundBoard& found = cycle_.boards()[board];
  CurrentReply packet;
  if (!decodePacket(*found.shape, found.id, bytes, static_cast<std::size_t>(size), packet)) return false;
  board_[board].age.take(found.shape->motors, packet.position, stamp_ns);
  bool believed = true;
  const int strings = static_cast<int>(device_.strings.size()), first = cycle_.firstChannel(board);
  for (int m = 0; m < found.shape->motors && first + m < strings; ++m) {
    const auto result = counter_[first + m].accept(packet.position[m], stamp_ns);
    believed = believed && result != CountUnwrapper::Result::kRefused;
    if (result == CountUnwrapper::Result::kRefused) story_.count(LinkStory::kRefused);
    if (result != CountUnwrapper::Result::kJumped || !startedAnew(board, m, packet, stamp_ns)) continue;
    story_.count(LinkStory::kRestarts);
    counters_restarted_ = true;
    suspect(Cause::kRestarted, board);  // a board that lost power lost its length table as well
  }
  if (board_[board].age.evidence().decided()) suspect(Cause::kOldCounts, board);
  return believed;
}

/// The counter of a motor jumped: with others of its board, or by whole turns? After a start all of a board's counters are within a
/// turn of zero: one that jumped alone, by a turn or so, is a string's that slipped or hangs.
bool BoardAnswers::startedAnew(int board, int motor, const CurrentReply& packet, std::int64_t stamp_ns) noexcept {
  BoardState& b = board_[board];
  if (stamp_ns - b.jumped_ns > kTogetherNs) b.jumped = 0;
  b.jumped |= 1u << motor;
  b.jumped_ns = stamp_ns;
  const bool together = (b.jumped & (b.jumped - 1)) != 0;
  const CountUnwrapper& counter = counter_[cycle_.firstChannel(board) + motor];
  const int turns = static_cast<int>(std::lround(static_cast<double>(counter.jump()) / kTurn));
  const bool whole_turns = turns != 0 && std::abs(counter.jump() - turns * kTurn) <= kOffLine;
  const int motors = cycle_.boards()[board].shape->motors;
  const bool at_start = std::all_of(packet.position.begin(), packet.position.begin() + motors,
                                    [](int position) { return std::abs(position) <= kTurn + kOffLine; });
  return at_start && (together || whole_turns);
}

/// The answers to the last question are all here, or will not come.
void BoardAnswers::settleExam() noexcept {
  if (exam_.answers == 0) return;
  if (!board_[exam_.board].lesson.take(exam_.kind, exam_.answers)) suspect(Cause::kTableSpoilt, exam_.board);
  exam_.answers = 0;
}

/// Lengths are bytes like headers: a board that may be inside of a packet must not wake in the middle of a lesson. So all that was
/// asked is answered first, as far as answers can tell.
const std::vector<std::uint8_t>* BoardAnswers::teach(std::int64_t now_ns, std::int64_t room_ns) noexcept {
  const std::int64_t since = now_ns - exam_.taught_ns;
  if (since < BoardLesson::kEveryNs || ledger_.marked() || (ownAnswers() && ledger_.owed() > 0)) return nullptr;
  settleExam();
  const bool next = exam_.kind == BoardLesson::kLong;
  if (next && !board_[exam_.board].lesson.doubtful()) exam_.board = (exam_.board + 1) % cycle_.boardCount();
  const auto kind = next ? BoardLesson::kShort : BoardLesson::kLong;
  const auto fits = [&](int exam) {
    return static_cast<std::int64_t>(cycle_.lesson(kind, exam).size()) * cycle_.byte_ns <= room_ns;
  };
  const bool asks = fits(exam_.board) && !expired(now_ns);
  // Where the wire has no idle time at all the next cycle waits.
  if (!asks && !fits(-1) && since < BoardLesson::kEveryNs + kMarkPauseNs) return nullptr;
  exam_.kind = kind;
  exam_.taught_ns = now_ns;
  if (!asks) return &cycle_.lesson(kind, -1);
  mark_ = Mark::kExam;
  ledger_.mark(exam_.board, now_ns);
  last_mark_ns_ = now_ns;
  return &cycle_.lesson(kind, exam_.board);
}

/// BOARD_INFO was answered once more, right behind the answer to the question behind a lesson.
bool BoardAnswers::takeSecondAnswer(int board) noexcept {
  if (exam_.answers != 1 || exam_.board != board || heard_ns_ - exam_.heard_ns > kMarkPauseNs) return false;
  exam_.answers = 2;
  return true;
}

void BoardAnswers::tellBoards(std::int64_t now_ns) noexcept {
  const int strings = static_cast<int>(device_.strings.size());
  for (int b = 0; b < cycle_.boardCount(); ++b)
    for (int m = 0; m < cycle_.boards()[b].shape->currents && cycle_.firstChannel(b) + m < strings; ++m)
      board_[b].obedience.tell(m, cycle_.digit(cycle_.firstChannel(b) + m), now_ns);
}

void BoardAnswers::takeState(int board, const std::uint8_t* bytes, int size) noexcept {
  const FoundBoard& found = cycle_.boards()[board];
  AllReply reply;
  if (!decodePacket(*found.shape, found.id, bytes, static_cast<std::size_t>(size), reply)) return;
  const int motors = std::min(found.shape->motors, static_cast<int>(device_.strings.size()) - cycle_.firstChannel(board));
  compareCounts(board, found.shape->motors, reply);
  const BoardObedience::Verdict verdict = board_[board].obedience.take(*found.shape, motors, reply);
  if (verdict == BoardObedience::Verdict::kWrongMode) suspect(Cause::kWrongMode, board);
  if (verdict == BoardObedience::Verdict::kCurrentsIgnored) suspect(Cause::kCurrentsIgnored, board);
}

/// Several boards that are late together tell sooner than each of them.
void BoardAnswers::compareCounts(int board, int motors, const AllReply& reply) noexcept {
  const std::int64_t latch_ns = ledger_.markSent() + kReplyDelayNs;
  AnswerAge& age = board_[board].age;
  age_.add(age.compare(motors, reply.position, latch_ns));
  if (!age_.decided() && !age.evidence().decided()) return;
  int oldest = 0;
  for (int b = 1; b < cycle_.boardCount(); ++b)
    if (board_[b].age.evidence().sum() > board_[oldest].age.evidence().sum()) oldest = b;
  suspect(Cause::kOldCounts, oldest);
}

void BoardAnswers::takeMark(int board, const std::uint8_t* bytes, int size) noexcept {
  const FoundBoard& found = cycle_.boards()[board];
  const Mark kind = bytes[0] == headerByte(BoardCommand::kGetParam, found.id) ? Mark::kMemory
                    : bytes[0] == headerByte(BoardCommand::kAll, found.id)    ? Mark::kState
                                                                              : Mark::kInfo;
  InfoReply info;
  if (kind == Mark::kInfo && !decodeInfo(bytes, size, found.id, info)) return;
  const bool exam = mark_ == Mark::kExam;
  if (!ledger_.marked() || ledger_.markBoard() != board || kind != (exam ? Mark::kInfo : mark_)) {
    if (kind != Mark::kInfo || !takeSecondAnswer(board)) story_.count(LinkStory::kDoubled);
    return;
  }
  switch (kind) {
    case Mark::kMemory: {
      ParamReply param;
      if (!decodePacket(*found.shape, found.id, bytes, static_cast<std::size_t>(size), param)) return;
      const BoardMemory::Verdict verdict = board_[board].memory.take(mark_param_, param.type);
      const bool power_lost = verdict == BoardMemory::Verdict::kPowerLost;
      counters_restarted_ = counters_restarted_ || power_lost;  // whether its counters went on nobody can know
      if (verdict != BoardMemory::Verdict::kFine) suspect(power_lost ? Cause::kPowerLost : Cause::kTableSpoilt, board);
      break;
    }
    case Mark::kState:
      takeState(board, bytes, size);
      break;
    case Mark::kInfo:
    case Mark::kExam:
      if (info.model != static_cast<int>(found.shape->model)) suspect(Cause::kOtherBoard, board);
      if (exam) exam_.answers = 1, exam_.heard_ns = heard_ns_;
  }
  if (kind != Mark::kState && !exam) measureDelay();
  settleLosses();
}

void BoardAnswers::measureDelay() noexcept {
  const std::int64_t trip = BusRestart::questionTime(cycle_.byte_ns, mark_reply_bytes_) + ledger_.markSent();
  const std::int64_t delay = std::max<std::int64_t>(0, heard_ns_ - trip);
  // It came just now, or at some time since somebody looked.
  const std::int64_t least = waited_ ? delay : std::clamp<std::int64_t>(looked_ns_ - trip, 0, delay);
  delay_ns_ = waited_ ? delay_ns_ + (delay - delay_ns_) / 4 : std::clamp(delay_ns_, least, delay);
  fastest_ns_ = std::min(least, fastest_ns_ + (least - fastest_ns_) / 4);
  story_.setDelay(delay_ns_);
  last_mark_ns_ = plain_ns_ = heard_ns_;
}

void BoardAnswers::settleLosses() noexcept {
  std::array<AnswerLedger::Credit, kMaxBoards> oldest;
  for (int b = 0; b < cycle_.boardCount(); ++b) oldest[static_cast<std::size_t>(b)] = ledger_.oldest(b);
  const AnswerLedger::Settled settled = ledger_.settle();
  story_.count(LinkStory::kDoubled, static_cast<std::uint64_t>(settled.doubled));
  const double cycles = static_cast<double>(std::max<std::uint64_t>(settled.cycles, 1));
  for (int b = 0; b < cycle_.boardCount(); ++b) {
    const int lost = settled.lost[b];
    if (lost > 0 && board_[b].unanswered_ns == 0) board_[b].unanswered_ns = oldest[static_cast<std::size_t>(b)].sent_ns;
    story_.count(LinkStory::kLost, static_cast<std::uint64_t>(lost));
    lost_ = std::max(lost_, lost);
    board_[b].lost += std::min(1.0, cycles / kLossWindow) * (lost / cycles - board_[b].lost);
    if (board_[b].lost > kLossLimit) suspect(Cause::kAnswersLost, b);
  }
}

bool BoardAnswers::markDue(std::int64_t sent_ns, std::int64_t idle_ns) noexcept {
  if (ledger_.marked() && (ledger_.overtaken() || sent_ns - ledger_.markSent() > silent_ns_)) dropMark();
  if (ledger_.marked()) return false;
  const std::int64_t since = sent_ns - last_mark_ns_;
  if (sent_ns - plain_ns_ >= kMarkEveryNs || stateDue(sent_ns, idle_ns)) return since >= kMarkPauseNs;
  const bool doubtful = ledger_.owed() > 0 || expired(sent_ns);
  // A second answer to ALL would not be taken for that of another mark: no pause behind it.
  const std::int64_t pause = mark_ == Mark::kState ? 0 : kMarkPauseNs;
  return doubtful && idle_ns >= mark_wire_ns_ && since >= std::max(cycle_.period_ns, pause);
}

const std::vector<std::uint8_t>* BoardAnswers::ask(std::int64_t sent_ns, std::uint64_t exchange,
                                                   std::int64_t idle_ns) noexcept {
  const bool marks = markDue(sent_ns, idle_ns);
  askPlain(sent_ns, exchange);
  tellBoards(sent_ns);
  if (!marks) return nullptr;
  const std::vector<std::uint8_t>& mark = chooseMark(sent_ns, stateDue(sent_ns, idle_ns));
  ledger_.mark(mark_ == Mark::kState ? next_state_ : next_mark_, sent_ns + cycle_.cycle_ns);
  last_mark_ns_ = sent_ns;
  return &mark;
}

bool BoardAnswers::hasRoom(const std::vector<std::uint8_t>& mark) const noexcept {
  return cycle_.slot_ns + static_cast<std::int64_t>(mark.size()) * cycle_.byte_ns < cycle_.period_ns;
}

/// The next mark's bytes, where the period has room for them: ALL when it is due, GET_PARAM where the board answers it, else
/// BOARD_INFO.
const std::vector<std::uint8_t>& BoardAnswers::chooseMark(std::int64_t now_ns, bool state_due) noexcept {
  if (state_due && now_ns - plain_ns_ < kMarkEveryNs) {
    if (!board_[next_state_].obedience.doubtful()) next_state_ = (next_state_ + 1) % cycle_.boardCount();
    state_ns_ = now_ns;
    ++state_asked_;
    mark_ = Mark::kState;
    board_[next_state_].obedience.ask();
    return cycle_.stateMark(next_state_);
  }
  plain_ns_ = now_ns;
  next_mark_ = (next_mark_ + 1) % cycle_.boardCount();
  const BoardMemory& state = board_[next_mark_].memory;
  const std::vector<std::uint8_t>& memory = cycle_.memoryMark(next_mark_, state.next());
  const bool asks_memory = hasRoom(memory) && state.answers();
  const std::vector<std::uint8_t>& mark = asks_memory ? memory : cycle_.infoMark(next_mark_);
  mark_ = asks_memory ? Mark::kMemory : Mark::kInfo;
  mark_param_ = asks_memory ? memory[1] : -1;
  mark_reply_bytes_ =
      asks_memory ? replyBytes(*cycle_.boards()[next_mark_].shape, BoardCommand::kGetParam) : kInfoBytes;
  mark_wire_ns_ = static_cast<std::int64_t>(mark.size()) * cycle_.byte_ns;
  return mark;
}

bool BoardAnswers::stateDue(std::int64_t now_ns, std::int64_t idle_ns) const noexcept {
  const std::vector<std::uint8_t>& question = cycle_.stateMark((next_state_ + 1) % cycle_.boardCount());
  const bool again = board_[next_state_].obedience.doubtful();
  const bool idle = idle_ns >= static_cast<std::int64_t>(question.size()) * cycle_.byte_ns;
  const std::int64_t uneven = state_asked_ * 5 % 3 * 1000000;  // 0, 2, 1 ms
  const std::int64_t every = again ? kMarkPauseNs : idle ? kCompareNs - 1000000 + uneven : kExamineNs / cycle_.boardCount();
  return now_ns - state_ns_ >= every && hasRoom(question) && !expired(now_ns);
}

/// The mark's answer will not come; what its board took in is not known.
void BoardAnswers::dropMark() noexcept {
  if (mark_ == Mark::kMemory) board_[ledger_.markBoard()].memory.lose();
  ledger_.dropMark();
}

bool BoardAnswers::expired(std::int64_t at_ns) const noexcept {
  for (int b = 0; b < cycle_.boardCount(); ++b)
    if (board_[b].stamp_ns < ready_ns_ || at_ns - board_[b].stamp_ns > silent_ns_ ||
        board_[b].memory.unproven())
      return true;
  return false;
}

bool BoardAnswers::wild() const noexcept {
  return std::any_of(board_.begin(), board_.begin() + cycle_.boardCount(), [](const BoardState& b) { return b.refused >= kWild; });
}

/// A board is silent since the first question that it owes an answer to, not since the last answer: a loop
/// that stood still has asked nothing. Patience is less while the board may hold more than the least tension,
/// until it has answered what came after the last such command.
std::uint32_t BoardAnswers::mute(std::int64_t now_ns, std::int64_t last_pull_ns) const noexcept {
  std::uint32_t ids = 0;
  for (int b = 0; b < cycle_.boardCount(); ++b) {
    const AnswerLedger::Credit question = ledger_.oldest(b);
    if (!question.owed) continue;
    // Another board's mark may have proven the first answers lost.
    const std::int64_t asked = board_[b].unanswered_ns > 0 ? board_[b].unanswered_ns : question.sent_ns;
    const std::int64_t since = std::max({board_[b].heard_ns, ready_ns_, resumed_ns_, asked - cycle_.period_ns});
    const bool may_pull = last_pull_ns > 0 && board_[b].stamp_ns - cycle_.period_ns <= last_pull_ns;
    if (now_ns - since <
        static_cast<std::int64_t>(1e9 * (may_pull ? settings_.zero_after_s : settings_.silent_after_s)))
      continue;
    ids |= 1u << cycle_.boards()[b].id;
    story_.blame(cycle_.boards()[b].id);
  }
  return ids;
}

bool BoardAnswers::allFresh() const noexcept {
  return std::all_of(board_.begin(), board_.begin() + cycle_.boardCount(),
                     [](const BoardState& b) { return b.fresh; });
}

void BoardAnswers::takeFresh() noexcept {
  for (BoardState& b : board_) b.fresh = false;
}

void BoardAnswers::read(DeviceSample& s, std::uint64_t exchange) const noexcept {
  s.stamp_ns = board_[0].stamp_ns;
  std::uint64_t oldest = board_[0].exchange;
  for (int b = 1; b < cycle_.boardCount(); ++b) {
    s.stamp_ns = std::min(s.stamp_ns, board_[b].stamp_ns);
    oldest = std::min(oldest, board_[b].exchange);
  }
  for (std::size_t i = 0; i < device_.strings.size(); ++i) s.counts[i] = counter_[i].countAt(s.stamp_ns);
  s.age_ticks = static_cast<std::uint32_t>(exchange - oldest);
  s.lost = static_cast<std::uint16_t>(lost_);
}

}  // namespace haptic
