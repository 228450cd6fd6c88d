#include "spidar_driver/transport/usb_amplifier.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/drive_limits.h"
#include "spidar_driver/transport/serial_port.h"

namespace haptic {
namespace {

constexpr double kMaxSh4RateHz = 4000;      // about 250 µs an exchange
constexpr double kMaxSimpleRateHz = 2500;   // three transfers, 125 µs microframes
constexpr double kMaxStringSpeed = 20;      // [m/s], as for the UART boards
constexpr double kMaxStringAcceleration = 1000;  // [m/s²], likewise
constexpr std::uint32_t kSilentAfter = 20;  // exchanges

}  // namespace

UsbAmplifier::UsbAmplifier(const DeviceDef& device, UsbModel model, double rate_hz,
                           std::unique_ptr<UsbPipe> pipe)
    : device_(device), model_(model), pipe_(std::move(pipe)) {
  if (device_.strings.size() > kUsbChannels)
    throw SetupError(device_.name, "has more strings than the amplifier's 8 channels", "use UART boards");
  max_rate_hz_ = std::min(model == UsbModel::kSh4 ? kMaxSh4RateHz : kMaxSimpleRateHz, device_.max_rate_hz);
  if (!(rate_hz > 0) || rate_hz > max_rate_hz_)
    throw SetupError(device_.name,
                     std::to_string(static_cast<int>(rate_hz)) +
                         " Hz asked, but the amplifier does at most " +
                         std::to_string(static_cast<int>(max_rate_hz_)) + " Hz",
                     "set the rate to at most that");
  for (std::size_t i = 0; i < device_.strings.size(); ++i) {
    const double per_count = std::max(std::abs(device_.strings[i].length_per_count), 1e-9);
    counter_[i] = CountUnwrapper({kMaxStringSpeed / per_count, kMaxStringAcceleration / per_count});
  }
  if (model_ == UsbModel::kSimple) {
    const SimplePacket phase = encodeSimplePhase(0), clear = encodeSimpleClear(0xFF);
    pipe_->send(phase.data(), static_cast<int>(phase.size()));
    pipe_->send(clear.data(), static_cast<int>(clear.size()));
  }
  if (transfer(UsbVoltages{}, last_) != UsbPipe::Result::kOk)
    throw SetupError(describe(), "the amplifier does not answer", "switch its power on and plug it in again");
}

DeviceSample UsbAmplifier::exchange(const DriveCommand& command) noexcept {
  cycles_.fetch_add(1, std::memory_order_relaxed);
  const UsbPipe::Result result = gone_ ? UsbPipe::Result::kGone : transfer(allowed(command), last_);
  if (result == UsbPipe::Result::kOk) {
    last_.age_ticks = believed_ ? 0 : last_.age_ticks + 1;
    last_.lost = 0;
    last_.status = restarted_ ? LinkStatus::kRestarted : believed_ ? LinkStatus::kOk : LinkStatus::kStale;
  } else {
    lost_.fetch_add(1, std::memory_order_relaxed);
    ++last_.age_ticks;
    last_.lost = 1;
    gone_ = result == UsbPipe::Result::kGone;
    last_.status = gone_                             ? LinkStatus::kDisconnected
                   : last_.age_ticks >= kSilentAfter ? LinkStatus::kSilent
                                                     : LinkStatus::kStale;
  }
  last_.age_us = static_cast<std::uint32_t>(
      std::clamp<std::int64_t>((steadyNanoseconds() - last_.stamp_ns) / 1000, 0, UINT32_MAX));
  return last_;
}

UsbVoltages UsbAmplifier::allowed(const DriveCommand& command) noexcept {
  UsbVoltages voltage{};
  if (!finiteDrive(device_, command)) {
    bad_commands_.fetch_add(1, std::memory_order_relaxed);
    return voltage;
  }
  for (std::size_t i = 0; i < device_.strings.size(); ++i) {
    bool clamped = false;
    voltage[i] = allowedVoltage(device_.strings[i], command.voltage[i], clamped);
    if (clamped) clamped_.fetch_add(1, std::memory_order_relaxed);
  }
  return voltage;
}

UsbPipe::Result UsbAmplifier::transfer(const UsbVoltages& voltage, DeviceSample& sample) noexcept {
  return model_ == UsbModel::kSh4 ? transferSh4(voltage, sample) : transferSimple(voltage, sample);
}

UsbPipe::Result UsbAmplifier::transferSh4(const UsbVoltages& voltage, DeviceSample& sample) noexcept {
  believed_ = true;
  int jumps = 0;
  const Sh4Packet out = encodeSh4(voltage);
  Sh4Packet in;
  UsbPipe::Result result = pipe_->send(out.data(), static_cast<int>(out.size()));
  if (result == UsbPipe::Result::kOk) result = pipe_->receive(in.data(), static_cast<int>(in.size()));
  if (result != UsbPipe::Result::kOk) return result;
  const Sh4Reply reply = decodeSh4(in);
  sample.stamp_ns = steadyNanoseconds();
  for (std::size_t i = 0; i < device_.strings.size(); ++i) {
    const auto taken = counter_[i].accept(static_cast<std::int16_t>(reply.counter[i]), sample.stamp_ns);
    if (taken == CountUnwrapper::Result::kRefused) refused_.fetch_add(1, std::memory_order_relaxed);
    believed_ = believed_ && taken != CountUnwrapper::Result::kRefused;
    jumps += taken == CountUnwrapper::Result::kJumped;
    sample.counts[i] = -counter_[i].count();
  }
  restarted_ = jumps > 1;  // one counter alone: its encoder slipped
  sample.buttons = buttonsOfPio(reply.pio);
  return result;
}

UsbPipe::Result UsbAmplifier::transferSimple(const UsbVoltages& voltage, DeviceSample& sample) noexcept {
  const SimplePacket drive = encodeSimpleDrive(voltage), latch = encodeSimpleLatch();
  SimplePacket in;
  UsbPipe::Result result = pipe_->send(drive.data(), static_cast<int>(drive.size()));
  if (result == UsbPipe::Result::kOk) result = pipe_->send(latch.data(), static_cast<int>(latch.size()));
  if (result == UsbPipe::Result::kOk) result = pipe_->receive(in.data(), static_cast<int>(in.size()));
  if (result != UsbPipe::Result::kOk) return result;
  const SimpleReply reply = decodeSimple(in);
  sample.stamp_ns = steadyNanoseconds();
  for (std::size_t i = 0; i < device_.strings.size(); ++i) sample.counts[i] = reply.counter[i];
  sample.buttons = buttonsOfPio(reply.pio);
  return result;
}

void UsbAmplifier::zeroDrive() noexcept {
  DeviceSample ignored;
  if (!gone_) transfer(UsbVoltages{}, ignored);
}

LinkReport UsbAmplifier::linkReport() const noexcept {
  LinkReport r;
  r.cycles = cycles_.load(std::memory_order_relaxed);
  r.stale = r.lost = lost_.load(std::memory_order_relaxed);
  r.bad_commands = bad_commands_.load(std::memory_order_relaxed);
  r.clamped = clamped_.load(std::memory_order_relaxed);
  r.refused_counts = refused_.load(std::memory_order_relaxed);
  return r;
}

std::string UsbAmplifier::describe() const {
  char rate[96];
  std::snprintf(rate, sizeof rate, ", at most %.0f Hz (untested on hardware)", max_rate_hz_);
  return std::string(model_ == UsbModel::kSh4 ? "USB amplifier SH4" : "USB amplifier Simple") + rate;
}

}  // namespace haptic
