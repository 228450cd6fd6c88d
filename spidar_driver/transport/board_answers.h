/// What comes back from the boards: bytes → replies → questions → counts; and what the answers say of the
/// boards.
///
/// An answer is stamped with the instant its question went over the wire, however late it comes: a slow wire
/// shows as age. Marks (answer_ledger.h) measure the wire's delay and tell which answers are lost; those of
/// GET_PARAM tell besides whether a board takes in what it is told (board_memory.h), those of ALL in which mode it is and, of
/// boards that measure them, whether its currents are those that it was told (board_obedience.h), those behind a lesson whether
/// a board keeps what it is taught (board_lesson.h). The positions in an answer to ALL tell whether those of CURRENT are of now
/// (answer_age.h).
///
/// Counters that jump together, or by whole turns, say that their board started anew; one that jumps alone is followed,
/// and what it means for its string is the device's business (count_screen.h).
#pragma once
#include <array>
#include <utility>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/answer_age.h"
#include "spidar_driver/transport/answer_ledger.h"
#include "spidar_driver/transport/board_cycle.h"
#include "spidar_driver/transport/board_lesson.h"
#include "spidar_driver/transport/board_obedience.h"
#include "spidar_driver/transport/byte_link.h"
#include "spidar_driver/transport/count_unwrapper.h"
#include "spidar_driver/transport/link_story.h"
#include "spidar_driver/transport/reply_stream.h"

namespace haptic {

class BoardAnswers {
 public:
  using Cause = WireFinding;
  /// Set-up. All must outlive this.
  BoardAnswers(const DeviceDef& device, const UartSettings& settings, const BoardCycle& cycle,
               LinkStory& story);

  /// (in realtime) The boards are in step, on a wire of that delay.
  void begin(std::int64_t now_ns, std::int64_t delay_ns) noexcept;

  /// (in realtime) A cycle goes out at `sent_ns`, in the exchange of that number, after the line was idle for
  /// `idle_ns`. Returns the mark that must follow it; nullptr: none is due.
  const std::vector<std::uint8_t>* ask(std::int64_t sent_ns, std::uint64_t exchange,
                                       std::int64_t idle_ns) noexcept;
  /// (in realtime) A lesson goes out now; `room_ns`: of the wire until the next cycle. Returns its bytes, with a question where there is
  /// room for it; nullptr: none is due, or an answer is still to come.
  const std::vector<std::uint8_t>* teach(std::int64_t now_ns, std::int64_t room_ns) noexcept;
  /// (in realtime) This program did not run until now: patience with the boards begins anew.
  void resume(std::int64_t now_ns) noexcept { resumed_ns_ = now_ns; }
  /// (in realtime) Zero currents: no mark.
  void askPlain(std::int64_t sent_ns, std::uint64_t exchange) noexcept {
    if (!ledger_.ask(sent_ns, exchange)) trouble_ = Cause::kSilent;
  }

  // (in realtime) What is heard. False: the line is gone.
  bool drain(ByteLink& link, std::uint64_t exchange) noexcept;  ///< what came since the last exchange
  /// Waits for this exchange's answers; on a wire whose delay exceeds the wait, for some answer of every
  /// board.
  bool collect(ByteLink& link, std::uint64_t exchange, std::int64_t sent_ns) noexcept;

  /// (in realtime) What was found while hearing; the board is in the story. Asking forgets it.
  Cause takeTrouble() noexcept { return std::exchange(trouble_, Cause::kNone); }
  Cause trouble() const { return trouble_; }
  /// (in realtime) A counter started anew since the last call: what was known of the strings' lengths is
  /// lost.
  bool takeRestarted() noexcept { return std::exchange(counters_restarted_, false); }

  /// The counts of some board are, at that instant, older than force may act on, or older than the last
  /// restart; or a board that can show it has not shown yet that it takes in what it is told.
  bool expired(std::int64_t at_ns) const noexcept;
  /// Bit per id of the boards that have been asked and not answered for too long, at the time `now_ns`.
  /// `last_pull_ns`: when a string was last told more than its least tension; 0: never. Blames one of them in
  /// the story.
  std::uint32_t mute(std::int64_t now_ns, std::int64_t last_pull_ns) const noexcept;

  /// The counts of some board have been for several answers such as no motor can make: it answers, and is not believed.
  bool wild() const noexcept;

  bool allFresh() const noexcept;  ///< every board has answered since the last `takeFresh`
  void takeFresh() noexcept;       ///< (in realtime)
  /// (in realtime) Counts, all at the instant of the oldest board's, stamp and age in exchanges.
  void read(DeviceSample& sample, std::uint64_t exchange) const noexcept;
  void beginExchange() noexcept { lost_ = 0; }  ///< (in realtime)

