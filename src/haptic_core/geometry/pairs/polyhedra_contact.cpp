// The tick's entry: detection, then the fast path, then, when that is not sure, cutting.
#include "haptic_core/geometry/volume/contact_volume.h"

#include <algorithm>

#include "haptic_core/geometry/search/gjk.h"
#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/geometry/volume/edge_clipping.h"
#include "haptic_core/geometry/volume/volume_cutting.h"

namespace haptic {
namespace {

using Status = ContactVolume::Status;

Vector3 firstDirection(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) {
  const Vector3 between = X_AB * B.centre() - A.centre();
  const double distance = between.norm();
  return distance > 0 ? Vector3(between / distance) : Vector3::UnitZ();
}

int boxSupport(const Vector3& n) {
  return (n.x() > 0) | (n.y() > 0) << 1 | (n.z() > 0) << 2;
}

/// Highest of A and lowest of B along the cached direction. For a box the support is a sum of projections.
EdgeClipper::Overlap overlapAlong(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                                  PairCache& cache) {
  const Vector3& n = cache.direction;
  const Vector3 n_B = X_AB.R.transpose() * n;
  double top, bottom;
  if (A.isBox()) {
    cache.vertex_a = boxSupport(n);
    top = A.halfSize().dot(n.cwiseAbs());
  } else {
    cache.vertex_a = A.support(n, cache.vertex_a);
    top = n.dot(A.vertices()[cache.vertex_a]);
  }
  if (B.isBox()) {
    cache.vertex_b = boxSupport(-n_B);
    bottom = n.dot(X_AB.p) - B.halfSize().dot(n_B.cwiseAbs());
  } else {
    cache.vertex_b = B.support(-n_B, cache.vertex_b);
    bottom = n.dot(X_AB.p) + n_B.dot(B.vertices()[cache.vertex_b]);
  }
  return {n, top, bottom, cache.vertex_a, cache.vertex_b};
}

/// Common points but no volume that rounding resolves.
void setTouching(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                 const ClosestPoints& near, PairCache& cache, ContactVolume& out) {
  const unsigned flags = out.flags;
  out = ContactVolume{};
  out.flags = flags | ContactVolume::kNormalFromHistory;
  out.status = Status::kTouching;
  const Vector3 n = cache.normal.squaredNorm() > 0 ? cache.normal : shortestWayOut(A, B, X_AB);
  out.X_AP = {patchAxes(n), 0.5 * (near.p_A + near.p_B)};
  cache.normal = cache.direction = n;
}

/// Shapes that the workspace was not made for: a cube as deep as the shortest way out stands for V, so that
/// the pair still pushes apart.
void pushWithoutWorkspace(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                          const ClosestPoints& near, PairCache& cache, ContactVolume& out) {
  setTouching(A, B, X_AB, near, cache, out);
  out.flags |= ContactVolume::kCapacityExceeded;
  const double depth = -gapAlong(A, B, X_AB, out.normal(), cache.vertex_a, cache.vertex_b);
  if (!(depth > 0)) return;
  out.status = Status::kOverlap;
  out.depth = depth;
  out.A0 = depth * depth;
  out.volume = out.A0 * depth;
  out.area_vector_A = out.A0 * out.normal();
  out.A2 = out.A0 * depth * depth / 12 * Matrix2::Identity();
  out.V2 = depth * out.A2;
}

/// GJK's word on a pair that showed no volume.
void decideWithoutVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                         PairCache& cache, ContactVolume& out) {
  ClosestPoints near;
  closestPoints(A, B, X_AB, cache.direction, near);
  cache.direction = near.direction;
  cache.vertex_a = near.vertex_a;
  cache.vertex_b = near.vertex_b;
  if (near.separated) {
    out.status = Status::kSeparated;
    out.flags = 0;
  } else {
    setTouching(A, B, X_AB, near, cache, out);
  }
}

/// True when it overlaps; `out` is then filled.
bool cutAndIntegrate(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB, PairCache& cache,
                     ContactWorkspace& workspace, const ContactRequest& request, ContactVolume& out) {
  bool complete = true;
  const bool left = cutVolume(A, B, X_AB, workspace, complete);
  if (!complete) out.flags |= ContactVolume::kCapacityExceeded;
  if (!left || !integrateContact(workspace, &A, &B, X_AB, cache, request, out)) return false;
  out.status = Status::kOverlap;
  return true;
}

void findContact(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB, PairCache& cache,
                 ContactWorkspace& workspace, const ContactRequest& request, ContactVolume& out) {
  out.status = Status::kSeparated;
  out.flags = 0;
  if (!(cache.direction.squaredNorm() > 0)) cache.direction = firstDirection(A, B, X_AB);
  const EdgeClipper::Overlap overlap = overlapAlong(A, B, X_AB, cache);
  out.depth = std::min(0.0, overlap.top_a - overlap.bottom_b);
  if (out.depth < 0) return;
  if (!workspace.fits(A, B)) {
    ClosestPoints near;
    closestPoints(A, B, X_AB, cache.direction, near);
    cache.direction = near.direction;
    if (!near.separated) pushWithoutWorkspace(A, B, X_AB, near, cache, out);
    return;
  }
  EdgeClipper clipper(A, B, X_AB, workspace);
  const auto result = A.isBox() && B.isBox() ? clipper.clipBoxes() : clipper.clip(overlap);
  if (result == EdgeClipper::Result::kClosed && integrateContact(workspace, &A, &B, X_AB, cache, request, out)) {
    out.status = Status::kOverlap;
    return;
  }
  // Nothing found: nearly always separated, which a direction must prove. Else cutting decides.
  if (result == EdgeClipper::Result::kNothing) {
    ClosestPoints near;
    closestPoints(A, B, X_AB, cache.direction, near);
    if (near.separated) {
      cache.direction = near.direction;
      cache.vertex_a = near.vertex_a;
      cache.vertex_b = near.vertex_b;
      return;
    }
  }
  if (!cutAndIntegrate(A, B, X_AB, cache, workspace, request, out)) decideWithoutVolume(A, B, X_AB, cache, out);
}

void findContactByCutting(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                          PairCache& cache, ContactWorkspace& workspace, const ContactRequest& request,
                          ContactVolume& out) {
  out = ContactVolume{};
  if (!(cache.direction.squaredNorm() > 0)) cache.direction = firstDirection(A, B, X_AB);
  if (gapAlong(A, B, X_AB, cache.direction, cache.vertex_a, cache.vertex_b) > 0) return;
  if (!cutAndIntegrate(A, B, X_AB, cache, workspace, request, out)) decideWithoutVolume(A, B, X_AB, cache, out);
}

/// The normal that kHistory starts from: the direction that last separated the pair.
void rememberSeparation(const ContactVolume& out, const ContactRequest& request, PairCache& cache) {
  if (request.rule == NormalRule::kHistory && out.status == Status::kSeparated) cache.normal = cache.direction;
}

}  // namespace

void contactVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB, PairCache& cache,
                   ContactWorkspace& workspace, ContactVolume& out, const ContactRequest& request) noexcept {
  workspace.round().filled = false;
  findContact(A, B, X_AB, cache, workspace, request, out);
  rememberSeparation(out, request, cache);
}

void contactVolumeByCutting(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                            PairCache& cache, ContactWorkspace& workspace, ContactVolume& out,
                            const ContactRequest& request) noexcept {
  findContactByCutting(A, B, X_AB, cache, workspace, request, out);
  rememberSeparation(out, request, cache);
}

}  // namespace haptic
