/// Everything that changes while a world runs; it is saved, restored and hashed. Plain structs; each lists its fields once
/// (base/fields.h).
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/contact/friction.h"
#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/pair_store.h"

namespace haptic {

/// Force of a contact in which nothing moves by itself, at the last evaluation.
struct LedForce {
  Vector3 p_W = Vector3::Zero();   ///< the patch's P [m]
  Wrench F_W, elastic_W;           ///< on B about P, in W's axes; of it the normal spring's

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.p_W), visit(s.F_W), visit(s.elastic_W);
  }
};

/// How a tree came to where it is.
enum class TreeMode : unsigned char {
  kImplicit,  ///< its island was solved
  kFlowed,    ///< it flowed (stepping/flow.h): its joints and sensors are read at the step's end
  kPut        ///< it was put there, and what overlaps there did not begin in a step
};

/// A pair's cache whose directions stay in W, in A's axes while this lives; written back where they changed, to the last bit.
class CacheInA {
 public:
  /// `R_WA` stays where it is while this lives.
  CacheInA(PairCache& cache_W, const Matrix3& R_WA) : cache_W_(cache_W), R_WA_(R_WA), before_(cache_W) {
    before_.direction = R_WA.transpose() * cache_W.direction;
    before_.normal = R_WA.transpose() * cache_W.normal;
    cache_ = before_;
  }
  ~CacheInA() {
    if (cache_.direction != before_.direction) cache_W_.direction = R_WA_ * cache_.direction;
    if (cache_.normal != before_.normal) cache_W_.normal = R_WA_ * cache_.normal;
    cache_W_.vertex_a = cache_.vertex_a;
    cache_W_.vertex_b = cache_.vertex_b;
  }
  CacheInA(const CacheInA&) = delete;
  CacheInA& operator=(const CacheInA&) = delete;
  operator PairCache&() { return cache_; }  ///< as geometry asks for it

 private:
  PairCache& cache_W_;
  const Matrix3& R_WA_;
  PairCache before_, cache_;
};

/// Means over a step of what a contact did, as the step's scheme applied it: BDF2 goes on from those of the step before. On B, about W's
/// origin, for the patch moves meanwhile.
struct ContactMeans {
  Wrench done;        ///< that moved the bodies [N·m], [N]
  Wrench F, elastic;  ///< of the contact's law at the velocities found, `done` up to the solve's tolerance; the part k Vol n of F
  Twist V;            ///< of B relative to A, as if hands and belts stood still

  /// Between these and `last`, of which `w` is the share of these.
  ContactMeans mixed(double w, const ContactMeans& last) const {
    return {done * w + last.done * (1 - w), F * w + last.F * (1 - w), elastic * w + last.elastic * (1 - w), V * w + last.V * (1 - w)};
  }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.done), visit(s.F), visit(s.elastic), visit(s.V);
  }
};

/// Two shapes whose boxes overlap, with their memory.
struct ActivePair {
  std::uint64_t key = 0;  ///< shape A in the upper, shape B in the lower 32 bits; A < B
  PairCache cache;            ///< of the search and of the normal, its directions in W: they turn with neither body (`CacheInA`)
  FrictionMemory friction;    ///< of the patch
  LedForce led;               ///< where nothing moves by itself
  ContactMeans means;         ///< over the last implicit step
  bool buried = false;  ///< overlapped deep at the start; pushed out slowly until it is shallow

  /// Shapes a < b.
  static std::uint64_t keyOf(int a, int b) {
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
  }
  int shapeA() const { return static_cast<int>(key >> 32); }          ///< index in the model
  int shapeB() const { return static_cast<int>(key & 0xffffffffu); }  ///< index in the model

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.key), visit(s.cache), visit(s.friction), visit(s.led), visit(s.means), visit(s.buried);
  }
};

/// A wrench on a link, about a point that moves with it.
struct LinkWrench {
  Wrench F;                          ///< about the point, in W's axes, or in the link's [N·m], [N]
  Vector3 p_L = Vector3::Zero();     ///< the point, in the link frame [m]
  bool in_link = false;              ///< F turns with the link

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.F), visit(s.p_L), visit(s.in_link);
  }
};

/// A wrench that acts for some steps (world/applied_wrench.h).
struct AppliedWrench {
  int link = -1;                     ///< world link index
  std::uint64_t end = 0;             ///< first step without it
  LinkWrench wrench;                 ///< constant meanwhile

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.link), visit(s.end), visit(s.wrench);
  }
};

/// Where a body goes that is told its motion pose by pose (world/led_motion.h): a cubic from one pose and twist to another.
struct MotionTarget {
  double start = 0, seconds = 0;     ///< when it left, and how long it takes [s]; 0 s: it stands
  Vector3 p_from = Vector3::Zero(), p_to = Vector3::Zero();                 ///< origin of the link frame [m]
  Quaternion q_from = Quaternion::Identity(), q_to = Quaternion::Identity();  ///< R_WL
  Twist V_from, V_to;                ///< at the link frame's origin, in W

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.start), visit(s.seconds), visit(s.p_from), visit(s.p_to), visit(s.q_from), visit(s.q_to), visit(s.V_from), visit(s.V_to);
  }
};

/// A pointer's hand: its target for the pointer's frame P (Model::pointerFrame), and the world's answer.
struct PointerState {
  Vector3 p_WP = Vector3::Zero();             ///< target [m]
  Quaternion q_WP = Quaternion::Identity();   ///< target
  Twist V_WP;                                 ///< of the target
  Wrench F_W;     ///< on the hand, about P's origin, mean over a step
  Wrench pull_W;  ///< of its coupling on the link, about P's origin: mean over the last implicit step
  Twist pulled_W;  ///< of P's origin: mean over that step
  int link = -1;  ///< world link index
  bool targeted = false;  ///< a target has come

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.p_WP), visit(s.q_WP), visit(s.V_WP), visit(s.F_W), visit(s.pull_W), visit(s.pulled_W), visit(s.link), visit(s.targeted);
  }
};

