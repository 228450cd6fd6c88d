/// The same scenes in other simulators, for scale: ODE, Bullet, MuJoCo, Jolt, Rapier, each in several settings.
///
/// A peer runs free and fixed bodies with boxes, hulls and its own round shapes, in double precision, Jolt and Rapier in single; Bullet (as
/// btMultiBody) and MuJoCo also trees of hinges and slides with drives. What it cannot run is refused by SetupError with the reason, so
/// that a report can say so. Contact parameters of the peers are theirs:
/// only friction (the dynamic coefficient, for none of them knows two) and geometry come from the definition.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic::peers {

enum class Peer { kOdeExact, kOdeQuick, kBullet, kMujocoEuler, kMujocoRk4, kMujocoWasm, kJolt, kRapier };

/// What MuJoCo 3 in WebAssembly is told, as text of MJCF. It is a process of its own: its errors are comparable, its times are not.
struct MujocoText {
  const char* option = "";   ///< attributes of <option>
  const char* flags = "";    ///< of <flag>
  double solref_steps = 0;   ///< time constant of solref in steps; 0: its default
  bool hard = false;         ///< solimp .99 .999 .001
};

/// What a peer's own manual advises: as it comes, for accuracy, for speed, with another solver, or with what has become slow put
/// to sleep. In the other tunings nothing sleeps. See `peerTable`.
enum class Tuning { kAsItComes, kAccurate, kFast, kDantzig, kSleeps };

/// A true shape of a peer in place of the polyhedra of one link: axis z of each shape's frame.
struct PeerShape {
  enum class Kind { kSphere, kCylinder, kCapsule, kCone, kPlane };
  int link = -1;
  Kind kind = Kind::kSphere;
  double radius = 0;  ///< [m]
  double length = 0;  ///< of cylinder and cone; of a capsule between its centres [m]
};

struct PeerSettings {
  Peer peer = Peer::kOdeExact;
  int iterations = 20;     ///< of ODE's QuickStep and Bullet's solver
  double step = 1e-3;      ///< [s]
  double restitution = 0;  ///< of all contacts, 0 or 1; MuJoCo, which has none, gets springs without damping for 1
  Tuning tuning = Tuning::kAsItComes;
  MujocoText mujoco;       ///< of kMujocoWasm
  std::vector<PeerShape> shapes;
};

/// One named setting of a peer.
struct NamedPeer {
  const char* name;
  PeerSettings settings;
  const char* purpose;  ///< what it is for: as it comes, accuracy, speed
  const char* meaning;  ///< every value that differs from the library's own, for people
};
/// All settings that the report runs.
const std::vector<NamedPeer>& peerTable();

/// Links are numbered through all articulations of the definition in order, as in `World`.
class PeerWorld {
 public:
  virtual ~PeerWorld() = default;
  virtual void step() = 0;
  virtual Pose linkPose(int link) const = 0;    ///< X_WL
  virtual Twist linkTwist(int link) const = 0;  ///< V_WL at the link frame's origin, in W
  /// Force [N] in W at a point of W on the next step only.
  virtual void applyForce(int link, const Vector3& f_W, const Vector3& p_W) = 0;
  /// All friction from the next step on, as a factor on the definition's.
  virtual void scaleFriction(double factor) = 0;
};

std::string name(const PeerSettings& settings);  ///< e.g. `ode_quick20`, `bullet50`, `mujoco_firm`
std::unique_ptr<PeerWorld> makePeer(const WorldDef& def, const PeerSettings& settings);

/// One link of a scene as every peer needs it.
struct PeerBody {
  const LinkDef* link = nullptr;
  bool fixed = false;     ///< nothing moves it: it hangs on the world by a fixed joint
  int parent = -1;        ///< link that its joint hangs on; -1: the world
  Pose X_PJ;              ///< joint frame in the parent, or in W
  Pose X_WL;    ///< initial
  Twist V_WL;   ///< initial, at L's origin, in W

  bool floating() const { return link->joint.type == JointType::kFloating; }
  /// A hinge or a slide.
  bool jointed() const { return link->joint.type == JointType::kRevolute || link->joint.type == JointType::kPrismatic; }
  bool driven() const { return link->joint.drive == JointDef::Drive::kPosition; }
  double mu = 0;
  const PeerShape* round = nullptr;  ///< in place of the link's polyhedra; null: none
};
/// Whether there are links on links, or on joints: a scene for peers that know trees.
bool hasTrees(const WorldDef& def);

/// Throws SetupError for loops, and for joints that a peer is not told of: all of them unless `trees`; else other ones than hinges and
/// slides, and limits, friction, springs, mimics and drives other than position drives without a limit.
std::vector<PeerBody> peerBodies(const WorldDef& def, const PeerSettings& settings, bool trees = false);

/// What is round of a shape: the body's own, in place of its polyhedra, or the shape itself; none: it has corners.
std::optional<PeerShape> roundShape(const PeerBody& body, const ConvexShape& shape);

/// It is a plane to the peer: a half-space, or told so.
bool isPlane(const PeerBody& body);

/// Upper face of a box, or a half-space's surface, as a plane: a point and the normal, in the link's frame.
struct UpperFace {
  Vector3 p_L, n_L;
};
UpperFace upperFace(const CollisionDef& collision);

std::unique_ptr<PeerWorld> makeOde(const WorldDef& def, const PeerSettings& settings);
std::unique_ptr<PeerWorld> makeBullet(const WorldDef& def, const PeerSettings& settings);
/// Engines in WebAssembly: errors only, see MujocoText. They need node, and the folder HAPTIC_WASM_PEERS with its node_modules.
std::unique_ptr<PeerWorld> makeMujocoWasm(const WorldDef& def, const PeerSettings& settings);
std::unique_ptr<PeerWorld> makeWasm(const WorldDef& def, const PeerSettings& settings);  ///< Jolt, Rapier
std::unique_ptr<PeerWorld> makeMujoco(const WorldDef& def, const PeerSettings& settings);

}  // namespace haptic::peers
