#include "robots_sensors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "../comparators/velocity_verlet.h"
#include "../scenes/blocks.h"
#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/contact_detail.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"
#include "robots_kdl.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

using Long = long double;
using Long3 = Eigen::Matrix<Long, 3, 1>;
using LongMatrix = Eigen::Matrix<Long, 3, 3>;

/// A link in W: frame, twist at its origin.
struct Body {
  LongMatrix R = LongMatrix::Identity();
  Long3 p = Long3::Zero(), omega = Long3::Zero(), v = Long3::Zero();
};

/// Torque about a point and force, or their momenta.
struct Pair {
  Long3 turn = Long3::Zero(), push = Long3::Zero();
};

bool isKnown(const ArticulationDef& def) {
  return std::all_of(def.links.begin(), def.links.end(), [](const LinkDef& link) {
    return link.joint.type == JointType::kFixed || link.joint.type == JointType::kFloating || isScalar(link.joint.type);
  });
}

/// Forward kinematics from the definition alone; q and v in the order of its links.
std::vector<Body> bodies(const ArticulationDef& def, const double* q, const double* v) {
  std::vector<Body> found;
  for (const LinkDef& link : def.links) {
    const JointDef& joint = link.joint;
    Body base;
    base.R = def.X_WA.R.cast<Long>(), base.p = def.X_WA.p.cast<Long>();
    const Body& parent = link.parent < 0 ? base : found[link.parent];
    const LongMatrix R_J = parent.R * joint.X_PJ.R.cast<Long>();
    Body body;
    body.R = R_J, body.omega = parent.omega;
    body.p = parent.p + parent.R * joint.X_PJ.p.cast<Long>();
    Long3 slide = Long3::Zero();
    if (joint.type == JointType::kFloating) {
      const Eigen::Quaternion<Long> turned(q[3], q[4], q[5], q[6]);
      body.R = turned.normalized().toRotationMatrix();
      const Long3 lever = body.R * link.inertia.p_LC.cast<Long>();
      body.omega = Long3(v[0], v[1], v[2]);
      body.p = Long3(q[0], q[1], q[2]) - lever;
      body.v = Long3(v[3], v[4], v[5]) - body.omega.cross(lever);
      q += 7, v += 6;
      found.push_back(body);
      continue;
    }
    const Long3 axis = joint.axis.cast<Long>().normalized();
    if (joint.type == JointType::kPrismatic) {
      body.p += R_J * axis * Long(*q++);
      slide = R_J * axis * Long(*v++);
    } else if (joint.type == JointType::kRevolute) {
      body.R = R_J * Eigen::AngleAxis<Long>(*q++, axis).toRotationMatrix();
      body.omega += R_J * axis * Long(*v++);
    }
    body.v = parent.v + parent.omega.cross(body.p - parent.p) + slide;
    found.push_back(body);
  }
  return found;
}

/// Momentum about `a`, and of gravity the moment of the mass.
Pair momentumOf(const LinkDef& link, const Body& body, const Long3& a, Long3& lever) {
  const Long3 r = body.R * link.inertia.p_LC.cast<Long>();
  const Long3 push = Long(link.inertia.mass) * (body.v + body.omega.cross(r));
  lever = body.p + r - a;
  return {body.R * link.inertia.I_C.cast<Long>() * body.R.transpose() * body.omega + lever.cross(push), push};
}

/// A wrench through every joint that carries one, of all articulations that move.
void addSensors(WorldDef& world, bool contacts) {
  for (std::size_t a = 0; a < world.articulations.size(); ++a) {
    for (std::size_t l = 0; l < world.articulations[a].links.size(); ++l) {
      SensorDef sensor;
      sensor.articulation = static_cast<int>(a), sensor.link = static_cast<int>(l);
      sensor.name = sensor.frame = "s" + std::to_string(a) + "_" + std::to_string(l);
      if (contacts) {
        sensor.kind = SensorDef::Kind::kContact;
        sensor.name += "c";
      } else if (world.articulations[a].links[l].joint.type == JointType::kFloating) {
        continue;
      }
      world.sensors.push_back(sensor);
    }
  }
}

