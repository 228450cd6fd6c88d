/// Everything that changes while a world runs, in flat memory: what is saved, restored and hashed.
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/contact/friction.h"
#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/geometry/contact_volume.h"

namespace haptic {

/// What a contact would need to know if it parted in the next step. Trivially copyable, doubles only.
struct ReleaseMemory {
  Vector3 p_WP = Vector3::Zero();      ///< patch [m]
  Vector3 torque_W = Vector3::Zero();  ///< wrench on B about P [N·m]
  Vector3 force_W = Vector3::Zero();   ///< [N]
  double leave = 0;                    ///< time to depth 0 at the present rate [s]; infinite: approaching
  double order = 1;                    ///< n of F ~ (time to depth 0)ⁿ
};

/// Shares of a contact in the stability numbers of its links (stability_number.h), as last measured.
struct StabilityMemory {
  double share[2] = {0, 0};        ///< of A's link, of B's
  double area = 0, volume = 0;     ///< of the patch then [m²], [m³]
};

/// How a tree is stepped.
enum TreeMode : int {
  kUnprimed,  ///< explicitly; velocity Verlet does not know yet what pulls
  kPrimed,    ///< explicitly, `WorldState::pull` is filled
  kImplicit
};

/// Two shapes whose boxes overlap, with what they remember. Trivially copyable.
struct ActivePair {
  std::uint64_t key = 0;  ///< shape A in the upper, shape B in the lower 32 bits; A < B
  PairCache cache;
  FrictionMemory friction;
  ReleaseMemory release;
  StabilityMemory stability;
  double buried = 0;  ///< 1: overlapped deep at the start; pushed out slowly until it is shallow

  static std::uint64_t keyOf(int a, int b) {
    return static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
  }
  int shapeA() const { return static_cast<int>(key >> 32); }
  int shapeB() const { return static_cast<int>(key & 0xffffffffu); }
};

/// A pointer's hand: where it wants the link, and what the world has said to it.
struct PointerState {
  double p_WL[3] = {0, 0, 0}, q_WL[4] = {1, 0, 0, 0};  ///< target pose; quaternion w, x, y, z
  double V_WL[6] = {0, 0, 0, 0, 0, 0};                 ///< target twist, angular first
  double F_W[6] = {0, 0, 0, 0, 0, 0};       ///< on the hand, about L's origin, mean over a step; torque first
  double F_last_W[6] = {0, 0, 0, 0, 0, 0};  ///< the same in the last substep
  double link = -1;                         ///< world link index
  double targeted = 0;                      ///< 1 once a target has come
};

struct WorldState {
  double time = 0;  ///< [s]
  std::uint64_t step = 0;
  std::vector<double> q, v;           ///< of all articulations, one after the other
  /// Velocity Verlet: what pulled at the end of the last step. Free bodies: torque [N·m], acceleration of C; trees whose
  /// joints have laws: Jᵀ F of contacts and hands; other trees: v̇ by contacts and hands.
  std::vector<double> pull;
  std::vector<double> mode;           ///< a TreeMode by tree
  std::vector<JointCommand> commands;  ///< of the links of trees whose joints have laws
  std::vector<PointerState> pointers;
  std::vector<ActivePair> pairs;  ///< storage of the plan's capacity, sorted by key
  int pair_count = 0;
  double energy[4] = {0, 0, 0, 0};    ///< sums of the ledger [J]: damping, friction, external, turning

  std::uint64_t hash() const;        ///< over all of it
  std::vector<double> pack() const;  ///< one vector, with lengths in front
  /// The same into `out`; (in realtime) allocates nothing where it has room for `packedCapacity()` numbers.
  void pack(std::vector<double>& out) const;
  std::size_t packedCapacity() const;  ///< with as many pairs as there is storage for
  /// Throws SetupError when `packed` was made by a world of another layout.
  void unpack(const std::vector<double>& packed);
};

}  // namespace haptic
