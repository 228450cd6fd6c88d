#include "haptic_core/world/seams.h"

#include <algorithm>

namespace haptic {

Seams::Seams(const Model& model) : model_(model) {
  for (const ModelShape& shape : model.shapes) any_ = any_ || !shape.hidden.empty();
  if (!any_) return;
  parts_.reserve(model.pair_capacity);
  found_.assign(model.pair_capacity, 0);
  normal_W_.resize(model.pair_capacity);
}

/// Its link, or all that never moves.
int Seams::bodyOf(int shape) const noexcept {
  const int link = model_.shapes[shape].link;
  return model_.links[link].moves ? link : static_cast<int>(model_.links.size());
}

bool Seams::joined(const Part& x, const Part& y) const noexcept {
  const auto near = [this](int s, int t) { return s == t || model_.areNeighbours(s, t); };
  return near(x.shape_a, y.shape_a) && near(x.shape_b, y.shape_b);
}

void Seams::find(ActivePair* pairs, const int* which, int count, const Pose* X_WS,
                        ContactWorkspace& workspace) noexcept {
  parts_.clear();
  for (int n = 0; n < count; ++n) {
    const int i = which ? which[n] : n;
    found_[i] = 0;
    const int a = pairs[i].shapeA(), b = pairs[i].shapeB();
    const HiddenFaces hidden = model_.hidden(a, b);
    if (!hidden.a && !hidden.b) continue;
    ContactVolume volume;
    contactVolume(*model_.shapes[a].shape, *model_.shapes[b].shape, relativePose(X_WS[a], X_WS[b]),
                  pairs[i].cache, workspace, volume, NormalRule::kAreaVector, hidden);
    if (volume.status != ContactVolume::Status::kOverlap || !(volume.flags & ContactVolume::kOnJoint))
      continue;
    const bool swapped = bodyOf(a) > bodyOf(b);
    const double sign = swapped ? -1 : 1;
    parts_.push_back(
        {i, swapped ? b : a, swapped ? a : b, parts_.size(), sign, sign * (X_WS[a].R * volume.area_vector_A)});
  }
  // Clusters by merging: few parts, found in the order of the pairs.
  for (int i = 0; i < parts_.size(); ++i)
    for (int j = 0; j < i; ++j) {
      const int from = parts_[i].cluster, to = parts_[j].cluster;
      if (from == to || !joined(parts_[i], parts_[j])) continue;
      for (int k = 0; k <= i; ++k)
        if (parts_[k].cluster == from) parts_[k].cluster = to;
    }
  for (const Part& part : parts_) {
    Vector3 sum = Vector3::Zero();
    double scale = 0;
    for (const Part& other : parts_) {
      if (other.cluster != part.cluster) continue;
      sum += other.S_W;
      scale += other.S_W.norm();
    }
    const double size = sum.norm();
    // Parts that face one another (a bar through a plate of pieces) have no common direction.
    if (!(size > 1e-6 * scale)) continue;
    found_[part.pair] = 1;
    normal_W_[part.pair] = part.sign / size * sum;
  }
}

}  // namespace haptic
