/// The world compiled from its definition: all that can ever happen, and so all that a step may have to do. Constant while a step
/// runs; `tuning` changes between two steps.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptic_core/contact/friction.h"
#include "haptic_core/dynamics/articulation.h"
#include "haptic_core/dynamics/force_kinds.h"
#include "haptic_core/dynamics/ring.h"
#include "haptic_core/geometry/search/box_tree.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/world/counted_work.h"
#include "haptic_core/world/definition.h"
#include "haptic_core/world/drive_paths.h"
#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/tuning.h"

namespace haptic {

/// A link of a compiled world.
struct ModelLink {
  std::string name;                 ///< as messages call it
  int articulation = 0, local = 0;  ///< which of `trees`, and which link in it
  double mass = 0;                  ///< [kg]
  double least_inertia = 0;         ///< smallest principal one about the centre of mass [kg·m²]
  double size = 0;                  ///< reach of its shapes from the centre of mass [m]; 1 m without shapes
  double section = 0;               ///< largest side of the box around its shapes [m²]: no patch is larger
  bool moves = false;               ///< has a degree of freedom of its own or of an ancestor
  bool led = false;                 ///< along a motion of the scene: nothing pushes it
};

/// A collision shape of a compiled world.
struct ModelShape {
  const ConvexShape* shape = nullptr;        ///< never null
  std::shared_ptr<const ConvexShape> owner;  ///< keeps it alive
  int link = 0;                     ///< world link index
  int material = 0;                 ///< index into the distinct materials
  Pose X_LS;                        ///< where it lies in its link
  double width = 0;                 ///< least width of the shape [m]
  double look = 0;                  ///< its half of a look at a pair (counted_work.h) [units]
  std::string name;                 ///< as messages call it
  InnerFaces inner;                 ///< what pieces of the same body cover of it
  std::vector<int> surface;         ///< by face: number of the flat surface that neighbours continue; -1, or empty: none
  SurfaceVelocity belt;             ///< of a belt
};

/// One articulation of the definition, or several that loops hold together: one model of several roots.
struct ModelTree {
  std::shared_ptr<const Articulation> model;  ///< never null; it never changes
  int q = 0, v = 0, link = 0;       ///< first index of the tree in the world's q, v and links
  int shape = 0, shape_end = 0;     ///< its shapes: from, up to
  int command = 0;                  ///< first of its joints' commands, one per link; none unless `has_laws`
  bool has_laws = false;            ///< joints do something by themselves, or loops close: TreeMotion moves it
  std::vector<RingDef> rings;       ///< its loops
};

/// A joint of one degree of freedom.
struct ModelJoint {
  std::string name;                 ///< as messages call it
  int link = 0;                     ///< world link that hangs on it
  int q = 0, v = 0;                 ///< its degree in the world's q, v
  bool driven = false;              ///< obeys commands
};

/// A force element of a compiled world (link_forces.h).
struct ModelForce {
  std::string name;                 ///< for messages
  ForceType type{};  ///< its kind
  int link_a = -1, link_b = -1;     ///< world link indices; link A −1: W
  int tree_a = -1, tree_b = -1;     ///< of these in `trees`; −1: W, or it never moves
  Vector3 p_A = Vector3::Zero(), p_B = Vector3::Zero();  ///< points, in A and in B [m]
  double parameter[kMostForceParameters] = {};           ///< by index, in the kind's units
};

/// Most steps that an island may be left for, WorldSettings::far_step over h: 10 ms at 10 kHz.
inline constexpr int kMostTurnSteps = 100;
/// Length from which on a part of an island's step that does not converge is done in halves [s]. A step may work as long as the time that
/// it stands for: a loop at 1 kHz and faster keeps the bound of one attempt, one of 10 ms has time for eight parts. No island is left for
/// as long: its turn is one part. Shorter: ticks at 1 kHz may take twice as long; longer: heaps at 3 ms are left unconverged.
inline constexpr double kWorthHalving = 2e-3;

/// A compiled scene: what every stage of a step reads and none changes.
class Model {
 public:
  /// Checks the definition and compiles it. Throws SetupError that names link, parameter and value.
  explicit Model(const WorldDef& def);

