#include "penalty_sim/state_files.h"

#include <cstring>
#include <fstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/whole_file.h"

namespace haptic {
namespace {

constexpr char kMagic[8] = {'H', 'A', 'P', 'S', 'T', 'A', 'T', '1'};
constexpr std::uint64_t kMaxNumbers = 1u << 24;  // 128 MB: no world of this simulation comes near

struct Header {
  char magic[8];
  std::uint64_t hash, numbers;
};

}  // namespace

void writeState(const std::string& file, const std::vector<double>& state, std::uint64_t hash) {
  Header header{{}, hash, state.size()};
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof(header));
  bytes.append(reinterpret_cast<const char*>(state.data()), state.size() * sizeof(double));
  writeWholeFile(file, bytes);
}

std::vector<double> readState(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw SetupError(file, "cannot be opened", "give the path of a state that ~save has written");
  Header header{};
  in.read(reinterpret_cast<char*>(&header), sizeof(header));
  if (!in || std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 || header.numbers > kMaxNumbers) {
    throw SetupError(file, "is no saved state", "give the path of a state that ~save has written");
  }
  std::vector<double> state(header.numbers);
  in.read(reinterpret_cast<char*>(state.data()), static_cast<std::streamsize>(state.size() * sizeof(double)));
  if (!in) throw SetupError(file, "ends early", "save the state again");
  return state;
}

}  // namespace haptic
