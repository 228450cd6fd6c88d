#include "haptic_core/world/led_motion.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/quaternion_step.h"
#include "haptic_core/world/model.h"

namespace haptic {
namespace {

/// Largest turn between two points [rad]. At half a circle the way round is anybody's guess.
constexpr double kMostTurnBetween = 3;
/// Poses that close a path may differ by rounding of their text [m], [rad].
constexpr double kCloses = 1e-6;

/// Coefficients of the left Jacobian at a rotation vector of this square length: J = 1 + a [θ]× + b [θ]×², J⁻¹ = 1 - ½ [θ]× + c [θ]×².
struct Jacobian {
  explicit Jacobian(double x2) {
    const HalfTurn half(0.25 * x2);
    a = 0.5 * half.sine_over_x * half.sine_over_x;
    if (x2 < 0.01) {  // the differences below lose what their series keep; the next terms are below 1e-15
      b = 1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040 - x2 * (1.0 / 362880)));
      c = 1.0 / 12 + x2 * (1.0 / 720 + x2 * (1.0 / 30240 + x2 * (1.0 / 1209600)));
    } else {
      b = (1 - half.sine_over_x * half.cosine) / x2;
      c = (1 - half.cosine / half.sine_over_x) / x2;
    }
  }
  double a, b, c;
};

Vector3 rateOf(const Vector3& theta, const Vector3& theta_dot) noexcept {
  const Jacobian J(theta.squaredNorm());
  const Vector3 across = theta.cross(theta_dot);
  return theta_dot + J.a * across + J.b * theta.cross(across);
}

Vector3 inverseRateOf(const Vector3& theta, const Vector3& omega) noexcept {
  const Jacobian J(theta.squaredNorm());
  const Vector3 across = theta.cross(omega);
  return omega - 0.5 * across + J.c * theta.cross(across);
}

Vector3 turnBetween(const Quaternion& from, const Quaternion& to) noexcept { return vectorFromRotation(to * from.conjugate()); }

/// A value that begins at 0, with the slopes m0 and m1 at its ends, and its slope.
struct Cubic {
  Vector3 value, slope;
  Cubic(const Vector3& end, const Vector3& m0, const Vector3& m1, double T, double t) {
    const double s = t / T;
    value = (T * s * (1 - s)) * ((1 - s) * m0 - s * m1) + (s * s * (3 - 2 * s)) * end;
    slope = ((1 - s) * (1 - 3 * s)) * m0 + (s * (3 * s - 2)) * m1 + (6 * s * (1 - s) / T) * end;
  }
};

/// Speeds at the rows from the ways to both neighbours.
void setSpeeds(ModelMotion& motion) {
  const int n = static_cast<int>(motion.points.size());
  for (int i = 0; i < n; ++i) {
    const bool first = i == 0, last = i == n - 1;
    if ((first || last) && !motion.repeat) continue;
    const int before = first ? n - 2 : i - 1, after = last ? 1 : i + 1;
    const double h0 = first ? motion.time[n - 1] - motion.time[n - 2] : motion.time[i] - motion.time[i - 1];
    const double h1 = last ? motion.time[1] - motion.time[0] : motion.time[i + 1] - motion.time[i];
    MotionPoint& here = motion.points[i];
    const auto slope = [&](const Vector3& way0, const Vector3& way1) {
      return Vector3((h1 / h0 * way0 + h0 / h1 * way1) / (h0 + h1));
    };
    here.V_WL.linear = slope(here.p_WL - motion.points[before].p_WL, motion.points[after].p_WL - here.p_WL);
    here.V_WL.angular = slope(turnBetween(motion.points[before].q_WL, here.q_WL), turnBetween(here.q_WL, motion.points[after].q_WL));
  }
}

}  // namespace

PathFault faultOf(const MotionDef& def) {
  const auto rows = static_cast<int>(def.pose.size());
  if (def.time.size() != def.pose.size()) return {0, "times and poses are not equally many", "give one row per time"};
  for (int i = 0; i < rows; ++i) {
    if (!std::isfinite(def.time[i]) || !def.pose[i].p.allFinite() || !def.pose[i].R.allFinite()) {
      return {i, "has a number that is not finite", "write seconds, metres and radians"};
    }
    if (i == 0) continue;
    if (!(def.time[i] > def.time[i - 1])) return {i, "does not come after the row before", "give one row per time, in order"};
    if (turnBetween(Quaternion(def.pose[i - 1].R), Quaternion(def.pose[i].R)).norm() <= kMostTurnBetween) continue;
    return {i, "turns by more than 3 rad since the row before", "give rows between: the way round must be clear"};
  }
  if (!def.repeat || rows == 0) return {};
  const Pose &first = def.pose.front(), &last = def.pose.back();
  const bool closes = (first.p - last.p).norm() <= kCloses && turnBetween(Quaternion(first.R), Quaternion(last.R)).norm() <= kCloses;
  if (rows >= 3 && closes) return {};
  return {rows - 1, "shall repeat, but the last row is not the first one, or there are less than three",
          "close the path, or take repeat out"};
}

