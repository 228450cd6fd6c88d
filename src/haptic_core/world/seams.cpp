#include "haptic_core/world/seams.h"

#include <algorithm>

namespace haptic {

Seams::Seams(const Model& model) : model_(model) {
  for (const ModelShape& shape : model.shapes) any_ = any_ || !shape.surface.empty();
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

/// Which of the shape's flat surfaces that go on in neighbours bound the V in the workspace.
std::uint64_t Seams::surfacesOf(int shape, Owner owner, const ContactWorkspace& workspace) const noexcept {
  const std::vector<int>& surface = model_.shapes[shape].surface;
  std::uint64_t bits = 0;
  for (const ContactFace& face : workspace.faces()) {
    if (surface.empty() || face.owner != owner || surface[face.index] < 0) continue;
    bits |= std::uint64_t{1} << (surface[face.index] & 63);
  }
  return bits;
}

bool Seams::joined(const Part& x, const Part& y) const noexcept {
  const auto flush = [this](int s, int t, std::uint64_t of_s, std::uint64_t of_t) {
    return s == t || ((of_s & of_t) != 0 && model_.areNeighbours(s, t));
  };
  return flush(x.shape_a, y.shape_a, x.surfaces_a, y.surfaces_a) &&
         flush(x.shape_b, y.shape_b, x.surfaces_b, y.surfaces_b);
}

void Seams::find(ActivePair* pairs, const int* which, int count, const Pose* X_WS,
                        ContactWorkspace& workspace) noexcept {
  parts_.clear();
  for (int n = 0; n < count; ++n) {
    const int i = which ? which[n] : n;
    found_[i] = 0;
    const int a = pairs[i].shapeA(), b = pairs[i].shapeB();
    if (model_.shapes[a].surface.empty() && model_.shapes[b].surface.empty()) continue;
    ContactVolume volume;
    contactVolume(*model_.shapes[a].shape, *model_.shapes[b].shape, relativePose(X_WS[a], X_WS[b]),
                  pairs[i].cache, workspace, volume, NormalRule::kAreaVector, model_.inner(a, b));
    if (volume.status != ContactVolume::Status::kOverlap || !(volume.flags & ContactVolume::kOnSeam))
      continue;
    const bool swapped = bodyOf(a) > bodyOf(b);
    const double sign = swapped ? -1 : 1;
    const std::uint64_t of_a = surfacesOf(a, Owner::kA, workspace), of_b = surfacesOf(b, Owner::kB, workspace);
    parts_.push_back({i, swapped ? b : a, swapped ? a : b, parts_.size(), sign,
                      sign * (X_WS[a].R * volume.area_vector_A), swapped ? of_b : of_a, swapped ? of_a : of_b});
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
    int joined = 0;
    for (const Part& other : parts_) {
      if (other.cluster != part.cluster) continue;
      ++joined;
      sum += other.S_W;
      scale += other.S_W.norm();
    }
    const double size = sum.norm();
    if (joined == 1) continue;  // it has a surface of its own
    // Parts that face one another (a bar through a plate of pieces) have no common direction.
    if (!(size > 1e-6 * scale)) continue;
    found_[part.pair] = 1;
    normal_W_[part.pair] = part.sign / size * sum;
  }
}

}  // namespace haptic
