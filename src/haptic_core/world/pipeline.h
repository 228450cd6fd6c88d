/// One step of a world, stage by stage: pointers → kinematics → pairs → contact volumes → wrenches → motion.
#pragma once
#include <memory>
#include <vector>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/dynamics/tree_motion.h"
#include "haptic_core/geometry/broad_phase.h"
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/geometry/time_of_impact.h"
#include "haptic_core/world/features.h"
#include "haptic_core/stepping/implicit_step.h"
#include "haptic_core/world/joint_normals.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/plan.h"
#include "haptic_core/world/stability_number.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_history.h"
#include "haptic_core/world/step_report.h"
#include "haptic_core/world/tuning.h"

namespace haptic {

/// Bits of StepReport::flags.
enum StepFlag : unsigned {
  kPairsDropped = 1u << 0,     ///< more overlapping boxes than the plan's pair capacity: raise kNeighboursPerShape
  kContactsIncomplete = 1u << 1,  ///< a contact volume dropped faces; it still pushes
  kNormalRemembered = 1u << 2, ///< a contact without area vector used its last normal
  kNotConverged = 1u << 3,     ///< the implicit solve ended at `residual`: shorten the step
  kPressureClipped = 1u << 4,  ///< somewhere a damper would have pulled; the pressure was held at 0 there
  kTooFast = 1u << 7,          ///< a body moved farther than shapes are thick between two looks at its contacts
  kJointsNotConverged = 1u << 5,  ///< some joint's force is not what its law says: shorten the step
  kDamperLimited = 1u << 6,    ///< a damper was weakened to what the explicit step can take (damper_limit.h)
};

/// Shares of the bound of stability at which an island becomes implicit, and explicit again. The numbers are upper
/// bounds, up to twice what is; the margin is for patches that grow within a step.
constexpr double kEnterImplicit = 0.9, kLeaveImplicit = 0.7;

/// A contact of this step until its work is booked in the ledger.
struct ContactWork {
  int pair = -1;                       ///< index in the state's pairs
  Pose X_WP;
  Wrench F_BP_P, J_BP_P;               ///< force, and the impulse that corrects it, see LocatedForce
  double elastic_force = 0, elastic_impulse = 0;  ///< along n, by k Vol [N], [N·s]
  bool sticking = false;
  FrictionMemory before;               ///< at the last evaluation
  Twist V_AB_P;                        ///< at the end of the step
};

class Pipeline {
 public:
  explicit Pipeline(const WorldDef& def);  ///< throws SetupError

  void step() noexcept;  ///< (in realtime)
  void measureStages(bool on) noexcept;  ///< (in realtime)
  void setPointerTarget(int i, const Pose& X_WL, const Twist& V_WL) noexcept;  ///< (in realtime)
  void grab(int pointer, int link);        ///< throws SetupError when the link cannot be held
  bool canGrab(int pointer, int link) const noexcept;  ///< (in realtime)
  bool tryGrab(int pointer, int link) noexcept;        ///< (in realtime) false: it cannot be held
  void tune(const WorldTuning& tuning);    ///< throws SetupError; between two steps
  void restore(const std::vector<double>& packed);
  /// (in realtime) False, and nothing done: not finite, or the joint obeys no commands.
  bool setJointCommand(int joint, const JointCommand& command) noexcept;
  JointReading joint(int i) const noexcept;
  std::string text() const;                ///< the plan, and what of the joints is not simulated

  const WorldSettings& settings() const { return settings_; }
  const WorldTuning& tuning() const { return tuning_; }
  int pointerHome(int pointer) const {     ///< link that the scene gives the pointer
    return plan_.link(pointers_[pointer].articulation, pointers_[pointer].link);
  }
  const Plan& plan() const { return plan_; }
  const WorldState& state() const { return state_; }
  const StepReport& report() const { return report_; }
  const StepHistory& history() const { return *history_; }
  const LinkWork& link(int i) const { return work_[i]; }
  const LoadedVector<ContactReport>& contacts() const { return contacts_; }

