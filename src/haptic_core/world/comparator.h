/// Another way to step a world, which the default is held against. None is part of the library: tests, benches and the report have them
/// (test/comparators). It lies beside the definition: no file of a scene and no binding names one.
#pragma once

namespace haptic {

class Model;
struct State;
struct Work;
struct StepReport;

/// Steps whole worlds in place of the rules of stepping/advance.h; one for each world.
class Comparator {
 public:
  virtual ~Comparator() = default;
  /// (in realtime) Over a step of length h [s]: hands, placement, pairs, contacts, motion, and `Work::reported`.
  virtual void advance(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept = 0;
};

}  // namespace haptic
