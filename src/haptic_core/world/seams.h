/// One normal for the contact of two bodies that is spread over several of their convex pieces.
#pragma once
#include <vector>

#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Where pieces of a body meet, each piece's V is a part of the bodies' V, cut off at an internal face. Taken
/// alone, its area vector contains that face's and its normal leans towards it, by up to 90° where little of
/// the piece is covered: a body sliding over the joint of two floor tiles would be braked by the edge between
/// them. In the sum over the parts internal faces cancel, and Σ S_A is the area vector of the whole. So the
/// parts that are joined (kOnJoint, between the same or neighbouring pieces on either side) all get the
/// normal of their sum.
class Seams {
 public:
  explicit Seams(const Model& model);

  /// False: no pieces of this world touch within a body; nothing needs to be called.
  bool any() const { return any_; }

  /// (in realtime) Computes the contact volume of each pair that may lie on a joint, and their common
  /// normals: of pairs[which[0 … count)], or of the first `count` when `which` is null. The pairs' caches advance.
  /// Cost: one contact volume per such pair.
  void find(ActivePair* pairs, const int* which, int count, const Pose* X_WS, ContactWorkspace& workspace) noexcept;

  /// Prepares the pair's cache and says by which rule its contact volume takes its normal: the common one,
  /// when pair i is a part, through the cache; else by `rule`.
  NormalRule ruleFor(int i, NormalRule rule, const Pose& X_WA, PairCache& cache) const noexcept {
    if (!any_ || !found_[i] || rule != NormalRule::kAreaVector) return rule;
    cache.normal = X_WA.R.transpose() * normal_W_[i];
    return NormalRule::kHistory;
  }

 private:
  /// From body to body in one order for all parts, whichever of a pair's shapes comes first.
  struct Part {
    int pair, shape_a, shape_b, cluster;
    double sign;  ///< -1: the pair has them the other way round
    Vector3 S_W;
  };
  int bodyOf(int shape) const noexcept;
  bool joined(const Part& x, const Part& y) const noexcept;

  const Model& model_;
  bool any_ = false;
  LoadedVector<Part> parts_;
  std::vector<char> found_;
  std::vector<Vector3> normal_W_;
};

}  // namespace haptic
