/// What an object remembers from tick to tick, as numbers, for recordings. The object lists its fields once, in
///     template <class Numbers> void remember(Numbers& n) { n(field_a_), n(field_b_); }
/// and the same list writes and reads them: no field can be kept in one order and taken in another.
#pragma once
#include <type_traits>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/base/spatial.h"

namespace haptic {

/// Visits an object's memory as numbers.
/// `Kind` has number(double&), and size(int, most) that keeps or gives the length of what has no fixed one.
template <class Kind>
class MemoryNumbers {
 public:
  void operator()(double& x) { self().number(x); }  ///< one number
  /// An integer or enum, exact up to 2⁵³.
  template <class T, class = std::enable_if_t<std::is_enum<T>::value || std::is_integral<T>::value>>
  void operator()(T& small) {  // exact up to 2⁵³
    double x = static_cast<double>(small);
    self().number(x);
    if (Kind::kReads) small = static_cast<T>(static_cast<std::int64_t>(x));
  }
  /// Coefficients column by column; in front of a vector of run-time size its length.
  template <class Derived>
  void operator()(Eigen::PlainObjectBase<Derived>& m) {
    if constexpr (Derived::RowsAtCompileTime == Eigen::Dynamic) {
      const int rows = self().size(static_cast<int>(m.rows()), Derived::MaxRowsAtCompileTime);
      if (Kind::kReads) m.resize(rows);
    }
    for (Eigen::Index i = 0; i < m.size(); ++i) self().number(m.data()[i]);
  }
  void operator()(Pose& X) { (*this)(X.R), (*this)(X.p); }              ///< rotation, then origin
  void operator()(Twist& V) { (*this)(V.angular), (*this)(V.linear); }  ///< angular, then linear
  void operator()(Wrench& F) { (*this)(F.torque), (*this)(F.force); }   ///< torque, then force

 private:
  Kind& self() { return static_cast<Kind&>(*this); }
};

/// Writes an object's memory as numbers.
/// (in realtime while `out` has room) Appends to `out`.
class MemoryWriter : public MemoryNumbers<MemoryWriter> {
 public:
  static constexpr bool kReads = false;                           ///< fields keep their values
  explicit MemoryWriter(std::vector<double>& out) : out_(out) {}  ///< `out` must outlive the writer
  void number(double& x) { out_.push_back(x); }                   ///< appends x
  /// Appends the length n and returns it.
  int size(int n, int) {
    out_.push_back(n);
    return n;
  }

 private:
  std::vector<double>& out_;
};

/// Reads an object's memory from numbers.
/// Throws SetupError when there are too few numbers, or, at `end`, too many.
class MemoryReader : public MemoryNumbers<MemoryReader> {
 public:
  static constexpr bool kReads = true;  ///< fields take the values that are read
  /// Reads `in` from its start; `whose` names the object in errors.
  MemoryReader(const std::vector<double>& in, const char* whose) : in_(in), whose_(whose) {}
  void number(double& x) { x = in_[need()]; }  ///< x becomes the next number
  /// The next number as a length of at most `most`.
  int size(int, int most) {
    const double n = in_[need()];
    if (!(n >= 0 && n <= most)) refuse();
    return static_cast<int>(n);
  }
  /// Throws SetupError when numbers are left.
  void end() const {
    if (next_ != in_.size()) refuse();
  }

 private:
  std::size_t need() {
    if (next_ >= in_.size()) refuse();
    return next_++;
  }
  [[noreturn]] void refuse() const {
    throw SetupError(whose_, "its memory of " + std::to_string(in_.size()) + " numbers does not fit",
                     "use a recording of this version");
  }
  const std::vector<double>& in_;
  const char* whose_;
  std::size_t next_ = 0;
};

}  // namespace haptic
