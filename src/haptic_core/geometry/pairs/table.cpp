#include "haptic_core/geometry/pairs/table.h"

#include "haptic_core/geometry/pairs/ball_contact.h"
#include "haptic_core/geometry/pairs/ball_rod_contact.h"
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

/// Part of the approach rate that a shape's movingTurns leave, over a patch of tangents x and y in its frame: see CompressingRate.
CompressingRate compressingRate(Shape shape, const Vector3& x, const Vector3& y, const Vector3& p_SP) {
  if (!shape.spins()) return {};
  const Vector3 &moving = shape.movingTurns(), lever = p_SP.cross(x.cross(y)), spins = lever - moving.cwiseProduct(lever),
                along_x = moving.cwiseProduct(x), along_y = moving.cwiseProduct(y);
  // The slope of a turn (ω_x, ω_y) is (ω_y, -ω_x).
  const double mixed = -along_x.dot(y);
  CompressingRate out;
  out.all = false;
  out.slope << along_y.dot(y), mixed, mixed, along_x.dot(x);
  out.lever << spins.dot(y), -spins.dot(x);
  return out;
}

/// Of two bodies the spins of both are taken away, one after the other, in the mean of both orders: for parallel axes those about
/// one, for crossed ones all in the plane of both, continuous between.
CompressingRate compressingRate(Shape A, Shape B, const Pose& X_AB, const Pose& X_AP) {
  const auto into_B = [&](const Vector3& v) { return Vector3(X_AB.R.col(0).dot(v), X_AB.R.col(1).dot(v), X_AB.R.col(2).dot(v)); };
  const Vector3 x = X_AP.R.col(0), y = X_AP.R.col(1);
  const CompressingRate a = compressingRate(A, x, y, X_AP.p), b = compressingRate(B, into_B(x), into_B(y), into_B(X_AP.p - X_AB.p));
  CompressingRate out;
  out.all = false;
  const Matrix2 product = a.slope * b.slope;
  out.slope = 0.5 * (product + product.transpose());
  out.lever = 0.5 * (a.lever + b.lever + a.slope * b.lever + b.slope * a.lever);
  return out;
}

}  // namespace

const PairEntry& pairEntry(ShapeKind first, ShapeKind second) noexcept {
  return kTable[static_cast<int>(first)][static_cast<int>(second)];
}

void contactVolume(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, PairCache& cache, ContactWorkspace& workspace,
                   ContactVolume& out, const ContactRequest& request) noexcept {
  const ShapePair pair = ordered(A, B, X_AB);
  entryOf(pair).contact(pair, request, cache, workspace, out);
  out.compressing = A.spins() || B.spins() ? compressingRate(A, B, X_AB, out.X_AP) : CompressingRate{};
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
