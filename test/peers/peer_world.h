/// The same scenes in other simulators, for scale: ODE, Bullet, MuJoCo, each with its own default contact.
///
/// A peer runs free and fixed bodies with box and hull shapes, in double precision. What it cannot run is refused
/// by SetupError with the reason, so that a report can say so. Contact parameters of the peers are theirs: only
/// friction (the dynamic coefficient, for none of them knows two) and geometry come from the definition.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic::peers {

enum class Peer { kOdeExact, kOdeQuick, kBullet, kMujocoEuler, kMujocoRk4 };

struct PeerSettings {
  Peer peer = Peer::kOdeExact;
  int iterations = 20;   ///< of ODE's QuickStep and Bullet's solver; the others have none
  double step = 1e-3;    ///< [s]
  double restitution = 0;  ///< of all contacts; MuJoCo has none and refuses it
};

/// Links are numbered through all articulations of the definition in order, as in `World`.
class PeerWorld {
 public:
  virtual ~PeerWorld() = default;
  virtual void step() = 0;
  virtual Pose linkPose(int link) const = 0;    ///< X_WL
  virtual Twist linkTwist(int link) const = 0;  ///< V_WL at the link frame's origin, in W
  /// Force [N] in W at a point of W on the next step only.
  virtual void applyForce(int link, const Vector3& f_W, const Vector3& p_W) = 0;
};

std::string name(const PeerSettings& settings);  ///< e.g. `ode_quick20`, `bullet50`, `mujoco_euler`
std::unique_ptr<PeerWorld> makePeer(const WorldDef& def, const PeerSettings& settings);

/// One link of a scene as every peer needs it.
struct PeerBody {
  const LinkDef* link = nullptr;
  bool fixed = false;
  Pose X_WL;    ///< initial
  Twist V_WL;   ///< initial, at L's origin, in W
  double mu = 0;
};
/// Throws SetupError for joints, loops and pointers that move: peers run free and fixed bodies here.
std::vector<PeerBody> peerBodies(const WorldDef& def);

std::unique_ptr<PeerWorld> makeOde(const WorldDef& def, const PeerSettings& settings);
std::unique_ptr<PeerWorld> makeBullet(const WorldDef& def, const PeerSettings& settings);
std::unique_ptr<PeerWorld> makeMujoco(const WorldDef& def, const PeerSettings& settings);

}  // namespace haptic::peers
