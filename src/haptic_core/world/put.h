/// What changes a world between two steps beside its steps: wrenches that begin, bodies and joints that are put elsewhere.
#pragma once
#include <utility>
#include <vector>

#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic {

/// (in realtime) Position and velocity of a free body, its 7 and 6 numbers of q and v (dynamics/articulation.h), of its link frame's pose
/// and twist at that frame's origin, in W. `p_LO`: of its link model.
void putFree(const Vector3& p_LO, const Vector3& p_WL, const Quaternion& q_WL, const Twist& V_WL, double* q, double* v) noexcept;
/// See World::applyWrench.
void applyWrench(const Model& model, int link, const LinkWrench& wrench, double seconds, State& state, Work& work);
/// See World::setBodyPose.
void putBody(const Model& model, int link, const Pose& X_WL, const Twist& V_WL, State& state, Work& work);
/// See World::setJointPositions.
void putJoints(const Model& model, const std::vector<std::pair<int, double>>& positions, State& state, Work& work);

}  // namespace haptic
