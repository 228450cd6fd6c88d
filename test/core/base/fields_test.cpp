// One list of fields serves all that visits them: nothing may be lost between saving, restoring and hashing.
#include "haptic_core/base/fields.h"

#include <gtest/gtest.h>

namespace haptic {
namespace fields_test {

enum class Mode : unsigned char { kFirst, kSecond };

struct Inner {
  double x = 0;
  bool on = false;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.x), visit(s.on);
  }
};

struct Outer {
  std::uint64_t bits = 0;
  int count = 0;
  Mode mode = Mode::kFirst;
  Vector3 v = Vector3::Zero();
  Quaternion q = Quaternion::Identity();
  Wrench F;
  Twist V;
  std::vector<Inner> list;
  double pair[2] = {0, 0};

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.bits), visit(s.count), visit(s.mode), visit(s.v), visit(s.q), visit(s.F), visit(s.V), visit(s.list),
        visit(s.pair);
  }
};

constexpr int kNumbers = 1 + 1 + 1 + 3 + 4 + 6 + 6 + 2 * 2 + 2;

/// Every number of it another one; the integer has bits that no double holds.
Outer filled() {
  Outer o;
  o.list.resize(2);
  double next = 0.1;
  eachNumber(o, [&next](auto& number) { setFromDouble(number, next += 1); });
  o.bits = 0xfedcba9876543210ull;
  o.mode = Mode::kSecond;
  o.list[1].on = true;
  return o;
}

TEST(Fields, ComeBackAsTheyWere) {
  const Outer one = filled();
  EXPECT_EQ(countFields(one), static_cast<std::size_t>(kNumbers));
  std::vector<double> numbers;
  appendFields(one, numbers);
  ASSERT_EQ(numbers.size(), static_cast<std::size_t>(kNumbers));
  Outer two;
  two.list.resize(2);
  const double* next = numbers.data();
  readFields(two, next);
  EXPECT_EQ(next, numbers.data() + numbers.size());
  EXPECT_EQ(two.bits, one.bits);
  EXPECT_EQ(two.mode, Mode::kSecond);
  EXPECT_TRUE(two.list[1].on);
  EXPECT_EQ(two.V.linear, one.V.linear);
  EXPECT_EQ(hashFields(kHashStart, two), hashFields(kHashStart, one));
}

TEST(Fields, EveryNumberReachesTheHash) {
  const std::uint64_t same = hashFields(kHashStart, filled());
  for (int changed = 0; changed < kNumbers; ++changed) {
    Outer o = filled();
    int i = 0;
    eachNumber(o, [&](auto& number) {
      if (i++ != changed) return;
      using Number = std::remove_reference_t<decltype(number)>;
      if constexpr (std::is_same_v<Number, bool>) {
        number = !number;
      } else if constexpr (std::is_enum_v<Number>) {
        number = Mode::kFirst;
      } else {
        number += 1;
      }
    });
    EXPECT_NE(hashFields(kHashStart, o), same) << changed;
  }
}

}  // namespace fields_test
}  // namespace haptic
