/// Definition of a world by its user. Constant while it runs; checked by `World`'s constructor.
#pragma once
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/contact/contact_material.h"
#include "haptic_core/contact/friction.h"
#include "haptic_core/dynamics/articulation_def.h"
#include "haptic_core/dynamics/force_kinds.h"
#include "haptic_core/dynamics/ring.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/attempts.h"
#include "haptic_core/world/comparator.h"
#include "haptic_core/world/sensor_def.h"

namespace haptic {

class ContactWorkspace;
class ConvexShape;

/// How a surface moves over its shape, as that of a conveyor belt does: in the link's frame, at its origin. A contact is told of the part
/// in its plane; what presses on the end of a belt is not lifted.
struct SurfaceVelocity {
  Twist V_L;                                      ///< angular [rad/s], linear [m/s]

  bool moves() const { return !V_L.angular.isZero(0) || !V_L.linear.isZero(0); }  ///< not still

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.V_L);
  }
};

/// A collision shape on a link, with the material of its surface.
struct CollisionDef {
  std::string name;                               ///< for messages and reports
  std::shared_ptr<const ConvexShape> shape;       ///< shared between links that repeat it
  Pose X_LS;                                      ///< shape frame in the link frame
  ContactMaterial material;  ///< NaN fields are taken from the other surface, or the world's default
  std::string material_source;                    ///< where the values came from, for the plan's listing
  SurfaceVelocity belt;                           ///< still, or a belt

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.shape), visit(s.X_LS), visit(s.material), visit(s.belt);  // names and sources move nothing
  }
};

/// A link that a fixed joint holds on another one and that was merged into it at load.
struct MergedLink {
  std::string name;                         ///< as the file called it
  Pose X_LM;                                ///< its frame in the link it was merged into
};

/// A body on its joint, with what collides.
struct LinkDef : BodyDef {
  std::vector<CollisionDef> collisions;     ///< may be empty: a link that touches nothing
  std::vector<MergedLink> merged;           ///< links fixed to this one, for names and frames

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    BodyDef::eachField(s, visit);
    visit(s.collisions);
  }
};

/// A tree of links. A free body is one link on a floating joint, a static body one on a fixed joint.
struct ArticulationDef {
  std::string name;                         ///< for messages
  std::vector<LinkDef> links;               ///< parents before children
  Pose X_WA;                                ///< initial pose of the frame A that root joints are given in
  Twist V_WA;                               ///< initial twist of a floating root, at A's origin, in W

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.links), visit(s.X_WA), visit(s.V_WA);
  }
};

/// The part of an articulation that dynamics compiles.
inline TreeDef treeOf(const ArticulationDef& def) {
  return {def.name, std::vector<BodyDef>(def.links.begin(), def.links.end()), def.X_WA, def.V_WA};
}

/// Two frames held together on top of the trees: a ring. Articulation −1: a frame in W. Trees that it joins become one.
struct LoopDef {
  std::string name;  ///< for messages
  /// Links by articulation and their index in it; articulation −1: the frame is fixed in W.
  int articulation_a = -1, link_a = -1, articulation_b = -1, link_b = -1;
  /// Frame F in each of the links, or in W.
  Pose X_AF, X_BF;                          ///< where the frames lie in the links
  using Type = RingDef::Type;               ///< point, hinge or weld
  Type type = Type::kPoint;                 ///< part of the frames that is held together
  Vector3 axis = Vector3::UnitZ();          ///< of a hinge, in F

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.articulation_a), visit(s.link_a), visit(s.articulation_b), visit(s.link_b), visit(s.X_AF);
    visit(s.X_BF), visit(s.type), visit(s.axis);
  }
};

/// Positions that drives are asked for over time: straight lines between the rows, the first row before them. After the
/// last one the drives keep it until they are told otherwise.
struct JointPathDef {
  std::string name;                         ///< the file's name, for messages
  std::vector<std::pair<int, int>> joints;  ///< articulation and link, a column each
  std::vector<double> time;                 ///< of the rows [s], rising
  std::vector<double> position;             ///< rows × columns [rad] or [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.joints), visit(s.time), visit(s.position);
  }
};

/// Of a value that is the greatest of three along axes: what each axis has of it, in [0, 1] [1].
struct AxisShares {
  Vector3 share = Vector3::Ones();          ///< along x, y and z
  /// As a matrix in the frame that R turns the axes into; equal ones give the identity itself, to the last bit.
  Matrix3 in(const Matrix3& R) const {
    if ((share.array() == 1).all()) return Matrix3::Identity();
    return R * share.asDiagonal() * R.transpose();
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.share);
  }
};

/// A body whose motion is given: it pushes and carries, and nothing pushes it (world/led_motion.h). With rows it runs along them from
/// the world's time 0 on; without it is told pose by pose while it runs.
struct MotionDef {
  std::string name;                         ///< for messages, and for who tells it poses
  int articulation = -1, link = -1;         ///< a free body of one link
  std::vector<double> time;                 ///< of the rows [s], rising
  std::vector<Pose> pose;                   ///< X_WL by row; turns of at most 3 rad from row to row
  bool repeat = false;                      ///< the last row is the first one again

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.articulation), visit(s.link), visit(s.time), visit(s.pose), visit(s.repeat);
  }
};

