/// A scene as MuJoCo's MJCF, and where its numbers are in MuJoCo's q and v.
#pragma once
#include "peer_trees.h"

namespace haptic::peers {

/// By link: MuJoCo numbers bodies, and the numbers of their joints, from parents to children, depth first.
struct MujocoLayout {
  explicit MujocoLayout(const std::vector<PeerBody>& bodies);
  /// Fills q and v at the start.
  void start(const std::vector<PeerBody>& bodies, double* q, double* v) const;

  std::vector<int> body;  ///< from 1 on: 0 is the world
  std::vector<int> q, v;  ///< first number of its joint; -1: none
  int nq = 0, nv = 0;     ///< numbers of all
};

/// Both MuJoCos: poses and twists from q and v, controls from drives.
class MujocoTreeWorld : public PeerTreeWorld {
 protected:
  MujocoTreeWorld(const WorldDef& def, const PeerSettings& settings)
      : PeerTreeWorld(peerBodies(def, settings, true)), layout_(bodies()), drives_(def, bodies()), step_(settings.step) {}
  virtual const double* positions() const = 0;  ///< MuJoCo's q
  virtual const double* rates() const = 0;      ///< MuJoCo's v
  Pose rootPose(int link) const final;
  Twist rootTwist(int link) const final;
  TreeMotion jointMotion(int link) const final;
  const MujocoLayout& layout() const { return layout_; }
  std::size_t driveCount() const { return drives_.all().size(); }
  void control(double* out);  ///< of the next step, one per drive

 private:
  MujocoLayout layout_;
  PeerDrives drives_;
  double step_;
  long steps_ = 0;
};

/// Throws SetupError for what MuJoCo cannot be told.
std::string mujocoModel(const WorldDef& def, const std::vector<PeerBody>& bodies, const PeerSettings& settings);

}  // namespace haptic::peers
