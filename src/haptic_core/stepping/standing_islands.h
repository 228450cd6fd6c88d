/// Islands that stand: the last step found them at rest and left them bit for bit as they were.
///
/// At rest is an island whose step would begin and end slower than a bound: such a step is not taken, positions and the memory of the
/// contacts stay, velocities become zero, and the energy of their motion is booked as a loss (ImplicitReport::rests). The bound is the
/// solve's rounding; for an island that stands alone and whose bodies have been slow for `kCalmSteps` it is a share of the error that a
/// step may make (`restingSpeed`). So what comes to rest by itself does so to rounding, and what would rock on for seconds stops. No
/// force out of balance moves an island at rest unless it is more than kOfAccuracy · accuracy of its weight, and of a motion of circular
/// frequency ω it keeps no more than
///
///     restingSpeed max(1/ω, 2/(kCalmSteps h ω²))
///
/// from its equilibrium: 60 nm at 10 rad/s and 1 ms. An unstable equilibrium is kept as well, where no more than that pulls it away.
///
/// A step is a function of its start. Where it has found an island at rest, and changed nothing, the next one would find and
/// change the same; so it is not computed, and its report is repeated, until something that moves comes near. Whether
/// an island stands is therefore no state: save, restore, hash and replay know nothing of it. It wakes without a jump of any wrench,
/// for the step that wakes it starts from the velocities and forces of those that were left out.
#pragma once
#include <cstdint>
#include <vector>

#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic::stepping {

/// Speed that rounding of coordinates makes in a step of length h at a distance from W's origin, beside bodies of this speed [m/s].
inline double roundingSpeed(double speed, double distance, double h) noexcept {
  // Smaller shares: solves iterate on rounding, and nothing ever stands; larger: what creeps stands.
  constexpr double kFinest = 1e-13, kRounding = 4 * 2.2e-16;
  return kFinest * speed + kRounding * distance / h;
}
/// Speeds below this many times that are rounding: coordinates of several bodies add up. Larger: what creeps slower than that
/// stands; smaller: heaps never come to rest, and cost as much as if they moved.
constexpr double kOfRounding = 4;
/// Share of the error that a step may make, WorldSettings::accuracy, that is left out of an island that stands alone. Larger: a body
/// pulled by more than 3e-5 of its weight stays where it is, farther from its equilibrium; smaller: a body that rocks by the solve's
/// tolerance, at 1e-7 m/s at 1 ms, does so for longer.
constexpr double kOfAccuracy = 1e-3;

/// Steps in a row in which a body has to be slower than that. Fewer: what approaches its rest in a tenth of a second is stopped short
/// of it; more: what rocks is computed for longer.
constexpr int kCalmSteps = 100;

/// Speed below which a body is slow, in a step of length h [m/s]: 3e-7 at 1 ms.
inline double restingSpeed(const WorldSettings& settings, double h) noexcept {
  return kOfAccuracy * settings.accuracy * h * settings.gravity.norm();
}

/// (in realtime) Every velocity of the tree is zero, as of all that stands.
bool isStill(const Model& model, int tree, const State& state) noexcept;

/// (in realtime) No hand pulls at it, no joint has a law of its own, and what its pairs know beside it never moves.
bool standsAlone(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) All bodies of the island have been slow for long enough.
bool isCalm(const Island& island, const State& state) noexcept;
/// (in realtime) After a whole step: how long its bodies have been slow.
void countCalm(const Model& model, const HandWork& hands, const Placement& placement, State& state) noexcept;
/// (in realtime) The same of one island that has gone over so many steps at once.
void countCalm(const Model& model, const Island& island, int steps, const Placement& placement, State& state) noexcept;

/// Reports of the last step on the islands that stand.
class StandingIslands {
 public:
  explicit StandingIslands(const Model& model);  ///< set-up: room for all trees and contacts

  /// (in realtime) Before a step: takes the last one's contacts; those left in their place are of no use.
  void open(LoadedVector<ContactReport>& contacts) noexcept;
  /// (in realtime) The tree moves on.
  void drop(int tree) noexcept { island_[tree].turn = 0; }
  /// (in realtime) State or model were changed by other than a step: nothing stands.
  void forget() noexcept;

  /// (in realtime) Of a world whose bodies become others: what stood there stands here, but for the islands of trees in `stirred`. `tree`:
  /// by tree, the one there, or −1; `contact`: by contact of the last report there, its index in this one's, or −1.
  void carryOver(const StandingIslands& from, const std::vector<int>& tree, const std::vector<int>& contact,
                 const std::vector<char>& stirred) noexcept;

  /// (in realtime) After a step: whether every tree that moves by itself sleeps or was reported again, none waits, and no hand acts.
  /// The next one would find the same, until somebody asks for something.
  void close(const HandWork& hands, bool any_sleeps, bool any_waits) noexcept;
  bool all() const { return all_; }      ///< so it is
  void wake() noexcept { all_ = false; }  ///< (in realtime) a hand has a target
  bool holds(int tree) const { return island_[tree].turn == turn_; }  ///< the tree's island stood in the last step
  /// (in realtime) Whether the last step's report of an island is this one's: it stood, and everything else that its pairs know never
  /// moves.
  bool repeats(const Model& model, const Island& island, const State& state) const noexcept;
  /// (in realtime) Reports it again.
  void repeat(const Island& island, Report& report) noexcept;
  /// (in realtime) After a step in which an island stood: its contacts are those of `report` from `first_contact` on.
  void note(const Island& island, int first_contact, const Report& report) noexcept;

  /// Of one island, by each of its trees.
  struct Standing {
    int trees = 0, pairs = 0;               ///< in it
    int first_contact = 0, contacts = 0;    ///< in the step's report
    std::uint64_t turn = 0;                 ///< of the step in which it stood
  };
  const Standing& of(int tree) const { return island_[tree]; }  ///< its memory; see `holds`
  /// (in realtime) The tree stood in the last step after all: a sleeping island is taken back, `within` this step or after it.
  void put(int tree, Standing standing, bool within) noexcept;
  LoadedVector<ContactReport>& contacts() { return contacts_; }  ///< within a step: the last one's

 private:
  void keep(const Island& island, Standing standing) noexcept;

  std::vector<Standing> island_;          ///< by tree
  std::uint64_t turn_ = 1;                ///< counts steps, and what makes that nothing stands
  bool all_ = false;
  std::size_t repeated_ = 0;              ///< trees whose report of the last step was the one before
  LoadedVector<ContactReport> contacts_;  ///< of the last step
};

}  // namespace haptic::stepping
