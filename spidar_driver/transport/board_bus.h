/// Finding the boards on a bus and teaching them each other's packet lengths. Set-up only.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/spidar/device_def.h"
#include "spidar_driver/transport/board_protocol.h"
#include "spidar_driver/transport/byte_link.h"

namespace haptic {

struct FoundBoard {
  int id = 0;
  const BoardShape* shape = nullptr;
  bool operator==(const FoundBoard& o) const { return id == o.id && shape == o.shape; }
};

/// What a scan of the ids 0–7 heard.
struct BusScan {
  std::vector<FoundBoard> boards;  ///< in order of id
  std::size_t foreign_bytes = 0;   ///< bytes that are no board's answer: wrong baud rate or another device
  std::int64_t late_ns = 0;        ///< when the last answer came, after the last question; 0: while questions went out
  std::string unknown;             ///< "id 3: model 9, 5 motors" of a board of unknown model; else empty
};

/// So many zeros end whatever a board believes to be inside of: a length is one byte, and a spoilt table may hold 255.
inline constexpr int kResyncZeros = 256;
inline constexpr int kLongInfoBytes = 15;  ///< a harmless length of BOARD_INFO; as a header, a question to board 7
inline constexpr int kInfoBytes = 7;  ///< of a reply to BOARD_INFO, the same for all models

/// BOARD_INFO for one id behind `lead` zeros, with the padding that is its reply's slot.
std::vector<std::uint8_t> infoQuestion(int id, int lead);
/// GET_PARAM for one id, with its reply's slot: the reply names the parameter that was asked for *before*.
std::vector<std::uint8_t> paramQuestion(const FoundBoard& board, int type);
/// (in realtime) False: no such reply of that id, or none that a board can give.
bool decodeInfo(const std::uint8_t* bytes, int size, int id, InfoReply& info);

/// Reads until the line has been silent for longer than any adapter keeps bytes back; bounded, 0.3 s.
void drainLink(ByteLink& link);

/// Probes each id with BOARD_INFO, all of them before the first answer need have come: a slow wire's answers are
/// known by their ids. Takes about 0.15 s; up to a second while fewer than `expected` boards have answered: a busy machine may bring
/// their answers late.
BusScan scanBus(ByteLink& link, std::size_t expected = 0);

/// A board that missed a header takes the bytes behind it for headers: is this one of the three commands of a board on the bus
/// that it must never find there?
bool spoilsBoards(int byte, const std::vector<FoundBoard>& boards);

/// The same of the commands that put a board into another mode as well: currents must not have it where a digit more or less
/// avoids it.
bool movesBoards(int byte, const std::vector<FoundBoard>& boards);

/// ALL in mode SKIP, which changes nothing, with its reply's slot: the reply names the board's mode, and the currents that it
/// measures where it does. A B3M: 49 bytes, 245 µs of the wire; a B5M: 90 bytes, 450 µs.
std::vector<std::uint8_t> stateQuestion(const FoundBoard& board);

/// SET_CMDLEN for every board, longer by a few bytes where a length would be a header that spoils a board: without it, a
/// board of one model loses step at a command for another model. `padding`: zeros behind each; kResyncZeros reaches a board
/// whose table says that this very command is longer. `info_bytes`: taught for BOARD_INFO (board_lesson.h).
std::vector<std::uint8_t> lengthLesson(const std::vector<FoundBoard>& boards, int padding = 0, int info_bytes = 1);

/// BOARD_INFO twice, the second one where a board that takes the first for kLongInfoBytes does not look for a header. The first
/// reply is over by then: 25 us, its seven bytes, and the board's FIFO. 41 bytes, 205 us.
std::vector<std::uint8_t> lessonQuestion(int id);

/// Zero currents for all eight ids, whatever their length tables say: a disturbed command may have spoilt a table or moved a
/// board to another id. Zeros end what a board is inside of; then every id gets zero currents by CURRENT, and by ALL for a
/// board whose table cuts CURRENT short; each header is followed by as many zeros as the longest board of its command needs,
/// and zeros at the end complete any length that a table can hold. 1.3 kB, 6.6 ms at 2 Mbaud.
std::vector<std::uint8_t> zeroForAnyTable();

/// "B3M (id 1), B3M (id 2)": for messages.
std::string listed(const std::vector<FoundBoard>& boards);

/// Throws SetupError, naming `port`, unless the scan found what the device needs: boards at all, known
/// models, the models of its file in order, enough motors for its strings. Returns the boards to use, in
/// channel order.
std::vector<FoundBoard> matchBoards(const BusScan& scan, const DeviceDef& device, const std::string& port);

}  // namespace haptic
