#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "../../penalty_sim/state_files.h"
#include "haptic_core/base/error.h"

namespace haptic::saved_state_test {
namespace {

std::string bytesOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes; }

/// What is said of a file; empty: it was accepted.
std::string refusalOf(const std::string& path) {
  try {
    readState(path);
    return {};
  } catch (const SetupError& error) {
    return error.what();
  }
}

struct SavedState : ::testing::Test {
  const std::string path = ::testing::TempDir() + "haptic_saved_state_test.state";
  std::vector<double> state{0.1, -1e300, 0.0, 3.0};
  void SetUp() override { writeState(path, state); }
  void TearDown() override { std::remove(path.c_str()); }
};

TEST_F(SavedState, ComesBackBitForBit) { EXPECT_EQ(readState(path), state); }

TEST_F(SavedState, WithAnyBitFlippedIsRefusedInOneLine) {
  const std::string bytes = bytesOf(path);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    write(path, damaged);
    const std::string said = refusalOf(path);
    EXPECT_NE(said.find(path), std::string::npos) << "bit " << bit << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST_F(SavedState, CutOrLongerIsRefused) {
  const std::string bytes = bytesOf(path);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    write(path, bytes.substr(0, size));
    EXPECT_NE(refusalOf(path), "") << size;
  }
  write(path, bytes + '\0');
  EXPECT_NE(refusalOf(path), "");
  EXPECT_NE(refusalOf("/dev/zero"), "");
}

}  // namespace
}  // namespace haptic::saved_state_test
