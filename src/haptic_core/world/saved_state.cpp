#include "haptic_core/world/saved_state.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/geometry/pairs/table.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {
namespace {

constexpr double kMostImplicitSteps = 1e9;  // in a row: a month at 1 kHz, and far within an int

bool isIndex(double number, double count) { return number >= 0 && number < count && number == std::floor(number); }

bool pairFits(const Model& model, const ActivePair& pair) {
  const auto shapes = static_cast<int>(model.shapes.size());
  const int a = pair.shapeA(), b = pair.shapeB();
  return a >= 0 && a < b && b < shapes && isIndex(pair.cache.vertex_a, cachedVertices(*model.shapes[static_cast<std::size_t>(a)].shape)) &&
         isIndex(pair.cache.vertex_b, cachedVertices(*model.shapes[static_cast<std::size_t>(b)].shape));
}

/// Reads on over the fields of a state, as State::unpack does, and judges those that are indices.
class Judge {
 public:
  Judge(const Model& model, const double* next)
      : links_(static_cast<double>(model.links.size())),
        modes_(static_cast<int>(TreeMode::kPut) + 1),
        next_(next) {}

  template <class Field>
  void operator()(const Field& field) {
    next_ += countFields(field);
  }
  void operator()(const std::vector<TreeMode>& modes) {
    for (std::size_t i = 0; i < modes.size(); ++i) take(modes_);
  }
  void operator()(const std::vector<int>& counts) {
    for (std::size_t i = 0; i < counts.size(); ++i) take(kMostImplicitSteps);
  }
  void operator()(std::uint64_t) { step_ = read<std::uint64_t>(); }
  void operator()(const std::vector<std::uint64_t>& turns) {
    for (std::size_t i = 0; i < turns.size(); ++i) good_ &= read<std::uint64_t>() <= step_ + 2 * kMostTurnSteps;
  }
  void operator()(const std::vector<PointerState>& pointers) {
    for (PointerState pointer : pointers) {
      readFields(pointer, next_);
      good_ &= pointer.link >= 0 && pointer.link < links_;
    }
  }
  template <class T>
  T read() {
    T record{};
    readFields(record, next_);
    return record;
  }
  void require(bool good) { good_ &= good; }
  bool good() const { return good_; }

 private:
  void take(double count) { good_ &= isIndex(*next_++, count); }
  double links_;
  std::uint64_t step_ = 0;  ///< of the state
  int modes_;  ///< that its trees may have; implicit is the last
  const double* next_;
  bool good_ = true;
};

}  // namespace

void refuseDamaged(const Model& model, const State& state, const std::vector<double>& packed) {
  const State::Layout layout = state.layoutOf(packed);
  Judge judge(model, packed.data() + State::kHead);
  State::eachField(state, judge);
  std::uint64_t last = 0;
  for (int i = 0; i < layout.pairs; ++i) {
    const ActivePair pair = judge.read<ActivePair>();
    judge.require(pairFits(model, pair) && (i == 0 || pair.key > last));
    last = pair.key;
  }
  for (int i = 0; i < layout.wrenches; ++i) {
    const int link = judge.read<AppliedWrench>().link;
    judge.require(link >= 0 && link < static_cast<int>(model.links.size()));
  }
  if (!judge.good()) throw SetupError("saved state", "is damaged: it names links, shapes or turns that are not there", "save it again");
}

}  // namespace haptic
