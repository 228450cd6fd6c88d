/// Steps in parts where something fast comes near something thin, and bodies that start inside others.
///
/// Contact volumes know the way out of a body only while less than half of it is inside. So a step in which a body would
/// move by more than a quarter of what is thin around it is swept first: it ends a little before the first touch, and
/// from there on goes by quarters of the width until the contact has taken the speed. What is slow, or meets nothing,
/// costs a comparison of its speed.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {
namespace {

constexpr double kShareOfWidth = 0.25;  ///< way between two looks, in widths of the thinner shape
constexpr double kClearance = 0.02;     ///< at which a sweep ends, in widths
constexpr double kMostTurn = 0.3;       ///< of a body in contact, in one part of an implicit step [rad]
constexpr int kMostParts = 200;         ///< of one substep; then the rest is done at once, flagged

/// Static bodies may be sunk into one another by this share of the thinner one's width; beyond, one of them is taken to
/// be where it should not be.
constexpr double kStaticOverlap = 0.1;

bool apart(const ConvexPolyhedron::Box& a, const ConvexPolyhedron::Box& b) {
  return (a.upper.array() < b.lower.array()).any() || (b.upper.array() < a.lower.array()).any();
}

}  // namespace

/// Motion of a shape over the time left of the step; hands move theirs to the target. `falls`: gravity counts, as the
/// mean of the speed that it adds; what rests on something does not fall.
ShapeMotion Pipeline::shapeMotion(int s, double left, bool falls) const noexcept {
  const int l = plan_.shapes[s].link;
  const LinkWork& link = work_[l];
  ShapeMotion motion;
  motion.X_WS = link.X_WL * plan_.shapes[s].X_LS;
  motion.p_W = link.p_WC();
  motion.reach = plan_.links[l].size;
  if (heldBy(l) >= 0) {
    const PointerState& pointer = state_.pointers[heldBy(l)];
    if (pointer.targeted == 0) return motion;
    const double *p = pointer.p_WL, *q = pointer.q_WL;
    const Quaternion turn = Quaternion(q[0], q[1], q[2], q[3]) * Quaternion(link.X_WL.R).conjugate();
    motion.V_W = Twist{vectorFromRotation(turn), Vector3(p[0], p[1], p[2]) - link.X_WL.p};
    motion.V_W = motion.V_W.shifted(motion.p_W - link.X_WL.p);
    motion.V_W.angular /= left;
    motion.V_W.linear /= left;
  } else if (plan_.links[l].moves) {
    motion.V_W = link.twistAt(motion.p_W);
    if (falls) motion.V_W.linear += 0.5 * left * settings_.gravity;
  }
  return motion;
}

/// May some link move by more than a quarter of what is thin around it?
bool Pipeline::anyFast(double left) const noexcept {
  const Vector3 fall = 0.5 * left * settings_.gravity;
  const double left2 = left * left;
  for (const MotionLimit& limit : motion_limits_) {
    const LinkWork& link = work_[limit.link];
    const double speed2 = (link.velocity + fall).squaredNorm() + limit.lever2 * link.omega.squaredNorm();
    if (2 * left2 * speed2 > limit.way2) return true;  // (a + b)² ≤ 2 (a² + b²)
  }
  for (int i = 0; i < pointerCount(); ++i) {
    const PointerState& pointer = state_.pointers[i];
    if (!holds(i) || pointer.targeted == 0) continue;
    const int l = static_cast<int>(pointer.link);
    const double way = kShareOfWidth * least_width_[l];
    if ((Vector3(pointer.p_WL) - work_[l].X_WL.p).squaredNorm() > way * way) return true;
  }
  return false;
}

/// How much of the time left may pass before contacts have to be looked at again.
double Pipeline::safePart(double left) noexcept {
  ++report_.substeps;
  if (!anyFast(left)) return left;
  if (report_.substeps > kMostParts) {
    report_.flags |= kTooFast;
    return left;
  }
  for (std::size_t s = 0; s < plan_.shapes.size(); ++s) {
    const ConvexPolyhedron& shape = *plan_.shapes[s].shape;
    const ShapeMotion motion = shapeMotion(static_cast<int>(s), left, true);
    boxes_[s] = shape.aabb(motion.X_WS);
    if (!plan_.links[plan_.shapes[s].link].moves) continue;
    const Vector3 way = left * motion.V_W.linear;
    const double turn = std::min(2.0, left * motion.V_W.angular.norm()) * motion.reach;
    boxes_[s].lower = (boxes_[s].lower + way.cwiseMin(0.0)).array() - turn;
    boxes_[s].upper = (boxes_[s].upper + way.cwiseMax(0.0)).array() + turn;
  }
  if (!broad_phase_->update(boxes_.data())) report_.flags |= kPairsDropped;
  double part = left;
  for (const BroadPhase::Pair& pair : broad_phase_->pairs()) {
    if (plan_.mayCollide(pair.a, pair.b)) part = std::min(part, safePart(pair.a, pair.b, left));
  }
  for (int i = 0; i < state_.pair_count; ++i) {
    if (state_.pairs[i].friction.touching == 0) continue;
    for (int s : {state_.pairs[i].shapeA(), state_.pairs[i].shapeB()}) {
      const double turn = isImplicit(treeOf(s)) ? work_[plan_.shapes[s].link].omega.norm() * left : 0;
      if (turn > kMostTurn) part = std::min(part, left * kMostTurn / turn);
    }
  }
  return part;
}

