/// A step in substeps, and those in parts where something fast comes near something thin.
///
/// Contact volumes know the way out of a body only while less than half of it is inside. So a step in which a body would
/// move by more than a quarter of the least width around it is swept first: where it would end more than a quarter of the
/// width deeper inside another one, it ends a little before the first touch, and from there on goes by such quarters until
/// the contact has taken the speed. Slow bodies, and those that meet none, cost a comparison of their speed; a body that
/// rolls or tips on another one, two supports of each.
///
/// Each is preceded by the bounds of the hands and the ways that their held links may go (hand_bound.h, held_proxy.h): the sweep is
/// along that way.
#pragma once
namespace haptic {

class Model;
struct State;
struct Work;
struct StepReport;

/// Way into each other between two looks at a contact, in widths of the thinner shape [1]. Less than the half that contact volumes can
/// tell inside from outside by, with the same again for the speed that a collision adds.
constexpr double kShareOfWidth = 0.25;
/// The same in a part of a step, of pairs in implicit islands: their solve looks at contacts in every pass, and limits the way
/// between two passes itself (stepping/implicit_stage.h). Larger: bullets pass through walls before anything is solved; smaller: a heap
/// of 100 thin plates that collapses takes 400 steps of 2000 in parts, and its worst step twice as long.
constexpr double kShareOfWidthSolved = 1;
/// Gap at which a sweep ends, in widths of the thinner shape [1].
constexpr double kClearance = 0.02;
/// Largest turn of a body in contact in one part of an implicit step [rad]: its patch is then still the same one.
constexpr double kMostTurn = 0.3;

/// A part of a substep, shortened where something is fast.
struct StepPart {
  double h = 0;         ///< [s]; 0: the step is over
  double share = 1;     ///< of a substep
  double progress = 1;  ///< share of the hands' way to their targets that is left at its start
  int substep = 0;      ///< index, from 0
  double left = 0;      ///< of the substep after this part [s]
};

/// (in realtime) The parts one after another: each is measured where the last one has ended. The links' placement and the
/// pairs of the last search are those of its start; the boxes of `work` are scratch.
StepPart firstPart(const Model& model, const State& state, Work& work, StepReport& report) noexcept;
/// (in realtime) See firstPart; `last` is the part that has been done.
StepPart nextPart(const Model& model, const StepPart& last, const State& state, Work& work, StepReport& report) noexcept;
}  // namespace haptic
