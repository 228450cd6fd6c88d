#include "spidar_driver/transport/usb_packets.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kAmplifierDigitPerVolt = 415;            // D/A of both amplifiers
constexpr double kVoltPerAdDigit = 24.0 / 4096;  // A/D of the SH4: 12 bits over 24 V

void putDigits(std::uint8_t* at, const UsbVoltages& voltage) {
  for (int i = 0; i < kUsbChannels; ++i) {
    const auto digit = static_cast<std::uint16_t>(usbDigit(voltage[i]));
    at[2 * i] = static_cast<std::uint8_t>(digit & 0xFF);
    at[2 * i + 1] = static_cast<std::uint8_t>(digit >> 8);
  }
}

std::uint16_t word(const std::uint8_t* at) {
  return static_cast<std::uint16_t>(at[0] | at[1] << 8);
}

SimplePacket order(std::uint8_t a, std::uint8_t b, std::uint8_t c) {
  SimplePacket packet{};
  packet[0] = a;
  packet[1] = b;
  packet[2] = c;
  return packet;
}

}  // namespace

std::int16_t usbDigit(double voltage) {
  if (std::isnan(voltage)) return 0;
  return static_cast<std::int16_t>(std::clamp(voltage * kAmplifierDigitPerVolt, -32768.0, 32767.0));
}

Sh4Packet encodeSh4(const UsbVoltages& voltage) {
  Sh4Packet packet{};
  packet[0] = 0x01;  // update all
  packet[1] = 0x0E;  // as the published host sends; its meaning is not known
  putDigits(&packet[2], voltage);
  return packet;
}

Sh4Reply decodeSh4(const Sh4Packet& packet) {
  Sh4Reply reply;
  for (int i = 0; i < kUsbChannels; ++i) {
    reply.counter[i] = word(&packet[16 + 2 * i]);
    reply.motor_voltage[i] = kVoltPerAdDigit * word(&packet[32 + 2 * i]);
  }
  reply.pio = word(&packet[48]);
  return reply;
}

SimplePacket encodeSimpleDrive(const UsbVoltages& voltage) {
  SimplePacket packet{};
  packet[0] = 0x52;
  putDigits(&packet[1], voltage);
  return packet;
}

SimplePacket encodeSimpleLatch() {
  SimplePacket packet{};
  packet[0] = 0x51;
  return packet;
}

SimplePacket encodeSimplePhase(std::uint8_t inverted) {
  return order(0xA2, 0x1A, inverted);
}
SimplePacket encodeSimpleClear(std::uint8_t channels) {
  return order(0xA2, 0x19, channels);
}

SimpleReply decodeSimple(const SimplePacket& packet) {
  SimpleReply reply;
  for (int i = 0; i < kUsbChannels; ++i) {
    const std::uint8_t* at = &packet[3 * i];
    const std::uint32_t bits = at[0] | at[1] << 8 | static_cast<std::uint32_t>(at[2]) << 16;
    reply.counter[i] =
        bits & 0x800000 ? static_cast<std::int32_t>(bits) - 0x1000000 : static_cast<std::int32_t>(bits);
  }
  reply.pio = packet[24];
  return reply;
}

}  // namespace haptic
