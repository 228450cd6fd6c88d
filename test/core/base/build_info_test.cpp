// Which recordings replay bit for bit: those of any library and compiler of this version and arithmetic, no others.
#include "haptic_core/base/build_info.h"

#include <gtest/gtest.h>

namespace haptic {
namespace {

TEST(BuildInfo, BothLibrariesGiveTheSameBitsAndEarlierReleasesOthers) {
  const std::string here = buildFlags();
  EXPECT_NE(here.find(", library " + libraryLevel() + ","), std::string::npos) << here;
  EXPECT_TRUE(sameBits(programVersion(), here));
  std::string other = here;
  const std::size_t level = other.find(libraryLevel());
  other.replace(level, libraryLevel().size(), libraryLevel() == "baseline" ? "x86-64-v3" : "baseline");
  EXPECT_TRUE(sameBits(programVersion(), other)) << other;
  EXPECT_FALSE(sameBits(programVersion(), "c++ 12.2.0, x86-64, release"));
  EXPECT_FALSE(sameBits(programVersion(), "c++ 12.2.0, avx2, fma, release"));
  EXPECT_FALSE(sameBits("haptic_core 0.0.1", here));
  EXPECT_FALSE(sameBits(programVersion(), here + "1"));
  EXPECT_FALSE(sameBits(programVersion(), ""));
}

}  // namespace
}  // namespace haptic
