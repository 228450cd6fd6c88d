#include "spidar_driver/transport/reply_collector.h"

namespace haptic {

void ReplyCollector::begin() noexcept {
  size_ = 0;
  current_ = -1;
  filled_ = foreign_ = foreign_inside_ = surplus_ = 0;
  started_ = false;
}

void ReplyCollector::expect(std::uint8_t header, int bytes, int allowed) noexcept {
  if (size_ == kMaxBoards || bytes < 1 || bytes > kMaxReplyBytes) return;
  Expected& e = expected_[size_++];
  e.header = header;
  e.bytes = static_cast<std::uint8_t>(bytes);
  e.allowed = static_cast<std::uint8_t>(allowed);
  e.received = 0;
}

bool ReplyCollector::complete() const {
  for (int i = 0; i < size_; ++i)
    if (expected_[i].received < expected_[i].allowed) return false;
  return true;
}

void ReplyCollector::feed(const std::uint8_t* bytes, std::size_t size) noexcept {
  for (std::size_t k = 0; k < size; ++k) {
    const std::uint8_t byte = bytes[k];
    if (current_ < 0) {
      for (int i = 0; i < size_ && current_ < 0; ++i)
        if (expected_[i].header == byte && expected_[i].received < expected_[i].allowed) current_ = i;
      if (current_ < 0) {
        if (complete()) {
          ++surplus_;
        } else {
          ++foreign_;
          foreign_inside_ += started_;
        }
        continue;
      }
      started_ = true;
      filled_ = 0;
    }
    Expected& e = expected_[current_];
    partial_[filled_++] = byte;
    if (filled_ == e.bytes) {
      e.reply = partial_;
      ++e.received;
      current_ = -1;
    }
  }
}

}  // namespace haptic
