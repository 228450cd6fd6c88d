#include "haptic_core/stepping/span.h"

#include <algorithm>

#include "haptic_core/geometry/pairs/time_of_impact.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Largest turn of a body in contact in one span [rad]: its patch is then still the same one.
constexpr double kMostTurn = 0.3;

/// Of the points of a free body's shapes from its link's origin [m].
double reachOf(const Model& model, int l) noexcept {
  const LinkModel& link = model.trees[model.links[l].articulation].model->link(model.links[l].local);
  return model.links[l].size + (link.p_LO + link.p_OC).norm();
}

/// A link that goes its way [rad, m] in `time` [s] from X_WL, its origin on a straight line.
ShapeMotion ledMotion(const Model& model, int shape, const Pose& X_WL, const Twist& way, double time) noexcept {
  const ModelShape& s = model.shapes[shape];
  return {X_WL * s.X_LS, X_WL.p, {way.angular / time, way.linear / time}, reachOf(model, s.link)};
}

/// Up to the touch at first, from there on by shares of the width. `h`: of the sweep [s].
double untilNextLook(const DepthTimes& at, double h) noexcept {
  return at.deep < h && at.touch > at.deep - at.touch ? at.touch : at.deep;
}

/// The motions of an island's shapes over the time left of a step.
class Sweep {
 public:
  Sweep(const Model& model, double left, double h, Work& work)
      : model_(model), left_(left), h_(h), fall_(model.settings.gravity.norm()), work_(work) {}
  double safe(const ActivePair& pair) const noexcept;

 private:
  double wayOf(int link) const noexcept;
  ShapeMotion motionOf(int shape, bool falls) const noexcept;
  double turnOf(int shape) const noexcept;

  const Model& model_;
  const double left_, h_, fall_;
  Work& work_;
};

/// Of any point of the link's shapes, and of a fall, at most [m].
double Sweep::wayOf(int l) const noexcept {
  const int lead = work_.hands.held_by[l];
  if (lead >= 0) {
    const Twist& way = work_.hands.moved[lead];
    return left_ / h_ * (way.linear.norm() + way.angular.norm() * reachOf(model_, l));
  }
  const LinkWork& link = work_.placement.link[l];
  if (!model_.links[l].moves) return 0;
  return left_ * (link.twistAt(link.p_WC()).linear.norm() + link.omega.norm() * model_.links[l].size + 0.5 * left_ * fall_);
}

/// `falls`: gravity counts, as the mean of the speed that it adds; what rests on something does not fall.
ShapeMotion Sweep::motionOf(int s, bool falls) const noexcept {
  const int l = model_.shapes[s].link, lead = work_.hands.held_by[l];
  const LinkWork& link = work_.placement.link[l];
  if (lead >= 0) {
    const Twist& way = work_.hands.moved[lead];
    const double back = left_ / h_;
    const Pose X_WL(rotationFromVector(-back * way.angular) * Quaternion(link.X_WL.R), link.X_WL.p - back * way.linear);
    return ledMotion(model_, s, X_WL, way, h_);
  }
  ShapeMotion motion;
  motion.X_WS = link.X_WL * model_.shapes[s].X_LS;
  motion.p_W = link.p_WC();
  motion.reach = model_.links[l].size;
  if (!model_.links[l].moves) return motion;
  motion.V_W = link.twistAt(motion.p_W);
  if (falls) motion.V_W.linear += 0.5 * left_ * model_.settings.gravity;
  return motion;
}

/// Angle by which a shape turns in the time left [rad].
double Sweep::turnOf(int s) const noexcept {
  const int l = model_.shapes[s].link;
  return model_.links[l].moves ? left_ * work_.placement.link[l].omega.norm() : 0;
}

double Sweep::safe(const ActivePair& pair) const noexcept {
  const int a = pair.shapeA(), b = pair.shapeB();
  const ModelShape &A = model_.shapes[a], &B = model_.shapes[b];
  const double width = std::min(A.width, B.width);
  const bool touching = pair.friction.touching != 0;
  const auto isLed = [&](const ModelShape& shape) { return work_.hands.held_by[shape.link] >= 0; };
  const double share = isLed(A) || isLed(B) ? kShareOfWidth : kShareOfWidthSolved, step = share * width;
  const double turn = touching ? std::max(turnOf(a), turnOf(b)) : 0;
  const double turned = turn > kMostTurn ? left_ * kMostTurn / turn : left_;
  if (wayOf(A.link) + wayOf(B.link) <= step) return turned;
  const ShapeMotion ma = motionOf(a, !touching), mb = motionOf(b, !touching);
  const double most = (ma.V_W.linear - mb.V_W.linear).norm() + ma.V_W.angular.norm() * ma.reach + mb.V_W.angular.norm() * mb.reach;
  if (most * left_ <= step) return turned;
  work_.counted.done += units::kSweep;
  const DepthTimes at =
      timesOfDepth(*A.shape, ma, *B.shape, mb, left_, kClearance * width, step, touching ? &pair.cache.normal : nullptr);
  return std::min(turned, untilNextLook(at, left_));
}