 private:
  void substep(double h, double progress) noexcept;
  void movePointers(double progress) noexcept;
  void updateKinematics() noexcept;
  void prepareSearch();
  void placeAll() noexcept;
  void placeShape(int s, double h) noexcept;
  // swept_step.cpp
  bool anyFast(double left) const noexcept;
  double safePart(double left) noexcept;
  double safePart(int a, int b, double left) noexcept;
  ShapeMotion shapeMotion(int shape, double left, bool falls) const noexcept;
  void findBuried();
  void refuseStaticOverlaps();
  // island_step.cpp
  void substepImplicit(double h, double progress) noexcept;
  void stepIslands(double h) noexcept;
  bool fliesFreely(int tree) const noexcept;
  void aimCouplings() noexcept;
  void takeCouplings() noexcept;
  void takeContacts() noexcept;
  void lookForExplicit(const Island& island, double h, bool flies) noexcept;
  // automatic_step.cpp
  void substepAutomatic(double h, double progress) noexcept;
  bool anyImplicit() const noexcept;
  void keepForRetreat() noexcept;
  void retreat() noexcept;
  bool modesMeet() const noexcept;
  bool anyTooStiff() noexcept;
  void makeImplicit(bool by_numbers) noexcept;
  void measureStability(ActivePair& pair, const ContactVolume& volume, const PatchTangent& tangent, const Pose& X_WP,
                        double h) noexcept;
  void noteStability(ActivePair& pair, const ContactVolume& volume, const PatchTangent& tangent, const Pose& X_WP,
                     double h) noexcept;
  void countStability(const ActivePair& pair) noexcept;
  double couplingNumber(int link, double h) const noexcept;
  bool tooStiff(int link) const { return number_[link] > kEnterImplicit * kStabilityBound; }
  bool isImplicit(int tree) const { return state_.mode[tree] == kImplicit; }
  int treeOf(int shape) const { return plan_.links[plan_.shapes[shape].link].articulation; }
  void noteContact(int a, int b, const ContactVolume& volume, double normal_force, bool sticking,
                   const Pose& X_WP, const Wrench& F_BP_W) noexcept;
  void findPairs(double h) noexcept;
  void evaluateContacts(const Advance& advance) noexcept;
  void evaluatePair(int index, const Advance& advance) noexcept;
  void remember(const ContactVolume& volume, const Twist& V_AB_P, const Vector3& p_WP, const Wrench& F_BP_W,
                ReleaseMemory& release) noexcept;
  void addMobility(int link, const Pose& X_WP, Matrix6& W) const noexcept;
  LocatedForce settledForce(const ActivePair& pair, const ContactVolume& volume, const PairLaw& law,
                            const Pose& X_WP, const Twist& V_AB_P, const Advance& advance) noexcept;
  void part(const ActivePair& pair, const Advance& advance) noexcept;
  void addKick(int link_a, int link_b, const Wrench& J_W, const Vector3& p_W) noexcept;
  void pullPointers(double h) noexcept;
  void collectPointerWrenches() noexcept;
  // time_step.cpp
  void substepEuler(double h, double progress) noexcept;
  bool substepVerlet(double h, double progress) noexcept;
  void prime(double h) noexcept;
  void forgetPull() noexcept;
  bool evaluate(const Advance& advance, double h) noexcept;
  void meanOfKick() noexcept;
  void startFree(const PlanTree& body, double h) noexcept;
  void finishFree(const PlanTree& body, double h) noexcept;
  void readFree(const PlanTree& body, double* pull) const noexcept;
  void kickFree(const PlanTree& body, const double* pull, double dt) noexcept;
  void coastFree(const PlanTree& body, double h) noexcept;
  void eulerTree(const PlanTree& tree, double h) noexcept;
  void startTree(const PlanTree& tree, double h) noexcept;
  void finishTree(const PlanTree& tree, double h) noexcept;
  void readTree(const PlanTree& tree, double* pull) noexcept;
  void kickTree(const PlanTree& tree, const double* pull, double dt) noexcept;
  void coastTree(const PlanTree& tree, double h) noexcept;
  bool isFree(const PlanTree& tree) const noexcept { return !kFullWorld || (tree.model->isFreeBody() && !tree.has_laws); }
  bool movesByItself(const PlanTree& tree) const noexcept;
  bool isStepped(const PlanTree& tree) const noexcept;
  int indexOf(const PlanTree& tree) const noexcept { return static_cast<int>(&tree - plan_.trees.data()); }
  /// Of a mover: by the explicit scheme. Only the automatic choice mixes schemes.
  bool isExplicit(const PlanTree& mover) const noexcept { return !(kFullWorld && automatic_) || !isImplicit(indexOf(mover)); }
  // joint_step.cpp
  void makeMotions();
  void addJointPaths(const WorldDef& def);
  void followJointPaths() noexcept;
  void moveJointed(const PlanTree& tree, double h, const double* tau) noexcept;
  void gatherPull(const PlanTree& tree, double h) noexcept;
  const JointCommand* commandsOf(const PlanTree& tree) const { return state_.commands.data() + tree.command; }
  TreeMotion* motionOf(const PlanTree& tree) const { return motions_[indexOf(tree)].get(); }
  void checkFinite() noexcept;
  // ledger.cpp
  void keepLedger(int pair, const ContactVolume& volume, const PairLaw& law, const LocatedForce& force,
                  const Pose& X_WP, const FrictionMemory& before, FrictionMemory& now) noexcept;
  void closeLedger(const FrictionMemory& last, double h, double tau, double order) noexcept;
  Twist twistForWork(int link, const Vector3& p_W, double h) const noexcept;
  Twist relativeTwist(const ContactWork& work, double h) const noexcept;
  void setLinkVelocities(const std::vector<double>& v) noexcept;
  void book(const ContactWork& work, const ContactPower& taken) noexcept;
  void bookEuler(double h) noexcept;
  void bookVerlet(double h) noexcept;
  void notePowers(double h) noexcept;
  void fillLedger() noexcept;
  bool holds(int pointer) const;           ///< the hand prescribes the link's motion (direct coupling)
  int pointerCount() const noexcept { return kFullWorld ? static_cast<int>(pointers_.size()) : 0; }
  bool keepsLedger() const noexcept { return kFullWorld && settings_.energy_ledger; }
  /// Pointer that prescribes the link's motion; -1: none.
  int heldBy(int link) const noexcept { return kFullWorld ? held_by_[link] : -1; }
  void noteHolders() noexcept;
  void resolveCoupling(int i) noexcept;
  CouplingLoad loadOf(int link) const noexcept { return {plan_.links[link].mass, plan_.links[link].least_inertia}; }

