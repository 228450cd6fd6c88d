/// A world of articulated bodies in contact, stepped at a fixed rate.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/dynamics/link_force.h"
#include "haptic_core/world/definition.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/sensor_def.h"
#include "haptic_core/world/tuning.h"

namespace haptic {

class Model;
class StepHistory;
struct AppliedWrench;
struct LinkWrench;
struct ModelMotion;
struct MotionPoint;
struct State;
struct Work;

class NextWorld;

/// A world of bodies, joints, contacts and hands, stepped at a fixed rate. Not safe from several threads at
/// once; a tick never throws or allocates.
class World {
 public:
  explicit World(const WorldDef& def);    ///< compiles the plan; throws SetupError
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// (in realtime) Advances by settings().step.
  void step() noexcept;

  /// (in realtime) Times of the stages in the report from the next step on. Off at first: costs as much as the clock's calls.
  void measureStages(bool on) noexcept;

  const WorldSettings& settings() const;  ///< as compiled; constant but for gravity, see WorldTuning
  const StepReport& report() const;       ///< of the last step
  double time() const;                    ///< simulated [s]

  int linkCount() const;                              ///< links of all articulations
  const std::string& linkName(int link) const;        ///< as messages call it
  int linkIndex(const std::string& name) const;       ///< -1 when there is none
  Pose linkPose(int link) const;                      ///< X_WL
  Twist linkTwist(int link) const;                    ///< V_WL at the link frame's origin, in W
  bool stands(int link) const noexcept;               ///< its island is at rest: left out until something comes near

  int jointCount() const;                 ///< joints of one degree of freedom
  const std::string& jointName(int joint) const;      ///< as files call it
  int jointIndex(const std::string& name) const;      ///< -1 when there is none
  int jointLink(int joint) const;                     ///< the link that hangs on it
  JointReading joint(int joint) const noexcept;       ///< as the last step left it
  bool obeysCommands(int joint) const;                ///< it has a drive, or gains for one, and follows no other
  /// (in realtime) Command of the joint's drive from the next step on; part of the state. False, and nothing done: not
  /// finite, or the joint obeys no commands.
  bool setJointCommand(int joint, const JointCommand& command) noexcept;

  /// Between two steps: a wrench on a link from the next step on, for a time [s] of whole steps, at least one; 0 s ends all that act
  /// on the link. Part of the state. Throws SetupError: no such link, a link that nothing pushes (fixed, in a hand, on a motion), numbers
  /// that are not finite, more than kMostWrenches at once, a wrench that moves the link by its size, or turns it by a radian, in a step.
  void applyWrench(int link, const LinkWrench& wrench, double seconds);
  int wrenchCount() const;                            ///< wrenches that act in the next step
  const AppliedWrench& wrench(int i) const;           ///< i < wrenchCount()

  /// Between two steps: puts a body somewhere, with this twist at its link frame's origin, in W. What its contacts remember is gone;
  /// where it lies deep in others they part slowly, as at the start. Throws SetupError: the link hangs on joints or is led.
  void setBodyPose(int link, const Pose& X_WL, const Twist& V_WL);
  /// The same for joints, by index, at rest [rad] or [m]; loops and followers close from there. Throws SetupError, and nothing has moved:
  /// no such joint, a follower, a position beyond its limits, loops that do not close, a tree that a pointer leads.
  void setJointPositions(const std::vector<std::pair<int, double>>& positions);

  int forceCount() const;                             ///< force elements: one of a definition, or one for each link that moves
  const std::string& forceName(int i) const;          ///< of the definition; of element i < forceCount()
  LinkForce force(int i) const noexcept;              ///< (in realtime) the element's force between the last step and the next

  int motionCount() const;                            ///< of the definition
  const ModelMotion& motion(int i) const;             ///< name and link
  int motionIndex(const std::string& name) const;     ///< -1 when there is none
  /// (in realtime) The body of motion i goes to this point and arrives after `seconds`, at least a step. False: it follows a path, or
  /// a number is not finite.
  bool leadBody(int i, const MotionPoint& to, double seconds) noexcept;
  /// (in realtime) The same where another program tells the poses, which may jump: without a jump of the body (led_motion.h, approachTo).
  bool followBody(int i, const MotionPoint& to, double seconds) noexcept;

