#include "haptic_core/geometry/pairs/table.h"

#include "haptic_core/geometry/pairs/ball_contact.h"
#include "haptic_core/geometry/pairs/ball_rod_contact.h"
#include "haptic_core/geometry/pairs/compressing_rate.h"
#include "haptic_core/geometry/pairs/ellipsoid_contact.h"
#include "haptic_core/geometry/pairs/half_space_contact.h"
#include "haptic_core/geometry/pairs/rod_contact.h"
#include "haptic_core/geometry/pairs/rod_rod_contact.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/pairs/stand_in.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {
namespace {

using Shape = const ConvexShape&;
using Room = ContactWorkspace&;

void polyhedraContact(const ShapePair& pair, const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace,
                      ContactVolume& out) noexcept {
  contactVolume(*pair.A().polyhedron(), *pair.B().polyhedron(), pair.X_AB, cache, workspace, out, request);
}

/// Neither of two half-spaces moves: they never touch.
void halfSpacesContact(const ShapePair&, const ContactRequest&, PairCache&, ContactWorkspace& workspace, ContactVolume& out) noexcept {
  workspace.clear();
  out = ContactVolume{};
}

constexpr PairEntry kNone{nullptr, nullptr, nullptr};
constexpr PairEntry kStandIn{standInContact, coresDistance, standInRoom};
constexpr PairEntry kTable[kShapeKinds][kShapeKinds] = {
    // half-space with half-space, polyhedron, ball, rod, ellipsoid, any other with a support function
    {{halfSpacesContact, halfSpaceDistance, [](Shape, Shape, Room) {}},
     {halfSpacePolyhedronContact, halfSpaceDistance, [](Shape, Shape b, Room w) { w.reserveCut(b, 1); }},
     {halfSpaceBallContact, halfSpaceDistance, [](Shape a, Shape, Room w) { w.reserveRound(a); }},
     {halfSpaceRodContact, halfSpaceDistance, [](Shape a, Shape, Room w) { w.reserveRod(a); }},
     {halfSpaceEllipsoidContact, halfSpaceDistance, [](Shape a, Shape, Room w) { w.reserveRound(a); }},
     {standInContact, halfSpaceDistance, standInRoom}},
    // polyhedron
    {kNone,
     {polyhedraContact, polyhedraDistance, [](Shape a, Shape b, Room w) { w.reserve(*a.polyhedron(), *b.polyhedron()); }},
     {polyhedronBallContact, polyhedronBallDistance, [](Shape a, Shape, Room w) { w.reserveRound(a); }},
     {polyhedronRodContact, coresDistance, [](Shape a, Shape, Room w) { w.reserveRod(a); }},
     {polyhedronEllipsoidContact, coresDistance, [](Shape a, Shape, Room w) { w.reserveCut(a, 0); }},
     kStandIn},
    // ball
    {kNone, kNone,
     {ballsContact, ballsDistance, [](Shape a, Shape, Room w) { w.reserveRound(a); }},
     {ballRodContact, coresDistance, [](Shape a, Shape, Room w) { w.reserveRod(a); }},
     kStandIn, kStandIn},
    // rod
    {kNone, kNone, kNone,
     {rodRodContact, coresDistance, [](Shape a, Shape, Room w) { w.reserveRod(a), w.round().reserveRods(); }},
     kStandIn, kStandIn},
    // ellipsoid
    {kNone, kNone, kNone, kNone, kStandIn, kStandIn},
    // any other
    {kNone, kNone, kNone, kNone, kNone, kStandIn}};

/// The pair in the table's order, while X_AB lives.
ShapePair ordered(Shape A, Shape B, const Pose& X_AB) {
  const bool turned = A.kind() > B.kind();
  return {turned ? B : A, turned ? A : B, turned, X_AB};
}

const PairEntry& entryOf(const ShapePair& pair) {
  return pairEntry(pair.first.kind(), pair.second.kind());
}

/// What rounding leaves of two shapes that just touch, a volume without depth, has no patch that could press.
void dropEmpty(ContactVolume& out) noexcept {
  if (out.status != ContactVolume::Status::kOverlap || (out.depth > 0 && out.volume > 0)) return;
  out.status = ContactVolume::Status::kTouching;
  out.volume = out.A0 = out.depth = 0;
  out.area_vector_A.setZero(), out.A1.setZero();
  out.A2.setZero(), out.V2.setZero();
}

}  // namespace

const PairEntry& pairEntry(ShapeKind first, ShapeKind second) noexcept {
  return kTable[static_cast<int>(first)][static_cast<int>(second)];
}

void contactVolume(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache, ContactWorkspace& workspace,
                   ContactVolume& out, const ContactRequest& request) noexcept {
  const ShapePair pair = ordered(A, B, X_AB);
  entryOf(pair).contact(pair, request, cache, workspace, out);
  dropEmpty(out);
  out.compressing = compressingRate(A, B, X_AB, out);
}

void closestPoints(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                   ClosestPoints& result) noexcept {
  const ShapePair pair = ordered(A, B, X_AB);
  entryOf(pair).distance(pair, direction, result);
}

void ContactWorkspace::reserve(const ConvexShape& A, const ConvexShape& B) {
  const bool turned = A.kind() > B.kind();
  const ConvexShape &first = turned ? B : A, &second = turned ? A : B;
  pairEntry(first.kind(), second.kind()).room(first, second, *this);
}

void ContactWorkspace::reserve(const std::vector<const ConvexShape*>& shapes) {
  // With the shape of most faces of each kind every shape has met its largest partners.
  const ConvexShape* finest[kShapeKinds] = {};
  for (const ConvexShape* shape : shapes) {
    const ConvexShape*& best = finest[static_cast<int>(shape->kind())];
    if (!best || shape->faceCount() > best->faceCount()) best = shape;
  }
  for (const ConvexShape* shape : shapes) {
    for (const ConvexShape* partner : finest) {
      if (partner) reserve(*shape, *partner);
    }
  }
}

int cachedVertices(const ConvexShape& shape) {
  const ConvexPolyhedron* solid = shape.polyhedron() ? shape.polyhedron() : shape.tessellation();
  return solid ? static_cast<int>(solid->vertices().size()) : 1;
}

}  // namespace haptic
