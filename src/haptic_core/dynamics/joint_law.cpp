#include "haptic_core/dynamics/joint_law.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

// Time in which a joint outside its limits is led back [s]. Shorter: it arrives faster and swings on; longer:
// it stays outside longer.
constexpr double kReturnTime = 0.02;
// Slack of a stuck joint's force, relative: keeps rounding from moving it back and forth [1].
constexpr double kForceSlack = 1e-12;
// How far a velocity may lie outside its piece [rad/s] or [m/s]: a drive that asks for the limit itself leaves nothing but
// rounding to tell resting on it from leaving it. A step of 10 ms passes a limit by 1e-15 with it.
constexpr double kVelocitySlack = 1e-13;

double clamp(double x, double limit) {
  return std::min(std::max(x, -limit), limit);
}

/// The drive before it saturates: offset − slope v₁.
void driveLine(const JointDef& joint, const JointCommand& command, double q, double h, double& offset,
               double& slope) {
  const double v_ref = clamp(command.velocity, joint.max_velocity);
  switch (command.drive) {
    case JointDef::Drive::kNone:
      offset = slope = 0;
      break;
    case JointDef::Drive::kEffort:
      offset = command.effort;
      slope = 0;
      break;
    case JointDef::Drive::kVelocity:
      offset = joint.drive_damping * v_ref + command.effort;
      slope = joint.drive_damping;
      break;
    case JointDef::Drive::kPosition:
      offset = joint.drive_stiffness * (command.position - q) + joint.drive_damping * v_ref + command.effort;
      slope = joint.drive_damping + h * joint.drive_stiffness;
      break;
  }
}

}  // namespace

int ForceGraph::at(double v) const {
  for (int i = 0; i < count; ++i)
    if (pieces[i].vertical && pieces[i].from == v) return i;
  for (int i = 0; i < count; ++i)
    if (!pieces[i].vertical && pieces[i].from <= v && v <= pieces[i].to) return i;
  return v < pieces[0].from ? 0 : count - 1;
}

bool ForceGraph::follow(double v1, double force, int& piece) const noexcept {
  const ForcePiece& now = pieces[piece];
  int direction = 0;
  if (now.vertical) {
    const double slack = kForceSlack * std::abs(force);
    direction = force > now.high + slack ? -1 : force < now.low - slack ? 1 : 0;
  } else {
    direction = v1 > now.to + kVelocitySlack ? 1 : v1 < now.from - kVelocitySlack ? -1 : 0;
  }
  const int next = piece + direction;
  if (direction == 0 || next < 0 || next >= count) return false;
  piece = next;
  return true;
}

void buildForceGraph(const JointDef& joint, const JointCommand& command, double q, double h,
                     ForceGraph& graph) noexcept {
  const auto bound = [&](double limit, bool outside) {
    return (limit - q) / (outside ? std::max(h, kReturnTime) : h);
  };
  double lowest = bound(joint.lower, q < joint.lower), highest = bound(joint.upper, q > joint.upper);
  if (lowest > highest) lowest = highest = 0.5 * (lowest + highest);

  double offset = 0, slope = 0;
  driveLine(joint, command, q, h, offset, slope);
  const double kInfinity = std::numeric_limits<double>::infinity();
  double saturated_below = -kInfinity, saturated_above = kInfinity;  // drive at +max below, at −max above
  if (slope > 0 && joint.max_effort < kInfinity) {
    saturated_below = (offset - joint.max_effort) / slope;
    saturated_above = (offset + joint.max_effort) / slope;
  }
  double kinks[5] = {lowest, saturated_below, saturated_above, joint.friction > 0 ? 0 : lowest, highest};
  std::sort(kinks, kinks + 5);

  graph.count = 0;
  if (lowest > -kInfinity) {
    ForcePiece stop;
    stop.vertical = true;
    stop.from = stop.to = lowest;
    stop.low = -kInfinity;
    stop.high = kInfinity;
    graph.pieces[graph.count++] = stop;
  }
  if (lowest == highest) return;
  double previous = lowest;
  for (double kink : kinks) {
    kink = std::min(kink, highest);
    if (!(kink > previous)) continue;
    const double middle = previous == -kInfinity
                              ? (kink == kInfinity ? 0 : kink - 1)
                              : (kink == kInfinity ? previous + 1 : 0.5 * (previous + kink));
    ForcePiece piece;
    piece.from = previous;
    piece.to = kink;
    piece.slope = joint.damping;
    piece.offset = joint.friction > 0 ? (middle > 0 ? -joint.friction : joint.friction) : 0;
    if (middle < saturated_below) {
      piece.offset += joint.max_effort;
    } else if (middle > saturated_above) {
      piece.offset -= joint.max_effort;
    } else {
      piece.offset += slope > 0 ? offset : clamp(offset, joint.max_effort);
      piece.slope += slope;
    }
    if (graph.count > 0) {
      ForcePiece& before = graph.pieces[graph.count - 1];
      const double start = piece.offset - piece.slope * previous;
      if (before.vertical) {
        before.low = start;
      } else if (previous == 0 && joint.friction > 0) {
        ForcePiece stick;
        stick.vertical = true;
        stick.from = stick.to = 0;
        stick.high = before.offset;
        stick.low = piece.offset;
        graph.pieces[graph.count++] = stick;
      }
    }
    graph.pieces[graph.count++] = piece;
    previous = kink;
  }
  if (highest < kInfinity) {
    const ForcePiece& before = graph.pieces[graph.count - 1];
    ForcePiece stop;
    stop.vertical = true;
    stop.from = stop.to = highest;
    stop.high = before.offset - before.slope * highest;
    stop.low = -kInfinity;
    graph.pieces[graph.count++] = stop;
  }
}

double driveForce(const JointDef& joint, const JointCommand& command, double q, double h,
                  double v1) noexcept {
  double offset = 0, slope = 0;
  driveLine(joint, command, q, h, offset, slope);
  return clamp(offset - slope * v1, joint.max_effort);
}

bool isFinite(const JointCommand& command) noexcept {
  return std::isfinite(command.position) && std::isfinite(command.velocity) && std::isfinite(command.effort);
}

JointDef ownLaw(const JointDef& joint) {
  JointDef law = joint;
  if (joint.mimic_joint < 0) return law;
  law.lower = -std::numeric_limits<double>::infinity();
  law.upper = std::numeric_limits<double>::infinity();
  law.friction = law.drive_stiffness = law.drive_damping = 0;
  law.drive = JointDef::Drive::kNone;
  return law;
}

bool isDriven(const JointDef& joint) {
  return joint.drive != JointDef::Drive::kNone || joint.drive_stiffness > 0 || joint.drive_damping > 0;
}

bool hasLaw(const JointDef& joint) {
  const double kInfinity = std::numeric_limits<double>::infinity();
  return joint.damping > 0 || joint.friction > 0 || joint.lower > -kInfinity || joint.upper < kInfinity ||
         isDriven(joint);
}

}  // namespace haptic
