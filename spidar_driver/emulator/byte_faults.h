/// What a bad cable does to one direction of a line.
#pragma once
#include <cstdint>
#include <random>

namespace haptic {

class ByteFaults {
 public:
  void drop(int bytes) { drop_ += bytes; }
  void corrupt(int bytes) { corrupt_ += bytes; }  ///< flips at least one bit of each
  void duplicate(int bytes) { duplicate_ += bytes; }
  void insert(int bytes) { insert_ += bytes; }  ///< foreign bytes before the next one
  /// From now on each byte is dropped, changed, doubled or preceded by another one with such a probability.
  struct Rates {
    double drop = 0, corrupt = 0, duplicate = 0, insert = 0;
  };
  Rates rates;
  /// Faults wait for so many bytes to pass.
  void after(int bytes) { pass_ = bytes; }

  /// Hands what becomes of `byte` to `emit`, none, one or more bytes.
  template <class Emit>
  void apply(std::uint8_t byte, Emit&& emit) {
    if (pass_ > 0) return --pass_, emit(byte);
    drop_ += hits(rates.drop), corrupt_ += hits(rates.corrupt);
    duplicate_ += hits(rates.duplicate), insert_ += hits(rates.insert);
    for (; insert_ > 0; --insert_) emit(random());
    if (drop_ > 0) {
      --drop_;
      return;
    }
    if (corrupt_ > 0) {
      --corrupt_;
      byte = static_cast<std::uint8_t>(byte ^ (random() | 1 << (state_ & 7)));
    }
    emit(byte);
    if (duplicate_ > 0) {
      --duplicate_;
      emit(byte);
    }
  }

 private:
  std::uint8_t random() {  // a fixed sequence: a fault run repeats
    state_ = state_ * 1664525u + 1013904223u;
    return static_cast<std::uint8_t>(state_ >> 24);
  }
  bool hits(double probability) {
    return probability > 0 && std::uniform_real_distribution<double>(0, 1)(chance_) < probability;
  }
  std::mt19937 chance_{1};
  int drop_ = 0, corrupt_ = 0, duplicate_ = 0, insert_ = 0, pass_ = 0;
  std::uint32_t state_ = 1;
};

}  // namespace haptic
