/// One list of a struct's fields, for everything that has to visit all of them: saving, restoring, hashing, comparing.
///
/// A struct states its fields once,
///     template <class Self, class Visit> static void eachField(Self& self, Visit&& visit) { visit(self.a); visit(self.b); }
/// with Self deduced const or not. Fields are numbers, enums, bools, Eigen vectors and quaternions, standard vectors and
/// arrays of these, strings, poses, and structs that state theirs. `eachNumber` flattens them into single numbers in that order; the
/// lengths of vectors are not among them.
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/base/word_hash.h"

namespace haptic {

/// T is U, const or not.
template <class T, class U>
inline constexpr bool kIs = std::is_same_v<std::remove_const_t<T>, U>;

/// A single number.
template <class T, class Visit>
std::enable_if_t<std::is_arithmetic_v<std::remove_const_t<T>> || std::is_enum_v<T>> eachNumber(T& value, Visit&& visit) {
  visit(value);
}

/// Column by column.
template <class T, class Visit>
std::enable_if_t<kIs<T, Vector3> || kIs<T, Matrix3>> eachNumber(T& matrix, Visit&& visit) {
  for (int i = 0; i < matrix.size(); ++i) visit(matrix.data()[i]);
}

/// w, x, y, z.
template <class T, class Visit>
std::enable_if_t<kIs<T, Quaternion>> eachNumber(T& q, Visit&& visit) {
  visit(q.w()), visit(q.x()), visit(q.y()), visit(q.z());
}

/// Rotation, then origin.
template <class T, class Visit>
std::enable_if_t<kIs<T, Pose>> eachNumber(T& X, Visit&& visit) {
  eachNumber(X.R, visit), eachNumber(X.p, visit);
}

/// Torque, then force.
template <class T, class Visit>
std::enable_if_t<kIs<T, Wrench>> eachNumber(T& F, Visit&& visit) {
  eachNumber(F.torque, visit), eachNumber(F.force, visit);
}

/// Angular, then linear.
template <class T, class Visit>
std::enable_if_t<kIs<T, Twist>> eachNumber(T& V, Visit&& visit) {
  eachNumber(V.angular, visit), eachNumber(V.linear, visit);
}

/// Character by character.
template <class Visit>
void eachNumber(const std::string& text, Visit&& visit) {
  for (const char& c : text) visit(c);
}

// Lists hold structs and structs hold lists: both must be known to both.
template <class A, class B, class Visit>
void eachNumber(const std::pair<A, B>& pair, Visit&& visit);
template <class T, class Visit>
void eachNumber(const std::vector<T>& values, Visit&& visit);
template <class T, class Visit>
void eachNumber(std::vector<T>& values, Visit&& visit);
template <class T, std::size_t kCount, class Visit>
void eachNumber(T (&values)[kCount], Visit&& visit);

/// Accepts any field; stands for a visitor where only the existence of a list is asked.
struct AnyField {
  template <class Field>
  void operator()(Field&) const {}  ///< does nothing
};

/// A struct that states its fields: field by field.
template <class T, class Visit>
auto eachNumber(T& record, Visit&& visit) -> decltype(std::remove_const_t<T>::eachField(record, AnyField{})) {
  std::remove_const_t<T>::eachField(record, [&visit](auto& field) { eachNumber(field, visit); });
}

/// First, then second.
template <class A, class B, class Visit>
void eachNumber(const std::pair<A, B>& pair, Visit&& visit) {
  eachNumber(pair.first, visit), eachNumber(pair.second, visit);
}

/// Element by element.
template <class T, class Visit>
void eachNumber(const std::vector<T>& values, Visit&& visit) {
  for (const T& value : values) eachNumber(value, visit);
}
/// Element by element.
template <class T, class Visit>
void eachNumber(std::vector<T>& values, Visit&& visit) {
  for (T& value : values) eachNumber(value, visit);
}

/// Element by element.
template <class T, std::size_t kCount, class Visit>
void eachNumber(T (&values)[kCount], Visit&& visit) {
  for (T& value : values) eachNumber(value, visit);
}

/// A number as 64 bits: doubles and 64-bit integers as they are, everything smaller as the double of its value.
template <class T>
double asDouble(const T& value) noexcept {
  if constexpr (std::is_same_v<T, std::uint64_t>) {
    double bits;
    std::memcpy(&bits, &value, sizeof bits);
    return bits;
  } else {
    return static_cast<double>(value);
  }
}
/// The inverse of `asDouble`.
template <class T>
void setFromDouble(T& value, double number) noexcept {
  if constexpr (std::is_same_v<T, std::uint64_t>) {
    std::memcpy(&value, &number, sizeof value);
  } else if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(static_cast<int>(number));
  } else if constexpr (std::is_same_v<T, bool>) {
    value = number != 0;
  } else {
    value = static_cast<T>(number);
  }
}

/// (in realtime) The hash continued over all numbers of `record`.
template <class T>
std::uint64_t hashFields(std::uint64_t hash, const T& record) noexcept {
  eachNumber(record, [&hash](const auto& number) {
    const double word = asDouble(number);
    hash = hashWords(hash, &word, sizeof word);
  });
  return hash;
}

/// Appends all numbers of `record` to `out`.
template <class T>
void appendFields(const T& record, std::vector<double>& out) {
  eachNumber(record, [&out](const auto& number) { out.push_back(asDouble(number)); });
}

/// Reads what `appendFields` wrote and moves `next` on; the caller knows that there is enough.
template <class T>
void readFields(T& record, const double*& next) noexcept {
  eachNumber(record, [&next](auto& number) { setFromDouble(number, *next++); });
}

/// (in realtime) How many numbers `record` has.
template <class T>
std::size_t countFields(const T& record) noexcept {
  std::size_t count = 0;
  eachNumber(record, [&count](const auto&) { ++count; });
  return count;
}

}  // namespace haptic
