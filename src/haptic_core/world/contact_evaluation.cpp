#include "haptic_core/world/contact_evaluation.h"

#include <algorithm>

#include "haptic_core/geometry/volume/contact_integrals.h"

namespace haptic {
namespace {

Twist twistOf(const BeltRates& belts) noexcept {
  const Vector3 rate = belts.b - belts.a;
  return {Vector3(0, 0, rate.z()), Vector3(rate.x(), rate.y(), 0)};
}

}  // namespace

BeltRates beltRates(const Model& model, int shape_a, int shape_b, const LinkWork* link, const Pose& X_WP) noexcept {
  if (!model.has_belts) return {};
  const auto of = [&](int shape) -> Vector3 {
    const Pose& X_WL = link[model.shapes[shape].link].X_WL;
    const Twist V_P = model.shapes[shape].belt.V_L.rotated(X_WL.R).shifted(X_WP.p - X_WL.p).rotated(X_WP.R.transpose());
    return {V_P.linear.x(), V_P.linear.y(), V_P.angular.z()};
  };
  return {of(shape_a), of(shape_b)};
}

Twist beltTwist(const Model& model, int shape_a, int shape_b, const LinkWork* link, const Pose& X_WP) noexcept {
  return twistOf(beltRates(model, shape_a, shape_b, link, X_WP));
}

PairLaw lawOf(const Model& model, const ContactPlaces& places, int a, int b) noexcept {
  const int link_a = model.shapes[a].link, link_b = model.shapes[b].link;
  PairLaw law = model.law(a, b, places.held_by[link_a] >= 0, places.held_by[link_b] >= 0);
  if (places.pressed) firm(model, std::max(places.pressed[link_a], places.pressed[link_b]), a, b, law);
  return law;
}

bool findVolume(const Model& model, Seams& seams, int index, ActivePair& pair, const Pose* X_WS, ContactWorkspace& workspace,
                ContactEvaluation& out) noexcept {
  const int a = pair.shapeA(), b = pair.shapeB();
  const ModelShape &A = model.shapes[a], &B = model.shapes[b];
  out.X_AB = relativePose(X_WS[a], X_WS[b]);
  const bool flush = seams.locate(index, pair, X_WS[a], out.X_AB, workspace, out.volume);
  if (out.volume.status != ContactVolume::Status::kOverlap) return false;
  if (flush) {  // joined parts: n is that of the surface that goes on from piece to piece
    out.volume.turns_with_b = A.surface.empty() ? 1 : B.surface.empty() ? 0 : 0.5;
  }
  return true;
}

void placeContact(const Model& model, const ActivePair& pair, const ContactPlaces& places, ContactEvaluation& out) noexcept {
  const int a = pair.shapeA(), b = pair.shapeB();
  const ModelShape &A = model.shapes[a], &B = model.shapes[b];
  out.X_WP = places.X_WS[a] * out.volume.X_AP;
  const LinkWork &link_a = places.link[A.link], &link_b = places.link[B.link];
  out.V_AB_P = (link_b.twistAt(out.X_WP.p) - link_a.twistAt(out.X_WP.p)).rotated(out.X_WP.R.transpose());
  out.belts = beltRates(model, a, b, places.link, out.X_WP);
  out.V_AB_P = out.V_AB_P + twistOf(out.belts);
  out.law = lawOf(model, places, a, b);
  if (pair.buried) out.law = model.recoveryLaw(out.law, a, b, out.volume);
  for (const int link : {A.link, B.link}) {
    if (!places.bound || places.held_by[link] < 0) continue;
    const int lead = places.held_by[link];
    const bool in_hand = lead < static_cast<int>(model.pointers.size());
    const Vector3 p_LH = in_hand ? model.pointerFrame(lead, link).p : Vector3::Zero().eval();
    const Vector3 arm_W = out.X_WP.p - places.link[link].X_WL * p_LH;
    boundLaw(places.bound[lead], model.settings.step, pair.friction, places.X_WS[a].R, arm_W, out.volume, out.law);
  }
}

bool locateContact(const Model& model, Seams& seams, int index, ActivePair& pair, const ContactPlaces& places,
                   ContactWorkspace& workspace, ContactEvaluation& out) noexcept {
  if (!findVolume(model, seams, index, pair, places.X_WS, workspace, out)) return false;
  placeContact(model, pair, places, out);
  return true;
}

bool evaluateContact(const Model& model, Seams& seams, int index, ActivePair& pair, const ContactPlaces& places,
                     const FrictionMemory& memory, const Advance& advance, ContactWorkspace& workspace,
                     ContactEvaluation& out) noexcept {
  if (!locateContact(model, seams, index, pair, places, workspace, out)) return false;
  Advance on = advance;
  on.belts = out.belts;
  out.force = locatedForce(out.volume, out.X_AB, workspace, out.V_AB_P, memory, out.law, on);
  return true;
}

double elasticEnergy(const ContactVolume& volume, double stiffness, ContactWorkspace& workspace) noexcept {
  return 0.5 * stiffness * thicknessSquared(workspace, volume);
}

ContactReport reportOf(const Model& model, const ActivePair& pair, const ContactVolume& volume, const Pose& X_WP,
                       const LocatedForce& force) noexcept {
  ContactReport contact;
  contact.shape_a = pair.shapeA();
  contact.shape_b = pair.shapeB();
  contact.link_a = model.shapes[contact.shape_a].link;
  contact.link_b = model.shapes[contact.shape_b].link;
  contact.X_WP = X_WP;
  contact.F_BP_W = force.F_BP_P.rotated(X_WP.R);
  contact.normal_force = force.normal_force;
  contact.volume = volume.volume;
  contact.area = volume.A0;
  contact.depth = volume.depth;
  contact.sticking = force.sticking;
  contact.flags = volume.flags | (force.incomplete ? ContactVolume::kCapacityExceeded : 0u);
  return contact;
}

}  // namespace haptic
