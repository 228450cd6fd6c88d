#include "haptic_core/geometry/pairs/half_space_contact.h"

#include "haptic_core/geometry/pairs/round_contact.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/geometry/volume/volume_cutting.h"

namespace haptic {

class HalfSpaceContact : public RoundContact {
 public:
  using RoundContact::RoundContact;

  /// The half-space is A, or B.
  void polyhedron(const ConvexPolyhedron& shape, bool is_a, const Pose& X_AB) {
    const Vector3 normal = is_a ? Vector3(Vector3::UnitZ()) : Vector3(X_AB.R.col(2));
    const ContactFace plane{normal, is_a ? 0 : normal.dot(X_AB.p), 0, is_a ? Owner::kA : Owner::kB};  // its surface, in A
    const Pose X_AS = is_a ? X_AB : Pose();
    const Vector3 n = is_a ? plane.normal : Vector3(-plane.normal);  // from A into B
    int& hint = is_a ? cache_.vertex_b : cache_.vertex_a;
    hint = shape.support(-(X_AS.R.transpose() * plane.normal), hint);
    const Vector3 lowest = X_AS * shape.vertices()[hint];
    const double depth = plane.offset - plane.normal.dot(lowest);
    if (depth < 0) return setSeparated(n, -depth);
    if (w_.solid().faces.capacity() <= shape.faceCount()) return setCube(n, lowest + 0.5 * depth * plane.normal, depth);
    bool complete = true;
    cutVolume(shape, X_AS, is_a ? Owner::kB : Owner::kA, plane, w_, complete);
    if (!complete) out_.flags |= ContactVolume::kCapacityExceeded;
    const ContactRequest along_n{request_.rule, request_.inner, n};
    if (!integrateContact(w_, nullptr, nullptr, X_AB, cache_, along_n, out_)) return setTouching(n, lowest);
    out_.status = ContactVolume::Status::kOverlap;
  }
};

void halfSpacePolyhedronContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                                ContactVolume& out) noexcept {
  HalfSpaceContact(request, cache, workspace, out).polyhedron(*pair.second.polyhedron(), !pair.turned, pair.X_AB);
}

}  // namespace haptic
