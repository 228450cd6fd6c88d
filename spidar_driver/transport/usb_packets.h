/// Bytes ↔ values of the two USB amplifiers, without I/O. Written from descriptions; untested on hardware.
///
/// SH4 (0cec:0205), one OUT and one IN transfer of 512 bytes per exchange:
///   OUT  0 = 0x01, 1 = 0x0E, 2… 8 × int16 D/A digits
///   IN   0… D/A echo, 16… 8 × uint16 counters, 32… 8 × uint16 A/D, 48 uint16 PIO
/// Simple (0cec:0203), 32 bytes each:
///   OUT  0x52, 8 × int16 D/A digits · OUT 0x51 (latch) · IN 8 × signed 24-bit counters, 24 = PIO
/// Little-endian; a D/A digit is 1/415 V; PIO bits 0–3 are buttons, 4–7 the rotary switch that names the
/// unit.
#pragma once
#include <array>
#include <cstdint>

namespace haptic {

inline constexpr int kUsbChannels = 8;
inline constexpr std::uint16_t kUsbVendor = 0x0CEC;
inline constexpr std::uint16_t kUsbSimpleProduct = 0x0203, kUsbSh4Product = 0x0205;

using Sh4Packet = std::array<std::uint8_t, 512>;
using SimplePacket = std::array<std::uint8_t, 32>;
using UsbVoltages = std::array<double, kUsbChannels>;  ///< [V]

struct Sh4Reply {
  std::array<std::uint16_t, kUsbChannels> counter{};  ///< counts down when the string pays out: negate
  std::array<double, kUsbChannels> motor_voltage{};   ///< at the motor's terminals [V]
  std::uint16_t pio = 0;
};

struct SimpleReply {
  std::array<std::int32_t, kUsbChannels> counter{};  ///< signed 24 bits
  std::uint8_t pio = 0;
};

/// Drive voltage [V] to D/A digit, saturated at int16. NaN gives 0.
std::int16_t usbDigit(double voltage);

Sh4Packet encodeSh4(const UsbVoltages& voltage);
Sh4Reply decodeSh4(const Sh4Packet& packet);

SimplePacket encodeSimpleDrive(const UsbVoltages& voltage);
SimplePacket encodeSimpleLatch();
SimplePacket encodeSimplePhase(std::uint8_t inverted);  ///< bit per channel whose encoder counts backwards
SimplePacket encodeSimpleClear(std::uint8_t channels);  ///< bit per counter to set to zero
SimpleReply decodeSimple(const SimplePacket& packet);

constexpr std::uint32_t buttonsOfPio(std::uint32_t pio) {
  return pio & 0x0F;
}
constexpr int unitOfPio(std::uint32_t pio) {
  return static_cast<int>(pio >> 4 & 0x0F);
}

}  // namespace haptic
