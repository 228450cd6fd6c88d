#include "haptic_core/dynamics/joint_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double clamp(double x, double limit) {
  return std::min(std::max(x, -limit), limit);
}

/// The drive before it saturates, offset − slope v₁, and where it does: at +max_effort below, at −max_effort above.
struct DriveRange {
  double offset = 0, slope = 0;
  double saturated_below = -kInfinity, saturated_above = kInfinity;
};

DriveRange driveRange(const JointDef& joint, const JointCommand& command, double q, double h) {
  DriveRange drive;
  const double v_ref = clamp(command.velocity, joint.max_velocity);
  switch (command.drive) {
    case JointDef::Drive::kNone:
      break;
    case JointDef::Drive::kEffort:
      drive.offset = command.effort;
      break;
    case JointDef::Drive::kVelocity:
      drive.offset = joint.drive_damping * v_ref + command.effort;
      drive.slope = joint.drive_damping;
      break;
    case JointDef::Drive::kPosition:
      drive.offset = joint.drive_stiffness * (command.position - q) + joint.drive_damping * v_ref + command.effort;
      drive.slope = joint.drive_damping + h * joint.drive_stiffness;
      break;
  }
  if (drive.slope > 0 && joint.max_effort < kInfinity) {
    drive.saturated_below = (drive.offset - joint.max_effort) / drive.slope;
    drive.saturated_above = (drive.offset + joint.max_effort) / drive.slope;
  }
  return drive;
}

/// A stop, or friction at rest: any force from `low` to `high` at velocity `at`.
ForcePiece verticalPiece(double at, double low, double high) {
  ForcePiece piece;
  piece.vertical = true;
  piece.from = piece.to = at;
  piece.low = low;
  piece.high = high;
  return piece;
}

/// Damping, spring, friction and drive between two kinks of the graph.
ForcePiece pieceBetween(const JointDef& joint, const JointFriction& friction, const DriveRange& drive, double q, double h, double from,
                        double to) {
  const double middle = from == -kInfinity ? (to == kInfinity ? 0 : to - 1) : (to == kInfinity ? from + 1 : 0.5 * (from + to));
  ForcePiece piece;
  piece.from = from;
  piece.to = to;
  piece.slope = joint.damping;
  piece.offset = middle > 0 ? -friction.forward : friction.backward;
  if (joint.spring_stiffness > 0) {
    piece.offset += joint.spring_stiffness * (joint.spring_position - q);
    piece.slope += h * joint.spring_stiffness;
  }
  if (middle < drive.saturated_below) {
    piece.offset += joint.max_effort;
  } else if (middle > drive.saturated_above) {
    piece.offset -= joint.max_effort;
  } else {
    piece.offset += drive.slope > 0 ? drive.offset : clamp(drive.offset, joint.max_effort);
    piece.slope += drive.slope;
  }
  return piece;
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

void buildForceGraph(const JointDef& joint, const JointFriction& friction, const JointCommand& command, double q, double h,
                     ForceGraph& graph) noexcept {
  const auto bound = [&](double limit, bool outside) {
    return (limit - q) / (outside ? std::max(h, kReturnTime) : h);
  };
  double lowest = bound(joint.lower, q < joint.lower), highest = bound(joint.upper, q > joint.upper);
  if (lowest > highest) lowest = highest = 0.5 * (lowest + highest);
  const DriveRange drive = driveRange(joint, command, q, h);
  double kinks[5] = {lowest, drive.saturated_below, drive.saturated_above, friction.sticks ? 0 : lowest, highest};
  std::sort(kinks, kinks + 5);

  graph.count = 0;
  if (lowest > -kInfinity) graph.pieces[graph.count++] = verticalPiece(lowest, -kInfinity, kInfinity);
  if (lowest == highest) return;
  double previous = lowest;
  for (double kink : kinks) {
    kink = std::min(kink, highest);
    if (!(kink > previous)) continue;
    const ForcePiece piece = pieceBetween(joint, friction, drive, q, h, previous, kink);
    if (graph.count > 0) {
      ForcePiece& before = graph.pieces[graph.count - 1];
      if (before.vertical) {
        before.low = piece.offset - piece.slope * previous;
      } else if (previous == 0 && friction.sticks) {
        graph.pieces[graph.count++] = verticalPiece(0, piece.offset, before.offset);
      }
    }
    graph.pieces[graph.count++] = piece;
    previous = kink;
  }
  if (highest < kInfinity) {
    const ForcePiece& before = graph.pieces[graph.count - 1];
    const double end = before.offset - before.slope * highest;
    graph.pieces[graph.count++] = verticalPiece(highest, -kInfinity, end);
  }
}

double driveForce(const JointDef& joint, const JointCommand& command, double q, double h,
                  double v1) noexcept {
  const DriveRange drive = driveRange(joint, command, q, h);
  return clamp(drive.offset - drive.slope * v1, joint.max_effort);
}

SmoothForce smoothForce(const JointDef& joint, const JointCommand& command, double q, double v, double h) noexcept {
  SmoothForce force;
  if (!(joint.lower < q && q < joint.upper) || (joint.friction > 0 && v == 0)) {
    force.side = SmoothForce::kOnAKink;
    return force;
  }
  const DriveRange drive = driveRange(joint, command, q, 0);
  const double free = drive.offset - drive.slope * v;
  force.drive = clamp(free, joint.max_effort);
  const bool saturated = force.drive != free;
  force.all = force.drive - joint.damping * v + joint.spring_stiffness * (joint.spring_position - q);
  force.slope = joint.damping + h * joint.spring_stiffness;
  if (!saturated) {
    force.slope += drive.slope;
    if (command.drive == JointDef::Drive::kPosition) force.slope += h * joint.drive_stiffness;
  }
  if (joint.friction > 0) force.all -= v > 0 ? joint.friction : -joint.friction;
  force.side = (saturated ? (free > 0 ? 2 : 1) : 0) + (joint.friction > 0 && v > 0 ? 3 : 0);
  return force;
}

bool isFinite(const JointCommand& command) noexcept {
  return std::isfinite(command.position) && std::isfinite(command.velocity) && std::isfinite(command.effort);
}

JointDef ownLaw(const JointDef& joint) {
  JointDef law = joint;
  if (joint.mimic_joint < 0) return law;
  law.lower = -kInfinity;
  law.upper = kInfinity;
  law.friction = law.drive_stiffness = law.drive_damping = 0;
  law.drive = JointDef::Drive::kNone;
  return law;
}

bool isDriven(const JointDef& joint) {
  return joint.drive != JointDef::Drive::kNone || joint.drive_stiffness > 0 || joint.drive_damping > 0;
}

bool hasLaw(const JointDef& joint) {
  return joint.damping > 0 || joint.friction > 0 || joint.spring_stiffness > 0 || joint.lower > -kInfinity || joint.upper < kInfinity ||
         isDriven(joint);
}

}  // namespace haptic
