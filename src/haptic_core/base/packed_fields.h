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
  static constexpr PackedAs value = PackedAs::kShared;  ///< an index; the object itself follows the index's first use
};

/// The way through a field of any kind, the same for writing and for reading. A `Stream` derives from this and says what to do with
///     number(field)   a number
///     length(list)    the length of a list: reading gives the list that length
///     choice(field)   which alternative a variant holds: reading makes it hold that one
///     share(pointer)  what several fields may point to
template <class Stream>
class FieldWay {
 public:
  /// Takes a field; `T` is const where it is written.
  template <class T>
  void operator()(T&& field) {
    constexpr PackedAs way = PackedWay<std::remove_cv_t<std::remove_reference_t<T>>>::value;
    auto& stream = static_cast<Stream&>(*this);
    if constexpr (way == PackedAs::kNumber) {
      stream.number(field);
    } else if constexpr (way == PackedAs::kList) {
      stream.length(field);
      for (auto& element : field) stream(element);
    } else if constexpr (way == PackedAs::kElements) {
      for (auto& element : field) stream(element);
    } else if constexpr (way == PackedAs::kPair) {
      stream(field.first), stream(field.second);
    } else if constexpr (way == PackedAs::kChoice) {
      stream.choice(field);
      std::visit(stream, field);
    } else if constexpr (way == PackedAs::kRecord) {
      std::remove_reference_t<T>::eachField(field, stream);
    } else if constexpr (way == PackedAs::kShared) {
      stream.share(field);
    } else {
      eachNumber(field, stream);
    }
  }
};

/// Appends fields to bytes.
class FieldWriter : public FieldWay<FieldWriter> {
 public:
  explicit FieldWriter(std::string& bytes) : bytes_(bytes) {}  ///< the caller's, which must outlive the writer

 private:
  friend FieldWay<FieldWriter>;
  template <class T>
  void number(const T& field) {
    bytes_.append(reinterpret_cast<const char*>(&field), sizeof field);
  }
  template <class List>
  void length(const List& field) {
    number(static_cast<std::uint32_t>(field.size()));
  }
  template <class Variant>
  void choice(const Variant& field) {
    number(static_cast<std::uint32_t>(field.index()));
  }
  template <class T>
  void share(const std::shared_ptr<T>& field) {
    std::uint32_t index = 0;
    while (index < shared_.size() && shared_[index] != field.get()) ++index;
    number(index);
    if (index < shared_.size()) return;
    shared_.push_back(field.get());
    pack(*this, *field);
  }

  std::string& bytes_;
  std::vector<const void*> shared_;  ///< in the order of their first use
};

/// Reads fields in the order in which they were written. Throws SetupError where the bytes end before the fields do.
class FieldReader : public FieldWay<FieldReader> {
 public:
  /// `where` is for messages; `bytes` are the caller's and must outlive the reader.
  FieldReader(const std::string& bytes, std::string where) : bytes_(bytes), where_(std::move(where)) {}

  bool atEnd() const { return next_ == bytes_.size(); }  ///< every byte was read
  /// Throws the SetupError of bytes that end too early.
  [[noreturn]] void cut() const { throw SetupError(where_, "ends too early, or was altered", "write it again"); }

 private:
  friend FieldWay<FieldReader>;
  template <class T>
  void number(T& field) {
    std::memcpy(&field, take(sizeof field), sizeof field);
  }
  std::uint32_t count() {
    std::uint32_t value = 0;
    number(value);
    return value;
  }
  template <class List>
  void length(List& field) {
    const std::uint32_t elements = count();
    if (elements > bytes_.size() - next_) cut();  // an element has at least a byte
    field.resize(elements);
  }
  /// `field` holds that alternative, with default values.
  template <class... Types>
  void choice(std::variant<Types...>& field) {
    choose(field, count(), std::index_sequence_for<Types...>());
  }
  template <class T, std::size_t... kIndex>
  void choose(T& field, std::uint32_t index, std::index_sequence<kIndex...>) const {
    if (!((index == kIndex ? (field.template emplace<kIndex>(), true) : false) || ...)) cut();
  }
  template <class T>
  void share(std::shared_ptr<T>& field) {
    const std::uint32_t index = count();
    if (index > shared_.size()) cut();
    if (index == shared_.size()) {
      shared_.emplace_back();
      std::shared_ptr<T> made;
      unpack(*this, made);
      shared_[index] = std::const_pointer_cast<std::remove_const_t<T>>(made);
    }
    field = std::static_pointer_cast<T>(shared_[index]);
  }
  const char* take(std::size_t bytes) {
    if (bytes > bytes_.size() - next_) cut();
    next_ += bytes;
    return bytes_.data() + next_ - bytes;
  }

  const std::string& bytes_;
  std::string where_;
  std::size_t next_ = 0;
  std::vector<std::shared_ptr<void>> shared_;  ///< in the order of their first use
};

}  // namespace haptic
