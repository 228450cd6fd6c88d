#include "spidar_driver/transport/uart_boards.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/drive_limits.h"

namespace haptic {
namespace {

// A board that falls out of step again and again within such a time keeps nothing of what it is taught: its
// table may cut SET_CMDLEN itself short. Only power helps; until then it is asked so seldom.
constexpr std::int64_t kProbationNs = 1000000000;
constexpr int kRelapses = 3;
constexpr std::int64_t kRestNs = 1000000000;
constexpr int kOpeningSteps = 6000;  // of at most 1 ms each
constexpr std::int64_t kLateNs = 20 * kMs;  // slower than any adapter's burst of 16 ms
constexpr std::int64_t kOpeningStepNs = 1000000;

}  // namespace

UartBoards::UartBoards(const DeviceDef& device, const UartSettings& settings, const std::string& where,
                       OpenLink open)
    : device_(device),
      settings_(settings),
      where_(where),
      recovery_(device_, settings, where, std::move(open), story_) {
  if (device_.strings.empty() || device_.strings.size() > kMaxStrings)
    throw SetupError(device_.file, "has no strings, or more than " + std::to_string(kMaxStrings),
                     "correct `strings`");
  std::unique_ptr<ByteLink> link = recovery_.open();
  const BusScan scan = scanBus(*link, std::max<std::size_t>(1, device_.boards.size()));
  opening_late_ns_ = scan.late_ns;
  cycle_.emplace(device_, settings_, matchBoards(scan, device_, where_));
  answers_.emplace(device_, settings_, *cycle_, story_);
  restart_.prepare(cycle_->boards(), cycle_->zero(), cycle_->byte_ns);
  connection_ = recovery_.connect(std::move(link), cycle_->zero());
  awaitBoards();
  recovery_.start(cycle_->boards(), cycle_->zero());
}

UartBoards::~UartBoards() {
  recovery_.stop();
  adoptConnection();
  zeroDrive();
}

/// Set-up: waits until the boards are in step. The scan has heard all of them: one that is late now is asked
/// again.
void UartBoards::awaitBoards() {
  restart(Cause::kNone);
  restart_.bePatient(true);
  for (int i = 0; i < kOpeningSteps && restarting_ && restart_.trouble() != BusRestart::Trouble::kOtherBoard;
       ++i)
    if (stepRestart(kOpeningStepNs) == Line::kGone)
      throw SetupError(where_, "the port was lost while it was opened", "check the cable and the adapter");
  restart_.bePatient(false);
  opening_late_ns_ = std::max(opening_late_ns_, restart_.slowest());
  if (!restarting_) return;
  throw SetupError(where_, trouble().empty() ? "the boards do not come into step" : trouble(),
                   "check power and cable, then start again");
}

DeviceSample UartBoards::exchange(const DriveCommand& command) noexcept {
  ++exchanges_;
  answers_->beginExchange();
  adoptConnection();
  if (!connection_) return sample();
  ByteLink& link = *connection_->link;
  noteStall(link.now());
  checkGuard(link.now());
  Line line = Line::kFine;
  if (restarting_) {
    line = stepRestart(cycle_->wait_ns);
  } else {
    waitForWire();
    const auto fine = [&] { return line == Line::kFine && answers_->trouble() == Cause::kNone; };
    line = answers_->drain(link, exchanges_) ? Line::kFine : Line::kGone;
    if (fine()) line = send(command);
    if (fine()) line = answers_->collect(link, exchanges_, sent_ns_) ? Line::kFine : Line::kGone;
    if (fine()) line = teach();
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
  guarded_ = true, guard_wanted_ = false;
  restart(Cause::kNone);
}

void UartBoards::disconnect() noexcept {
  armed_ = false;
  if (connection_) recovery_.replace(std::move(connection_));
}

/// The loop itself stood still with current on: no board is to blame for what is old then.
void UartBoards::noteStall(std::int64_t now_ns) noexcept {
  const auto longest = static_cast<std::int64_t>(1e9 * settings_.zero_after_s) + cycle_->period_ns;
  const std::int64_t before = std::exchange(last_exchange_ns_, now_ns);
  if (before == 0 || now_ns - before < longest) return;
  answers_->resume(now_ns);
  if (!armed_) return;
  story_.count(LinkStory::kStalls);
  story_.setStall(now_ns - before);
  story_.setCause(Cause::kStalled);
}

/// Two that watch each other: without a guard no current, until another one watches.
void UartBoards::checkGuard(std::int64_t now_ns) noexcept {
  if (!connection_->guard) return;
  if (guard_wanted_)
    if (DriveGuard* fresh = recovery_.takeGuard()) {
      fresh->follow(*connection_->guard);
      recovery_.bury(connection_->guard.release());
      connection_->guard.reset(fresh);
      guard_wanted_ = false;
    }
  const bool before = guarded_;
  guarded_ = connection_->guard->watches(now_ns);
  if (guarded_ || guard_wanted_) return;
  if (before) story_.count(LinkStory::kUnguarded);
  if (!connection_->guard->ended()) return;  // it stands still, and may go on
  guard_wanted_ = true;
  recovery_.wantGuard(connection_->guard->port());
}

/// The boards are not, or may not be, in step: no current, and no command until they are.
void UartBoards::restart(Cause cause) noexcept {
  restarting_ = true;
  restart_cause_ = cause;
  const std::int64_t now = connection_->link->now();
  // Silence says nothing of what a board keeps: the machine may bring its answers late.
  const bool lapse = cause == Cause::kAnswersLost || cause == Cause::kTableSpoilt;
  relapses_ = lapse && now - ready_ns_ < kProbationNs ? relapses_ + 1 : 0;
  if (cause != Cause::kNone) story_.setCause(cause);
  may_hold_ = armed_;
  zeroDrive();
  if (relapses_ < kRelapses)
    restart_.begin();
  else
    restart_.beginAfter(now + kRestNs, story_.blamed());
  // A board with a spoilt table holds its currents until the restart has sent its zeros: a loop that stops before has the guard.
  if (connection_->guard) connection_->guard->beat(may_hold_);
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
  if (connection_->guard) connection_->guard->beat(may_hold_ && restart_.zeroing());
  story_.setTrouble(restart_.trouble(), restart_.troubleBoard());
  if (restart_.trouble() == BusRestart::Trouble::kSilentBoard)
    story_.setSilentBoards(1u << restart_.troubleBoard());
  if (step == BusRestart::Step::kGone) return Line::kGone;
  if (step == BusRestart::Step::kWorking) return Line::kFine;
  restarting_ = false;
  if (relapses_ >= kRelapses)  // in step for now: the advice stands until they have stayed so
    story_.setTrouble(BusRestart::Trouble::kForgets, story_.blamed());
  story_.setSilentBoards(0);
  ready_ns_ = wire_free_ns_ = link.now();
  last_pull_ns_ = 0;
  answers_->begin(ready_ns_, restart_.delay());
  story_.setJitter(restart_.jitter());
  story_.count(LinkStory::kRetaught);
  return Line::kFine;
}

void UartBoards::waitForWire() noexcept {
  if (connection_->link->now() >= wire_free_ns_) return;
  story_.count(LinkStory::kOverRate);
  connection_->link->waitUntil(wire_free_ns_);
}

/// The answers are here and the tick computes: the wire is idle.
UartBoards::Line UartBoards::teach() noexcept {
  const std::int64_t now = std::max(connection_->link->now(), wire_free_ns_);
  const std::vector<std::uint8_t>* lesson = answers_->teach(now, sent_ns_ + cycle_->period_ns - now);
  if (!lesson) return Line::kFine;
  wire_free_ns_ = now + static_cast<std::int64_t>(lesson->size()) * cycle_->byte_ns;
  return connection_->link->write(lesson->data(), lesson->size()) ? Line::kFine : Line::kGone;
}

UartBoards::Line UartBoards::send(const DriveCommand& command) noexcept {
  sent_ns_ = connection_->link->now();
  const bool finite = finiteDrive(device_, command);
  if (!finite) story_.count(LinkStory::kBadCommands);
  // What is sent now acts until the next exchange.
  const bool usable = finite && guarded_ && !answers_->expired(sent_ns_ + cycle_->period_ns);
  const BoardCycle::Drive drive = cycle_->encode(command, usable);
  armed_ = drive.armed;
  if (drive.clamped) story_.count(LinkStory::kClamped);
  if (drive.pulls) last_pull_ns_ = sent_ns_;
  if (connection_->guard && armed_) connection_->guard->arm();  // before the motors have the current
  std::size_t bytes = cycle_->size();
  if (const std::vector<std::uint8_t>* mark = answers_->ask(sent_ns_, exchanges_, sent_ns_ - wire_free_ns_))
    bytes = cycle_->append(*mark);
  if (!connection_->link->write(cycle_->bytes().data(), bytes)) return Line::kGone;
  if (connection_->guard) {
    connection_->guard->beat(armed_);
    story_.setGuardStalls(connection_->guard->stalls());
  }
  wire_free_ns_ =
      sent_ns_ + cycle_->slot_ns + static_cast<std::int64_t>(bytes - cycle_->size()) * cycle_->byte_ns;
  story_.count(LinkStory::kCycles);
  return Line::kFine;
}

/// What this exchange found out about the boards.
void UartBoards::judge() noexcept {
  const std::int64_t now = connection_->link->now();
  endProbation(now);
  const std::uint32_t mute = answers_->mute(now, last_pull_ns_);
  Cause cause = answers_->takeTrouble();
  if (mute && cause == Cause::kNone) cause = Cause::kSilent;
  story_.setProven(!answers_->expired(now));
  if (cause == Cause::kNone) return;
  story_.setSilentBoards(mute);
  restart(cause);
}

/// Why the boards are out of step, or keep being so.
WireFinding UartBoards::finding() const noexcept {
  if (!restarting_) return answers_ && answers_->wild() ? WireFinding::kCountsWild : WireFinding::kNone;
  switch (restart_.trouble()) {
    case BusRestart::Trouble::kNone:
      break;
    case BusRestart::Trouble::kSilentBoard:
      return WireFinding::kSilent;
    case BusRestart::Trouble::kOtherBoard:
      return WireFinding::kOtherBoard;
    case BusRestart::Trouble::kNoisy:
      return WireFinding::kNoise;
    case BusRestart::Trouble::kForgets:
      return WireFinding::kForgets;
  }
  return restart_cause_;
}

DeviceSample UartBoards::sample() noexcept {
  DeviceSample s;
  s.finding = finding();
  s.board = static_cast<std::int8_t>(restart_.trouble() == BusRestart::Trouble::kNone ? story_.blamed() : restart_.troubleBoard());
  answers_->read(s, exchanges_);
  const std::int64_t age_ns =
      connection_ ? connection_->link->now() - s.stamp_ns : s.age_ticks * cycle_->period_ns;
  s.age_us = static_cast<std::uint32_t>(std::clamp<std::int64_t>(age_ns / 1000, 0, UINT32_MAX));
  if (!connection_)
    s.status = LinkStatus::kDisconnected;
  else if (answers_->takeRestarted())
    s.status = LinkStatus::kRestarted;
  else if (restarting_)
    s.status = LinkStatus::kSilent;
  else if (answers_->allFresh()) {
    answers_->takeFresh();
    if (!guarded_) s.status = LinkStatus::kUnguarded;
  } else
    s.status = LinkStatus::kStale;
  if (!bringsCounts(s.status)) story_.count(LinkStory::kStale);
  return s;
}

void UartBoards::zeroDrive() noexcept {
  if (!connection_) return;
  const std::vector<std::uint8_t>& zero = cycle_->zero();
  const std::int64_t start = std::max(connection_->link->now(), wire_free_ns_);
  connection_->link->write(zero.data(), zero.size());
  answers_->askPlain(start + BoardCycle::kZeroLead * cycle_->byte_ns, exchanges_);
  if (connection_->guard) connection_->guard->beat(false);
  armed_ = false;
  wire_free_ns_ = start + static_cast<std::int64_t>(zero.size()) * cycle_->byte_ns;
}

std::string UartBoards::describe() const {
  char text[160];
  std::snprintf(text, sizeof text, ", %.0f us a cycle, at most %.0f Hz, wire delay %u us (spread %u us)",
                1e6 * cycleSeconds(), maxRateHz(), story_.delayUs(), story_.jitterUs());
  std::string late;
  if (opening_late_ns_ > kLateNs)
    late = "; answers came up to " + std::to_string(opening_late_ns_ / kMs) + " ms late while it was opened: this machine is busy";
  return where_ + ": " + listed(boards()) + text + late;
}

}  // namespace haptic
