// The MJCF of a scene, for MuJoCo 2.2 in this process and for 3.x in WebAssembly.
#include "mujoco_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::peers {
namespace {

std::string text(const Vector3& v) {
  std::ostringstream s;
  s.precision(17);
  s << v.x() << ' ' << v.y() << ' ' << v.z();
  return s.str();
}
std::string text(const Matrix3& R) {
  const Quaternion q(R);
  std::ostringstream s;
  s.precision(17);
  s << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
  return s.str();
}

/// Contact of two geoms has the larger friction of both, or that of the higher priority: fixed bodies get the latter, with
/// the geometric mean that the other simulators take.
std::string frictionOf(const PeerBody& b, double mu_moving) {
  std::ostringstream s;
  s.precision(17);
  s << "' friction='" << (b.fixed ? std::sqrt(b.mu * mu_moving) : b.mu) << " 0.005 0.0001' priority='" << b.fixed << "'/>";
  return s.str();
}

/// Friction of the bodies that move; NaN when none does.
double movingFriction(const std::vector<PeerBody>& bodies) {
  double mu = std::nan("");
  for (const PeerBody& b : bodies) {
    if (b.fixed) continue;
    if (!std::isnan(mu) && mu != b.mu) {
      throw SetupError("MuJoCo", "takes the larger friction of two bodies", "give all moving bodies the same");
    }
    mu = b.mu;
  }
  return mu;
}

/// `type` and `size` of a geom, and where it lies.
std::string geomText(const PeerBody& b, const CollisionDef& collision, int& mesh, std::ostringstream& assets) {
  std::ostringstream s;
  s.precision(17);
  Vector3 p = collision.X_LS.p;
  const auto round = roundShape(b, *collision.shape);
  if (round && round->kind != PeerShape::Kind::kCone) {
    const PeerShape& r = *round;
    switch (r.kind) {
      case PeerShape::Kind::kSphere:
        s << "<geom type='sphere' size='" << r.radius;
        break;
      case PeerShape::Kind::kCapsule:
        s << "<geom type='capsule' size='" << r.radius << ' ' << 0.5 * r.length;
        break;
      case PeerShape::Kind::kPlane:
        s << "<geom type='plane' size='0 0 1";
        p = upperFace(collision).p_L;
        break;
      default:
        s << "<geom type='cylinder' size='" << r.radius << ' ' << 0.5 * r.length;
    }
  } else if (const ConvexPolyhedron* hull = collision.shape->polyhedron(); hull->isBox()) {
    s << "<geom type='box' size='" << text(hull->halfSize());
  } else {
    assets << "<mesh name='m" << mesh << "' vertex='";
    for (const Vector3& v : hull->vertices()) assets << text(v) << ' ';
    assets << "'/>";
    s << "<geom type='mesh' mesh='m" << mesh++;
  }
  s << "' pos='" << text(p) << "' quat='" << text(collision.X_LS.R);
  return s.str();
}

/// Solver, cone, softness. MuJoCo has no restitution: springs without damping, in the direct form of solref, give back
/// what they take; a period of 4π steps is as stiff as its Euler steps resolve.
std::string optionText(const PeerSettings& s) {
  std::ostringstream option;
  option.precision(17);
  if (s.peer == Peer::kMujocoWasm) {
    const std::string flags = *s.mujoco.flags ? "<flag " + std::string(s.mujoco.flags) + "/>" : "";
    option << s.mujoco.option << ">" << flags << "</option><default><geom ";
    if (s.restitution > 0) {
      option << "solref='" << -0.25 / (s.step * s.step) << " 0' ";
    } else if (s.mujoco.solref_steps > 0) {
      option << "solref='" << s.mujoco.solref_steps * s.step << " 1' ";
    }
    return option.str() + (s.mujoco.hard ? "solimp='0.99 0.999 0.001'" : "") + "/></default>";
  }
  const bool accurate = s.tuning == Tuning::kAccurate, fast = s.tuning == Tuning::kFast;
  if (accurate) {
    option << "integrator='implicit' cone='elliptic' impratio='10' noslip_iterations='10'";
  } else {
    option << "integrator='" << (s.peer == Peer::kMujocoRk4 ? "RK4" : "Euler") << "'";
    if (fast) option << " solver='CG' iterations='10'";
  }
  std::ostringstream contact;
  contact.precision(17);
  if (s.restitution > 0) {
    contact << "solref='" << -0.25 / (s.step * s.step) << " 0' ";
  } else if (accurate || fast) {
    contact << "solref='" << 2 * s.step << " 1' ";
  }
  if (accurate) contact << "solimp='0.99 0.999 0.001'";
  return option.str() + "/><default><geom " + contact.str() + "/></default>";
}

/// Joint and inertia of a link that moves.
std::string jointText(const PeerBody& b, std::size_t i) {
  std::ostringstream s;
  s.precision(17);
  const JointDef& j = b.link->joint;
  if (b.floating()) s << "<freejoint/>";
  if (b.jointed()) {
    // A drive's damper is a joint's: MuJoCo's implicit integrators know that one, and Euler takes it implicitly.
    s << "<joint name='j" << i << "' type='" << (j.type == JointType::kRevolute ? "hinge" : "slide") << "' axis='" << text(j.axis)
      << "' damping='" << j.damping + (b.driven() ? j.drive_damping : 0) << "'/>";
  }
  const LinkInertia& inertia = b.link->inertia;
  const Matrix3& I = inertia.I_C;
  s << "<inertial pos='" << text(inertia.p_LC) << "' mass='" << inertia.mass << "' fullinertia='" << I(0, 0) << ' ' << I(1, 1) << ' '
    << I(2, 2) << ' ' << I(0, 1) << ' ' << I(0, 2) << ' ' << I(1, 2) << "'/>";
  return s.str();
}

std::string actuatorText(const std::vector<PeerBody>& bodies) {
  std::ostringstream s;
  s.precision(17);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double K = bodies[i].link->joint.drive_stiffness;
    if (!bodies[i].driven()) continue;
    s << "<general joint='j" << i << "' gainprm='" << K << "' biastype='affine' biasprm='0 " << -K << " 0'/>";
  }
  return s.str().empty() ? "" : "<actuator>" + s.str() + "</actuator>";
}