std::vector<ModelMotion> compileMotions(const WorldDef& def, const Model& model) {
  std::vector<ModelMotion> motions;
  for (const MotionDef& told : def.motions) {
    const int articulations = static_cast<int>(def.articulations.size());
    if (told.articulation < 0 || told.articulation >= articulations || told.link < 0 ||
        told.link >= static_cast<int>(def.articulations[told.articulation].links.size())) {
      throw SetupError(def.name, "motion " + told.name + " names a link that does not exist", "name one of the scene's links");
    }
    ModelMotion motion;
    motion.name = told.name;
    motion.link = model.link(told.articulation, told.link);
    motion.repeat = told.repeat;
    const ModelLink& link = model.links[motion.link];
    if (!model.isFree(model.trees[link.articulation])) {
      throw SetupError(told.name, "moves link " + link.name + ", which hangs on joints or is fixed",
                       "give a motion to a body of one link on a floating joint, or drive the joint");
    }
    const auto same = [&](const ModelMotion& other) { return other.link == motion.link; };
    if (std::any_of(motions.begin(), motions.end(), same)) {
      throw SetupError(told.name, "moves link " + link.name + ", which has a motion already", "give one motion to a link");
    }
    const PathFault fault = faultOf(told);
    if (fault.row >= 0) throw SetupError(told.name + ", row " + std::to_string(fault.row + 1), fault.what, fault.remedy);
    motion.time = told.time;
    for (const Pose& X_WL : told.pose) motion.points.push_back({X_WL.p, Quaternion(X_WL.R), {}});
    if (motion.repeat) motion.points.back() = motion.points.front();
    setSpeeds(motion);
    motions.push_back(std::move(motion));
  }
  return motions;
}

MotionPoint between(const MotionPoint& a, const MotionPoint& b, double T, double t) noexcept {
  const Cubic way(b.p_WL - a.p_WL, a.V_WL.linear, b.V_WL.linear, T, t);
  const Vector3 all = turnBetween(a.q_WL, b.q_WL);
  const Cubic turn(all, a.V_WL.angular, inverseRateOf(all, b.V_WL.angular), T, t);
  return {a.p_WL + way.value, (quaternionStep(turn.value) * a.q_WL).normalized(), {rateOf(turn.value, turn.slope), way.slope}};
}

namespace {

MotionPoint onPath(const ModelMotion& motion, double t) noexcept {
  const double first = motion.time.front(), last = motion.time.back();
  if (motion.repeat) t -= (last - first) * std::floor((t - first) / (last - first));
  if (t <= first) return motion.points.front();
  if (t >= last) return motion.points.back();
  const auto next = static_cast<std::size_t>(std::upper_bound(motion.time.begin(), motion.time.end(), t) - motion.time.begin());
  return between(motion.points[next - 1], motion.points[next], motion.time[next] - motion.time[next - 1], t - motion.time[next - 1]);
}

/// On the way to the target; then its speed falls to nothing over as long again.
MotionPoint towards(const MotionTarget& target, double t) noexcept {
  const double T = target.seconds, gone = t - target.start;
  if (gone < T) return between({target.p_from, target.q_from, target.V_from}, {target.p_to, target.q_to, target.V_to}, T, gone);
  if (T == 0) return {target.p_to, target.q_to, {}};
  const double after = std::min(gone - T, T), way = after - 0.5 * after * after / T, speed = 1 - after / T;
  return {target.p_to + way * target.V_to.linear, (quaternionStep(way * target.V_to.angular) * target.q_to).normalized(),
          {speed * target.V_to.angular, speed * target.V_to.linear}};
}

}  // namespace

MotionPoint motionAt(const ModelMotion& motion, const MotionTarget& target, double t) noexcept {
  return motion.time.empty() ? towards(target, t) : onPath(motion, t);
}

Approach approachTo(const MotionPoint& from, const MotionPoint& to, double seconds) noexcept {
  // Left beyond the mean of both speeds, and from where the other is now.
  const Vector3 way = to.p_WL - from.p_WL, turn = turnBetween(from.q_WL, to.q_WL);
  const Vector3 beyond = way - 0.5 * seconds * (from.V_WL.linear + to.V_WL.linear), gap = way - seconds * to.V_WL.linear;
  const Vector3 beyond_turn = turn - 0.5 * seconds * (from.V_WL.angular + to.V_WL.angular), gap_turn = turn - seconds * to.V_WL.angular;
  const auto timeOf = [](const Vector3& p, const Vector3& theta) {
    return 1.5 * std::max(p.norm() / kFollowSpeed, theta.norm() / kFollowTurn);
  };
  if (!(timeOf(beyond, beyond_turn) > seconds)) return {to, seconds};
  const double takes = std::max(seconds, timeOf(gap, gap_turn)), later = takes - seconds;
  return {{to.p_WL + later * to.V_WL.linear, (quaternionStep(later * to.V_WL.angular) * to.q_WL).normalized(), to.V_WL}, takes};
}

MotionTarget standingAt(const Pose& X_WL) noexcept {
  MotionTarget target;
  target.p_from = target.p_to = X_WL.p;
  target.q_from = target.q_to = Quaternion(X_WL.R);
  return target;
}

MotionTarget leavingFor(const ModelMotion& motion, const MotionTarget& before, const MotionPoint& to, double now,
                        double seconds) noexcept {
  const MotionPoint from = motionAt(motion, before, now);
  MotionTarget target;
  target.start = now;
  target.seconds = seconds;
  target.p_from = from.p_WL, target.q_from = from.q_WL, target.V_from = from.V_WL;
  target.p_to = to.p_WL, target.q_to = to.q_WL, target.V_to = to.V_WL;
  return target;
}

}  // namespace haptic
