#include "spidar_driver/transport/open_transport.h"

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/serial_port.h"
#include "spidar_driver/transport/uart_boards.h"
#include "spidar_driver/transport/usb_amplifier.h"

namespace haptic {
namespace {

/// The first serial port with the boards that the device needs. Throws what the last candidate threw.
std::string findPort(const DeviceDef& device, int baud) {
  const std::vector<std::string> candidates = serialCandidates();
  if (candidates.empty())
    throw SetupError(device.name, "no serial port found (/dev/ttyUSB*, /dev/ttyACM*)",
                     "plug the adapter in, or set the port");
  for (const std::string& path : candidates) {
    try {
      SerialPort port(path, baud);
      matchBoards(scanBus(port), device, path);
      return path;
    } catch (const SetupError&) {
      if (path == candidates.back()) throw;
    }
  }
  return {};
}

std::unique_ptr<Transport> openUart(const DeviceDef& device, const TransportSettings& settings) {
  UartSettings uart;
  uart.rate_hz = settings.rate_hz;
  uart.baud = settings.baud;
  uart.reply_wait_s = settings.reply_wait_s;
  uart.max_string_speed = settings.max_string_speed;
  uart.guard = settings.guard;
  const std::string given = settings.port;
  const std::string path = given.empty() ? findPort(device, settings.baud) : given;
  const int baud = settings.baud;
  // An adapter may come back under another name after it was unplugged.
  auto open = [given, path, baud, device] {
    const std::string now = given.empty() ? findPort(device, baud) : path;
    return std::unique_ptr<ByteLink>(std::make_unique<SerialPort>(now, baud));
  };
  return std::make_unique<UartBoards>(device, uart, path, open);
}

}  // namespace

std::vector<std::string> transportNames() {
  return {"twin", "uart", "usb_sh4", "usb_simple"};
}

std::unique_ptr<Transport> openTransport(const DeviceDef& device, const TransportSettings& settings) {
  if (!(settings.rate_hz > 0)) throw SetupError(device.name, "rate is not positive", "set it to 1000 Hz");
  if (device.transport == "twin") {
    TwinSettings twin = settings.twin;
    twin.period = 1 / settings.rate_hz;
    return std::make_unique<DeviceTwin>(device, twin);
  }
  if (device.transport == "uart") return openUart(device, settings);
  if (device.transport == "usb_sh4")
    return std::make_unique<UsbAmplifier>(device, UsbModel::kSh4, settings.rate_hz,
                                          openUsbPipe(kUsbSh4Product, settings.usb_unit));
  if (device.transport == "usb_simple")
    return std::make_unique<UsbAmplifier>(device, UsbModel::kSimple, settings.rate_hz,
                                          openUsbPipe(kUsbSimpleProduct, settings.usb_unit));
  std::string names;
  for (const std::string& name : transportNames()) names += (names.empty() ? "" : ", ") + name;
  throw SetupError(device.file.empty() ? device.name : device.file,
                   "unknown transport '" + device.transport + "'", "set `transport` to one of " + names);
}

}  // namespace haptic
