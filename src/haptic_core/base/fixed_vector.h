/// A vector with run-time size and compile-time capacity, without heap: for lists inside a tick.
#pragma once
#include <array>
#include <cstddef>

namespace haptic {

/// A vector of at most kCapacity elements, stored inside the object: no heap. No access checks its bounds.
template <class T, std::size_t kCapacity>
class FixedVector {
 public:
  bool push_back(const T& value) {  ///< false, and nothing stored, when full
    if (size_ == kCapacity) return false;
    data_[size_++] = value;
    return true;
  }
  void clear() { size_ = 0; }  ///< elements are not destroyed
  /// At most the capacity; elements added hold what they held before.
  void resize(std::size_t n) { size_ = n < kCapacity ? n : kCapacity; }
  std::size_t size() const { return size_; }                     ///< number of elements
  bool empty() const { return size_ == 0; }                      ///< no elements
  static constexpr std::size_t capacity() { return kCapacity; }  ///< largest size
  T& operator[](std::size_t i) { return data_[i]; }              ///< element i < size()
  const T& operator[](std::size_t i) const { return data_[i]; }  ///< element i < size()
  T* begin() { return data_.data(); }                            ///< the first element
  T* end() { return data_.data() + size_; }                      ///< one past the last element
  const T* begin() const { return data_.data(); }                ///< the first element
  const T* end() const { return data_.data() + size_; }          ///< one past the last element
  T& back() { return data_[size_ - 1]; }                         ///< the last element; not of an empty vector
  const T& back() const { return data_[size_ - 1]; }             ///< the last element; not of an empty vector

 private:
  std::array<T, kCapacity> data_{};
  std::size_t size_ = 0;
};

}  // namespace haptic
