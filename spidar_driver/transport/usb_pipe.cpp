// libusb's side of the amplifiers.
#include <libusb.h>

#include <array>

#include "haptic_core/base/error.h"
#include "spidar_driver/transport/usb_amplifier.h"

namespace haptic {
namespace {

constexpr unsigned char kOut = 0x02, kIn = 0x86;  // EP2 OUT and EP6 IN of the FX2 design
constexpr unsigned kTimeoutMs = 2;                // a healthy transfer takes 0.1 ms; longer is a lost tick

class LibusbPipe : public UsbPipe {
 public:
  LibusbPipe(libusb_context* context, libusb_device_handle* handle) : context_(context), handle_(handle) {}
  ~LibusbPipe() override {
    libusb_release_interface(handle_, 0);
    libusb_close(handle_);
    libusb_exit(context_);
  }
  Result send(const std::uint8_t* bytes, int size) noexcept override {
    return transfer(kOut, const_cast<std::uint8_t*>(bytes), size);  // libusb's one signature for both ways
  }
  Result receive(std::uint8_t* bytes, int size) noexcept override { return transfer(kIn, bytes, size); }

 private:
  Result transfer(unsigned char endpoint, std::uint8_t* bytes, int size) noexcept {
    int moved = 0;
    const int error = libusb_bulk_transfer(handle_, endpoint, bytes, size, &moved, kTimeoutMs);
    if (error == LIBUSB_ERROR_NO_DEVICE) return Result::kGone;
    return error == 0 && moved == size ? Result::kOk : Result::kTimeout;
  }
  libusb_context* context_;
  libusb_device_handle* handle_;
};

/// Number on the rotary switch, read with the drive at zero; -1 when the amplifier does not answer.
int readUnit(UsbPipe& pipe, std::uint16_t product) {
  if (product == kUsbSh4Product) {
    const Sh4Packet out = encodeSh4({});
    Sh4Packet in;
    const bool ok = pipe.send(out.data(), static_cast<int>(out.size())) == UsbPipe::Result::kOk &&
                    pipe.receive(in.data(), static_cast<int>(in.size())) == UsbPipe::Result::kOk;
    return ok ? unitOfPio(decodeSh4(in).pio) : -1;
  }
  const SimplePacket out = encodeSimpleLatch();
  SimplePacket in;
  const bool ok = pipe.send(out.data(), static_cast<int>(out.size())) == UsbPipe::Result::kOk &&
                  pipe.receive(in.data(), static_cast<int>(in.size())) == UsbPipe::Result::kOk;
  return ok ? unitOfPio(decodeSimple(in).pio) : -1;
}

/// Opens device `wanted` of those with this product; nullptr when there are fewer. `error` is libusb's.
std::unique_ptr<UsbPipe> openNth(std::uint16_t product, int wanted, int& error) {
  libusb_context* context = nullptr;
  if ((error = libusb_init(&context)) != 0) return nullptr;
  libusb_device** list = nullptr;
  const ssize_t count = libusb_get_device_list(context, &list);
  libusb_device_handle* handle = nullptr;
  int seen = 0;
  for (ssize_t i = 0; i < count && !handle && error == 0; ++i) {
    libusb_device_descriptor descriptor{};
    libusb_get_device_descriptor(list[i], &descriptor);
    if (descriptor.idVendor == kUsbVendor && descriptor.idProduct == product && seen++ == wanted)
      error = libusb_open(list[i], &handle);
  }
  if (list) libusb_free_device_list(list, 1);
  if (handle && error == 0) error = libusb_claim_interface(handle, 0);
  if (!handle || error != 0) {
    if (handle) libusb_close(handle);
    libusb_exit(context);
    return nullptr;
  }
  return std::make_unique<LibusbPipe>(context, handle);
}

}  // namespace

std::unique_ptr<UsbPipe> openUsbPipe(std::uint16_t product, int unit) {
  char where[64];
  std::snprintf(where, sizeof where, "usb %04x:%04x", kUsbVendor, product);
  std::string others;
  for (int i = 0;; ++i) {
    int error = 0;
    std::unique_ptr<UsbPipe> pipe = openNth(product, i, error);
    if (error == LIBUSB_ERROR_ACCESS)
      throw SetupError(where, "no permission", "install the udev rule (spidar_driver/udev/README.md)");
    if (error == LIBUSB_ERROR_BUSY)
      throw SetupError(where, "another program holds the amplifier", "stop it; a device has one driver");
    if (error != 0)
      throw SetupError(where, libusb_strerror(static_cast<libusb_error>(error)), "plug it in again");
    if (!pipe && !others.empty())
      throw SetupError(where, "no amplifier with unit " + std::to_string(unit) + ", found" + others,
                       "set usb_unit to the number on the rotary switch at its back");
    if (!pipe) throw SetupError(where, "no such amplifier is plugged in", "check cable and power (lsusb)");
    if (unit < 0) return pipe;
    const int found = readUnit(*pipe, product);
    if (found == unit) return pipe;
    others += " " + std::to_string(found);
  }
}

}  // namespace haptic