/// Share of the way of a hand's link that it may go [1]: `motion` over 1 s is that of the shape s, `other` that of the shape o.
double safeShare(const Model& model, int s, const ShapeMotion& motion, int o, const ShapeMotion& other, const State& state) noexcept {
  const bool first = s < o;
  const int a = first ? s : o, b = first ? o : s;
  if (!model.mayCollide(a, b)) return 1;
  const ModelShape &A = model.shapes[a], &B = model.shapes[b];
  const double width = std::min(A.width, B.width);
  const int known = state.pairs.find(ActivePair::keyOf(a, b));
  const bool touching = known >= 0 && state.pairs[known].friction.touching != 0;
  const ShapeMotion &ma = first ? motion : other, &mb = first ? other : motion;
  // It enters by no more than the clearance: how deep it presses its rows decide (held_proxy.h), which know a contact once it touches.
  const DepthTimes at = timesOfDepth(*A.shape, ma, *B.shape, mb, 1, kClearance * width, (touching ? kShareOfWidth : kClearance) * width,
                                     touching ? &state.pairs[known].cache.normal : nullptr);
  return untilNextLook(at, 1);
}

/// Of the box of a shape that goes so far.
ConvexShape::Box sweptBox(const ConvexShape& shape, const ShapeMotion& motion) noexcept {
  ConvexShape::Box box = shape.aabb(motion.X_WS);
  const Vector3& way = motion.V_W.linear;
  const double turn = std::min(2.0, motion.V_W.angular.norm()) * motion.reach;
  box.lower = (box.lower + way.cwiseMin(0.0)).array() - turn;
  box.upper = (box.upper + way.cwiseMax(0.0)).array() + turn;
  return box;
}

}  // namespace

double safeSpan(const Model& model, const Island& island, double left, double h, const State& state, Work& work) noexcept {
  const Sweep sweep(model, left, h, work);
  double span = left;
  for (int i = 0; i < island.pair_count; ++i) span = std::min(span, sweep.safe(state.pairs[island.pairs[i]]));
  return span;
}

void stopShort(const Model& model, const State& state, Work& work) noexcept {
  HandWork& hands = work.hands;
  const auto wayOf = [&](int lead) {
    const Pose& X_WL = work.placement.link[ledLink(model, state, lead)].X_WL;
    const HeldGoal& goal = hands.goal[lead];
    return Twist{vectorFromRotation(goal.q_WL * Quaternion(X_WL.R).conjugate()), goal.p_WL - X_WL.p};
  };
  for (const int lead : hands.leading) {
    if (lead >= static_cast<int>(model.pointers.size())) return;  // motions go where they are told
    const int l = ledLink(model, state, lead);
    const Twist way = wayOf(lead);
    const double most = way.linear.norm() + way.angular.norm() * reachOf(model, l);
    if (most <= kShareOfWidth * model.least_width[l]) continue;
    const Pose& X_WL = work.placement.link[l].X_WL;
    const ModelTree& tree = model.trees[model.links[l].articulation];
    double share = 1;
    for (int s = tree.shape; s < tree.shape_end; ++s) {
      const ShapeMotion motion = ledMotion(model, s, X_WL, way, 1);
      model.fixed_boxes.eachOverlap(sweptBox(*model.shapes[s].shape, motion), [&](int fixed) {
        const int o = model.fixed_shapes[fixed];
        const Pose& X_WO = work.placement.link[model.shapes[o].link].X_WL;
        share = std::min(share, safeShare(model, s, motion, o, ledMotion(model, o, X_WO, Twist{}, 1), state));
      });
      for (const int other : hands.leading) {
        if (other == lead) continue;
        const int ol = ledLink(model, state, other);
        const ModelTree& led = model.trees[model.links[ol].articulation];
        for (int o = led.shape; o < led.shape_end; ++o) {
          const ShapeMotion goes = ledMotion(model, o, work.placement.link[ol].X_WL, wayOf(other), 1);
          share = std::min(share, safeShare(model, s, motion, o, goes, state));
        }
      }
    }
    if (share == 1) continue;
    HeldGoal& goal = hands.goal[lead];
    goal.p_WL = X_WL.p + share * way.linear;
    goal.q_WL = (rotationFromVector(share * way.angular) * Quaternion(X_WL.R)).normalized();
    work.counted.done += units::kSweep;
  }
}

}  // namespace haptic::stepping