  /// Whether shapes a < b are ever tested: on different links, not both fixed, not neighbours, not filtered.
  bool mayCollide(int a, int b) const;
  /// Law of a pair of shapes; the reduced mass is the pair's, infinite masses for fixed and hand-moved links.
  PairLaw law(int a, int b, bool a_held, bool b_held) const;
  /// Between two steps: checked against the couplings' loads by the caller. No allocation.
  void tune(const WorldTuning& tuning);

  /// The faces of two shapes that are no surface of their bodies.
  InnerSides inner(int a, int b) const {
    const auto of = [this](int s) { return shapes[s].inner.covers.empty() ? nullptr : &shapes[s].inner; };
    return {of(a), of(b)};
  }
  /// Whether two shapes of one body share a face.
  bool areNeighbours(int a, int b) const;

  /// Depth from which a pair that overlaps at the start counts as buried, and how it is then pushed out [m].
  /// `area` [m²] of the patch: at a depth that carries twice all that moves nothing is buried.
  double buriedDepth(int a, int b, double area) const;
  /// See `buriedDepth`.
  PairLaw recoveryLaw(const PairLaw& law, int a, int b, const ContactVolume& volume) const;

  /// Makes room for every pair of the shapes.
  void reserve(ContactWorkspace& workspace) const;

  /// Work of a look at a pair, its share of common normals included [units].
  double look(int a, int b) const { return shapes[a].look + shapes[b].look + (has_seams ? units::kSeams : 0); }

  /// World link of a link of the definition.
  int link(int articulation, int local) const { return first_link_[articulation] + local; }
  /// Whether the definition has that link.
  bool hasLink(int articulation, int local) const;

  int articulationCount() const { return static_cast<int>(first_link_.size()); }  ///< of the definition
  int linkCount(int articulation) const { return link_count_[articulation]; }     ///< of an articulation of the definition

  int treeOf(int shape) const { return links[shapes[shape].link].articulation; }  ///< index in `trees`
  /// Of one of `trees`.
  int indexOf(const ModelTree& tree) const { return static_cast<int>(&tree - trees.data()); }
  /// One body on a floating joint, with nothing but inertia, gravity and wrenches.
  bool isFree(const ModelTree& tree) const { return tree.model->isFreeBody() && !tree.has_laws; }
  /// The hand prescribes the motion of the pointer's link (direct coupling).
  bool holds(int pointer) const { return tuning.coupling[pointer].mode == PointerCoupling::Mode::kDirect; }
  /// Who may lead a link: the pointers, then the motions.
  int leads() const { return static_cast<int>(pointers.size() + motions.size()); }
  /// Link that the scene gives the pointer.
  int pointerHome(int pointer) const { return link(pointers[pointer].articulation, pointers[pointer].link); }
  /// X_LP: the pointer's frame in the link that it moves, of a body that it has grabbed the link's own.
  Pose pointerFrame(int pointer, int link) const { return link == pointerHome(pointer) ? pointers[pointer].X_LP : Pose(); }
  /// The mass and inertia that a virtual coupling would have to move there.
  CouplingLoad loadOf(int link) const { return {links[link].mass, links[link].least_inertia}; }

  std::string text() const;         ///< for people: sizes, stages, those left out and why

  std::string name;                  ///< of the scene
  WorldSettings settings;            ///< as defined; gravity as tuned
  std::vector<PointerDef> pointers;  ///< as defined
  WorldTuning tuning;                ///< what may change between two steps

