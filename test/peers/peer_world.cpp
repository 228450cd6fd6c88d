#include "peer_world.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "peer_trees.h"

namespace haptic::peers {

namespace {

PeerSettings with(Peer peer, int iterations, Tuning tuning = Tuning::kAsItComes) {
  PeerSettings s;
  s.peer = peer;
  s.iterations = iterations;
  s.tuning = tuning;
  return s;
}

PeerSettings withMujoco3(const MujocoText& text) {
  PeerSettings s = with(Peer::kMujocoWasm, 0);
  s.mujoco = text;
  return s;
}

std::vector<NamedPeer> makeTable() {
  using P = Peer;
  using T = Tuning;
  return {
      {"ode_exact", with(P::kOdeExact, 20), "as it comes", "dWorldStep, ERP 0.2, CFM 1e-10, friction pyramid on fixed axes"},
      {"ode_exact_firm", with(P::kOdeExact, 20, T::kAccurate), "accuracy",
       "dWorldStep, ERP 0.8, CFM 1e-12, first friction axis along the slip, finite rotations"},
      {"ode_quick20", with(P::kOdeQuick, 20), "as it comes", "dWorldQuickStep, 20 iterations, ERP 0.2, CFM 1e-10"},
      {"ode_quick10", with(P::kOdeQuick, 10, T::kFast), "speed", "dWorldQuickStep, 10 iterations, ERP 0.2, CFM 1e-10"},
      {"ode_quick100_firm", with(P::kOdeQuick, 100, T::kAccurate), "accuracy",
       "dWorldQuickStep, 100 iterations, ERP 0.8, CFM 1e-12, first friction axis along the slip, finite rotations"},
      {"ode_quick20_sleeps", with(P::kOdeQuick, 20, T::kSleeps), "speed",
       "dWorldQuickStep, 20 iterations, ERP 0.2, CFM 1e-10, bodies below 0.01 m/s and rad/s disabled after 10 steps"},
      {"bullet10", with(P::kBullet, 10), "as it comes", "sequential impulses, 10 iterations, ERP 0.2, margin 1 mm"},
      {"bullet5", with(P::kBullet, 5, T::kFast), "speed", "sequential impulses, 5 iterations, ERP 0.2, margin 1 mm"},
      {"bullet10_sleeps", with(P::kBullet, 10, T::kSleeps), "speed",
       "sequential impulses, 10 iterations, ERP 0.2, margin 1 mm, islands below 0.8 m/s and 1 rad/s for 2 s asleep"},
      {"bullet50", with(P::kBullet, 50), "accuracy", "sequential impulses, 50 iterations, ERP 0.2, margin 1 mm"},
      {"bullet200_firm", with(P::kBullet, 200, T::kAccurate), "accuracy",
       "sequential impulses, 200 iterations, ERP 0.8, two friction directions, restitution at any speed, margin 1 mm"},
      {"bullet_dantzig", with(P::kBullet, 50, T::kDantzig), "accuracy",
       "Dantzig's MLCP solver (50 sequential impulses where it fails), ERP 0.2, margin 1 mm"},
      {"mujoco_euler", with(P::kMujocoEuler, 0), "as it comes", "Euler, solref 0.02 1, pyramidal cone, Newton"},
      {"mujoco_rk4", with(P::kMujocoRk4, 0), "accuracy", "RK4, solref 0.02 1, pyramidal cone, Newton"},
      {"mujoco_firm", with(P::kMujocoEuler, 0, T::kAccurate), "accuracy",
       "implicit integrator, solref two steps and 1, solimp 0.99 0.999 0.001, elliptic cone, impratio 10, 10 iterations of noslip"},
      {"mujoco_fast", with(P::kMujocoEuler, 0, T::kFast), "speed",
       "Euler, solref two steps and 1, pyramidal cone, conjugate gradients, 10 iterations"},
      {"mujoco3_euler", withMujoco3({"integrator='Euler'", "", 0, false}), "as it comes",
       "3.14 in WebAssembly, errors only: Euler, pyramidal cone"},
      {"mujoco3_implicitfast", withMujoco3({"integrator='implicitfast'", "", 0, false}), "as it comes",
       "3.14 in WebAssembly, errors only: implicitfast, pyramidal cone"},
      {"mujoco3_elliptic", withMujoco3({"integrator='implicitfast' cone='elliptic' impratio='10'", "", 0, false}), "accuracy",
       "3.14 in WebAssembly, errors only: implicitfast, elliptic cone, impratio 10"},
      {"mujoco3_firm",
       withMujoco3({"integrator='implicitfast' cone='elliptic' impratio='10' noslip_iterations='10'", "multiccd='enable'", 2, true}),
       "accuracy",
       "3.14 in WebAssembly, errors only: implicitfast, elliptic cone, impratio 10, 10 iterations of noslip, multiccd, solref two steps "
       "and 1, solimp 0.99 0.999 0.001"},
      {"jolt", with(P::kJolt, 10), "as it comes",
       "1.1.0 of npm in WebAssembly, single precision, errors only: 10 steps for velocities and 2 for positions, slop and speculative "
       "distance 1 mm, no convex radius"},
      {"jolt_firm", with(P::kJolt, 50, T::kAccurate), "accuracy",
       "1.1.0 of npm in WebAssembly, single precision, errors only: 50 steps for velocities and 10 for positions, slop 1 um"},
      {"rapier", with(P::kRapier, 4), "as it comes",
       "0.21 in WebAssembly, single precision, errors only: 4 iterations, contacts of 30 Hz, allowed error and prediction 1 mm"},
      {"rapier_firm", with(P::kRapier, 50, T::kAccurate), "accuracy",
       "0.21 in WebAssembly, single precision, errors only: 50 iterations, contacts of 0.2 / step, allowed error 1 um"},
  };
}

}  // namespace

const std::vector<NamedPeer>& peerTable() {
  static const std::vector<NamedPeer> kTable = makeTable();
  return kTable;
}

std::string name(const PeerSettings& s) {
  for (const NamedPeer& row : peerTable()) {
    const bool counts = s.peer == Peer::kOdeQuick || s.peer == Peer::kBullet;
    if (s.peer == Peer::kMujocoWasm && std::string(row.settings.mujoco.option) != s.mujoco.option) continue;
    if (row.settings.peer == s.peer && row.settings.tuning == s.tuning && (!counts || row.settings.iterations == s.iterations)) {
      return row.name;
    }
  }
  return "unknown";
}

std::optional<PeerShape> roundShape(const PeerBody& body, const ConvexShape& shape) {
  using Kind = PeerShape::Kind;
  if (body.round) return *body.round;
  if (shape.ball()) return PeerShape{-1, Kind::kSphere, shape.ball()->radius(), 0};
  if (shape.halfSpace()) return PeerShape{-1, Kind::kPlane, 0, 0};
  if (const Rod* rod = shape.rod()) {
    return PeerShape{-1, rod->isCapsule() ? Kind::kCapsule : Kind::kCylinder, rod->radius(), 2 * rod->halfLength()};
  }
  return std::nullopt;
}

bool isPlane(const PeerBody& body) {
  const auto& collisions = body.link->collisions;
  if (body.round) return body.round->kind == PeerShape::Kind::kPlane;
  return collisions.size() == 1 && collisions[0].shape->halfSpace();
}

UpperFace upperFace(const CollisionDef& collision) {
  if (collision.shape->halfSpace()) return {collision.X_LS.p, collision.X_LS.R.col(2)};
  return {collision.X_LS * Vector3(0, 0, collision.shape->polyhedron()->halfSize().z()), collision.X_LS.R.col(2)};
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
    case Peer::kMujocoWasm:
      return makeMujocoWasm(def, settings);
    case Peer::kJolt:
    case Peer::kRapier:
      return makeWasm(def, settings);
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

bool hasTrees(const WorldDef& def) {
  for (const ArticulationDef& articulation : def.articulations) {
    for (const LinkDef& link : articulation.links) {
      const bool floating = link.joint.type == JointType::kFloating;
      if (link.parent >= 0 || !(floating || link.joint.type == JointType::kFixed)) return true;
    }
  }
  return false;
}

namespace {

void checkJoint(const std::string& scene, const LinkDef& link) {
  const JointDef& j = link.joint;
  const bool jointed = j.type == JointType::kRevolute || j.type == JointType::kPrismatic;
  const auto refuse = [&](const char* what) {
    throw SetupError(scene + ", link " + link.name, what, "peers run trees of hinges and slides with position drives");
  };
  const bool floats = j.type == JointType::kFloating && link.parent < 0;
  if (!jointed && j.type != JointType::kFixed && !floats) refuse("has a joint of another type");
  if (!jointed) return;
  if (j.mimic_joint >= 0 || j.friction != 0 || j.spring_stiffness != 0) refuse("has a mimic, friction or a spring in its joint");
  if (std::isfinite(j.lower) || std::isfinite(j.upper)) refuse("has a limit");
  if (j.drive != JointDef::Drive::kNone && j.drive != JointDef::Drive::kPosition) refuse("has a drive that follows no position");
  if (j.drive != JointDef::Drive::kNone && !(j.drive_stiffness > 0)) refuse("has a drive without stiffness");
  if (std::isfinite(j.max_effort)) refuse("has a drive with a limit");
}

}  // namespace

std::vector<PeerBody> peerBodies(const WorldDef& def, const PeerSettings& settings, bool trees) {
  if (!def.loops.empty()) throw SetupError(def.name, "has a closed loop", "peers run trees");
  if (!trees && hasTrees(def)) throw SetupError(def.name, "has joints", "this peer runs free and fixed bodies only");
  std::vector<PeerBody> bodies;
  for (const ArticulationDef& articulation : def.articulations) {
    const int first = static_cast<int>(bodies.size());
    for (const LinkDef& link : articulation.links) {
      checkJoint(def.name, link);
      PeerBody body;
      body.link = &link;
      body.fixed = link.joint.type == JointType::kFixed && link.parent < 0;
      if (link.parent >= 0) body.parent = first + link.parent;
      body.X_PJ = body.parent < 0 ? articulation.X_WA * link.joint.X_PJ : link.joint.X_PJ;
      const TreeMotion start = {link.joint.position, link.joint.velocity};
      const auto [X_WL, V_WL] = onJoint(body, start, body.parent < 0 ? Pose() : bodies[body.parent].X_WL,
                                        body.parent < 0 ? Twist() : bodies[body.parent].V_WL);
      body.X_WL = X_WL;
      body.V_WL = V_WL;
      if (body.floating()) body.V_WL = articulation.V_WA.shifted(body.X_WL.p - articulation.X_WA.p);
      body.mu = def.settings.default_material.mu_dynamic;
      for (const CollisionDef& collision : link.collisions) {
        if (!std::isnan(collision.material.mu_dynamic)) body.mu = collision.material.mu_dynamic;
      }
      if (std::isnan(body.mu)) body.mu = 0.5;  // neither surface nor world says: the scenes' usual value
      for (const PeerShape& shape : settings.shapes) {
        if (shape.link == static_cast<int>(bodies.size())) body.round = &shape;
      }
      bodies.push_back(body);
    }
  }
  return bodies;
}

}  // namespace haptic::peers
