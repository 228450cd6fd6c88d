#include "haptic_core/geometry/pairs/stand_in.h"

namespace haptic {

void standInContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                    ContactVolume& out) noexcept {
  const ConvexShape &A = pair.A(), &B = pair.B();
  const bool a = A.kind() != B.kind() ? A.kind() > B.kind() : A.tessellationError() < B.tessellationError();
  ContactRequest rest = request;
  (a ? rest.inner.a : rest.inner.b) = nullptr;  // covers are of faces that the shape has itself
  contactVolume(a ? *A.tessellation() : A, a ? B : *B.tessellation(), pair.X_AB, cache, workspace, out, rest);
}

void standInRoom(const ConvexShape& first, const ConvexShape& second, ContactWorkspace& workspace) {
  workspace.reserve(first, *second.tessellation());
  if (first.kind() == second.kind()) workspace.reserve(*first.tessellation(), second);
}

}  // namespace haptic
