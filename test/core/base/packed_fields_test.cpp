// One list of fields writes and reads: what is written comes back bit for bit, what is shared stays shared, and bytes that end early
// are refused wherever they end.
#include "haptic_core/base/packed_fields.h"

#include <gtest/gtest.h>

#include <limits>

namespace haptic {
namespace packed_fields_test {

enum class Mode : unsigned char { kFirst, kSecond };

/// Something that is pointed to.
struct Thing {
  double size = 0;
};
void pack(FieldWriter& to, const Thing& thing) { to(thing.size); }
void unpack(FieldReader& from, std::shared_ptr<const Thing>& thing) {
  auto made = std::make_shared<Thing>();
  from(made->size);
  thing = made;
}

struct Inner {
  std::string name;
  std::pair<int, float> numbers{0, 0};
  std::shared_ptr<const Thing> thing;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.numbers), visit(s.thing);
  }
};

struct Outer {
  std::vector<Inner> inner;
  std::vector<std::vector<int>> loops;
  std::array<float, 2> colour{};
  Pose X;
  Mode mode = Mode::kFirst;
  bool on = false;
  std::uint64_t bits = 0;
  double odd[3] = {};
  std::variant<int, Inner, std::vector<double>> choice;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.inner), visit(s.loops), visit(s.colour), visit(s.X), visit(s.mode), visit(s.on), visit(s.bits), visit(s.odd);
    visit(s.choice);
  }
};

/// A NaN that carries bits, a zero with a sign and the smallest number: what text would lose.
Outer filled() {
  Outer o;
  const auto shared = std::make_shared<const Thing>(Thing{0.1});
  o.inner = {{"one", {1, 0.5f}, shared}, {"", {-2, -0.0f}, std::make_shared<const Thing>(Thing{3})}, {"two\n", {3, 1}, shared}};
  o.loops = {{1, 2, 3}, {}, {4}};
  o.colour = {0.25f, 0.75f};
  o.X.p = Vector3(0.1, 1.0 / 3, 1e300);
  o.X.R(1, 2) = -0.7;
  o.mode = Mode::kSecond;
  o.on = true;
  o.bits = 0xfedcba9876543210ull;
  const std::uint64_t nan = 0x7ff8dead00000001ull;
  std::memcpy(&o.odd[0], &nan, sizeof nan);
  o.odd[1] = -0.0;
  o.odd[2] = std::numeric_limits<double>::denorm_min();
  o.choice = Inner{"chosen", {5, 6}, shared};
  return o;
}

std::string bytesOf(const Outer& o) {
  std::string bytes;
  FieldWriter write(bytes);
  write(o);
  return bytes;
}

TEST(PackedFields, ComeBackBitForBit) {
  const Outer one = filled();
  const std::string bytes = bytesOf(one);
  Outer two;
  FieldReader read(bytes, "a file");
  read(two);
  EXPECT_TRUE(read.atEnd());
  ASSERT_EQ(two.inner.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(two.inner[i].name, one.inner[i].name);
    EXPECT_EQ(two.inner[i].numbers, one.inner[i].numbers);
    EXPECT_EQ(two.inner[i].thing->size, one.inner[i].thing->size);
  }
  EXPECT_TRUE(std::signbit(two.inner[1].numbers.second));
  EXPECT_EQ(two.loops, one.loops);
  EXPECT_EQ(two.colour, one.colour);
  EXPECT_EQ(two.X.p, one.X.p);
  EXPECT_EQ(two.X.R, one.X.R);
  EXPECT_EQ(two.mode, Mode::kSecond);
  EXPECT_TRUE(two.on);
  EXPECT_EQ(two.bits, one.bits);
  ASSERT_EQ(two.choice.index(), 1u);
  EXPECT_EQ(std::get<Inner>(two.choice).name, "chosen");
  EXPECT_EQ(std::get<Inner>(two.choice).thing, two.inner[0].thing);
  EXPECT_EQ(std::memcmp(two.odd, one.odd, sizeof one.odd), 0);
}

TEST(PackedFields, WhatIsSharedStaysShared) {
  const std::string bytes = bytesOf(filled());
  Outer two;
  FieldReader(bytes, "a file")(two);
  EXPECT_EQ(two.inner[0].thing, two.inner[2].thing);
  EXPECT_NE(two.inner[0].thing, two.inner[1].thing);
}

TEST(PackedFields, AnEarlyEndIsRefused) {
  const std::string bytes = bytesOf(filled());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string cut = bytes.substr(0, size);
    Outer two;
    EXPECT_THROW(FieldReader(cut, "a file")(two), SetupError) << size;
  }
}

TEST(PackedFields, ALengthBeyondTheBytesIsRefusedBeforeItIsMade) {
  std::string bytes;
  FieldWriter write(bytes);
  write(std::uint32_t{0xffffffff});
  std::vector<double> list;
  EXPECT_THROW(FieldReader(bytes, "a file")(list), SetupError);
}

TEST(PackedFields, AChoiceThatThereIsNotIsRefused) {
  std::string bytes;
  FieldWriter write(bytes);
  write(std::uint32_t{3}), write(0.0);
  std::variant<int, double> choice;
  EXPECT_THROW(FieldReader(bytes, "a file")(choice), SetupError);
}

}  // namespace packed_fields_test
}  // namespace haptic