/// How a pointer follows the hand. Direct: its pose is the hand's and the contact wrench goes to the hand (the
/// seeds' way). Virtual: it is a body with inertia on a spring-damper, whose wrench goes to the hand.
struct PointerCoupling {
  /// How the hand reaches the link: by setting its motion, or by pulling at it with a spring and damper.
  enum class Mode : unsigned char { kDirect, kVirtual } mode = Mode::kDirect;
  /// Virtual: a stiffness or damping of this value is derived from the link and the step, see world/tuning.h.
  static constexpr double kDerived = -1;
  double stiffness = kDerived;              ///< [N/m]
  double damping = kDerived;                ///< [N·s/m]
  double rotational_stiffness = kDerived;   ///< [N·m/rad]
  double rotational_damping = kDerived;     ///< [N·m·s/rad]
  /// The four are those of the axis that has most; bounds on them hold for all axes.
  AxisShares along_stiffness, along_damping, about_stiffness, about_damping;  ///< of each axis
  /// Whose axes those are: the link's, which turn with the tool, or the grip's, as the hand wants the link to stand.
  enum class Axes : unsigned char { kLink, kGrip } axes = Axes::kLink;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.mode), visit(s.stiffness), visit(s.damping), visit(s.rotational_stiffness);
    visit(s.rotational_damping), visit(s.along_stiffness), visit(s.along_damping), visit(s.about_stiffness);
    visit(s.about_damping), visit(s.axes);
  }
};

/// The frame of a link that a hand moves.
struct PointerDef {
  std::string device = "spidar";            ///< name of the device that drives it
  int articulation = -1, link = -1;         ///< the link
  PointerCoupling coupling;                 ///< how it follows the hand
  Pose X_LP;                                ///< the pointer's frame P in the link: where the named frame is that was merged into it
  std::string name;                         ///< of that frame; empty: the link's

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.articulation), visit(s.link), visit(s.coupling), visit(s.X_LP);
  }
};

/// Set-up of another way to step worlds of a model (world/comparator.h).
using MakeComparator = std::unique_ptr<Comparator> (*)(const Model& model);

/// Step, gravity and methods of a world.
struct WorldSettings {
  double step = 1e-3;                       ///< h [s], fixed; 0 < h ≤ 0.1
  Vector3 gravity = Vector3(0, 0, -9.8);    ///< [m/s²] in W
  PressureLaw pressure_law = PressureLaw::kHuntCrossley;  ///< which damper the normal pressure has
  /// Where an implicit solve ends, as a share of the step's own error (stage_passes.h). 0: at rounding, for references.
  double tolerance = 1e-2;
  /// Error of position that a step may add, over the way that gravity and its change of speed move a body in it [1]; 0 < accuracy ≤ 1.
  /// Smaller: more second order and sub-steps, as far as the budget of a step lasts (stepping/implicit_step.h).
  double accuracy = 0.03;
  /// Step of islands that no hand touches or can reach before their next one [s], rounded to steps of h; 0: all are stepped by h. Up to
  /// kMostTurnSteps h and below kWorthHalving, in worlds with hands, large enough for islands to sleep (stepping/own_rate.h).
  double far_step = 0;
  bool energy_ledger = true;                ///< false: no energies are booked or reported, which costs less; the motion is the same
  int history_steps = 1000;                 ///< last steps kept to look back on (world/step_history.h); 0…100000
  ContactMaterial default_material;         ///< for pairs where neither surface gives a value; unset: `DefaultMaterial`

  // For tests, benches and the report, which compare the one method with others. No file of a scene and no binding reaches them.
  Attempts attempts = Attempts::kAll;                  ///< that a step is chosen from, island by island
  MakeComparator comparator = nullptr;                 ///< null: the attempts above
  bool torsional_friction = true;                      ///< false: patches resist sliding, not spinning (an ideal pivot)
  bool leave_out = true;                               ///< false: the general pipeline; bit-identical

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    // Neither the history nor leaving out changes a bit, and no file knows a comparator.
    visit(s.step), visit(s.gravity), visit(s.attempts), visit(s.pressure_law), visit(s.torsional_friction);
    visit(s.energy_ledger), visit(s.default_material), visit(s.tolerance), visit(s.accuracy), visit(s.far_step);
  }
};

/// A pair of links that shall not collide.
struct CollisionFilter {
  /// The two links, by articulation and index in it.
  int articulation_a = -1, link_a = -1, articulation_b = -1, link_b = -1;

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.articulation_a), visit(s.link_a), visit(s.articulation_b), visit(s.link_b);
  }
};

/// A whole scene as a user defines it: what World is made from.
struct WorldDef {
  std::string name;                            ///< for messages
  WorldSettings settings;                      ///< step, gravity, methods
  std::vector<ArticulationDef> articulations;  ///< all bodies
  std::vector<LoopDef> loops;                  ///< closed on top of the trees
  std::vector<ForceDef> forces;                ///< springs between links, fields: dynamics/force_kinds.h
  std::vector<JointPathDef> joint_paths;       ///< of drives, over time
  std::vector<MotionDef> motions;              ///< of bodies that are led along them
  std::vector<PointerDef> pointers;            ///< links that hands move
  std::vector<CollisionFilter> filters;        ///< pairs that shall not collide
  std::vector<SensorDef> sensors;              ///< they move nothing, and are in no field

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.settings), visit(s.articulations), visit(s.loops), visit(s.joint_paths), visit(s.motions), visit(s.pointers);
    visit(s.filters), visit(s.forces);
  }
};

}  // namespace haptic
