#include "penalty_sim/actor_services.h"

#include <haptic_msgs/conversions.h>

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/ports.h"
#include "penalty_sim/scene_links.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

/// A quaternion that a user wrote may miss unit length by the digits that were left out [1].
constexpr double kOfUnitLength = 1e-3;

Vector3 pointOf(const geometry_msgs::Point& p) { return {p.x, p.y, p.z}; }

Pose givenPose(const geometry_msgs::Pose& pose) {
  const auto& o = pose.orientation;
  const Quaternion q(o.w, o.x, o.y, o.z);
  if (!(std::abs(q.norm() - 1) < kOfUnitLength)) {
    throw SetupError("pose", "its orientation is no unit quaternion", "write w 1 and x, y, z 0 for none");
  }
  return {q.normalized(), pointOf(pose.position)};
}

}  // namespace

ActorServices::ActorServices(ros::NodeHandle& priv, const SceneDef& scene, WorldPort& port, PortOffer& offer)
    : scene_(scene), port_(port), offer_(offer) {
  services_ = {priv.advertiseService("apply_wrench", &ActorServices::onWrench, this),
               priv.advertiseService("set_body_pose", &ActorServices::onPose, this),
               priv.advertiseService("set_joint_positions", &ActorServices::onJoints, this),
               priv.advertiseService("set_gravity", &ActorServices::onGravity, this)};
}

template <class Response, class Make>
bool ActorServices::answer(Response& response, Make&& make) {
  try {
    const LoopCommand command{make()};
    response.success = offer_.send(port_, WorldPort::Change{{&command}, nullptr});
    if (!response.success) response.message = offer_.holder() + " did not answer: nothing was done";
  } catch (const SetupError& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

bool ActorServices::onWrench(haptic_msgs::ApplyWrench::Request& request, haptic_msgs::ApplyWrench::Response& response) {
  return answer(response, [&]() -> LoopCommand::Kind {
    const NamedLink named = namedLink(scene_, port_.world, request.link);
    ApplyWrench apply;
    apply.link = named.link;
    apply.wrench.in_link = request.frame == "link";
    if (!apply.wrench.in_link && !request.frame.empty() && request.frame != "world") {
      throw SetupError("wrench", "frame '" + request.frame + "' is unknown", "write world or link");
    }
    apply.wrench.F = fromWrench(request.wrench);
    if (apply.wrench.in_link) apply.wrench.F = apply.wrench.F.rotated(named.X_LM.R);
    apply.wrench.p_L = named.X_LM * pointOf(request.point);
    apply.seconds = request.duration;
    return apply;
  });
}

bool ActorServices::onPose(haptic_msgs::SetBodyPose::Request& request, haptic_msgs::SetBodyPose::Response& response) {
  return answer(response, [&]() -> LoopCommand::Kind {
    const NamedLink named = namedLink(scene_, port_.world, request.link);
    PutBody put;
    put.link = named.link;
    put.X_WL = givenPose(request.pose) * named.X_LM.inverse();
    const Twist V_WM{fromVector(request.twist.angular), fromVector(request.twist.linear)};
    put.V_WL = V_WM.shifted(put.X_WL.p - pointOf(request.pose.position));
    return put;
  });
}

bool ActorServices::onJoints(haptic_msgs::SetJointPositions::Request& request, haptic_msgs::SetJointPositions::Response& response) {
  return answer(response, [&]() -> LoopCommand::Kind {
    if (request.names.empty() || request.names.size() != request.positions.size()) {
      throw SetupError("joint positions", "names " + std::to_string(request.names.size()) + " joints and " +
                                              std::to_string(request.positions.size()) + " positions", "give one for each");
    }
    PutJoints put;
    for (std::size_t i = 0; i < request.names.size(); ++i) {
      const int joint = port_.world.jointIndex(request.names[i]);
      if (joint < 0) throw SetupError("joint positions", "there is no joint '" + request.names[i] + "'", "see joint_states for names");
      put.positions.emplace_back(joint, request.positions[i]);
    }
    return put;
  });
}

bool ActorServices::onGravity(haptic_msgs::SetGravity::Request& request, haptic_msgs::SetGravity::Response& response) {
  return answer(response, [&]() -> LoopCommand::Kind {
    const Vector3 gravity = fromVector(request.gravity);
    if (!gravity.allFinite()) throw SetupError("gravity", "has a number that is not finite", "write m/s^2");
    return SetGravity{gravity};
  });
}

}  // namespace haptic
