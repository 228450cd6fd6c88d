/// A vector with run-time size and compile-time capacity, without heap: for lists inside a tick.
#pragma once
#include <array>
#include <cstddef>

namespace haptic {

template <class T, std::size_t kCapacity>
class FixedVector {
 public:
  bool push_back(const T& value) {  ///< false, and nothing stored, when full
    if (size_ == kCapacity) return false;
    data_[size_++] = value;
    return true;
  }
  void clear() { size_ = 0; }
  void resize(std::size_t n) { size_ = n < kCapacity ? n : kCapacity; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  static constexpr std::size_t capacity() { return kCapacity; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T* begin() { return data_.data(); }
  T* end() { return data_.data() + size_; }
  const T* begin() const { return data_.data(); }
  const T* end() const { return data_.data() + size_; }
  T& back() { return data_[size_ - 1]; }
  const T& back() const { return data_[size_ - 1]; }

 private:
  std::array<T, kCapacity> data_{};
  std::size_t size_ = 0;
};

}  // namespace haptic
