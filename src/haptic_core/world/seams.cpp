#include "haptic_core/world/seams.h"

#include <algorithm>
#include <utility>

#include "haptic_core/geometry/volume/contact_moments.h"

namespace haptic {
namespace {

/// Volumes on seams that are kept until they are asked for: those of five boxes in inner corners. Further ones are computed twice;
/// each takes most of a megabyte where a ball may meet stones of many faces.
constexpr int kKept = 16;

/// The moments of a polyhedron V that is there already, about the normal of the request. False: there are none.
bool turnTo(const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace, const Pose& X_AB, ContactVolume& out) noexcept {
  if (workspace.round().filled) return false;
  out.flags &= ContactVolume::kCapacityExceeded;
  return integrateContact(workspace, nullptr, nullptr, X_AB, cache, request, out);
}

bool same(const Pose& a, const Pose& b) { return a.R == b.R && a.p == b.p; }

}  // namespace

Seams::Seams(const Model& model) : model_(model) {
  if (!any()) return;
  parts_.reserve(model.pair_capacity);
  found_.assign(model.pair_capacity, 0);
  normal_W_.resize(model.pair_capacity);
  centroid_W_.resize(model.pair_capacity);
  kept_.resize(model.pair_capacity);
  volumes_.resize(std::min(kKept, model.pair_capacity));
  ContactWorkspace largest;
  model.reserve(largest);
  for (KeptVolume& V : volumes_) largest.reserve(V);
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
  std::size_t used = 0;
  for (int n = 0; n < count; ++n) {
    const int i = which ? which[n] : n;
    found_[i] = 0;
    kept_[i].known = false;
    const int a = pairs[i].shapeA(), b = pairs[i].shapeB();
    if (model_.shapes[a].surface.empty() && model_.shapes[b].surface.empty()) continue;
    Kept& kept = kept_[i];
    ContactVolume& volume = kept.volume;
    kept.X_AB = relativePose(X_WS[a], X_WS[b]);
    CacheInA cache(pairs[i].cache, X_WS[a].R);
    contactVolume(*model_.shapes[a].shape, *model_.shapes[b].shape, kept.X_AB, cache, workspace, volume,
                  {NormalRule::kAreaVector, model_.inner(a, b), Vector3::Zero()});
    kept.V = nullptr;
    kept.known = volume.status != ContactVolume::Status::kOverlap;
    if (kept.known) continue;
    const bool on_seam = volume.flags & ContactVolume::kOnSeam;
    const std::uint64_t of_a = on_seam ? surfacesOf(a, Owner::kA, workspace) : 0,
                        of_b = on_seam ? surfacesOf(b, Owner::kB, workspace) : 0;
    kept.known = used < volumes_.size();
    if (kept.known) {
      kept.V = &volumes_[used++];
      workspace.exchange(*kept.V);
    }
    if (!on_seam) continue;
    const bool swapped = bodyOf(a) > bodyOf(b);
    const double sign = swapped ? -1 : 1;
    const Matrix3 R = sign * X_WS[a].R;
    Part part{i, a, b, parts_.size(), sign, R * (volume.area_vector_A - volume.covered_a.vector),
              R * (volume.area_vector_A + volume.covered_b.vector), volume.covered_a.area, volume.covered_b.area,
              volume.volume * (X_WS[a] * volume.X_AP.p), volume.volume, of_a, of_b};
    if (swapped) {
      std::swap(part.shape_a, part.shape_b), std::swap(part.own_a_W, part.own_b_W);
      std::swap(part.covered_a, part.covered_b), std::swap(part.surfaces_a, part.surfaces_b);
    }
    parts_.push_back(part);
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
    Vector3 of_a = Vector3::Zero(), of_b = Vector3::Zero(), moment = Vector3::Zero();
    double scale = 0, volume = 0, covered_a = 0, covered_b = 0;
    int joined = 0;
    for (const Part& other : parts_) {
      if (other.cluster != part.cluster) continue;
      ++joined;
      of_a += other.own_a_W, of_b += other.own_b_W;
      covered_a += other.covered_a, covered_b += other.covered_b;
      scale += other.own_a_W.norm() + other.own_b_W.norm();
      moment += other.moment_W;
      volume += other.volume;
    }
    if (joined == 1) continue;  // it has a surface of its own
    const double share_a = covered_a + covered_b > 0 ? covered_a / (covered_a + covered_b) : 0.5;
    const Vector3 sum = share_a * of_a + (1 - share_a) * of_b;
    const double size = sum.norm();
    // Parts that face one another (a bar through a plate of pieces) have no common direction.
    if (!(size > 1e-6 * scale)) continue;
    found_[part.pair] = 1;
    normal_W_[part.pair] = part.sign / size * sum;
    centroid_W_[part.pair] = moment / volume;
  }
}

bool Seams::locate(int i, ActivePair& pair, const Pose& X_WA, const Pose& X_AB, ContactWorkspace& workspace,
                   ContactVolume& out) noexcept {
  const bool flush = locatePart(i, pair, X_WA, X_AB, workspace, out);
  if (flush) out.flags |= ContactVolume::kOnSeam;  // computed for a given normal, it does not know
  out.rise = flush ? out.normal().dot(X_WA.inverse() * centroid_W_[i] - out.X_AP.p) : 0;
  out.X_AP.p += out.rise * out.normal();
  return flush;
}

/// `locate`, with P at the part's own centroid.
bool Seams::locatePart(int i, ActivePair& pair, const Pose& X_WA, const Pose& X_AB, ContactWorkspace& workspace,
                       ContactVolume& out) noexcept {
  const int a = pair.shapeA(), b = pair.shapeB();
  const bool flush = any() && found_[i];
  ContactRequest request;
  if (flush)
    request.normal = X_WA.R.transpose() * normal_W_[i];
  else
    request.inner = model_.inner(a, b);
  const ConvexShape &A = *model_.shapes[a].shape, &B = *model_.shapes[b].shape;
  CacheInA cache(pair.cache, X_WA.R);
  if (any() && kept_[i].known && same(kept_[i].X_AB, X_AB)) {
    kept_[i].known = false;
    out = kept_[i].volume;
    if (kept_[i].V) workspace.exchange(*kept_[i].V);
    if (!flush || turnTo(request, cache, workspace, X_AB, out)) return flush;
  }
  contactVolume(A, B, X_AB, cache, workspace, out, request);
  return flush;
}

}  // namespace haptic
