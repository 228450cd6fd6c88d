/// Work of a step, counted and not timed: the same on every machine, so that what depends on it is replayed bit for bit.
///
/// A count follows from the state alone: the search, and islands that are found to stand, are left out of it, for a world that was looked
/// at or restored does them again. A unit is about a nanosecond of one core of the machine that README.md names; analysis/deadline.h
/// measures what one takes here. The weights are fitted to the times of the shipped scenes (`./run bench islands`, deadline.ns_per_unit_*).
#pragma once
#include <limits>

namespace haptic {

/// Weights [units]. Faces do not show: a pair of hulls of 100 takes as long as one of boxes.
namespace units {
constexpr double kStep = 700;             ///< of a step in which something moves, its search included
constexpr double kLink = 200;             ///< of an attempt or an evaluation: a link that is moved, placed and taken back
constexpr double kLook = 2000;            ///< of a look at a pair of flat shapes or balls
constexpr double kCurved = 8000;          ///< more for each other shape: its section is found by points
constexpr double kSeams = 4000;           ///< of a pair in a scene with joined pieces, whose common planes are looked for
constexpr double kSweep = 3000;           ///< of a pair that is swept for its first touch
constexpr double kRow = 600;              ///< of a Newton step: a contact, force or tree, with the search along the step
constexpr double kProduct = 1;            ///< of a factorisation: a multiplication, with its share of assembly and solve
}  // namespace units

/// What a step has done so far, and what it may do.
struct CountedWork {
  double done = 0;  ///< [units]
  double most = std::numeric_limits<double>::infinity();  ///< WorldTuning::budget [units]
  bool gave_way = false;  ///< something was left out for it

  /// (in realtime) A step begins. `budget`: 0: none.
  void begin(double budget) noexcept {
    done = units::kStep;
    most = budget > 0 ? budget : std::numeric_limits<double>::infinity();
    gave_way = false;
  }
  bool bounded() const noexcept { return most < std::numeric_limits<double>::infinity(); }  ///< there is a budget
  double left() const noexcept { return most - done; }  ///< [units]; negative: overdrawn
  /// The budget is used up: what has to be done none the less takes the shortest way.
  bool spent() noexcept {
    gave_way |= done >= most;
    return done >= most;
  }
};

}  // namespace haptic
