#include "haptic_core/world/state.h"

#include <cstring>
#include <type_traits>

#include "haptic_core/base/error.h"
#include "haptic_core/base/word_hash.h"

namespace haptic {
namespace {

static_assert(std::is_trivially_copyable_v<PointerState> && sizeof(PointerState) % sizeof(double) == 0);

static_assert(std::is_standard_layout_v<FrictionMemory> && sizeof(FrictionMemory) % sizeof(double) == 0);
static_assert(std::is_standard_layout_v<ReleaseMemory> && sizeof(ReleaseMemory) % sizeof(double) == 0);

/// The numbers of a pair, so that neither padding nor alignment enters hash or file.
constexpr int kFrictionNumbers = sizeof(FrictionMemory) / sizeof(double);
constexpr int kReleaseNumbers = sizeof(ReleaseMemory) / sizeof(double);
constexpr int kStabilityNumbers = sizeof(StabilityMemory) / sizeof(double);
constexpr int kPairNumbers = 1 + 6 + 2 + kFrictionNumbers + kReleaseNumbers + kStabilityNumbers + 1;

void toNumbers(const ActivePair& pair, double* out) {
  std::memcpy(out, &pair.key, sizeof pair.key);
  std::memcpy(out + 1, pair.cache.direction.data(), 3 * sizeof(double));
  std::memcpy(out + 4, pair.cache.normal.data(), 3 * sizeof(double));
  out[7] = pair.cache.vertex_a;
  out[8] = pair.cache.vertex_b;
  std::memcpy(out + 9, &pair.friction, sizeof pair.friction);
  std::memcpy(out + 9 + kFrictionNumbers, &pair.release, sizeof pair.release);
  std::memcpy(out + 9 + kFrictionNumbers + kReleaseNumbers, &pair.stability, sizeof pair.stability);
  out[kPairNumbers - 1] = pair.buried;
}

ActivePair fromNumbers(const double* in) {
  ActivePair pair;
  std::memcpy(&pair.key, in, sizeof pair.key);
  std::memcpy(pair.cache.direction.data(), in + 1, 3 * sizeof(double));
  std::memcpy(pair.cache.normal.data(), in + 4, 3 * sizeof(double));
  pair.cache.vertex_a = static_cast<int>(in[7]);
  pair.cache.vertex_b = static_cast<int>(in[8]);
  std::memcpy(static_cast<void*>(&pair.friction), in + 9, sizeof pair.friction);
  std::memcpy(static_cast<void*>(&pair.release), in + 9 + kFrictionNumbers, sizeof pair.release);
  std::memcpy(static_cast<void*>(&pair.stability), in + 9 + kFrictionNumbers + kReleaseNumbers, sizeof pair.stability);
  pair.buried = in[kPairNumbers - 1];
  return pair;
}

constexpr std::size_t kCommandNumbers = 4, kPointerNumbers = sizeof(PointerState) / sizeof(double);
/// Lengths, time, step and the sums of the ledger.
constexpr std::size_t kHead = 10;

void toNumbers(const JointCommand& command, double* out) {
  const double numbers[kCommandNumbers] = {static_cast<double>(command.drive), command.position, command.velocity,
                                           command.effort};
  std::memcpy(out, numbers, sizeof numbers);
}

}  // namespace

std::uint64_t WorldState::hash() const {
  std::uint64_t hash = kHashStart;
  hash = hashWords(hash, &time, sizeof time);
  hash = hashWords(hash, &step, sizeof step);
  hash = hashWords(hash, q.data(), q.size() * sizeof(double));
  hash = hashWords(hash, v.data(), v.size() * sizeof(double));
  hash = hashWords(hash, pull.data(), pull.size() * sizeof(double));
  hash = hashWords(hash, mode.data(), mode.size() * sizeof(double));
  for (const JointCommand& command : commands) {
    double numbers[kCommandNumbers];
    toNumbers(command, numbers);
    hash = hashWords(hash, numbers, sizeof numbers);
  }
  hash = hashWords(hash, pointers.data(), pointers.size() * sizeof(PointerState));
  hash = hashWords(hash, energy, sizeof energy);
  for (int i = 0; i < pair_count; ++i) {
    double numbers[kPairNumbers];
    toNumbers(pairs[i], numbers);
    hash = hashWords(hash, numbers, sizeof numbers);
  }
  return hash;
}

std::size_t WorldState::packedCapacity() const {
  return kHead + mode.size() + q.size() + v.size() + pull.size() + commands.size() * kCommandNumbers +
         pointers.size() * kPointerNumbers + pairs.size() * kPairNumbers;
}

std::vector<double> WorldState::pack() const {
  std::vector<double> out;
  pack(out);
  return out;
}

void WorldState::pack(std::vector<double>& out) const {
  out = {double(q.size()), double(v.size()), double(pointers.size()), double(pair_count), time, double(step)};
  out.insert(out.end(), energy, energy + 4);
  out.insert(out.end(), mode.begin(), mode.end());
  out.insert(out.end(), q.begin(), q.end());
  out.insert(out.end(), v.begin(), v.end());
  out.insert(out.end(), pull.begin(), pull.end());
  for (const JointCommand& command : commands) {
    out.resize(out.size() + kCommandNumbers);
    toNumbers(command, out.data() + out.size() - kCommandNumbers);
  }
  const auto* pointer_numbers = reinterpret_cast<const double*>(pointers.data());
  out.insert(out.end(), pointer_numbers, pointer_numbers + pointers.size() * kPointerNumbers);
  for (int i = 0; i < pair_count; ++i) {
    out.resize(out.size() + kPairNumbers);
    toNumbers(pairs[i], out.data() + out.size() - kPairNumbers);
  }
}

void WorldState::unpack(const std::vector<double>& in) {
  const bool head = in.size() >= kHead && in[0] == double(q.size()) && in[1] == double(v.size()) &&
                    in[2] == double(pointers.size()) && in[3] >= 0 && in[3] <= double(pairs.size());
  const std::size_t count = head ? static_cast<std::size_t>(in[3]) : 0;
  const std::size_t expected =
      kHead + mode.size() + q.size() + 2 * v.size() + commands.size() * kCommandNumbers + pointers.size() * kPointerNumbers +
      count * kPairNumbers;
  if (!head || in.size() != expected) {
    throw SetupError("saved state", "is of another scene or version", "restore it into the scene it was saved from");
  }
  const double* next = in.data() + 4;
  time = *next++;
  step = static_cast<std::uint64_t>(*next++);
  const auto take = [&next](double* target, std::size_t n) {
    std::memcpy(target, next, n * sizeof(double));
    next += n;
  };
  take(energy, 4);
  take(mode.data(), mode.size());
  take(q.data(), q.size());
  take(v.data(), v.size());
  take(pull.data(), pull.size());
  for (JointCommand& command : commands) {
    double numbers[kCommandNumbers];
    take(numbers, kCommandNumbers);
    command = {static_cast<JointDef::Drive>(static_cast<int>(numbers[0])), numbers[1], numbers[2], numbers[3]};
  }
  take(reinterpret_cast<double*>(pointers.data()), pointers.size() * kPointerNumbers);
  pair_count = static_cast<int>(count);
  for (int i = 0; i < pair_count; ++i, next += kPairNumbers) pairs[i] = fromNumbers(next);
}

}  // namespace haptic
