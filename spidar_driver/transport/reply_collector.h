/// Sorts the bytes that come back from a cycle of commands into the boards' replies.
///
/// There is no start byte and no checksum, but the host knows which replies it asked for and how long they
/// are. A cycle is sound when, from the first recognised header on, exactly the expected replies follow each
/// other: a lost byte leaves the last reply short, an extra byte leaves one over, a foreign byte stands where
/// a header must. An unsound cycle is dropped as a whole; the line is quiet between cycles, so the next
/// starts in step.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "spidar_driver/transport/board_model.h"

namespace haptic {

class ReplyCollector {
 public:
  struct Expected {
    std::uint8_t header = 0;
    std::uint8_t bytes = 0;  ///< header included
    std::uint8_t allowed =
        1;  ///< replies that may come: 2 while one of an earlier cycle may still be on its way
    std::uint8_t received = 0;
    std::array<std::uint8_t, kMaxReplyBytes> reply{};  ///< the latest
  };

  void begin() noexcept;  ///< forgets the cycle before
  void expect(std::uint8_t header, int bytes, int allowed) noexcept;
  void feed(const std::uint8_t* bytes, std::size_t size) noexcept;  ///< (in realtime)

  int size() const { return size_; }
  const Expected& operator[](int i) const { return expected_[i]; }
  bool complete() const;  ///< every reply that may come has come
  bool sound() const { return foreign_inside_ == 0 && surplus_ == 0 && current_ < 0; }
  int foreign() const { return foreign_; }  ///< bytes where a header was due
  int surplus() const { return surplus_; }  ///< bytes behind the last reply

 private:
  std::array<Expected, kMaxBoards> expected_{};
  int size_ = 0;
  int current_ = -1;  ///< index of the reply under way
  int filled_ = 0;    ///< its bytes so far
  int foreign_ = 0, foreign_inside_ = 0, surplus_ = 0;
  bool started_ = false;
  std::array<std::uint8_t, kMaxReplyBytes> partial_{};
};

}  // namespace haptic