struct Errors {
  double reaction = 0, sum = 0, sum_turn = 0;
  long samples = 0, contacts = 0;
};

/// Of one step; `q_0`, `v_0`: before it.
class StepCheck {
 public:
  StepCheck(const World& world, const WorldDef& def, const State& before) : world_(world), def_(def), before_(before) {}

  void take(std::size_t a, Errors& errors) {
    const ArticulationDef& tree = def_.articulations[a];
    const Model& model = world_.model();
    const int first = model.link(static_cast<int>(a), 0);
    const ModelTree& placed = model.trees[model.links[first].articulation];
    const auto bodiesAt = [&](const State& state) { return bodies(tree, state.q.data() + placed.q, state.v.data() + placed.v); };
    const std::vector<Body> start = bodiesAt(before_), end = bodiesAt(world_.state());
    std::vector<Pair> wanted(tree.links.size()), read(tree.links.size());
    Long push = 0, turn = 0;
    for (std::size_t l = 0; l < tree.links.size(); ++l) {
      wanted[l] = needed(tree, start, end, l, first, false);
      push = std::max(push, wanted[l].push.norm()), turn = std::max(turn, wanted[l].turn.norm());
    }
    for (std::size_t l = 0; l < tree.links.size(); ++l) {
      if (tree.links[l].joint.type == JointType::kFloating) continue;
      read[l] = sensed("s" + std::to_string(a) + "_" + std::to_string(l), end[l]);
      const Long off = std::max((read[l].push - wanted[l].push).norm() / push, (read[l].turn - wanted[l].turn).norm() / turn);
      errors.reaction = std::max(errors.reaction, static_cast<double>(off));
      ++errors.samples;
    }
    for (std::size_t l = 0; l < tree.links.size(); ++l) takeSum(a, l, tree, start, end, read, errors);
  }

 private:
  /// What has to come through joint l: all beyond it changes its momentum, falls, and touches; `alone`: link l only, without contacts.
  Pair needed(const ArticulationDef& tree, const std::vector<Body>& start, const std::vector<Body>& end, std::size_t l, int first,
              bool alone) const {
    const Long h = def_.settings.step;
    const Long3 a = end[l].p, g = def_.settings.gravity.cast<Long>();
    std::vector<bool> beyond(tree.links.size(), false);
    beyond[l] = true;
    Pair sum;
    for (std::size_t i = l; i < tree.links.size(); ++i) {
      const int parent = tree.links[i].parent;
      if (!alone && i != l) beyond[i] = parent >= 0 && beyond[parent];
      if (!beyond[i]) continue;
      Long3 lever_0, lever_1;
      const Pair before = momentumOf(tree.links[i], start[i], a, lever_0), after = momentumOf(tree.links[i], end[i], a, lever_1);
      const Long3 weight = Long(tree.links[i].inertia.mass) * g;
      sum.push += (after.push - before.push) / h - weight;
      sum.turn += (after.turn - before.turn) / h - ((lever_0 + lever_1) / 2).cross(weight);
    }
    for (int c = 0; !alone && c < world_.contactCount(); ++c) {
      const ContactReport& contact = world_.contact(c);
      for (const auto& [link, sign] : {std::pair{contact.link_b, 1}, std::pair{contact.link_a, -1}}) {
        const int local = link - first;
        if (local < 0 || local >= static_cast<int>(beyond.size()) || !beyond[local]) continue;
        const Long3 F = Long(sign) * contact.F_BP_W.force.cast<Long>();
        sum.push -= F;
        sum.turn -= Long(sign) * contact.F_BP_W.torque.cast<Long>() + (contact.X_WP.p.cast<Long>() - a).cross(F);
      }
    }
    return sum;
  }

