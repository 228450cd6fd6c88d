#include <string>

#include "haptic_core/base/word_hash.h"
#include "haptic_core/geometry/convex_polyhedron.h"
#include "haptic_core/loop/session.h"

namespace haptic {
namespace {

class Digest {
 public:
  void add(double value) { hash_ = hashWords(hash_, &value, sizeof value); }
  void add(const Vector3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const Matrix3& m) {
    for (int i = 0; i < 9; ++i) add(m.data()[i]);
  }
  void add(const Pose& X) {
    add(X.R);
    add(X.p);
  }
  void add(const std::string& text) {
    add(static_cast<double>(text.size()));
    for (const char c : text) add(static_cast<double>(c));
  }
  void add(const ContactMaterial& m) {
    for (const double v : {m.stiffness, m.damping, m.dissipation, m.tangential_stiffness, m.tangential_damping,
                           m.mu_static, m.mu_dynamic}) {
      add(v);
    }
  }
  void add(const JointDef& j) {
    add(static_cast<double>(j.type));
    add(j.X_PJ);
    add(j.axis);
    for (const double v : {j.lower, j.upper, j.max_effort, j.max_velocity, j.damping, j.friction, j.position, j.velocity,
                           double(j.mimic_joint), j.mimic_multiplier, j.mimic_offset, double(j.drive), j.drive_stiffness,
                           j.drive_damping}) {
      add(v);
    }
  }
  void add(const LinkDef& link) {
    add(link.name);
    add(static_cast<double>(link.parent));
    add(link.joint);
    add(link.inertia.mass);
    add(link.inertia.p_LC);
    add(link.inertia.I_C);
    for (const CollisionDef& collision : link.collisions) {
      add(collision.X_LS);
      add(collision.material);
      for (const Vector3& vertex : collision.shape->vertices()) add(vertex);
      for (const ConvexPolyhedron::Face& face : collision.shape->faces()) add(static_cast<double>(face.count));
    }
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = kHashStart;
};

}  // namespace

std::uint64_t fingerprint(const WorldDef& def) {
  Digest digest;
  const WorldSettings& s = def.settings;
  digest.add(s.step);
  digest.add(s.gravity);
  for (const double v : {double(s.substeps), double(s.integrator), double(s.contact_model), double(s.pressure_law),
                         double(s.normal_rule), double(s.torsional_friction), double(s.energy_ledger)}) {
    digest.add(v);
  }
  digest.add(s.default_material);
  for (const ArticulationDef& articulation : def.articulations) {
    digest.add(articulation.X_WA);
    digest.add(articulation.V_WA.angular);
    digest.add(articulation.V_WA.linear);
    for (const LinkDef& link : articulation.links) digest.add(link);
  }
  for (const LoopDef& loop : def.loops) {
    for (const double v : {double(loop.articulation_a), double(loop.link_a), double(loop.articulation_b),
                           double(loop.link_b), double(loop.type)}) {
      digest.add(v);
    }
    digest.add(loop.X_AF);
    digest.add(loop.X_BF);
    digest.add(loop.axis);
  }
  for (const PointerDef& pointer : def.pointers) {
    digest.add(static_cast<double>(pointer.articulation));
    digest.add(static_cast<double>(pointer.link));
  }
  for (const CollisionFilter& f : def.filters) {
    for (const int v : {f.articulation_a, f.link_a, f.articulation_b, f.link_b}) digest.add(static_cast<double>(v));
  }
  return digest.value();
}

}  // namespace haptic
