/// The USB amplifiers SH4 and Simple as a device's wire. Written from descriptions; untested on hardware.
///
/// SH4: one OUT and one IN bulk transfer per exchange, about 250 µs at high speed. Simple: drive OUT, latch
/// OUT, counters IN. Endpoints 0x02 OUT and 0x86 IN of interface 0, as the Windows driver's pipe numbers
/// suggest. A transfer that does not finish in `transfer_timeout_ms` gives a stale sample; libusb allocates
/// inside the kernel transfer, which is I/O of the transport and not part of the tick.
#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "haptic_core/spidar/transport.h"
#include "spidar_driver/transport/count_unwrapper.h"
#include "spidar_driver/transport/link_report.h"
#include "spidar_driver/transport/usb_packets.h"

namespace haptic {

/// Two bulk endpoints of an opened amplifier; a fake one in tests.
class UsbPipe {
 public:
  enum class Result : unsigned char { kOk, kTimeout, kGone };
  virtual ~UsbPipe() = default;
  virtual Result send(const std::uint8_t* bytes, int size) noexcept = 0;
  virtual Result receive(std::uint8_t* bytes, int size) noexcept = 0;  ///< exactly `size` bytes
};

/// Opens the first amplifier with this product id whose rotary switch says `unit` (-1: any). Throws
/// SetupError: none plugged in, no permission, in use, wrong unit.
std::unique_ptr<UsbPipe> openUsbPipe(std::uint16_t product, int unit);

enum class UsbModel : unsigned char { kSh4, kSimple };

class UsbAmplifier : public Transport, public LinkReporter {
 public:
  /// Throws SetupError when the device has more strings than the amplifier channels, the rate is too high, or
  /// the first exchange fails.
  UsbAmplifier(const DeviceDef& device, UsbModel model, double rate_hz, std::unique_ptr<UsbPipe> pipe);
  ~UsbAmplifier() override { zeroDrive(); }

  DeviceSample exchange(const DriveCommand& command) noexcept override;
  void zeroDrive() noexcept override;
  double maxRateHz() const override { return max_rate_hz_; }
  LinkReport linkReport() const noexcept override;
  std::string describe() const override;

 private:
  UsbPipe::Result transfer(const UsbVoltages& voltage, DeviceSample& sample) noexcept;
  UsbPipe::Result transferSh4(const UsbVoltages& voltage, DeviceSample& sample) noexcept;
  UsbPipe::Result transferSimple(const UsbVoltages& voltage, DeviceSample& sample) noexcept;
  UsbVoltages allowed(const DriveCommand& command) noexcept;

  const DeviceDef device_;
  const UsbModel model_;
  std::unique_ptr<UsbPipe> pipe_;
  double max_rate_hz_ = 0;
  std::array<CountUnwrapper, kUsbChannels> counter_;
  DeviceSample last_;
  std::atomic<std::uint64_t> cycles_{0}, lost_{0}, bad_commands_{0}, clamped_{0}, refused_{0};
  bool gone_ = false, believed_ = true, restarted_ = false;  ///< the last two: of the last answer's counters
};

}  // namespace haptic
