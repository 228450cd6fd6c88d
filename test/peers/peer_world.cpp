#include "peer_world.h"

#include <cmath>

#include "haptic_core/base/error.h"

namespace haptic::peers {

std::string name(const PeerSettings& s) {
  switch (s.peer) {
    case Peer::kOdeExact:
      return "ode_exact";
    case Peer::kOdeQuick:
      return "ode_quick" + std::to_string(s.iterations);
    case Peer::kBullet:
      return "bullet" + std::to_string(s.iterations);
    case Peer::kMujocoEuler:
      return "mujoco_euler";
    case Peer::kMujocoRk4:
      return "mujoco_rk4";
  }
  return "unknown";
}

std::unique_ptr<PeerWorld> makePeer(const WorldDef& def, const PeerSettings& settings) {
  switch (settings.peer) {
    case Peer::kOdeExact:
    case Peer::kOdeQuick:
      return makeOde(def, settings);
    case Peer::kBullet:
      return makeBullet(def, settings);
    case Peer::kMujocoEuler:
    case Peer::kMujocoRk4:
      return makeMujoco(def, settings);
  }
  return nullptr;
}

#ifndef HAPTIC_HAVE_ODE
std::unique_ptr<PeerWorld> makeOde(const WorldDef&, const PeerSettings&) {
  throw SetupError("ODE", "is not installed", "apt-get install libode-dev, and build again");
}
#endif
#ifndef HAPTIC_HAVE_BULLET
std::unique_ptr<PeerWorld> makeBullet(const WorldDef&, const PeerSettings&) {
  throw SetupError("Bullet", "is not installed", "apt-get install libbullet-extras-dev, and build again");
}
#endif
#ifndef HAPTIC_HAVE_MUJOCO
std::unique_ptr<PeerWorld> makeMujoco(const WorldDef&, const PeerSettings&) {
  throw SetupError("MuJoCo", "is not installed", "apt-get install libmujoco-dev, and build again");
}
#endif

std::vector<PeerBody> peerBodies(const WorldDef& def) {
  if (!def.loops.empty()) throw SetupError(def.name, "has a closed loop", "peers run free and fixed bodies only");
  std::vector<PeerBody> bodies;
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) {
      const bool floating = link.joint.type == JointType::kFloating;
      if (link.parent >= 0 || !(floating || link.joint.type == JointType::kFixed)) {
        throw SetupError(def.name + ", link " + link.name, "hangs on a joint",
                         "peers run free and fixed bodies only");
      }
      PeerBody body;
      body.link = &link;
      body.fixed = !floating;
      body.X_WL = articulation.X_WA * link.joint.X_PJ;
      if (floating) body.V_WL = articulation.V_WA.shifted(body.X_WL.p - articulation.X_WA.p);
      body.mu = def.settings.default_material.mu_dynamic;
      for (const CollisionDef& collision : link.collisions) {
        if (!std::isnan(collision.material.mu_dynamic)) body.mu = collision.material.mu_dynamic;
      }
      if (std::isnan(body.mu)) body.mu = 0.5;  // neither surface nor world says: the scenes' usual value
      bodies.push_back(body);
    }
  }
  return bodies;
}

}  // namespace haptic::peers