 private:
  struct BoardState {
    std::uint64_t exchange = 0;  ///< whose question its counts answer
    std::int64_t stamp_ns = 0;   ///< latch of its counts
    std::int64_t heard_ns = 0;   ///< latch of its last answer, believed or not
    int refused = 0;             ///< answers in a row that were not believed
    std::int64_t unanswered_ns = 0;  ///< when the first question since went out whose answer is lost; 0: none
    bool fresh = false;          ///< new since the last sample that had new counts of all
    double lost = 0;             ///< share of the last questions without an answer
    BoardMemory memory;          ///< whether it takes in what it is told
    BoardObedience obedience;    ///< whether it does what it is told
    BoardLesson lesson;          ///< whether it keeps what it is taught
    AnswerAge age;               ///< whether its counts are of now
    std::uint32_t jumped = 0;    ///< bit per motor whose counter jumped lately
    std::int64_t jumped_ns = 0;  ///< when
  };
  /// Which kind of question is on its way as a mark.
  enum class Mark : unsigned char { kInfo, kMemory, kState, kExam };
  /// The question behind the last lesson.
  struct Exam {
    int board = 0;     ///< index of the board that is asked, or was last
    int answers = 0;   ///< that came; 0: none yet, or none was asked
    BoardLesson::Kind kind = BoardLesson::kLong;  ///< of the last lesson
    std::int64_t taught_ns = 0, heard_ns = 0;
  };

  int hear(ByteLink& link, std::uint64_t exchange, std::int64_t deadline_ns) noexcept;
  void takeReply(const std::uint8_t* bytes, int size, std::uint64_t exchange) noexcept;
  void takeAnswer(int board, const std::uint8_t* bytes, int size, std::uint64_t exchange) noexcept;
  bool startedAnew(int board, int motor, const CurrentReply& packet, std::int64_t stamp_ns) noexcept;
  void takeState(int board, const std::uint8_t* bytes, int size) noexcept;
  void compareCounts(int board, int motors, const AllReply& reply) noexcept;
  bool takeSecondAnswer(int board) noexcept;
  void tellBoards(std::int64_t now_ns) noexcept;
  void settleExam() noexcept;
  bool hasRoom(const std::vector<std::uint8_t>& mark) const noexcept;
  bool takePositions(int board, const std::uint8_t* bytes, int size, std::int64_t stamp_ns) noexcept;
  void takeMark(int board, const std::uint8_t* bytes, int size) noexcept;
  void measureDelay() noexcept;
  void settleLosses() noexcept;
  bool markDue(std::int64_t sent_ns, std::int64_t idle_ns) noexcept;
  const std::vector<std::uint8_t>& chooseMark(std::int64_t now_ns, bool state_due) noexcept;
  bool stateDue(std::int64_t now_ns, std::int64_t idle_ns) const noexcept;
  void dropMark() noexcept;
  bool ownAnswers() const noexcept { return fastest_ns_ + cycle_.cycle_ns + mark_wire_ns_ <= cycle_.wait_ns; }
  void suspect(Cause cause, int board) noexcept;

  const DeviceDef& device_;
  const UartSettings settings_;
  const BoardCycle& cycle_;
  LinkStory& story_;
  ReplyStream stream_;
  AnswerLedger ledger_;
  std::array<BoardState, kMaxBoards> board_{};
  std::array<CountUnwrapper, kMaxStrings> counter_;
  std::int64_t silent_ns_ = 0, ready_ns_ = 0, heard_ns_ = 0, looked_ns_ = 0;
  std::int64_t last_mark_ns_ = 0;  ///< asked or answered
  std::int64_t delay_ns_ = 0,
               fastest_ns_ = 0;  ///< of the wire beyond its bytes' own time: mean, and what it can do at best
  std::int64_t mark_wire_ns_ = 0;
  std::uint64_t foreign_seen_ = 0;
  int lost_ = 0;  ///< answers that this exchange proved lost, of the board that lost most
  int next_mark_ = 0;
  Mark mark_ = Mark::kInfo;      ///< on its way
  int mark_param_ = -1;          ///< parameter that it asks for, of kMemory
  std::int64_t state_ns_ = 0, plain_ns_ = 0, resumed_ns_ = 0;  ///< ALL asked last; any other mark; see `resume`
  int next_state_ = 0;
  std::int64_t state_asked_ = 0;  ///< so many times
  Exam exam_;
  PageTest age_;  ///< of all boards together
  int mark_reply_bytes_ = kInfoBytes;
  Cause trouble_ = Cause::kNone;
  bool waited_ = false;  ///< the last read waited: what it brought came just now
  bool counters_restarted_ = false;
};

}  // namespace haptic
