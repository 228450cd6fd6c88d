/// Trees of links in peers: where joints put links, and what drives ask for.
#pragma once
#include <utility>
#include <vector>

#include "peer_world.h"

namespace haptic::peers {

/// A joint's position and its rate: [rad], [rad/s] of a hinge, [m], [m/s] of a slide.
struct TreeMotion {
  double q = 0, v = 0;
};

/// Pose and twist (at L's origin, in W) of a link from those of its parent; a floating or fixed link sits in its joint frame.
std::pair<Pose, Twist> onJoint(const PeerBody& body, const TreeMotion& joint, const Pose& X_WP, const Twist& V_WP);

/// What the position drives of a scene are asked for: K (q − q_now) + D (v − v_now) + effort, along its joint paths, which ours follows to
/// the end of each step.
class PeerDrives {
 public:
  struct Drive {
    int link = -1;
    const JointDef* joint = nullptr;
    const JointPathDef* path = nullptr;  ///< null: it keeps its first position
    int column = 0;                      ///< in the path
    int begun = 0;                       ///< rows of the path until the time that was asked for last
  };
  PeerDrives(const WorldDef& def, const std::vector<PeerBody>& bodies);
  const std::vector<Drive>& all() const { return drives_; }  ///< in the order of links
  /// Position, rate and effort [N·m] or [N] that drive i asks for at a time, which only rises; `def` must live.
  struct Wanted {
    TreeMotion motion;
    double effort = 0;
  };
  Wanted at(std::size_t i, double time);

 private:
  std::vector<Drive> drives_;
};

/// A peer whose state has joint coordinates: links follow from them and from the roots.
class PeerTreeWorld : public PeerWorld {
 public:
  Pose linkPose(int i) const override;
  Twist linkTwist(int i) const override;

 protected:
  explicit PeerTreeWorld(std::vector<PeerBody> bodies) : bodies_(std::move(bodies)) {}
  virtual Pose rootPose(int link) const = 0;         ///< X_WL of a floating link
  virtual Twist rootTwist(int link) const = 0;       ///< V_WL at its origin, in W
  virtual TreeMotion jointMotion(int link) const = 0;  ///< of a hinge or slide
  const std::vector<PeerBody>& bodies() const { return bodies_; }

 private:
  std::pair<Pose, Twist> motion(int link) const;
  std::vector<PeerBody> bodies_;
};

}  // namespace haptic::peers
