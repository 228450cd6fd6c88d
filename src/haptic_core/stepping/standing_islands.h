/// Islands that stand: the last step found them at rest and left them bit for bit as they were.
///
/// A step is a function of what it finds. Where it has found an island at rest, and changed nothing, the next one would find and
/// change the same; so it is not computed, and what it would report is reported again, until something that moves comes near.
/// This leaves work out, not motion: no threshold but that of the solve's rounding (ImplicitReport::stands) decides.
///
/// Only implicit islands stand. Explicit steps never leave a body bit for bit where it was; what they have brought to rest is made
/// implicit (settleExplicit), where soft contacts rest in the same place, and goes back once something has moved it.
#pragma once
#include <vector>

#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"

namespace haptic {
struct ImplicitReport;
}

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

/// (in realtime) No hand pulls at it, no joint has a law of its own, and what its pairs know beside it never moves.
bool standsAlone(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) After a step of length h: explicit islands that rest on something to within rounding become implicit.
void settleExplicit(const Model& model, double h, const Placement& placement, Islands& islands, const HandWork& hands,
                    State& state) noexcept;

/// What the last step reported of the islands that stand.
class StandingIslands {
 public:
  explicit StandingIslands(const Model& model);  ///< set-up: room for all trees and contacts

  /// (in realtime) Before a step: takes the last one's contacts; what is left in their place is of no use.
  void open(LoadedVector<ContactReport>& contacts) noexcept;
  /// (in realtime) State or model were changed by other than a step: nothing stands.
  void forget() noexcept;

  /// (in realtime) Of a world whose bodies become others: what stood there stands here, but for the islands of trees in `stirred`. `tree`:
  /// by tree, the one there, or −1; `contact`: by contact of the last report there, its index in this one's, or −1.
  void carryOver(const StandingIslands& from, const std::vector<int>& tree, const std::vector<int>& contact,
                 const std::vector<char>& stirred) noexcept;

  /// (in realtime) After a step: whether it reported every tree that moves by itself again, and no hand acts. The next one would as
  /// well, until somebody asks for something.
  void close(const HandWork& hands) noexcept;
  bool all() const { return all_; }      ///< so it is
  void wake() noexcept { all_ = false; }  ///< (in realtime) a hand has a target
  /// (in realtime) Whether the last step's report of an island is this one's: it stood, and everything else that its pairs know never
  /// moves.
  bool repeats(const Model& model, const Island& island, const State& state) const noexcept;
  /// (in realtime) Reports it again.
  void repeat(const Island& island, const State& state, Report& report) noexcept;
  /// (in realtime) After a step in which an island stood: its contacts are those of `report` from `first_contact` on.
  void note(const Island& island, const ImplicitReport& solved, int first_contact, const Report& report) noexcept;

 private:
  /// Of one island, by each of its trees.
  struct Standing {
    int trees = 0, pairs = 0;               ///< in it; 0: it does not stand
    int first_contact = 0, contacts = 0;    ///< in the step's report
    double residual = 0, wrench_error = 0;  ///< of its last solve [m/s], [N]
  };
  void keep(const Island& island, const Standing& standing) noexcept;

  std::vector<Standing> last_, now_;      ///< by tree
  bool any_last_ = false, any_ = false;   ///< something stands in them
  bool all_ = false;
  std::size_t repeated_ = 0;              ///< trees whose report of the last step was the one before
  LoadedVector<ContactReport> contacts_;  ///< of the last step
};

}  // namespace haptic::stepping