/// Sums of the ledger since the start [J]; see EnergyLedger.
struct EnergySums {
  double damping = 0, friction = 0, external = 0, turning = 0;  ///< as in EnergyLedger
  double stilled = 0;      ///< of `damping`: motion of islands that were brought to rest
  double still = 0;        ///< part of `turning` that was booked while n stood still: the step's
  double lost = 0;         ///< of the balance
  double balance = 0;      ///< after the last step; see `balanced`
  double supply = 0;       ///< what there was to draw on: motion and springs at the start, falls, hands and drives; runaway.h
  double highest = 0, lowest = 0;  ///< potential energy from which falls are counted, and down to which they went
  Vector3 gravity = Vector3::Zero();  ///< under which those two were found [m/s²]
  bool balanced = false;   ///< false: bodies changed hands or values changed, the next step takes the balance anew

  /// (in realtime) Energy that a contact's dampers took from its bodies, and that its springs took beyond their own gain [J]. The pressure
  /// that pushes out a `buried` pair follows no potential: the energy that its springs gave up and its bodies did not get is lost.
  void bookPressure(double damped, double beyond, const FrictionMemory& before, const FrictionMemory& now, bool buried) noexcept {
    if (!buried) {
      damping += damped;
      bookTurning(beyond, before, now);
    } else {
      (damped + beyond > 0 ? damping : turning) += damped + beyond;
    }
  }
  /// (in realtime) Energy that a contact took from its bodies beyond the gain of its springs [J].
  void bookTurning(double energy, const FrictionMemory& before, const FrictionMemory& now) noexcept {
    constexpr double kStands = 1e-6;  // [rad]: the work of that turn is this share of the energy exchanged
    turning += energy;
    const bool both = before.touching != 0 && now.touching != 0;
    if (!both || (now.normal_A - before.normal_A).squaredNorm() < kStands * kStands) still += energy;
  }
  /// Made or lost by the time steps, and by k Vol n where n turns [J].
  double unaccounted() const noexcept { return turning + lost; }

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.damping), visit(s.friction), visit(s.external), visit(s.turning), visit(s.stilled), visit(s.still);
    visit(s.lost), visit(s.balance), visit(s.supply), visit(s.highest), visit(s.lowest), visit(s.gravity), visit(s.balanced);
  }
};

/// Wrenches that may act at once. More are refused; each costs a step some 50 ns.
inline constexpr int kMostWrenches = 32;

/// Everything of a world that evolves. The model says how long its vectors are.
struct State {
  double time = 0;  ///< [s]
  std::uint64_t step = 0;  ///< since the start
  /// Positions and velocities, see articulation.h.
  std::vector<double> q, v;  ///< of all trees, one after the other
  std::vector<TreeMode> mode;          ///< by tree
  /// What BDF2 takes up from the last implicit step (stepping/implicit_step.h): acceleration at its end; means over it.
  std::vector<double> a_end, a_mean, v_mean;
  /// By tree: length of that step [s]; 0: there is none to go on from; negative: contacts jumped in it.
  std::vector<double> last_step;
  std::vector<int> calm;               ///< by tree: steps in a row in which it was slow (stepping/rest.h)
  /// By tree: step at whose start it has its next turn, 0: every step is; and the number of steps after which it was as it is now
  /// (stepping/own_rate.h).
  std::vector<std::uint64_t> turn, as_of;
  std::vector<JointCommand> commands;  ///< of the links of trees whose joints have laws
  std::vector<PointerState> pointers;  ///< by pointer
  std::vector<MotionTarget> motions;   ///< by motion of the model
  EnergySums energy;                   ///< of the ledger
  PairStore<ActivePair> pairs;          ///< of the model's capacity
  std::vector<AppliedWrench> wrenches;  ///< storage for kMostWrenches, in the order in which they came
  int wrench_count = 0;           ///< valid entries of `wrenches`

  /// All but pairs and wrenches, whose number varies.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.time), visit(s.step), visit(s.q), visit(s.v), visit(s.mode), visit(s.a_end),
        visit(s.a_mean), visit(s.v_mean), visit(s.last_step), visit(s.calm), visit(s.turn), visit(s.as_of);
    visit(s.commands);
    visit(s.pointers), visit(s.motions), visit(s.energy);
  }

  /// (in realtime) What the tree's next step would go on from holds no longer.
  void beginAnew(int tree) noexcept { last_step[tree] = 0; }
  std::uint64_t hash() const;        ///< over all of it
  std::vector<double> pack() const;  ///< one vector, with lengths in front
  /// The same into `out`; (in realtime) allocates nothing where it has room for `packedCapacity()` numbers.
  void pack(std::vector<double>& out) const;
  std::size_t packedCapacity() const;  ///< with as many pairs and wrenches as there is storage for
  /// Numbers in front of a packed state: its format, and what another layout would have otherwise.
  static constexpr std::size_t kHead = 6;
  /// Counts up where a field gets another meaning and not another number of numbers: such a state would move otherwise, unnoticed.
  static constexpr double kFormat = 5;
  /// Contents of a packed state beside the fields.
  struct Layout {
    int pairs = 0, wrenches = 0;  ///< so many
  };
  /// Throws SetupError when `packed` was made by a world of another layout.
  Layout layoutOf(const std::vector<double>& packed) const;
  /// Likewise, and takes it over. Its indices are not judged: saved_state.h.
  void unpack(const std::vector<double>& packed);
};

}  // namespace haptic
