/// Finds the boards' replies in the bytes that come back.
///
/// There is no start byte and no checksum; a reply is known by its header and its length alone. It counts when what
/// follows it is another known header, or silence: a lost byte makes a reply swallow the next header, an added one leaves a
/// byte over, and both show behind it. Otherwise its first byte is dropped and the search goes on from the second, so that
/// a payload byte that looks like a header costs nothing but that look.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "spidar_driver/transport/board_model.h"

namespace haptic {

class ReplyStream {
 public:
  void know(std::uint8_t header, int bytes) { length_[header] = static_cast<std::uint8_t>(bytes); }  ///< set-up
  void forget() noexcept { size_ = 0; }                     ///< drops what is under way
  int pending() const { return static_cast<int>(size_); }   ///< bytes that are no proven reply yet
  bool complete() const { return size_ > 0 && size_ == length_[buffer_[0]]; }  ///< a reply that only silence must prove
  std::uint64_t foreign() const { return foreign_; }        ///< bytes that belong to no reply, since the start

  /// (in realtime) Hands each proven reply to `take(bytes, size)`.
  template <class Take>
  void feed(const std::uint8_t* bytes, std::size_t size, Take&& take) noexcept {
    for (std::size_t k = 0; k < size; ++k) {
      buffer_[size_++] = bytes[k];
      search(take);
    }
  }
  /// (in realtime) The line is silent: a complete reply is one.
  template <class Take>
  void settle(Take&& take) noexcept {
    if (!complete()) return;
    take(buffer_.data(), static_cast<int>(size_));
    size_ = 0;
  }
  /// (in realtime) No byte will complete what is under way: it is dropped.
  void abandon() noexcept {
    foreign_ += size_;
    size_ = 0;
  }

 private:
  // Bounded: a reply and one byte behind it are decided at once, so the buffer never holds more.
  template <class Take>
  void search(Take&& take) noexcept {
    for (;;) {
      std::size_t skip = 0;
      while (skip < size_ && length_[buffer_[skip]] == 0) ++skip;
      foreign_ += skip;
      drop(skip);
      if (size_ == 0) return;
      const std::size_t length = length_[buffer_[0]];
      if (size_ <= length) return;
      const bool proven = length_[buffer_[length]] != 0;
      if (proven) take(buffer_.data(), static_cast<int>(length));
      if (!proven) ++foreign_;
      drop(proven ? length : 1);
    }
  }
  void drop(std::size_t n) noexcept {
    if (n == 0) return;
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(n), buffer_.begin() + static_cast<std::ptrdiff_t>(size_),
              buffer_.begin());
    size_ -= n;
  }

  std::array<std::uint8_t, 256> length_{};  ///< of the reply with that header; 0: no header
  std::array<std::uint8_t, 2 * kMaxReplyBytes> buffer_{};
  std::size_t size_ = 0;
  std::uint64_t foreign_ = 0;
};

}  // namespace haptic
