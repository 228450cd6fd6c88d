#include <memory>

#include "haptic_core/base/fields.h"
#include "haptic_core/geometry/shapes/convex_shape.h"
#include "haptic_core/loop/session.h"

namespace haptic {

/// The numbers of a shape go to `visit`.
template <class Visit>
void eachNumber(const std::shared_ptr<const ConvexShape>& shape, Visit&& visit) {
  struct Forward : NumberVisitor {
    explicit Forward(Visit& to) : to_(to) {}
    void visit(double value) override { to_(value); }
    void visit(int value) override { to_(value); }
    Visit& to_;
  };
  Forward forward(visit);
  if (shape) shape->eachNumber(forward);
}

/// Without the derived stiffnesses: recordings of scenes that give k keep the fingerprint that they had before these fields existed.
template <class Visit>
void eachNumber(const ContactMaterial& material, Visit&& visit) {
  ContactMaterial::eachField(material, [&](const double& value) {
    const bool chosen =
        &value == &material.rest_stiffness || &value == &material.touch_stiffness || &value == &material.rigid_stiffness;
    if (!chosen || value > 0) visit(value);
  });
}

/// Without the frame where it is the link's own: recordings keep the fingerprint that they had before pointers had frames.
template <class Visit>
void eachNumber(const PointerDef& pointer, Visit&& visit) {
  const bool own = pointer.X_LP.R.isIdentity(0) && pointer.X_LP.p.isZero(0);
  PointerDef::eachField(pointer, [&](const auto& field) {
    if (static_cast<const void*>(&field) != &pointer.X_LP || !own) eachNumber(field, visit);
  });
}

std::uint64_t fingerprint(const WorldDef& def) {
  std::uint64_t hash = hashFields(kHashStart, def);
  // Lengths, which tell lists apart that hold the same numbers one after the other.
  std::vector<std::uint64_t> lengths{def.articulations.size(), def.loops.size(), def.joint_paths.size(),
                                     def.pointers.size(), def.filters.size()};
  for (const ArticulationDef& articulation : def.articulations) {
    lengths.push_back(articulation.links.size());
    for (const LinkDef& link : articulation.links) lengths.push_back(link.collisions.size());
  }
  for (const JointPathDef& path : def.joint_paths) lengths.push_back(path.time.size());
  for (const MotionDef& motion : def.motions) lengths.push_back(motion.time.size());
  if (!def.forces.empty()) lengths.push_back(def.forces.size());  // scenes without keep the fingerprint of the time before there were any
  return hashFields(hash, lengths);
}

}  // namespace haptic
