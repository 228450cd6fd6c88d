#include "haptic_core/geometry/half_space_contact.h"

#include "haptic_core/geometry/ball_contact.h"
#include "haptic_core/geometry/contact_moments.h"
#include "haptic_core/geometry/half_space.h"
#include "haptic_core/geometry/rod_contact.h"
#include "haptic_core/geometry/round_contact.h"
#include "haptic_core/geometry/volume_cutting.h"

namespace haptic {

class HalfSpaceContact : public RoundContact {
 public:
  using RoundContact::RoundContact;

  /// The half-space is A, or B; `plane` is its surface in A's frame.
  void polyhedron(const ConvexShape& A, const ConvexShape& B, bool is_a, const Pose& X_AB, const ContactFace& plane,
                  const InnerSides& inner) {
    const ConvexPolyhedron& shape = is_a ? *B.polyhedron() : *A.polyhedron();
    const Pose X_AS = is_a ? X_AB : Pose();
    const Vector3 n = is_a ? plane.normal : Vector3(-plane.normal);  // from A into B
    int& hint = is_a ? cache_.vertex_b : cache_.vertex_a;
    hint = shape.support(-(X_AS.R.transpose() * plane.normal), hint);
    const Vector3 lowest = X_AS * shape.vertices()[hint];
    const double depth = plane.offset - plane.normal.dot(lowest);
    if (depth < 0) return setSeparated(n, -depth);
    cache_.normal = n;
    if (w_.solid().faces.capacity() <= shape.faceCount()) return setCube(n, lowest + 0.5 * depth * plane.normal, depth);
    bool complete = true;
    cutVolume(shape, X_AS, is_a ? Owner::kB : Owner::kA, plane, w_, complete);
    if (!complete) out_.flags |= ContactVolume::kCapacityExceeded;
    // The normal is known, to the last bit: as one that history gives.
    if (!integrateContact(w_, A, B, X_AB, cache_, NormalRule::kHistory, inner, out_)) return setTouching(n, lowest);
    out_.status = ContactVolume::Status::kOverlap;
  }

  using RoundContact::setSeparated;
};

void halfSpaceContact(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache, ContactWorkspace& workspace,
                      ContactVolume& out, NormalRule rule, const InnerSides& inner) noexcept {
  const bool is_a = A.halfSpace() != nullptr;
  const ConvexShape& other = is_a ? B : A;
  if (other.rod()) return rodOnHalfSpace(*other.rod(), is_a, X_AB, cache, workspace, out, rule);
  if (other.ball()) return ballOnHalfSpace(other.ball()->radius(), is_a, X_AB, cache, workspace, out, rule);
  HalfSpaceContact contact(rule, cache, workspace, out);
  if (other.halfSpace()) return contact.setSeparated(Vector3::UnitZ(), 0);
  const Vector3 normal = is_a ? Vector3(Vector3::UnitZ()) : Vector3(X_AB.R.col(2));
  contact.polyhedron(A, B, is_a, X_AB, {normal, is_a ? 0 : normal.dot(X_AB.p), 0, is_a ? Owner::kA : Owner::kB}, inner);
}

}  // namespace haptic
