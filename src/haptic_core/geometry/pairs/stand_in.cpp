#include "haptic_core/geometry/pairs/stand_in.h"

namespace haptic {

void standInContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                    ContactVolume& out) noexcept {
  const ConvexShape &A = pair.A(), &B = pair.B();
  const bool alike = A.kind() == B.kind();
  const bool a = alike ? A.tessellationError() <= B.tessellationError() : A.kind() > B.kind(),
             b = alike ? B.tessellationError() <= A.tessellationError() : !a;
  ContactRequest rest = request;
  if (a) rest.inner.a = nullptr;  // covers are of faces that the shape has itself
  if (b) rest.inner.b = nullptr;
  contactVolume(a ? *A.tessellation() : A, b ? *B.tessellation() : B, pair.X_AB, cache, workspace, out, rest);
}

void standInRoom(const ConvexShape& first, const ConvexShape& second, ContactWorkspace& workspace) {
  workspace.reserve(first, *second.tessellation());
  if (first.kind() != second.kind()) return;
  workspace.reserve(*first.tessellation(), second);
  workspace.reserve(*first.tessellation(), *second.tessellation());
}

}  // namespace haptic