  /// About the sensor's origin, in W.
  Pair sensed(const std::string& name, const Body& body) const {
    const Wrench& F = world_.sensorReading(world_.sensorIndex(name)).F_S;
    return {body.R * F.torque.cast<Long>(), body.R * F.force.cast<Long>()};
  }

  /// Joint, children, contacts and weight of one link, as sensors say, against the change of its own momentum.
  void takeSum(std::size_t a, std::size_t l, const ArticulationDef& tree, const std::vector<Body>& start, const std::vector<Body>& end,
               const std::vector<Pair>& read, Errors& errors) const {
    if (tree.links[l].joint.type == JointType::kFloating && tree.links.size() == 1 && !touches(a)) return;  // it falls
    const Pair change = needed(tree, start, end, l, 0, true);
    Pair sum = read[l];
    Long push = sum.push.norm() + change.push.norm(), turn = sum.turn.norm() + change.turn.norm();
    const auto add = [&](const Pair& F, const Long3& arm, Long sign) {
      sum.push += sign * F.push, sum.turn += sign * (F.turn + arm.cross(F.push));
      push += F.push.norm(), turn += F.turn.norm() + arm.norm() * F.push.norm();
    };
    add(sensed("s" + std::to_string(a) + "_" + std::to_string(l) + "c", end[l]), Long3::Zero(), 1);
    for (std::size_t child = l + 1; child < tree.links.size(); ++child) {
      if (tree.links[child].parent == static_cast<int>(l) && tree.links[child].joint.type != JointType::kFloating) {
        add(read[child], end[child].p - end[l].p, -1);
      }
    }
    if (!(push > 0)) return;
    errors.sum = std::max(errors.sum, static_cast<double>((sum.push - change.push).norm() / push));
    // Torques over their own size and that of the forces at the link's reach: about its own middle a link may have hardly any.
    const Model& model = world_.model();
    const Long reach = model.links[model.link(static_cast<int>(a), static_cast<int>(l))].size;
    errors.sum_turn = std::max(errors.sum_turn, static_cast<double>((sum.turn - change.turn).norm() / (turn + reach * push)));
  }

  bool touches(std::size_t a) const {
    const int link = world_.model().link(static_cast<int>(a), 0);
    for (int c = 0; c < world_.contactCount(); ++c) {
      if (world_.contact(c).link_a == link || world_.contact(c).link_b == link) return true;
    }
    return false;
  }

  const World& world_;
  const WorldDef& def_;
  const State& before_;
};

Errors check(WorldDef def, int steps, const std::string& name) {
  def.pointers.clear();
  addSensors(def, false), addSensors(def, true);
  World world(def);
  Errors errors;
  for (int i = 0; i < steps; ++i) {
    const State before = world.state();
    world.step();
    if (!world.report().finite) throw SetupError(name, "became non-finite", "");
    errors.contacts += world.contactCount();
    StepCheck step(world, def, before);
    for (std::size_t a = 0; a < def.articulations.size(); ++a) {
      const ArticulationDef& tree = def.articulations[a];
      const bool free = tree.links.size() == 1 && tree.links[0].joint.type == JointType::kFloating;
      if (isKnown(tree) && !free) step.take(a, errors);
    }
  }
  std::printf("sensors of %s: %ld samples, %ld contacts, reaction %.2g, sum %.2g\n", name.c_str(), errors.samples, errors.contacts,
              errors.reaction, errors.sum);
  return errors;
}

/// Joints let go, as they start.
WorldDef loose(const std::string& file, double step) {
  SceneOptions options;
  options.default_density = 1000;
  options.missing = MissingMeshes::kBox;
  options.add_pointer = false;
  options.step = step;
  WorldDef def = loadScene(file, options).world;
  for (ArticulationDef& tree : def.articulations) {
    int i = 0;
    for (LinkDef& link : tree.links) {
      link.joint.drive = JointDef::Drive::kNone, link.joint.drive_stiffness = link.joint.drive_damping = 0;
      if (isScalar(link.joint.type) && link.joint.mimic_joint < 0) link.joint.velocity = 0.5 * std::sin(1.7 * ++i);
    }
  }
  return def;
}

