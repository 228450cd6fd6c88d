/// Structs as bytes and back, by the list of fields that they state (base/fields.h): one description writes and reads.
///
/// A number is its own bytes, so a double comes back bit for bit; a list is its length and its elements; Eigen's types and structs are
/// their numbers in the order of `eachNumber` and `eachField`. What several fields share is written once. Numbers stand as the
/// processor has them, low byte first; a field must have the same size on every machine, so none of it may be a `long` or `size_t`.
///
/// A type that holds more than its fields is written and read by two functions beside it, found by argument:
///     void pack(FieldWriter& to, const T& field);   void unpack(FieldReader& from, T& field);
/// At set-up: allocates.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"

namespace haptic {

/// How a field is written.
enum class PackedAs : unsigned char { kNumber, kList, kElements, kPair, kChoice, kRecord, kShared, kNumbers };

/// The way of a type: `PackedAs` as `value`.
template <class T, class = void>
struct PackedWay {
  static constexpr PackedAs value =
      std::is_arithmetic_v<T> || std::is_enum_v<T> ? PackedAs::kNumber : PackedAs::kNumbers;  ///< of anything without a rule below
};
/// A struct that states its fields.
template <class T>
struct PackedWay<T, std::void_t<decltype(T::eachField(std::declval<T&>(), AnyField{}))>> {
  static constexpr PackedAs value = PackedAs::kRecord;  ///< field by field
};
/// A list.
template <class T>
struct PackedWay<std::vector<T>> {
  static constexpr PackedAs value = PackedAs::kList;  ///< length and elements
};
/// A list of fixed length: its elements.
template <class T, std::size_t kCount>
struct PackedWay<std::array<T, kCount>> {
  static constexpr PackedAs value = PackedAs::kElements;  ///< one after the other
};
/// A text.
template <>
struct PackedWay<std::string> {
  static constexpr PackedAs value = PackedAs::kList;  ///< length and characters
};
/// Two values.
template <class A, class B>
struct PackedWay<std::pair<A, B>> {
  static constexpr PackedAs value = PackedAs::kPair;  ///< one after the other
};
/// One of several types.
template <class... Types>
struct PackedWay<std::variant<Types...>> {
  static constexpr PackedAs value = PackedAs::kChoice;  ///< which, and its value
};
/// What several fields may point to.
template <class T>
struct PackedWay<std::shared_ptr<T>> {
  static constexpr PackedAs value = PackedAs::kShared;  ///< an index, and the first time what it stands for
};

/// Appends fields to bytes.
class FieldWriter {
 public:
  explicit FieldWriter(std::string& bytes) : bytes_(bytes) {}  ///< the caller's, which must outlive the writer

  /// Appends a field of any kind.
  template <class T>
  void operator()(const T& field) {
    constexpr PackedAs way = PackedWay<T>::value;
    if constexpr (way == PackedAs::kNumber) {
      bytes_.append(reinterpret_cast<const char*>(&field), sizeof field);
    } else if constexpr (way == PackedAs::kList) {
      (*this)(static_cast<std::uint32_t>(field.size()));
      for (const auto& element : field) (*this)(element);
    } else if constexpr (way == PackedAs::kElements) {
      for (const auto& element : field) (*this)(element);
    } else if constexpr (way == PackedAs::kPair) {
      (*this)(field.first), (*this)(field.second);
    } else if constexpr (way == PackedAs::kChoice) {
      (*this)(static_cast<std::uint32_t>(field.index()));
      std::visit(*this, field);
    } else if constexpr (way == PackedAs::kRecord) {
      T::eachField(field, *this);
    } else if constexpr (way == PackedAs::kShared) {
      share(field);
    } else {
      eachNumber(field, *this);
    }
  }

 private:
  template <class T>
  void share(const std::shared_ptr<T>& field) {
    std::uint32_t index = 0;
    while (index < shared_.size() && shared_[index] != field.get()) ++index;
    (*this)(index);
    if (index < shared_.size()) return;
    shared_.push_back(field.get());
    pack(*this, *field);
  }

  std::string& bytes_;
  std::vector<const void*> shared_;  ///< in the order of their first use
};

/// Reads fields in the order in which they were written. Throws SetupError where the bytes end before the fields do.
class FieldReader {
 public:
  /// `where` is for messages; `bytes` are the caller's and must outlive the reader.
  FieldReader(const std::string& bytes, std::string where) : bytes_(bytes), where_(std::move(where)) {}

  /// Reads a field of any kind.
  template <class T>
  void operator()(T& field) {
    constexpr PackedAs way = PackedWay<T>::value;
    if constexpr (way == PackedAs::kNumber) {
      std::memcpy(&field, take(sizeof field), sizeof field);
    } else if constexpr (way == PackedAs::kList) {
      std::uint32_t count = 0;
      (*this)(count);
      if (count > bytes_.size() - next_) cut();  // an element has at least a byte
      field.resize(count);
      for (auto& element : field) (*this)(element);
    } else if constexpr (way == PackedAs::kElements) {
      for (auto& element : field) (*this)(element);
    } else if constexpr (way == PackedAs::kPair) {
      (*this)(field.first), (*this)(field.second);
    } else if constexpr (way == PackedAs::kChoice) {
      std::uint32_t index = 0;
      (*this)(index);
      choose(field, index, std::make_index_sequence<std::variant_size_v<T>>());
      std::visit(*this, field);
    } else if constexpr (way == PackedAs::kRecord) {
      T::eachField(field, *this);
    } else if constexpr (way == PackedAs::kShared) {
      share(field);
    } else {
      eachNumber(field, *this);
    }
  }

  bool atEnd() const { return next_ == bytes_.size(); }  ///< every byte was read
  /// Throws the SetupError of bytes that end too early.
  [[noreturn]] void cut() const { throw SetupError(where_, "ends too early, or was altered", "write it again"); }

 private:
  const char* take(std::size_t count) {
    if (count > bytes_.size() - next_) cut();
    next_ += count;
    return bytes_.data() + next_ - count;
  }
  /// `field` holds its alternative `index`, with default values.
  template <class T, std::size_t... kIndex>
  void choose(T& field, std::uint32_t index, std::index_sequence<kIndex...>) const {
    if (!((index == kIndex ? (field.template emplace<kIndex>(), true) : false) || ...)) cut();
  }
  template <class T>
  void share(std::shared_ptr<T>& field) {
    std::uint32_t index = 0;
    (*this)(index);
    if (index > shared_.size()) cut();
    if (index == shared_.size()) {
      shared_.emplace_back();
      std::shared_ptr<T> made;
      unpack(*this, made);
      shared_[index] = std::const_pointer_cast<std::remove_const_t<T>>(made);
    }
    field = std::static_pointer_cast<T>(shared_[index]);
  }

  const std::string& bytes_;
  std::string where_;
  std::size_t next_ = 0;
  std::vector<std::shared_ptr<void>> shared_;  ///< in the order of their first use
};

}  // namespace haptic
