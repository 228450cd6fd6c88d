#include "haptic_core/spidar/device_diagnosis.h"

#include <cmath>
#include <iterator>

namespace haptic {
namespace {

constexpr unsigned bit(LinkStatus status) { return 1u << static_cast<unsigned>(status); }
constexpr unsigned bit(WireFinding finding) { return 1u << static_cast<unsigned>(finding); }

constexpr unsigned kNothing = 0;
using C = Consequence;

// In order: certain findings of the wire; faults of this program; answers that the wire fails to bring; counters;
// lengths. A row may rest on evidence that a row above explains better, never the other way round.
constexpr CauseRow kRows[] = {
    {DeviceCause::kUnplugged, kNothing, 0, bit(LinkStatus::kDisconnected), 0, C::kStop, C::kPause, false},
    {DeviceCause::kUnguarded, kUnguarded, 0, 0, 0, C::kStop, C::kStop, false},
    {DeviceCause::kOtherBoard, kNothing, 0, 0, bit(WireFinding::kOtherBoard), C::kStop, C::kStop, true},
    {DeviceCause::kPowerLost, kNothing, 0, 0, bit(WireFinding::kPowerLost), C::kStop, C::kStop, true},
    {DeviceCause::kForgets, kNothing, 0, 0, bit(WireFinding::kForgets), C::kStop, C::kPause, false},
    {DeviceCause::kTableSpoilt, kNothing, 0, 0, bit(WireFinding::kTableSpoilt), C::kStop, C::kPause, false},
    {DeviceCause::kWrongMode, kNothing, 0, 0, bit(WireFinding::kWrongMode), C::kStop, C::kPause, false},
    {DeviceCause::kCurrentsIgnored, kNothing, 0, 0, bit(WireFinding::kCurrentsIgnored), C::kStop, C::kPause, false},
    {DeviceCause::kCountsOld, kNothing, 0, 0, bit(WireFinding::kOldCounts), C::kStop, C::kPause, false},
    {DeviceCause::kBoardRestarted, kCounterRestarted, 0, 0, 0, C::kStop, C::kStop, true},
    {DeviceCause::kAnswersLost, kNothing, 0, 0, bit(WireFinding::kAnswersLost), C::kStop, C::kPause, false},
    {DeviceCause::kNoise, kNothing, 0, 0, bit(WireFinding::kNoise), C::kStop, C::kPause, false},
    {DeviceCause::kCounterJumped, kLinkLost, 0, 0, bit(WireFinding::kCountsWild), C::kStop, C::kStop, true},
    {DeviceCause::kBoardSilent, std::uint64_t{kLinkLost} | kSilenceLasts, 0, 0, 0, C::kStop, C::kPause, false},
    {DeviceCause::kLoopLate, kLinkLost | kLoopLate, 0, 0, 0, C::kPause, C::kPause, false},
    {DeviceCause::kBoardSilent, kLinkLost, 0, 0, 0, C::kPause, C::kPause, false},
    {DeviceCause::kAnswersLost, kAnswersFailing, kLoopLate, 0, 0, C::kStop, C::kSay, false},
    {DeviceCause::kAnswersLost, kAnswersLost, kLoopLate, 0, 0, C::kReduce, C::kSay, false},
    {DeviceCause::kBoardRepeats, kSomeCountersStill | kResidualHigh, 0, 0, 0, C::kStop, C::kStop, true},
    {DeviceCause::kBoardRepeats, kSomeCountersStill | kCountersLost, 0, 0, 0, C::kStop, C::kStop, true},
    {DeviceCause::kCounterJumped, kCountersLost, 0, 0, 0, C::kStop, C::kStop, true},
    {DeviceCause::kCountersStill, kCountersStill, 0, 0, 0, C::kStop, C::kStop, true},
    {DeviceCause::kCountersFrozen, kCountersFrozen, 0, 0, 0, C::kReduce, C::kSay, false},
    {DeviceCause::kStringWrong, kCountsRefusedLong, 0, 0, 0, C::kStop, C::kStop, false},
    {DeviceCause::kStringWrong, kLengthsBroken, 0, 0, 0, C::kStop, C::kStop, false},
    {DeviceCause::kStringWrong, kStringNamed, 0, 0, 0, C::kStop, C::kSay, false},
    {DeviceCause::kStringDoubtful, kResidualHigh, 0, 0, 0, C::kReduce, C::kSay, false},
    {DeviceCause::kOverRate, kRateRefused, 0, 0, 0, C::kRest, C::kRest, false},
    {DeviceCause::kWireSlow, kForceRefused, 0, 0, 0, C::kRest, C::kSay, false},
    {DeviceCause::kWireSlow, kDelayTooLong, 0, 0, 0, C::kReduce, C::kSay, false},
    {DeviceCause::kLoopLate, kLoopLate, 0, 0, 0, C::kSay, C::kSay, false},
    {DeviceCause::kNone, 0, 0, 0, 0, C::kSay, C::kSay, false},
};


/// What happened, in the words of the state's message; %B: the board, %L: how late.
struct CauseText {
  const char* name;
  const char* happened;
};
constexpr CauseText kTexts[] = {
    {"none", ""},
    {"loop late", "the loop stood still for %L, this machine was busy or the driver was stopped: spidar_latency says what to change"},
    {"unplugged", "the port is gone"},
    {"power lost", "%B had lost its power"},
    {"board restarted", "%B started anew, its counters tell no lengths"},
    {"other board", "%B answered as another model"},
    {"table spoilt", "%B answered and did not obey: it cuts its packets short, its length table is spoilt"},
    {"wrong mode", "%B answered and did not obey: it is not in the mode in which it follows currents"},
    {"currents ignored", "%B answered and did not obey: its currents are not those that it is told"},
    {"forgets", "%B loses step again as soon as it is taught"},
    {"noise", "bytes came without end"},
    {"board silent", "%B was silent"},
    {"answers lost", "%B lost too many commands or answers"},
    {"wire slow", "the wire is too slow for force"},
    {"counter jumped", "a counter jumped"},
    {"board repeats", "a board repeats its counts while the others move"},
    {"counters still", "no counter moves although the force does: a board repeats its counts, or the grip is clamped"},
    {"counters frozen", "all counters of the moving grip stopped at once: a board repeats its counts, or the grip hit something hard"},
    {"string wrong", "a string measures wrong"},
    {"string doubtful", "the strings' lengths contradict each other"},
    {"over rate", "the exchange ran faster than the wire carries"},
    {"unguarded", "the motor guard has ended or stands still"},
    {"counts old", "%B answered with counts of cycles ago: its full answers contradict them"},
};
static_assert(std::size(kTexts) == static_cast<std::size_t>(DeviceCause::kCauses), "a text for every cause");

const CauseText& textOf(DeviceCause cause) { return kTexts[static_cast<std::size_t>(cause)]; }

}  // namespace

const CauseRow& diagnose(std::uint64_t signs, LinkStatus status, WireFinding finding) noexcept {
  const CauseRow* row = kRows;
  const auto fits = [&](const CauseRow& r) {
    return (signs & r.signs) == r.signs && !(signs & r.excuses) && (r.statuses == 0 || (r.statuses & bit(status))) &&
           (r.findings == 0 || (r.findings & bit(finding)));
  };
  while (!fits(*row)) ++row;  // the last row fits everything
  return *row;
}

DeviceCause causeOf(WireFinding finding) noexcept {
  switch (finding) {
    case WireFinding::kNone:
      break;
    case WireFinding::kStalled:
      return DeviceCause::kLoopLate;
    case WireFinding::kSilent:
      return DeviceCause::kBoardSilent;
    case WireFinding::kRestarted:
      return DeviceCause::kBoardRestarted;
    case WireFinding::kPowerLost:
    case WireFinding::kOtherBoard:
    case WireFinding::kTableSpoilt:
    case WireFinding::kWrongMode:
    case WireFinding::kCurrentsIgnored:
    case WireFinding::kForgets:
    case WireFinding::kAnswersLost:
    case WireFinding::kNoise:
    case WireFinding::kOldCounts:
    case WireFinding::kCountsWild:
      for (const CauseRow& row : kRows)
        if (row.findings & bit(finding)) return row.cause;
  }
  return DeviceCause::kNone;
}

const char* toString(DeviceCause cause) {
  return textOf(cause).name;
}

std::string whatHappened(DeviceCause cause, int board, double late_s) {
  std::string text = textOf(cause).happened;
  const auto put = [&text](const char* mark, const std::string& value) {
    const std::size_t at = text.find(mark);
    if (at != std::string::npos) text.replace(at, 2, value);
  };
  put("%B", board < 0 ? "a board" : "board " + std::to_string(board));
  put("%L", std::to_string(std::lround(1e3 * late_s)) + " ms");
  return text;
}

}  // namespace haptic