double Pipeline::safePart(int a, int b, double left) noexcept {
  const PlanShape &A = plan_.shapes[a], &B = plan_.shapes[b];
  const double width = std::min(A.width, B.width), step = kShareOfWidth * width;
  const ActivePair* end = state_.pairs.data() + state_.pair_count;
  const ActivePair* known = std::lower_bound(
      static_cast<const ActivePair*>(state_.pairs.data()), end, ActivePair::keyOf(a, b),
      [](const ActivePair& pair, std::uint64_t key) { return pair.key < key; });
  const bool touching = known != end && known->key == ActivePair::keyOf(a, b) && known->friction.touching != 0;
  const ShapeMotion ma = shapeMotion(a, left, !touching), mb = shapeMotion(b, left, !touching);
  const double most = (ma.V_W.linear - mb.V_W.linear).norm() + ma.V_W.angular.norm() * ma.reach +
                      mb.V_W.angular.norm() * mb.reach;
  if (most * left <= step) return left;
  Vector3 direction_A = ma.X_WS.R.transpose() * (mb.p_W - ma.p_W);
  double meet = 0;
  if (touching) {
    direction_A = known->cache.normal;
  } else {
    meet = timeOfImpact(*A.shape, ma, *B.shape, mb, left, kClearance * width, direction_A);
    if (meet >= left) return left;
  }
  const Vector3 n = ma.at(meet).R * direction_A;
  const double rate = approachRate(ma, mb, n);
  if (rate * left <= step) return left;
  // Up to the touch in one part, from there on by quarters.
  return meet * rate > step ? meet : std::min(left, meet + step / rate);
}

void Pipeline::refuseStaticOverlaps() {
  const int n = static_cast<int>(plan_.shapes.size());
  for (int a = 0; a < n; ++a) {
    const PlanShape& A = plan_.shapes[a];
    if (plan_.links[A.link].moves) continue;
    const Pose X_WA = work_[A.link].X_WL * A.X_LS;
    const ConvexPolyhedron::Box box = A.shape->aabb(X_WA);
    for (int b = a + 1; b < n; ++b) {
      const PlanShape& B = plan_.shapes[b];
      const Pose X_WB = work_[B.link].X_WL * B.X_LS;
      if (plan_.links[B.link].moves || treeOf(a) == treeOf(b) || apart(box, B.shape->aabb(X_WB))) continue;
      ContactVolume volume;
      PairCache cache;
      contactVolume(*A.shape, *B.shape, relativePose(X_WA, X_WB), cache, workspace_, volume);
      const double allowed = kStaticOverlap * std::min(A.width, B.width);
      if (volume.status != ContactVolume::Status::kOverlap || volume.depth <= allowed) continue;
      throw SetupError(plan_.links[A.link].name,
                       "and " + plan_.links[B.link].name + " are fixed and overlap by " +
                           std::to_string(1e3 * volume.depth) + " mm: nothing could push them apart",
                       "move one of them, or make them one body");
    }
  }
}

/// Pairs that overlap deep before the first step are pushed out slowly.
void Pipeline::findBuried() {
  refuseStaticOverlaps();
  least_width_.assign(plan_.links.size(), std::numeric_limits<double>::infinity());
  if (plan_.possible_pairs == 0) return;
  findPairs(0);
  for (int i = 0; i < state_.pair_count; ++i) {
    ActivePair& pair = state_.pairs[i];
    const int a = pair.shapeA(), b = pair.shapeB();
    ContactVolume volume;
    PairCache cache;
    contactVolume(*plan_.shapes[a].shape, *plan_.shapes[b].shape, relativePose(X_WS_[a], X_WS_[b]), cache, workspace_,
                  volume, settings_.normal_rule);
    const bool overlaps = volume.status == ContactVolume::Status::kOverlap;
    pair.buried = overlaps && volume.depth > plan_.buriedDepth(a, b, volume.A0) ? 1 : 0;
  }
  for (int a = 0; a < static_cast<int>(plan_.shapes.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(plan_.shapes.size()); ++b) {
      if (!plan_.mayCollide(a, b)) continue;
      const double width = std::min(plan_.shapes[a].width, plan_.shapes[b].width);
      for (int s : {a, b}) {
        double& least = least_width_[plan_.shapes[s].link];
        least = std::min(least, width);
      }
    }
  }
  for (int l = 0; l < static_cast<int>(plan_.links.size()); ++l) {
    if (!plan_.links[l].moves || std::isinf(least_width_[l])) continue;
    const double way = kShareOfWidth * least_width_[l], size = plan_.links[l].size;
    // A lever so long that a turn of kMostTurn alone is too much.
    const double lever = std::max(size, way / (std::sqrt(2.0) * kMostTurn));
    motion_limits_.push_back({l, way * way, lever * lever});
  }
}

}  // namespace haptic
