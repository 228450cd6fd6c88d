/// The shared line with its boards: bytes of the host in, bytes of the boards out, each at its time on the
/// wire.
///
/// The line's clock runs at 10 bits per byte. Boards look at their receive FIFO when it is ¾ full (6 of 8
/// bytes): a command is not seen before so many bytes came, which is why a host must pad. A reply starts 25
/// µs after its header was seen. Replies that overlap in time collide: an open-drain line carries the AND of
/// their bits.
#pragma once
#include <array>
#include <cstddef>
#include <deque>
#include <memory>
#include <vector>

#include "spidar_driver/emulator/byte_faults.h"
#include "spidar_driver/emulator/emulated_board.h"

namespace haptic {

struct BusEmulatorSettings {
  int baud = 2000000;
  std::int64_t reply_delay_ns = 25000;
  int fifo_trigger = 6;  ///< bytes; 1: boards see every byte at once
};

/// What the host's adapter does to the boards' answers on their way up; their order stays.
struct AdapterDelay {
  std::int64_t constant_ns = 0;
  double drift = 0;            ///< change of it [ns/ns], between 0 and ten times the constant
  std::int64_t burst_ns = 0;   ///< delivers at multiples of this only
};

class BoardBusEmulator {
 public:
  BoardBusEmulator(MotorPlant& plant, const BusEmulatorSettings& settings = {});

  /// Adds a board; channels of the plant are given in order of adding. `model` as "B3M". Throws SetupError.
  void addBoard(const std::string& model, int id);

  /// Bytes that the host hands to its port at `now_ns`; they follow each other on the wire.
  void receive(const std::uint8_t* bytes, std::size_t size, std::int64_t now_ns);
  /// Takes out what the boards have sent until `now_ns` of the line's clock.
  std::size_t take(std::uint8_t* bytes, std::size_t capacity, std::int64_t now_ns);
  std::int64_t nextByteAt() const;  ///< instant of the next byte to the host; INT64_MAX: none under way
  std::int64_t quietAt() const;     ///< instant at which the reply under way is complete; INT64_MAX: none
  void clearLine();                 ///< bytes under way are lost (unplugged)

  EmulatedBoard* board(int id);  ///< nullptr when there is none
  const std::vector<std::unique_ptr<EmulatedBoard>>& boards() const { return boards_; }
  MotorPlant& plant() { return plant_; }
  ByteFaults to_host, to_boards;
  void setAdapter(const AdapterDelay& adapter) { adapter_ = adapter, drift_start_ns_ = line_ns_; }
  const AdapterDelay& adapter() const { return adapter_; }
  void loseReplies(int replies) { lose_ = replies; }      ///< the next ones never come
  void doubleReplies(int replies) { double_ = replies; }  ///< the next ones come twice
  void swapReplies(int pairs) { swap_ = pairs; }          ///< the next ones come behind their successors
  /// From now on CURRENT is answered with what was answered so many cycles ago, 200 at most; 0: no more.
  void replayReplies(int cycles) { replay_ = cycles; }
  /// Replies come as soon as their bytes were asked for, without wire time, while the adapter has no delay.
  void setInstant(bool instant) { instant_ = instant; }
  /// The host's adapter keeps the next replies back for so long; their order stays.
  void delayReplies(int replies, std::int64_t ns) { late_replies_ = replies, late_ns_ = ns; }
  std::uint64_t collisions() const { return collisions_; }
  bool allCurrentsZero() const;

 private:
  struct TimedByte {
    std::int64_t at;   ///< on the wire
    std::int64_t due;  ///< at the host
    std::uint8_t byte;
  };
  void hear(std::uint8_t byte);
  const std::uint8_t* bytesOf(const EmulatedBoard& board, int size);  ///< of its reply, or of one before
  void reply(const EmulatedBoard& board, int size);
  void transmit(const std::uint8_t* bytes, int size, std::int64_t at, std::int64_t delay);
  std::int64_t adapterDelay() const;
  void put(std::int64_t at, std::int64_t delay, std::uint8_t byte);

  MotorPlant& plant_;
  BusEmulatorSettings settings_;
  std::int64_t byte_ns_;
  std::vector<std::unique_ptr<EmulatedBoard>> boards_;
  int channels_ = 0;
  std::vector<std::uint8_t> fifo_;
  std::int64_t line_ns_ = 0;  ///< end of the last byte from the host
  std::deque<TimedByte> out_;
  AdapterDelay adapter_;
  std::int64_t drift_start_ns_ = 0, handed_ns_ = 0;
  int lose_ = 0, double_ = 0, swap_ = 0;
  bool instant_ = false;
  std::vector<std::uint8_t> held_;  ///< reply that its successor overtakes
  using Reply = std::array<std::uint8_t, kMaxReplyBytes>;
  std::array<std::deque<Reply>, kMaxBoards> past_;  ///< replies to CURRENT by id, the newest first
  int replay_ = 0;
  int late_replies_ = 0;
  std::int64_t late_ns_ = 0;
  std::uint64_t collisions_ = 0;
};

}  // namespace haptic