void visit(const std::vector<PeerBody>& bodies, int parent, const std::function<void(int)>& enter, const std::function<void()>& leave) {
  for (int i = 0; i < static_cast<int>(bodies.size()); ++i) {
    if (bodies[i].parent != parent) continue;
    enter(i);
    visit(bodies, i, enter, leave);
    leave();
  }
}

}  // namespace

MujocoLayout::MujocoLayout(const std::vector<PeerBody>& bodies)
    : body(bodies.size(), 0), q(bodies.size(), -1), v(bodies.size(), -1) {
  int count = 0;
  const auto enter = [&](int i) {
    body[i] = ++count;
    const PeerBody& b = bodies[i];
    const int positions = b.floating() ? 7 : b.jointed(), rates = b.floating() ? 6 : b.jointed();
    if (rates > 0) q[i] = nq, v[i] = nv;
    nq += positions;
    nv += rates;
  };
  visit(bodies, -1, enter, [] {});
}

void MujocoLayout::start(const std::vector<PeerBody>& bodies, double* positions, double* rates) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const PeerBody& b = bodies[i];
    if (b.floating()) {
      const Quaternion turn(b.X_WL.R);
      Eigen::Map<Vector3>(positions + q[i]) = b.X_WL.p;
      Eigen::Map<Eigen::Vector4d>(positions + q[i] + 3) << turn.w(), turn.x(), turn.y(), turn.z();
      Eigen::Map<Vector3>(rates + v[i]) = b.V_WL.linear;  // linear in W, angular in the body's axes
      Eigen::Map<Vector3>(rates + v[i] + 3) = b.X_WL.R.transpose() * b.V_WL.angular;
    } else if (b.jointed()) {
      positions[q[i]] = b.link->joint.position;
      rates[v[i]] = b.link->joint.velocity;
    }
  }
}

Pose MujocoTreeWorld::rootPose(int i) const {
  const double* q = positions() + layout_.q[i];
  return {Quaternion(q[3], q[4], q[5], q[6]).normalized(), Vector3(q[0], q[1], q[2])};
}
Twist MujocoTreeWorld::rootTwist(int i) const {
  const double* v = rates() + layout_.v[i];
  return {rootPose(i).R * Vector3(v[3], v[4], v[5]), Vector3(v[0], v[1], v[2])};
}
TreeMotion MujocoTreeWorld::jointMotion(int i) const { return {positions()[layout_.q[i]], rates()[layout_.v[i]]}; }

void MujocoTreeWorld::control(double* out) {
  const double time = step_ * static_cast<double>(++steps_);  // at the end of the step
  for (std::size_t i = 0; i < drives_.all().size(); ++i) {
    const PeerDrives::Wanted wanted = drives_.at(i, time);
    const JointDef& joint = *drives_.all()[i].joint;
    out[i] = wanted.motion.q + (joint.drive_damping * wanted.motion.v + wanted.effort) / joint.drive_stiffness;
  }
}

std::string mujocoModel(const WorldDef& def, const std::vector<PeerBody>& bodies, const PeerSettings& settings) {
  std::ostringstream assets, tree;
  tree.precision(17);
  const double mu_moving = movingFriction(bodies);
  int mesh = 0;
  const auto enter = [&](int i) {
    const PeerBody& b = bodies[i];
    tree << "<body name='b" << i << "' pos='" << text(b.X_PJ.p) << "' quat='" << text(b.X_PJ.R) << "'>";
    if (!b.fixed) tree << jointText(b, i);
    for (const CollisionDef& collision : b.link->collisions) {
      tree << geomText(b, collision, mesh, assets) << frictionOf(b, mu_moving);
    }
  };
  visit(bodies, -1, enter, [&tree] { tree << "</body>"; });
  std::ostringstream model;
  model.precision(17);
  // Contacts of boxes have up to eight points, bodies in heaps half a dozen contacts; what does not fit is dropped by MuJoCo.
  const int contacts = std::min<int>(1500, 50 + 20 * static_cast<int>(bodies.size()));
  model << "<mujoco><compiler inertiafromgeom='false' balanceinertia='false' angle='radian'/><size njmax='" << 4 * contacts
        << "' nconmax='" << contacts << "'/><option timestep='" << settings.step << "' gravity='"
        << text(def.settings.gravity) << "' " << optionText(settings) << "<asset>" << assets.str() << "</asset><worldbody>" << tree.str()
        << "</worldbody>" << actuatorText(bodies) << "</mujoco>";
  return model.str();
}

}  // namespace haptic::peers
