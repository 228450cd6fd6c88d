// Saved states that are damaged: what is an index in them is judged before anything is taken over.
#include "haptic_core/world/saved_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "../../scenes/blocks.h"
#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/world/applied_wrench.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace saved_state_test {

using namespace scenes;

/// Three cubes, one on the other, one of them a pointer's, and a wrench on the top one.
struct Saved {
  Saved() {
    for (int i = 0; i < 50; ++i) world.step();
    world.applyWrench(world.linkIndex("cube2"), {{Vector3::Zero(), Vector3(0, 0, 1)}, Vector3::Zero(), false}, 1);
    world.step();
    packed = world.save();
  }
  static WorldDef def() {
    WorldDef def = stack(3, CubeParameters{}, WorldSettings{});
    PointerDef pointer;
    pointer.articulation = static_cast<int>(def.articulations.size()) - 2, pointer.link = 0;
    def.pointers.push_back(pointer);
    return def;
  }
  bool refused(const std::vector<double>& state) {
    const std::uint64_t before = world.hash();
    try {
      world.restore(state);
    } catch (const SetupError&) {
      EXPECT_EQ(world.hash(), before) << "what was refused has changed something";
      return true;
    }
    return false;
  }
  /// Index of the first number of pair i.
  std::size_t pair(int i) const {
    return State::kHead + countFields(world.state()) + static_cast<std::size_t>(i) * countFields(ActivePair{});
  }
  World world{def()};
  std::vector<double> packed;
};

double bits(std::uint64_t value) {
  double number;
  std::memcpy(&number, &value, sizeof number);
  return number;
}

TEST(SavedState, IndicesAreJudged) {
  Saved s;
  ASSERT_GE(s.world.state().pairs.count(), 2);
  EXPECT_FALSE(s.refused(s.packed));
  const auto changed = [&](std::size_t at, double number) {
    std::vector<double> state = s.packed;
    state[at] = number;
    return s.refused(state);
  };
  EXPECT_TRUE(changed(s.pair(0), bits(ActivePair::keyOf(0, 1000)))) << "a shape that is not there";
  EXPECT_TRUE(changed(s.pair(0), bits(ActivePair::keyOf(1, 1)))) << "with itself";
  EXPECT_TRUE(changed(s.pair(1), s.packed[s.pair(0)])) << "a pair twice";
  const std::size_t vertex = s.pair(0) + 1 + 6;  // after the key, the direction and the normal
  EXPECT_TRUE(changed(vertex, 8)) << "a box has eight vertices";
  EXPECT_TRUE(changed(vertex + 1, -1));
  EXPECT_FALSE(changed(vertex, 7));
  EXPECT_TRUE(changed(s.packed.size() - countFields(AppliedWrench{}), 99)) << "a wrench on a link that is not there";
  // Modes and the pointer's link are found by what a state with others has there.
  ASSERT_FALSE(s.refused(s.packed));
  State other = s.world.state();
  other.mode[0] = other.mode[0] == TreeMode::kPut ? TreeMode::kFlowed : TreeMode::kPut;
  const std::vector<double> with_mode = other.pack();
  other = s.world.state();
  other.pointers[0].link = 0;
  const std::vector<double> with_link = other.pack();
  for (std::size_t i = 0; i < s.packed.size(); ++i) {
    const auto differs = [&](const std::vector<double>& with) { return std::memcmp(&with[i], &s.packed[i], sizeof(double)) != 0; };
    if (differs(with_mode)) { EXPECT_TRUE(changed(i, 5) && changed(i, 0.5)) << "a mode that there is not"; }
    if (differs(with_link)) { EXPECT_TRUE(changed(i, -1) && changed(i, 1e3)) << "a pointer on no link"; }
  }
}

/// Same numbers of other meanings: the format says so, and says it alone.
TEST(SavedState, AnotherFormatIsRefused) {
  Saved s;
  std::vector<double> other = s.packed;
  ASSERT_EQ(other[0], State::kFormat);
  other[0] = State::kFormat - 1;
  EXPECT_TRUE(s.refused(other));
  other.erase(other.begin());
  EXPECT_TRUE(s.refused(other)) << "of before there was a format";
}

/// Whatever one number is, the state is refused or the world steps on, finite or stopped.
TEST(SavedState, AnyNumberMayBeDamaged) {
  Saved s;
  for (const double number : {-1.0, 1e18, std::numeric_limits<double>::quiet_NaN(), bits(~0ull), 0.5}) {
    for (std::size_t i = State::kHead; i < s.packed.size(); ++i) {
      std::vector<double> state = s.packed;
      state[i] = number;
      if (s.refused(state)) continue;
      for (int k = 0; k < 3; ++k) s.world.step();
      const bool stopped = !s.world.report().finite;
      for (int l = 0; l < s.world.linkCount() && !stopped; ++l) ASSERT_TRUE(s.world.linkPose(l).p.allFinite()) << i << " " << number;
      ASSERT_FALSE(s.refused(s.packed));
    }
  }
}

}  // namespace saved_state_test
}  // namespace haptic
