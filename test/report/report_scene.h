/// A scene of the report: how it is made for a method, who pulls, and where its bodies exactly are.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/world/definition.h"
#include "peer_world.h"

namespace haptic::report {

/// What the user of a simulator chooses. Peers know `step` alone: their contact parameters are their own.
struct Choice {
  Attempts attempts = Attempts::kAll;
  MakeComparator comparator = nullptr;
  double step = 1e-3;    ///< [s]
  double accuracy = WorldSettings{}.accuracy;  ///< that a step is asked for (world/definition.h) [1]
  double stiffness = 0;  ///< foundation k [N/m³]; 0: the scene's own
  bool rigid = false;    ///< all surfaces are said to be rigid (penalty_sim/scene/stiffness_choice.h), whatever the scene says
  bool leave_out = true;  ///< false: the general pipeline, which visits everything in every step
  int facets = 0;        ///< of round bodies (0…6, subdivisions or doublings); 0: the scene's own, true balls
};

struct BodyState {
  Pose X_WL;
  Twist V_WL;  ///< at L's origin, in W
};

/// A hand on a spring and a damper: its wrench is the haptic one. `path` gives its position and velocity.
struct HandSpring {
  int link = -1;                ///< world link index
  double stiffness = 0;         ///< [N/m]
  double damping = 0;           ///< [N·s/m]
  double rotational_stiffness = 0, rotational_damping = 0;  ///< [N·m/rad], [N·m·s/rad]
  Vector3 p_L = Vector3::Zero();  ///< where it holds, in the link's frame; the link's origin for ours
  std::function<BodyState(double)> path;
};

/// Friction that changes once: factors on what the definition says.
struct FrictionChange {
  double time = 0;    ///< of the step from which on it is another [s]
  double before = 1;  ///< until then
  std::function<double(const std::function<BodyState(int)>&)> after;  ///< from the states of links at that time
};

/// States at one sample time, and what follows from them for all compared bodies together.
struct Sample {
  double time = 0;
  double energy = 0;            ///< kinetic and potential [J]
  Vector3 momentum = Vector3::Zero(), angular_momentum = Vector3::Zero();  ///< about W's origin
  std::vector<Wrench> hands;    ///< on each hand, in W, about the link's origin
  std::vector<BodyState> bodies;
};

/// An error of a scene's own that needs no reference motion: something conserved, an overlap, a closed form. `name` is a
/// metric of run_errors.py, which says the unit. The samples begin with the state before the first step.
struct Measure {
  std::string name;
  std::function<double(const std::vector<Sample>&)> of;
};

struct Scene {
  std::string name;
  std::string title;            ///< one line for people
  std::string parameters;       ///< sizes, masses, friction: what a reader needs to repeat it
  std::string reference;        ///< where `exact` comes from; empty: no exact solution
  double seconds = 1;           ///< simulated
  int samples = 20;             ///< states compared, evenly spread
  std::vector<int> bodies;      ///< world link indices that are compared
  double stiffness = 0;         ///< k of the scene itself [N/m³]
  bool stiffer_is_truer = true; ///< a higher k comes closer to `exact`
  bool round = false;           ///< has facets to choose
  double restitution = 0;       ///< that peers are told: 1 where the scene's contact is elastic
  double size = 0.1;            ///< a run with a body farther than this from the reference has failed [m]
  bool chaotic = false;         ///< no motion is the right one: judged by `measures` and `escaped` alone
  double smallest_step = 0;     ///< none shorter is run [s]: the scene is large
  std::vector<Measure> measures;
  /// Why a state is lost although no reference says where bodies belong; empty: it is not.
  std::function<std::string(const Sample&)> escaped;
  std::string benchmark;        ///< whose public benchmark this is, and what they published; empty: ours
  std::vector<peers::PeerShape> peer_shapes;  ///< what peers get in place of polyhedra
  std::string not_for_peers;    ///< reason why no peer here can run it; empty: they can
  std::function<WorldDef(const Choice&)> make;
  std::function<std::vector<BodyState>(double)> exact;  ///< of `bodies` at a time; empty: unknown
  std::vector<HandSpring> hands;                        ///< one per pointer with virtual coupling
  std::optional<FrictionChange> friction;
  /// Hands that hold a link by its pose (direct coupling): state of pointer i at a time. Empty: none.
  std::function<BodyState(int, double)> held;
  std::vector<HandSpring> peer_hands;                   ///< of peers in the place of `held`, one per pointer: they have no led bodies
};

std::vector<Scene> motionScenes();    ///< single bodies: rest, bounce, tilt, slides, slopes, top, torque-free body
std::vector<Scene> frictionScenes();  ///< stick-slip, a hand that presses, slides and slopes
std::vector<Scene> pileScenes();      ///< stack and pyramid of 15, seam
std::vector<Scene> movingScenes();    ///< heaps, dominoes, crosses, a carrier, a corner
std::vector<Scene> benchmarkScenes();  ///< the field's own
std::vector<Scene> robotScenes();      ///< links on joints: chain, arm with a load, quadruped
Scene stackScene(int n);              ///< n cubes on one another
Scene pyramidScene(int rows);         ///< a flat pyramid of cubes, `rows` at the bottom
/// Any file that the simulator loads: no exact solution, hands on their scripted paths. Throws SetupError.
Scene fileScene(const std::string& file);

/// A true ball, or the polyhedron of the same volume where facets are chosen.
inline std::shared_ptr<const ConvexShape> ballShape(double radius, const Choice& choice) {
  if (choice.facets == 0) return std::make_shared<Ball>(radius);
  return std::make_shared<ConvexPolyhedron>(makeSphere(radius, choice.facets, RoundFit::kEqualVolume));
}

/// World settings of a choice over those of a scene.
inline WorldSettings settingsOf(const Choice& choice, const WorldSettings& base = {}) {
  WorldSettings s = base;
  s.attempts = choice.attempts;
  s.comparator = choice.comparator;
  s.step = choice.step;
  s.accuracy = choice.accuracy;
  s.leave_out = choice.leave_out;
  return s;
}

}  // namespace haptic::report