struct KdlError {
  double difference = 0, size = 0;
};

/// Along the axes, against KDL in the middle of the step; without contacts, limits and followers.
KdlError againstKdl(const std::string& file, double h) {
  WorldDef def = loose(file, h);
  const auto unknown = [](const ArticulationDef& tree) { return !kdlKnows(tree); };
  def.articulations.erase(std::remove_if(def.articulations.begin(), def.articulations.end(), unknown), def.articulations.end());
  if (def.articulations.empty()) return {};
  def.articulations.resize(1);
  def.filters.clear(), def.pointers.clear(), def.joint_paths.clear(), def.loops.clear(), def.sensors.clear();
  ArticulationDef& tree = def.articulations[0];
  for (LinkDef& link : tree.links) {
    JointDef free;
    free.name = link.joint.name, free.type = link.joint.type, free.X_PJ = link.joint.X_PJ, free.axis = link.joint.axis;
    free.position = link.joint.position, free.velocity = link.joint.velocity;
    link.joint = free;
    link.collisions.clear();
  }
  addSensors(def, false);
  World world(def);
  KdlError worst;
  for (int i = 0; i < std::lround(0.05 / h); ++i) {
    const State before = world.state();
    world.step();
    const State& after = world.state();
    std::vector<double> q, v, v_dot;
    for (std::size_t k = 0; k < after.v.size(); ++k) {
      q.push_back(0.5 * (before.q[k] + after.q[k])), v.push_back(0.5 * (before.v[k] + after.v[k]));
      v_dot.push_back((after.v[k] - before.v[k]) / h);
    }
    const std::vector<Body> mid = bodies(tree, q.data(), v.data());
    const std::vector<double> forces = kdlInverseDynamics(tree, q, v, v_dot, def.settings.gravity);
    int degree = 0;
    for (std::size_t l = 0; l < tree.links.size(); ++l) {
      if (!isScalar(tree.links[l].joint.type)) continue;
      // A reading is in axes of the step's end; KDL's axes are those of the middle.
      const Pose X_WL = world.linkPose(static_cast<int>(l)), X_WM(mid[l].R.cast<double>(), mid[l].p.cast<double>());
      const Wrench F = world.sensorReading(static_cast<int>(l)).F_S.rotated(X_WL.R).shifted(X_WM.p - X_WL.p);
      const Vector3 axis = X_WM.R * tree.links[l].joint.axis;
      const double along = axis.dot(tree.links[l].joint.type == JointType::kPrismatic ? F.force : F.torque);
      worst.difference = std::max(worst.difference, std::abs(along - forces[degree]));
      // A free joint carries nothing along its axis: against what is across it.
      worst.size = std::max({worst.size, F.torque.norm(), std::abs(forces[degree])});
      ++degree;
    }
  }
  return worst;
}

/// A cube under gravity that pulls aside and a mass off its middle: how far the centre of pressure is from the line of the load [m].
double pressureError() {
  scenes::CubeParameters c;
  WorldSettings settings;
  settings.gravity = Vector3(1.2, -0.7, -9.8);
  WorldDef def = scenes::cubeOnFloor(c, settings);
  def.articulations[1].links[0].inertia.p_LC = Vector3(-0.015, 0.02, -0.01);
  World world(def);
  for (int i = 0; i < 20000; ++i) world.step();
  if (world.contactCount() != 1) return NAN;
  const Vector3 along = settings.gravity.normalized();
  const Vector3 off = centreOfPressure(world.contact(0)) - world.linkPose(1) * def.articulations[1].links[0].inertia.p_LC;
  return (off - along.dot(off) * along).norm();
}

