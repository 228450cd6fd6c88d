#include "spidar_driver/transport/bus_restart.h"

#include <algorithm>

namespace haptic {
namespace {

constexpr std::int64_t kQuietNs = 20 * kMs;      // longer than the slowest adapter's burst of 16 ms
constexpr std::int64_t kPatienceNs = 200 * kMs;  // for silence; then the line is noisy
constexpr int kTries = 2;
constexpr int kProofTries = 4;  // a byte may be disturbed here as well
constexpr int kProofAnswers = 2;
constexpr std::int64_t kBoardDelayNs = 25000;  // of the firmware, from header to reply

/// CURRENT with a few digits on the last motor, less than its least tension, then with none.
std::vector<std::uint8_t> proofOf(const FoundBoard& board) {
  const BoardShape& shape = *board.shape;
  const std::size_t packet = static_cast<std::size_t>(commandBytes(shape, BoardCommand::kCurrent));
  const std::size_t slot = packet + static_cast<std::size_t>(paddingBytes(shape, BoardCommand::kCurrent));
  std::vector<std::uint8_t> bytes(2 * slot, 0);
  bytes[0] = bytes[slot] = headerByte(BoardCommand::kCurrent, board.id);
  bytes[packet - 2] = headerByte(BoardCommand::kBoardInfo, board.id);
  return bytes;
}

}  // namespace

std::int64_t BusRestart::questionTime(std::int64_t byte_ns, int reply_bytes) {
  return (kFifoBytes + reply_bytes) * byte_ns + kBoardDelayNs;
}

void BusRestart::prepare(const std::vector<FoundBoard>& boards, const std::vector<std::uint8_t>& zero_drive,
                         std::int64_t byte_ns) {
  boards_ = boards;
  byte_ns_ = byte_ns;
  std::vector<std::uint8_t> taught(kResyncZeros, 0);
  const std::vector<std::uint8_t> lesson = lengthLesson(boards, kResyncZeros);
  taught.insert(taught.end(), lesson.begin(), lesson.end());
  taught.insert(taught.end(), zero_drive.begin(), zero_drive.end());
  zero_ = {zeroForAnyTable(), taught, zeroForAnyTable(), taught};
  first_question_.clear();
  question_.clear();
  proof_.clear();
  for (const FoundBoard& b : boards) {
    first_question_.push_back(infoQuestion(b.id, kResyncZeros));
    question_.push_back(infoQuestion(b.id, 0));
    proof_.push_back(proofOf(b));
    stream_.know(headerByte(BoardCommand::kBoardInfo, b.id), kInfoBytes);
    stream_.know(headerByte(BoardCommand::kCurrent, b.id), replyBytes(*b.shape, BoardCommand::kCurrent));
  }
}

BusRestart::Step BusRestart::step(ByteLink& link, std::int64_t deadline_ns) noexcept {
  switch (phase_) {
    case Phase::kZero:
      return zero(link, deadline_ns);
    case Phase::kQuiet:
      return quiet(link, deadline_ns);
    case Phase::kAsk: {
      const std::size_t board = static_cast<std::size_t>(asked_) % boards_.size();
      const auto& question =
          asked_ < static_cast<int>(boards_.size()) ? first_question_[board] : question_[board];
      answered_ = false;
      since_ns_ = link.now();
      phase_ = Phase::kListen;
      if (!link.write(question.data(), question.size())) return Step::kGone;
      return listen(link, deadline_ns);
    }
    case Phase::kListen:
      return listen(link, deadline_ns);
    case Phase::kProve:
      return prove(link, deadline_ns);
  }
  return Step::kWorking;
}

/// One message after the other, each when the wire has carried the last: what waits in a buffer comes late.
BusRestart::Step BusRestart::zero(ByteLink& link, std::int64_t deadline_ns) noexcept {
  if (sent_ == 0) asked_ = tries_ = trips_ = proven_ = 0, proof_sent_ = false;
  if (sent_ > 0 && link.now() < since_ns_ && !hear(link, std::min(deadline_ns, since_ns_)))
    return Step::kGone;
  if (sent_ > 0 && link.now() < since_ns_) return Step::kWorking;
  const std::vector<std::uint8_t>& message = zero_[static_cast<std::size_t>(sent_)];
  since_ns_ = heard_ns_ = link.now() + static_cast<std::int64_t>(message.size()) * byte_ns_;
  if (++sent_ == static_cast<int>(zero_.size())) {
    sent_ = 0;
    phase_ = Phase::kQuiet;
  }
  return link.write(message.data(), message.size()) ? Step::kWorking : Step::kGone;
}

BusRestart::Step BusRestart::quiet(ByteLink& link, std::int64_t deadline_ns) noexcept {
  if (!hear(link, deadline_ns)) return Step::kGone;
  const std::int64_t now = link.now();
  if (now - std::max(since_ns_, rest_until_ns_) > kPatienceNs) {
    giveUp(Trouble::kNoisy, -1);
  } else if (now - heard_ns_ >= kQuietNs && now >= rest_until_ns_) {
    stream_.forget();
    phase_ = Phase::kAsk;
  }
  return Step::kWorking;
}

void BusRestart::take(const std::uint8_t* bytes, int size) noexcept {
  const std::size_t number =
      static_cast<std::size_t>(phase_ == Phase::kProve ? proven_ : asked_) % boards_.size();
  const FoundBoard& board = boards_[number];
  InfoReply info;
  currents_ += bytes[0] == headerByte(BoardCommand::kCurrent, board.id);
  if (!decodeInfo(bytes, size, board.id, info)) return;
  answered_ = true;
  right_ = info.model == static_cast<int>(board.shape->model);
}

/// Takes in what comes; remembers when, and whether it answers the question that is open.
bool BusRestart::hear(ByteLink& link, std::int64_t deadline_ns) noexcept {
  constexpr int kReads = 8;  // 2 kB at most: more than a wire carries in 8 ms
  const auto take = [this](const std::uint8_t* bytes, int size) { this->take(bytes, size); };
  std::array<std::uint8_t, 256> in;
  for (int i = 0; i < kReads; ++i) {
    const bool asks = phase_ == Phase::kListen || phase_ == Phase::kProve;
    const bool ready =
        asks && (answered_ || stream_.complete() || currents_ == (rest_sent_ ? kProofAnswers : 1));
    const int got = link.read(in.data(), in.size(), ready ? 0 : deadline_ns);
    if (got < 0) return false;
    if (got == 0) break;
    heard_ns_ = link.now();
    stream_.feed(in.data(), static_cast<std::size_t>(got), take);
  }
  stream_.settle(take);
  return true;
}

BusRestart::Step BusRestart::listen(ByteLink& link, std::int64_t deadline_ns) noexcept {
  if (!hear(link, deadline_ns)) return Step::kGone;
  const int boards = static_cast<int>(boards_.size());
  const FoundBoard& board = boards_[static_cast<std::size_t>(asked_ % boards)];
  if (answered_ && !right_) {
    giveUp(Trouble::kOtherBoard, board.id);
  } else if (answered_) {
    if (patience_ns_ == kPatient) slowest_ns_ = std::max(slowest_ns_, heard_ns_ - since_ns_);
    if (asked_ >= boards) trip_ns_[trips_++] = heard_ns_ - since_ns_;
    tries_ = 0;
    phase_ = Phase::kAsk;
    if (++asked_ < kRounds * boards) return Step::kWorking;
    measure();
    phase_ = Phase::kProve;
  } else if (link.now() - since_ns_ > patience_ns_) {
    stream_.abandon();
    phase_ = Phase::kAsk;
    if (++tries_ == kTries) giveUp(Trouble::kSilentBoard, board.id);
  }
  return Step::kWorking;
}

/// Two answers and nothing else: the board at the turn has taken in both commands whole.
BusRestart::Step BusRestart::prove(ByteLink& link, std::int64_t deadline_ns) noexcept {
  const std::size_t number = static_cast<std::size_t>(proven_);
  // The rest follows when the header was answered: two answers of one board at a time would garble each
  // other.
  const std::vector<std::uint8_t>& proof = proof_[number];
  // A board of three motors would not look at so few bytes: it gets all at once.
  const std::size_t before =
      static_cast<std::size_t>(commandBytes(*boards_[number].shape, BoardCommand::kCurrent)) - 2;
  const std::size_t head = before >= kFifoBytes ? before : proof.size();
  if (!proof_sent_) {
    answered_ = rest_sent_ = false;
    proof_sent_ = true;
    currents_ = 0;
    foreign_ = stream_.foreign();
    since_ns_ = link.now();
    if (!link.write(proof.data(), head)) return Step::kGone;
  }
  if (!hear(link, deadline_ns)) return Step::kGone;
  if (currents_ == 1 && !rest_sent_) {
    rest_sent_ = true;
    if (head < proof.size() && !link.write(proof.data() + head, proof.size() - head)) return Step::kGone;
    return Step::kWorking;
  }
  const bool clean = !answered_ && stream_.foreign() == foreign_;
  if (clean && currents_ == kProofAnswers && stream_.pending() == 0) {
    proof_sent_ = false;
    tries_ = 0;
    if (++proven_ < static_cast<int>(boards_.size())) return Step::kWorking;
    trouble_ = Trouble::kNone;
    return Step::kReady;
  }
  if (link.now() - since_ns_ <= patience_ns_) return Step::kWorking;
  stream_.abandon();
  proof_sent_ = false;
  if (++tries_ == kProofTries) giveUp(Trouble::kForgets, boards_[number].id);
  return Step::kWorking;
}

void BusRestart::giveUp(Trouble trouble, int id) noexcept {
  trouble_ = trouble;
  trouble_id_ = id;
  phase_ = Phase::kZero;
}

void BusRestart::measure() noexcept {
  std::sort(trip_ns_.begin(), trip_ns_.begin() + trips_);
  delay_ns_ = std::max<std::int64_t>(0, trip_ns_[trips_ / 2] - questionTime(byte_ns_));
  jitter_ns_ = trip_ns_[trips_ - 1] - trip_ns_[0];
}

}  // namespace haptic
