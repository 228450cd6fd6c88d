/// A vector for ticks: sized at load, never growing.
#pragma once
#include <utility>
#include <vector>

namespace haptic {

/// A vector whose storage is made at load. A push on a full one stores nothing and returns false.
template <class T>
class LoadedVector {
 public:
  /// Set-up: room for `capacity` elements, never less than before.
  void reserve(int capacity) {
    if (capacity <= capacity_) return;
    data_.resize(capacity);
    capacity_ = capacity;
  }
  /// Sets the number of elements; those added keep their old values. At most the capacity.
  void resize(int size) noexcept { size_ = size < capacity() ? size : capacity(); }
  /// The whole storage, whatever the size.
  std::vector<T>& all() noexcept { return data_; }
  /// (in realtime) False, and nothing stored, when full.
  bool push_back(const T& value) noexcept {
    if (size_ == capacity_) return false;
    data_[size_++] = value;
    return true;
  }
  /// (in realtime) Exchanges the storage too. O(1).
  void swap(LoadedVector& other) noexcept {
    data_.swap(other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }
  void clear() noexcept { size_ = 0; }                            ///< keeps the storage
  int size() const noexcept { return size_; }                     ///< elements
  bool empty() const noexcept { return size_ == 0; }              ///< no elements
  int capacity() const noexcept { return capacity_; }             ///< elements that fit
  T& operator[](int i) noexcept { return data_[i]; }              ///< element i < size()
  const T& operator[](int i) const noexcept { return data_[i]; }  ///< element i < size()
  T* begin() noexcept { return data_.data(); }                    ///< the first element
  T* end() noexcept { return data_.data() + size_; }              ///< one past the last element
  const T* begin() const noexcept { return data_.data(); }        ///< the first element
  const T* end() const noexcept { return data_.data() + size_; }  ///< one past the last element

 private:
  std::vector<T> data_;
  int size_ = 0, capacity_ = 0;
};

}  // namespace haptic
