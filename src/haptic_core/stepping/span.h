/// How far bodies may go before their contacts have to be looked at again: nothing fast passes through anything thin.
///
/// Contact volumes know the way out of a body only while less than half of it is inside. So an island in which a pair would get more
/// than a share of the thinner shape's width deeper within a step is advanced in spans: one ends a little before the first touch, the
/// next ones by such shares, until the contact has taken the speed. Each island has its own: no other is cut for it. The link of a hand
/// stops short of what never moves, and goes on in the next step. Slow pairs cost a comparison of their speed.
#pragma once
#include "haptic_core/world/islands.h"
#include "haptic_core/world/report.h"

namespace haptic {
class Model;
struct State;
struct Work;
}  // namespace haptic

namespace haptic::stepping {

/// Way into each other between two looks at a contact, in widths of the thinner shape [1]. Less than the half that contact volumes can
/// tell inside from outside by, with the same again for the speed that a collision adds.
constexpr double kShareOfWidth = 0.25;
/// The same of pairs that a solve moves: it looks at contacts in every pass, and limits the way between two passes itself
/// (depth_limit.h). Larger: bullets pass through walls before anything is solved; smaller: a heap of 100 thin plates that collapses
/// takes 400 steps of 2000 in spans, and its worst step twice as long.
constexpr double kShareOfWidthSolved = 1;
/// Gap at which a sweep ends, in widths of the thinner shape [1].
constexpr double kClearance = 0.02;
/// Spans of an island in one step; then the rest is done at once, flagged kTooFast.
constexpr int kMostSpans = 200;

/// (in realtime) How much of the `left` seconds of a step of length h [s] the island may go before it is looked at again. Its trees are
/// placed where they are now, held links where they are at the step's end.
double safeSpan(const Model& model, const Island& island, double left, double h, const State& state, Work& work) noexcept;

/// (in realtime) Before held links move: the goals of hands' links end where these would get too deep into something that never moves,
/// or that another hand or a motion leads.
void stopShort(const Model& model, const State& state, Work& work) noexcept;

}  // namespace haptic::stepping
