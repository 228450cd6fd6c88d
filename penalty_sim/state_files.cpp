#include "penalty_sim/state_files.h"

#include <fstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/packed_file.h"
#include "haptic_core/base/whole_file.h"

namespace haptic {
namespace {

const std::string kStateFormat = "haptic saved state 2\n";
constexpr std::size_t kLongestState = 128u << 20;  // [byte] no world of this simulation comes near

struct SavedState {
  std::vector<double> numbers;  ///< of World::save

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.numbers);
  }
};

}  // namespace

void writeState(const std::string& file, const std::vector<double>& state) {
  writeWholeFile(file, packFile(kStateFormat, SavedState{state}));
}

std::vector<double> readState(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw SetupError(file, "cannot be opened", "give the path of a state that ~save has written");
  std::string bytes;
  for (char piece[65536]; bytes.size() <= kLongestState && (in.read(piece, sizeof piece), in.gcount() > 0);) {
    bytes.append(piece, static_cast<std::size_t>(in.gcount()));
  }
  if (bytes.size() > kLongestState) {
    throw SetupError(file, "is too long for a saved state", "give the path of a state that ~save has written");
  }
  return unpackFile<SavedState>(kStateFormat, bytes, file).numbers;
}

}  // namespace haptic
