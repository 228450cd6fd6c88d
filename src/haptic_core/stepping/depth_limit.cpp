#include "haptic_core/stepping/depth_limit.h"

#include <algorithm>

#include "haptic_core/stepping/span.h"

namespace haptic {

DepthLimit::DepthLimit(const Model& model, const FrozenProblem& problem, const StageContacts& contacts)
    : model_(model), problem_(problem), contacts_(contacts), X_last_(model.shapes.size()) {}

double DepthLimit::mostDepth(const ActivePair& pair) const noexcept {
  return stepping::kShareOfWidth * std::min(model_.shapes[pair.shapeA()].width, model_.shapes[pair.shapeB()].width);
}

/// Bound of the way that the pair's shapes go towards one another [m].
double DepthLimit::way(const ActivePair& pair, const double* velocity, double g) const noexcept {
  double sum = 0;
  for (const int shape : {pair.shapeA(), pair.shapeB()}) {
    const int link = model_.shapes[shape].link;
    if (problem_.nodeOf(link) >= 0) sum += g * problem_.speedOf(model_.links[link].articulation, velocity);
  }
  return sum;
}

bool DepthLimit::mayBePassed(const Island& island, const State& state, const double* velocity, double g) const noexcept {
  const double most = 2 * g * problem_.speed(velocity);
  return std::any_of(island.pairs, island.pairs + island.pair_count, [&](int i) {
    const ActivePair& pair = state.pairs[i];
    const double depth = mostDepth(pair);
    return most > depth && way(pair, velocity, g) > depth;
  });
}

void DepthLimit::note(const Pose* X_WS, int first, int end) noexcept { std::copy(X_WS + first, X_WS + end, X_last_.begin() + first); }

/// In a time of 1. What hands hold is where it is.
ShapeMotion DepthLimit::motion(int s, const Pose& X_WS) const noexcept {
  const ModelShape& shape = model_.shapes[s];
  ShapeMotion motion;
  motion.X_WS = X_WS;
  motion.p_W = X_WS.p;
  if (problem_.nodeOf(shape.link) < 0) return motion;
  motion.X_WS = X_last_[s];
  motion.p_W = X_last_[s] * shape.shape->centre();
  motion.reach = shape.shape->boundingRadius();
  motion.V_W.angular = vectorFromRotation(Quaternion(X_WS.R) * Quaternion(X_last_[s].R).conjugate());
  motion.V_W.linear = X_WS * shape.shape->centre() - motion.p_W;
  return motion;
}

double DepthLimit::share(const Island& island, const State& state, const Pose* X_WS, const double* velocity, double g,
                         bool first) const noexcept {
  double share = 1;
  for (int i = 0; i < island.pair_count; ++i) {
    const ActivePair& pair = state.pairs[island.pairs[i]];
    const ModelShape &A = model_.shapes[pair.shapeA()], &B = model_.shapes[pair.shapeB()];
    const double depth = mostDepth(pair);
    if (way(pair, velocity, g) <= depth) continue;
    const ShapeMotion a = motion(pair.shapeA(), X_WS[pair.shapeA()]), b = motion(pair.shapeB(), X_WS[pair.shapeB()]);
    if ((a.V_W.linear - b.V_W.linear).norm() + a.V_W.angular.norm() * a.reach + b.V_W.angular.norm() * b.reach <= depth) continue;
    const bool touches = first ? pair.friction.touching != 0 : contacts_.touches(island.pairs[i]);
    const double clearance = stepping::kClearance * std::min(A.width, B.width);
    share = std::min(share, timesOfDepth(*A.shape, a, *B.shape, b, 1, clearance, depth, touches ? &pair.cache.normal : nullptr).deep);
  }
  return share;
}

}  // namespace haptic
