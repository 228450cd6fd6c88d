// Packets of the USB amplifiers against the published layouts, and their wire on a pipe in memory.
#include "spidar_driver/transport/usb_amplifier.h"

#include <gtest/gtest.h>

#include <cmath>

#include "emulated_device.h"

namespace haptic {
namespace usb_amplifier_test {

TEST(UsbPackets, Sh4LayoutByteForByte) {
  const Sh4Packet out = encodeSh4({1, -1, 0.01, 100, -100, 0, std::nan(""), 2});
  const std::uint8_t expected[] = {0x01, 0x0E, 0x9F, 0x01, 0x61, 0xFE, 0x04, 0x00, 0xFF,
                                   0x7F, 0x00, 0x80, 0x00, 0x00, 0x00, 0x00, 0x3E, 0x03};
  EXPECT_TRUE(std::equal(std::begin(expected), std::end(expected), out.begin()));  // ±415, 4, saturated, 830
  Sh4Packet in{};
  in[16] = 0x34;
  in[17] = 0x12;
  in[30] = 0xFF;
  in[31] = 0xFF;
  in[32] = 0x00;
  in[33] = 0x08;
  in[48] = 0xA5;
  const Sh4Reply reply = decodeSh4(in);
  EXPECT_EQ(reply.counter[0], 0x1234);
  EXPECT_EQ(reply.counter[7], 0xFFFF);
  EXPECT_DOUBLE_EQ(reply.motor_voltage[0], 12.0);  // 2048 of 4096 over 24 V
  EXPECT_EQ(buttonsOfPio(reply.pio), 5u);
  EXPECT_EQ(unitOfPio(reply.pio), 10);
}

TEST(UsbPackets, SimpleLayoutByteForByte) {
  const SimplePacket drive = encodeSimpleDrive({1, 0, 0, 0, 0, 0, 0, -1});
  EXPECT_EQ(drive[0], 0x52);
  EXPECT_EQ(drive[1] | drive[2] << 8, 415);
  EXPECT_EQ(static_cast<std::int16_t>(drive[15] | drive[16] << 8), -415);
  EXPECT_EQ(encodeSimpleLatch()[0], 0x51);
  const SimplePacket phase = encodeSimplePhase(0x81), clear = encodeSimpleClear(0xFF);
  EXPECT_EQ(phase[0] << 16 | phase[1] << 8 | phase[2], 0xA21A81);
  EXPECT_EQ(clear[0] << 16 | clear[1] << 8 | clear[2], 0xA219FF);
  SimplePacket in{};
  in[0] = 0xFF, in[1] = 0xFF, in[2] = 0xFF;     // −1
  in[21] = 0x00, in[22] = 0x00, in[23] = 0x80;  // −2²³
  in[3] = 0x40, in[4] = 0xE2, in[5] = 0x01;     // 123456
  in[24] = 0x31;
  const SimpleReply reply = decodeSimple(in);
  EXPECT_EQ(reply.counter[0], -1);
  EXPECT_EQ(reply.counter[7], -8388608);
  EXPECT_EQ(reply.counter[1], 123456);
  EXPECT_EQ(reply.pio, 0x31);
}

/// An amplifier as the layouts describe it.
class FakeAmplifier : public UsbPipe {
 public:
  explicit FakeAmplifier(FakeAmplifier** self) { *self = this; }
  Result send(const std::uint8_t* bytes, int size) noexcept override {
    if (state != Result::kOk) return state;
    const int at = size == 512 ? 2 : 1;
    if (size == 512 || bytes[0] == 0x52)
      for (int i = 0; i < 8; ++i)
        digits[i] = static_cast<std::int16_t>(bytes[at + 2 * i] | bytes[at + 2 * i + 1] << 8);
    return state;
  }
  Result receive(std::uint8_t* bytes, int size) noexcept override {
    if (state != Result::kOk) return state;
    std::fill_n(bytes, size, std::uint8_t{0});
    for (int i = 0; i < 8; ++i) {
      const int wide = size == 512 ? 2 : 3, first = size == 512 ? 16 : 0;
      for (int b = 0; b < wide; ++b)
        bytes[first + wide * i + b] = static_cast<std::uint8_t>(counters[i] >> (8 * b));
    }
    bytes[size == 512 ? 48 : 24] = 0x02;
    return state;
  }
  Result state = Result::kOk;
  std::array<std::int16_t, 8> digits{};
  std::array<std::int32_t, 8> counters{};
};

TEST(UsbAmplifier, CountsUnwrapAndTheDriveStaysInsideItsBounds) {
  const DeviceDef device = plainDevice({}, 8);
  for (const UsbModel model : {UsbModel::kSh4, UsbModel::kSimple}) {
    FakeAmplifier* fake = nullptr;
    auto pipe = std::make_unique<FakeAmplifier>(&fake);
    UsbAmplifier amplifier(device, model, 1000, std::move(pipe));
    const int sign = model == UsbModel::kSh4 ? -1 : 1;  // the SH4 counts backwards
    DeviceSample s;
    for (int k = 1; k <= 4000; ++k) {
      fake->counters[0] = 20 * k;  // wraps 16 bits once
      DriveCommand command;
      command.voltage = {0.1, -0.1, 1e30, 1e30, -1e30, -1e30, 0, 0};
      s = amplifier.exchange(command);
    }
    EXPECT_EQ(s.status, LinkStatus::kOk);
    EXPECT_EQ(s.counts[0], sign * 80000);
    EXPECT_EQ(s.buttons, 2u);
    EXPECT_EQ(fake->digits[0], 41);
    EXPECT_EQ(fake->digits[1], -41);
    EXPECT_EQ(fake->digits[2], static_cast<int>(6 * 0.091 * 415));
    EXPECT_EQ(fake->digits[3], 0);  // pulls with negative voltage
    EXPECT_EQ(fake->digits[4], 0);
    DriveCommand bad;
    bad.voltage[5] = std::nan("");
    bad.voltage[0] = 0.1;
    amplifier.exchange(bad);
    EXPECT_EQ(fake->digits[0], 0);

    fake->state = UsbPipe::Result::kTimeout;
    EXPECT_EQ(amplifier.exchange({}).status, LinkStatus::kStale);
    for (int k = 0; k < 20; ++k) s = amplifier.exchange({});
    EXPECT_EQ(s.status, LinkStatus::kSilent);
    fake->state = UsbPipe::Result::kGone;
    EXPECT_EQ(amplifier.exchange({}).status, LinkStatus::kDisconnected);
  }
}

TEST(UsbAmplifier, SetUpSaysWhatIsWrong) {
  FakeAmplifier* fake = nullptr;
  EXPECT_THROW(UsbAmplifier(plainDevice({}, 9), UsbModel::kSh4, 1000, std::make_unique<FakeAmplifier>(&fake)),
               SetupError);
  EXPECT_THROW(UsbAmplifier(plainDevice({}, 8), UsbModel::kSh4, 9000, std::make_unique<FakeAmplifier>(&fake)),
               SetupError);
  auto silent = std::make_unique<FakeAmplifier>(&fake);
  fake->state = UsbPipe::Result::kTimeout;
  EXPECT_THROW(UsbAmplifier(plainDevice({}, 8), UsbModel::kSh4, 1000, std::move(silent)), SetupError);
}

}  // namespace usb_amplifier_test
}  // namespace haptic