/// Of the six axes of a coupling: how many pull a tool that stands aslant with their own stiffness, and no other does.
int couplingAxes() {
  const Matrix3 R = rotationAbout(Vector3(1, -2, 0.5).normalized(), 1.1);
  const Vector3 along(200, 120, 40), about(2, 0.8, 1.2);
  int good = 0;
  for (int axis = 0; axis < 6; ++axis) {
    WorldDef def;
    def.name = "tool";
    def.settings.gravity.setZero();
    def.settings.comparator = comparators::velocityVerlet;
    def.articulations.push_back(scenes::freeBody("tool", nullptr, 0.5, 2e-3 * Matrix3::Identity(), Pose(R, Vector3::Zero())));
    PointerDef pointer;
    pointer.articulation = pointer.link = 0;
    PointerCoupling& c = pointer.coupling;
    c.mode = PointerCoupling::Mode::kVirtual;
    c.stiffness = along.maxCoeff(), c.along_stiffness.share = along / c.stiffness;
    c.rotational_stiffness = about.maxCoeff(), c.about_stiffness.share = about / c.rotational_stiffness;
    c.damping = c.rotational_damping = 0;
    def.pointers.push_back(pointer);
    World world(def);
    constexpr double kAway = 1e-3;  // [m] or [rad]
    const Vector3 unit = R.col(axis % 3);
    world.setPointerTarget(0, axis < 3 ? Pose(R, kAway * unit) : Pose(rotationAbout(unit, kAway) * R, Vector3::Zero()), {});
    world.step();
    const Wrench F = -world.pointerWrench(0);
    const Vector3 force = axis < 3 ? Vector3(along[axis] * kAway * unit) : Vector3(Vector3::Zero());
    const Vector3 torque = axis < 3 ? Vector3(Vector3::Zero()) : Vector3(about[axis - 3] * kAway * unit);
    good += (F.force - force).norm() + (F.torque - torque).norm() < 1e-12;
  }
  return good;
}

}  // namespace

void measureSensors() {
  const std::string source = HAPTIC_SOURCE_DIR, robots = source + "/../shared/example-robot-data/robots/";
  Errors worst;
  const auto take = [&](const Errors& errors) {
    worst.reaction = std::max(worst.reaction, errors.reaction), worst.sum = std::max(worst.sum, errors.sum);
    worst.sum_turn = std::max(worst.sum_turn, errors.sum_turn);
    worst.samples += errors.samples, worst.contacts += errors.contacts;
  };
  std::vector<std::string> files = {source + "/urdf/scenes/panda_touch.yaml", source + "/urdf/scenes/allegro_grasp.yaml"};
  for (const char* name : {"panda_description/urdf/panda.urdf", "allegro_hand_description/urdf/allegro_right_hand.urdf",
                           "double_pendulum_description/urdf/double_pendulum.urdf"}) {
    files.push_back(robots + name);
  }
  KdlError coarse, fine;
  for (const std::string& file : files) {
    try {
      take(check(loose(file, 1e-3), 300, file));
      const KdlError once = againstKdl(file, 1e-3), halved = againstKdl(file, 5e-4);
      coarse.difference = std::max(coarse.difference, once.difference), fine.difference = std::max(fine.difference, halved.difference);
      coarse.size = std::max(coarse.size, once.size);
    } catch (const SetupError& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
  }
  figure("sensors.samples", static_cast<double>(worst.samples), "1");
  figure("sensors.contacts", static_cast<double>(worst.contacts), "1");
  figure("sensors.reaction_err_rel", worst.reaction, "1");
  figure("sensors.sum_err_rel", worst.sum, "1");
  figure("sensors.sum_torque_err_rel", worst.sum_turn, "1");
  figure("sensors.kdl_err_rel", coarse.difference / coarse.size, "1");
  figure("sensors.kdl_order", std::log2(coarse.difference / fine.difference), "1");
  figure("contacts.cop_err_m", pressureError(), "m");
  figure("coupling.axes", couplingAxes(), "1");
}

}  // namespace haptic::bench