  std::vector<ModelTree> trees;    ///< articulations; those that loops join are one tree
  std::vector<ModelLink> links;    ///< by world link index
  std::vector<ModelShape> shapes;  ///< by link
  std::vector<ModelJoint> joints;  ///< of one degree of freedom
  /// In the order of State.
  std::vector<double> q_start, v_start;  ///< initial state
  int nq = 0, nv = 0, commands = 0;      ///< sizes of q, of v, and of the commands
  int pair_capacity = 0;            ///< pairs of overlapping boxes that a step can hold
  long possible_pairs = 0;          ///< pairs that may ever touch; the others are never tested
  std::vector<ModelForce> forces;      ///< elements between two links, or a link and W
  /// Elements with an end on a tree that moves, ascending by tree, and where those of each tree begin; both empty where there are none.
  std::vector<int> tree_forces, first_tree_force;
  std::vector<DrivePath> drive_paths;  ///< of the definition
  std::vector<ModelMotion> motions;    ///< of the definition
  bool has_seams = false;           ///< pieces of a body are flush somewhere (seams.h)
  bool has_belts = false;           ///< some shape has a surface that moves
  double belt_speed = 0;            ///< bound of the speed of any of them [m/s]
  std::vector<double> least_width;  ///< by link: of its shapes and all that they may meet [m]; infinite: meets nothing
  std::vector<double> own_width;    ///< by link that moves: of its shapes alone [m]; infinite: it has none
  double fixed_width = std::numeric_limits<double>::infinity();  ///< of the shapes that never move [m]
  /// What there is in this world at all.
  bool has_contacts = false, has_joints = false, has_friction = false;

  // The trees and shapes that a step visits. In the general pipeline (`WorldSettings::leave_out` false) everything; else what can change.
  std::vector<int> updated_trees;   ///< kinematics is computed every step: all but the fixed ones
  std::vector<int> updated_shapes;  ///< pose and box are computed every step: on links that move
  /// Shapes on links that move, and all others, ascending; and a tree of the latter's boxes, numbered as in `fixed_shapes`.
  std::vector<int> moving_shapes, fixed_shapes;
  BoxTree fixed_boxes;              ///< see above; in W
  bool implicit_steps = true;       ///< islands are solved where they do not flow
  bool allFlows() const { return !settings.comparator && !implicit_steps; }  ///< nothing can touch or pull at anything
  bool searches_pairs = true;       ///< false: nothing can ever touch
  int turn_steps = 1;               ///< steps between two turns of an island that is far (stepping/own_rate.h); 1: none is
  /// A few pairs are tested box against box, in the order of their keys, without sorting anything; empty: sweep.
  std::vector<std::pair<int, int>> listed_pairs;

 private:
  void stiffenRigid(int a, int b, PairLaw& law) const;
  void addTrees(const WorldDef& def);
  void addTree(const WorldDef& world, const std::vector<int>& articulations);
  void addLink(const LinkDef& link, int local, const WorldDef& world);
  void addJoints(const ModelTree& tree);
  void addLoops(const WorldDef& def);
  void checkPointers(const WorldDef& def) const;
  void addMaterials(const WorldDef& def);
  void addFilters(const WorldDef& def);
  void addForces(const WorldDef& def);
  void sortShapes();
  void findInternalFaces();
  void countPairs();
  int fixedNeighbours() const;
  int fixedWithin(double width) const;
  void chooseVisits();
  void measureWidths();
  void checkSettings() const;

  void addMotions(const WorldDef& def);

  std::vector<ContactMaterial> materials_;
  std::vector<PairLaw> defined_laws_;         ///< by material index a·n + b
  std::vector<PairLaw> laws_;                 ///< the same, scaled
  std::vector<std::uint64_t> excluded_;       ///< link pairs, sorted
  std::vector<std::uint64_t> neighbours_;     ///< shape pairs, sorted
  std::vector<int> first_link_, link_count_;  ///< by articulation of the definition
  std::vector<Pose> X_WF_;                    ///< of `fixed_shapes`
};

}  // namespace haptic
