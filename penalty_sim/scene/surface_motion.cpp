#include "scene/surface_motion.h"

#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

/// Speed of a surface at the start that is too fast to touch [m/s]. A rim that hits the sphere this fast sinks 1 mm a tick into
/// what a relaxed hand bears, 4.6 N/mm: twice as much force as a device raises in that time.
constexpr double kTooFastToTouch = 1;
constexpr double kTouch = 1e-3;     ///< [m] between boxes of what may carry one another: what a scene has rest starts nearer
constexpr int kSteps = 100;         ///< of 1 ms, alone: what falls is then 49 mm lower, a held robot has sagged
constexpr double kLeaves = 0.005;   ///< [m] in that time: the sphere's clearance

Vector3 velocityAt(const ArticulationDef& articulation, int link, const Vector3& p_W) {
  const std::vector<Pose> X_WL = initialPoses(articulation);
  Vector3 v = Vector3::Zero();
  for (int l = link; l >= 0; l = articulation.links[l].parent) {
    const JointDef& joint = articulation.links[l].joint;
    const Vector3 axis = X_WL[l].R * joint.axis.normalized();  // the joint's own motion leaves it where it is
    if (joint.type == JointType::kRevolute) v += joint.velocity * axis.cross(p_W - X_WL[l].p);
    if (joint.type == JointType::kPrismatic) v += joint.velocity * axis;
    if (joint.type == JointType::kFloating) {
      v += articulation.V_WA.linear + articulation.V_WA.angular.cross(p_W - articulation.X_WA.p);
    }
  }
  return v;
}

std::vector<ConvexShape::Box> boxesOf(const ArticulationDef& articulation) {
  const std::vector<Pose> X_WL = initialPoses(articulation);
  std::vector<ConvexShape::Box> boxes;
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    for (const CollisionDef& c : articulation.links[i].collisions) boxes.push_back(c.shape->aabb(X_WL[i] * c.X_LS));
  }
  return boxes;
}

bool touchesAnother(const WorldDef& world, int articulation) {
  const std::vector<ConvexShape::Box> own = boxesOf(world.articulations[articulation]);
  for (int other = 0; other < static_cast<int>(world.articulations.size()); ++other) {
    if (other == articulation) continue;
    for (const ConvexShape::Box& b : boxesOf(world.articulations[other])) {
      for (const ConvexShape::Box& a : own) {
        const bool apart = ((a.lower - b.upper).array() > kTouch).any() || ((b.lower - a.upper).array() > kTouch).any();
        if (!apart) return true;
      }
    }
  }
  return false;
}

bool isClosed(const WorldDef& world, int articulation) {
  for (const LoopDef& loop : world.loops) {
    if (loop.articulation_a == articulation || loop.articulation_b == articulation) return true;
  }
  return false;
}

/// How far the point goes while its articulation is left to itself [m].
double wayAlone(const WorldDef& world, int articulation, int link, const Vector3& p_W) {
  WorldDef alone;
  alone.name = world.name;
  alone.settings = world.settings;
  alone.settings.step = 1e-3;
  alone.settings.history_steps = 0;
  alone.articulations = {world.articulations[articulation]};
  for (LinkDef& each : alone.articulations[0].links) each.collisions.clear();
  World trial(alone);
  const Vector3 p_L = trial.linkPose(link).inverse() * p_W;
  for (int i = 0; i < kSteps; ++i) trial.step();
  return (trial.linkPose(link) * p_L - p_W).norm();
}

}  // namespace

bool staysPut(const WorldDef& world, int articulation, int link, const Vector3& p_W) {
  if (velocityAt(world.articulations[articulation], link, p_W).norm() > kTooFastToTouch) return false;
  if (isClosed(world, articulation) || touchesAnother(world, articulation)) return true;
  try {
    return wayAlone(world, articulation, link, p_W) < kLeaves;
  } catch (const SetupError&) {
    return true;  // who makes the world is told what is wrong with it
  }
}

}  // namespace haptic
