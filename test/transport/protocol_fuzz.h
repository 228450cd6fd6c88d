/// One execution of the fuzz target: any bytes, taken for the line of a device. Nothing may crash, hang,
/// throw or drive a motor out of its range.
#pragma once
#include <algorithm>
#include <cstdlib>

#include "spidar_driver/emulator/memory_link.h"
#include "spidar_driver/transport/count_unwrapper.h"
#include "spidar_driver/transport/reply_stream.h"
#include "spidar_driver/transport/usb_packets.h"

namespace haptic {

class FuzzPlant : public MotorPlant {
 public:
  void advance(std::int64_t) override {}
  void drive(int channel, std::int16_t digit) override {
    if (channel < 0 || channel >= 2 * kMaxBoardMotors || std::abs(digit) > 4095) std::abort();
  }
  std::int32_t position(int channel) const override { return 1000 * channel; }
};

template <class... Packets>
struct PacketList {
  static void decodeAll(const BoardShape& shape, const std::uint8_t* bytes, std::size_t size) {
    (decodeOne<Packets>(shape, bytes, size), ...);
  }
  /// What decodes must encode to the same bytes.
  template <class Packet>
  static void decodeOne(const BoardShape& shape, const std::uint8_t* bytes, std::size_t size) {
    Packet packet;
    std::uint8_t again[128];
    const int id = size > 0 ? bytes[0] & 7 : 0;
    if (!decodePacket(shape, id, bytes, size, packet)) return;
    const int length = encodePacket(shape, id, packet, again, sizeof again);
    if (length != static_cast<int>(size) || !std::equal(bytes, bytes + size, again)) std::abort();
  }
};
using AllPackets = PacketList<InfoCommand, LengthCommand, AllCommand, SensorCommand, DirectPacket,
                              CurrentCommand, InterpolateCommand, ForceControlCommand, ParamCommand,
                              ResetSensorCommand, GetParamCommand, InfoReply, AllReply, SensorReply,
                              CurrentReply, InterpolateReply, ForceControlReply, ParamReply>;

inline void fuzzOne(const std::uint8_t* bytes, std::size_t size) {
  if (size < 2) return;
  const BoardShape& shape = *findBoardModel(1 + bytes[0] % 7);
  const int boards = 1 + bytes[1] % 3;
  bytes += 2;
  size -= 2;
  AllPackets::decodeAll(shape, bytes, size);

  ReplyStream stream;
  for (int b = 0; b < boards; ++b) {
    stream.know(headerByte(BoardCommand::kCurrent, b), replyBytes(shape, BoardCommand::kCurrent));
    stream.know(headerByte(BoardCommand::kBoardInfo, b), replyBytes(shape, BoardCommand::kBoardInfo));
  }
  std::size_t taken = 0;
  const auto take = [&taken](const std::uint8_t*, int n) { taken += static_cast<std::size_t>(n); };
  stream.feed(bytes, size, take);
  // Every byte is part of a reply, foreign, or waits for what follows it.
  if (taken + stream.foreign() + static_cast<std::size_t>(stream.pending()) != size) std::abort();
  stream.settle(take);

  CountUnwrapper counter(CountUnwrapper::Limits{1e6, 5e7});
  for (std::size_t i = 0; i + 1 < size; i += 2)
    counter.accept(static_cast<std::int16_t>(bytes[i] | bytes[i + 1] << 8),
                   static_cast<std::int64_t>(i) * 500000);

  FuzzPlant plant;
  BoardBusEmulator bus(plant);
  bus.addBoard(shape.name, 1);
  bus.addBoard("B5M", 2);
  std::uint8_t out[256];
  bus.receive(bytes, size, 0);
  while (bus.take(out, sizeof out, bus.quietAt()) > 0) {
  }
  Sh4Packet sh4{};
  SimplePacket simple{};
  std::copy_n(bytes, std::min(size, sh4.size()), sh4.begin());
  std::copy_n(bytes, std::min(size, simple.size()), simple.begin());
  decodeSh4(sh4);
  decodeSimple(simple);
}

}  // namespace haptic