  WorldSettings settings_;
  std::vector<PointerDef> pointers_;
  WorldTuning tuning_;
  Plan plan_;
  WorldState state_;
  StepReport report_;
  StageClock clock_;

  std::unique_ptr<StepHistory> history_;

  // Work of one step; nothing here outlives it.
  std::vector<LinkWork> work_;                     ///< by world link index
  std::vector<Pose> X_WS_;                         ///< by shape
  std::vector<ConvexPolyhedron::Box> boxes_;
  std::unique_ptr<BroadPhase> broad_phase_;
  ContactWorkspace workspace_;
  JointNormals joint_normals_;
  std::unique_ptr<ImplicitStep> implicit_;         ///< null: explicit
  struct JointPath {
    std::vector<int> commands;                     ///< by column: index in the state's commands
    std::vector<double> time, position;
  };
  std::vector<JointPath> joint_paths_;
  std::vector<std::unique_ptr<TreeMotion>> motions_;  ///< by tree; null: joints without laws of their own
  std::unique_ptr<Islands> islands_;               ///< with `implicit_`
  bool automatic_ = false;
  std::vector<double> number_;                     ///< stability numbers by link, see stability_number.h
  struct {
    std::vector<double> q, v, pull;
    double energy[4];
    int pair_count;
    unsigned flags;
  } retreat_;                                      ///< the state before an explicit attempt
  std::vector<double> least_width_;                ///< by link: of its shapes and all that they may meet [m]
  struct MotionLimit {
    int link;
    double way2, lever2;                           ///< squares: way that needs no sweep, lever that turns count with [m²]
  };
  std::vector<MotionLimit> motion_limits_;         ///< of the links that move
  std::vector<ActivePair> previous_pairs_;
  std::vector<double> v_dot_, half_, alone_;       ///< by world velocity index
  std::vector<double> coasting_;                   ///< stages of stepRungeKutta
  std::vector<Wrench> no_wrench_;                  ///< zeros, by local link
  std::vector<Wrench> kick_;                       ///< by world link index, about O [N·m·s, N·s]
  bool has_kick_ = false;
  std::vector<int> held_by_;                       ///< by world link index
  std::vector<const PlanTree*> free_movers_, jointed_movers_;  ///< trees that no hand holds and that are not fixed
  std::vector<int> contacts_on_;                   ///< by world link index: contacts that touched in the last step
  double share_ = 1;                               ///< of a substep that the present part of it is
  std::vector<Wrench> pointer_wrench_;             ///< summed over the substeps
  std::vector<Twist> pointer_moved_;               ///< displacement in this substep: [rad], [m]
  LoadedVector<ContactReport> contacts_;
  LoadedVector<ContactWork> works_;                ///< of the explicit contacts, while the ledger is kept
};

}  // namespace haptic
