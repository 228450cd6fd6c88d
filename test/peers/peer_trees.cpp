#include "peer_trees.h"

#include <algorithm>

namespace haptic::peers {

std::pair<Pose, Twist> onJoint(const PeerBody& body, const TreeMotion& joint, const Pose& X_WP, const Twist& V_WP) {
  const Pose X_WJ = X_WP * body.X_PJ;
  const Vector3 axis_W = X_WJ.R * body.link->joint.axis;
  Pose X_WL = X_WJ;
  Twist own;
  if (body.link->joint.type == JointType::kRevolute) {
    X_WL.R = X_WJ.R * Eigen::AngleAxisd(joint.q, body.link->joint.axis).toRotationMatrix();
    own.angular = joint.v * axis_W;
  } else if (body.link->joint.type == JointType::kPrismatic) {
    X_WL.p += joint.q * axis_W;
    own.linear = joint.v * axis_W;
  }
  return {X_WL, V_WP.shifted(X_WL.p - X_WP.p) + own};
}

PeerDrives::PeerDrives(const WorldDef& def, const std::vector<PeerBody>& bodies) {
  std::vector<int> first;  // link of each articulation
  int links = 0;
  for (const ArticulationDef& articulation : def.articulations) {
    first.push_back(links);
    links += static_cast<int>(articulation.links.size());
  }
  for (int link = 0; link < static_cast<int>(bodies.size()); ++link) {
    if (!bodies[link].driven()) continue;
    Drive drive;
    drive.link = link;
    drive.joint = &bodies[link].link->joint;
    for (const JointPathDef& path : def.joint_paths) {
      for (std::size_t c = 0; c < path.joints.size(); ++c) {
        if (first[path.joints[c].first] + path.joints[c].second != link) continue;
        drive.path = &path;
        drive.column = static_cast<int>(c);
      }
    }
    drives_.push_back(drive);
  }
}

PeerDrives::Wanted PeerDrives::at(std::size_t i, double time) {
  Drive& drive = drives_[i];
  if (!drive.path) return {{drive.joint->position, 0}, drive.joint->drive_effort};
  const std::vector<double>& times = drive.path->time;
  const int rows = static_cast<int>(times.size());
  while (drive.begun < rows && times[drive.begun] <= time) ++drive.begun;  // a search would cost a fast peer some percent
  const int next = drive.begun, a = std::max(next - 1, 0), b = std::min(next, rows - 1);
  const auto value = [&](int row) { return drive.path->position[row * drive.path->joints.size() + drive.column]; };
  if (a == b || next == 0) return {{value(a), 0}, 0};
  const double rate = (value(b) - value(a)) / (times[b] - times[a]);
  return {{value(a) + rate * (time - times[a]), rate}, 0};
}

std::pair<Pose, Twist> PeerTreeWorld::motion(int i) const {
  const PeerBody& body = bodies_[i];
  if (body.fixed) return {body.X_WL, Twist{}};
  if (body.floating()) return {rootPose(i), rootTwist(i)};
  const auto [X_WP, V_WP] = body.parent < 0 ? std::pair<Pose, Twist>() : motion(body.parent);
  return onJoint(body, body.jointed() ? jointMotion(i) : TreeMotion{}, X_WP, V_WP);
}

Pose PeerTreeWorld::linkPose(int i) const { return motion(i).first; }
Twist PeerTreeWorld::linkTwist(int i) const { return motion(i).second; }

}  // namespace haptic::peers