  int pointerCount() const;                ///< of the definition
  const PointerDef& pointer(int i) const;  ///< of the definition
  int pointerLink(int i) const;            ///< world link index of pointer i; `grab` changes it
  Pose pointerPose(int i) const;           ///< X_WP: of its frame, the link's own where it has grabbed another link
  /// (in realtime) Where the hand wants the pointer's frame at the end of the next step, and how its origin moves there.
  void setPointerTarget(int i, const Pose& X_WP, const Twist& V_WP) noexcept;
  /// (in realtime) What pointer i's hand bears, from the next step on: stiffer contacts are weakened (hand_bound.h), and the
  /// link stays behind its target where it would press harder (held_proxy.h). Infinite at first. Not part of the state: who
  /// moves the pointer says it before each step.
  void setPointerBound(int i, const PointerBound& bound) noexcept;
  const PointerBound& pointerBound(int i) const noexcept;  ///< as it was told
  /// (in realtime) Stiffness [N/m] that the hand on pointer i would meet after the last step if nothing were weakened.
  double pointerStiffness(int i) const noexcept;
  /// (in realtime) Wrench of the world on pointer i in the last step, about its frame's origin, in W.
  Wrench pointerWrench(int i) const noexcept;
  /// (in realtime) Estimate of the last step of the error of that force, by its own change within the step [N]. See `ErrorEstimator` for
  /// one that steps anew.
  double pointerForceError(int i) const noexcept;
  void grab(int pointer, int link);                   ///< makes another link the pointer from the next step on
  int pointerHome(int i) const;                       ///< link that the scene gives pointer i
  bool canGrab(int pointer, int link) const noexcept; ///< (in realtime) a link that moves freely, not held by another
  bool tryGrab(int pointer, int link) noexcept;       ///< (in realtime) `grab`; false: it cannot be held

  const WorldTuning& tuning() const;                  ///< what may change while running; a reset keeps it
  void tune(const WorldTuning& tuning);               ///< between two steps; throws SetupError

  int contactCount() const;                   ///< of the last step
  const ContactReport& contact(int i) const;  ///< i < contactCount()

  int sensorCount() const;                    ///< of the definition
  const SensorDef& sensor(int i) const;       ///< of the definition
  int sensorIndex(const std::string& name) const;      ///< -1 when there is none
  const SensorReading& sensorReading(int i) const;     ///< the last sample; not part of the state, a restore takes it away

  /// The last settings().history_steps steps that were finite, newest last; also after the world has stopped.
  const StepHistory& history() const;

  // The structs behind, for analysis and tests: what World's functions above read and write.
  const Model& model() const;  ///< constant but for its tuning
  const State& state() const;  ///< between two steps
  const std::vector<double>& q() const;  ///< State::q
  const std::vector<double>& v() const;  ///< State::v
  const Work& work() const;    ///< scratch: means something only right after a step

  /// (in realtime) Between two steps: goes on as the world that `next` was made of, with the state of what stays; `next` then holds the
  /// old one, to be destroyed where that takes time. Indices of links, joints and shapes are those of the new definition from now on.
  /// False, and nothing done: `next` was made of another world, or before another exchange.
  bool exchange(NextWorld& next) noexcept;
  /// (in realtime) Between two steps, in some tick before: goes through the exchange, and with `steps` the step after it, on the new world
  /// alone, which then stands at its start again. Brings it into this processor's caches: the exchange itself costs a third then.
  void rehearse(NextWorld& next, bool steps) noexcept;

  std::uint64_t hash() const;                         ///< of the complete state
  std::vector<double> save() const;                   ///< complete state, contact memory included
  void restore(const std::vector<double>& state);     ///< throws SetupError when it is of another world, or damaged
  std::string planText() const;                       ///< the features left out, and why

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The next form of a running world: compiled, with all of its storage, in any thread while the world goes on (world/carry_over.h).
class NextWorld {
 public:
  /// Set-up. `kept`: by articulation of `def`, which one of the running world's definition it is; −1: it comes. Kept ones stay in order.
  /// Reads values of `running` that no step changes. Throws SetupError: `def` is refused, or is not the running world with other bodies.
  NextWorld(const World& running, const WorldDef& def, const std::vector<int>& kept);
  ~NextWorld();
  const std::vector<double>& start() const;     ///< state in which a world of the new definition begins: World::save()
  std::size_t stateCapacity() const;            ///< numbers that its greatest state has
  /// Between two ticks of `running`: throws SetupError where a hand holds a link that goes, or that a motion then leads.
  void refuseHeld(const World& running) const;
  int linkNow(int link_before) const noexcept;  ///< (in realtime) new world index of a link of the running world; −1: it goes

 private:
  friend class World;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic
