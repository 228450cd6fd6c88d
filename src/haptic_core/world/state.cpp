#include "haptic_core/world/state.h"

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"

namespace haptic {
namespace {

std::size_t pairNumbers() { return countFields(ActivePair{}); }
std::size_t wrenchNumbers() { return countFields(AppliedWrench{}); }

}  // namespace

std::uint64_t State::hash() const {
  std::uint64_t hash = hashFields(kHashStart, *this);
  pairs.each([&](int i) { hash = hashFields(hash, pairs[i]); });
  for (int i = 0; i < wrench_count; ++i) hash = hashFields(hash, wrenches[i]);
  return hash;
}

std::size_t State::packedCapacity() const {
  return kHead + countFields(*this) + static_cast<std::size_t>(pairs.capacity()) * pairNumbers() + wrenches.size() * wrenchNumbers();
}

std::vector<double> State::pack() const {
  std::vector<double> out;
  pack(out);
  return out;
}

void State::pack(std::vector<double>& out) const {
  out.clear();
  out.push_back(kFormat);
  for (const std::size_t length : {q.size(), v.size(), commands.size(), pointers.size(), std::size_t(pairs.count())}) {
    out.push_back(static_cast<double>(length));
  }
  appendFields(*this, out);
  pairs.each([&](int i) { appendFields(pairs[i], out); });
  for (int i = 0; i < wrench_count; ++i) appendFields(wrenches[i], out);
}

State::Layout State::layoutOf(const std::vector<double>& in) const {
  const bool same = in.size() >= kHead && in[0] == kFormat && in[1] == double(q.size()) && in[2] == double(v.size()) &&
                    in[3] == double(commands.size()) && in[4] == double(pointers.size()) && in[5] >= 0 &&
                    in[5] <= double(pairs.capacity());
  const std::size_t count = same ? static_cast<std::size_t>(in[5]) : 0, all = kHead + countFields(*this) + count * pairNumbers();
  const std::size_t left = in.size() > all ? in.size() - all : 0, acting = left / wrenchNumbers();  // what remains is wrenches
  if (!same || in.size() != all + acting * wrenchNumbers() || acting > wrenches.size()) {
    throw SetupError("saved state", "is of another scene or version", "restore it into the scene it was saved from");
  }
  return {static_cast<int>(count), static_cast<int>(acting)};
}

void State::unpack(const std::vector<double>& in) {
  const Layout layout = layoutOf(in);
  const double* next = in.data() + kHead;
  readFields(*this, next);
  pairs.clear();
  for (int i = 0; i < layout.pairs; ++i) readFields(pairs[pairs.append(0)], next);  // by key, as they were written
  wrench_count = layout.wrenches;
  for (int i = 0; i < wrench_count; ++i) readFields(wrenches[i], next);
}

}  // namespace haptic
