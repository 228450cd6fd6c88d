/// What `./run check SCENE` prints about a loaded scene.
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "scene/contact_properties.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

void printLink(const LinkDef& link, const ArticulationDef& articulation, std::ostream& out) {
  const JointDef& joint = link.joint;
  const JointKind& kind = kindOf(joint.type);
  out << "    " << link.name << ": " << kind.name;
  if (link.parent >= 0) out << " on " << articulation.links[link.parent].name;
  if (isScalar(joint.type)) {
    out << " '" << joint.name << "' at " << joint.position << (kind.turns ? " rad" : " m");
    if (std::isfinite(joint.lower) || std::isfinite(joint.upper))
      out << " in [" << joint.lower << ", " << joint.upper << "]";
    if (joint.mimic_joint >= 0) out << ", follows " << articulation.links[joint.mimic_joint].joint.name;
    if (joint.drive == JointDef::Drive::kPosition)
      out << ", held by " << joint.drive_stiffness
          << (kind.turns ? " N·m/rad" : " N/m");
  }
  if (joint.type != JointType::kFixed) out << ", " << link.inertia.mass << " kg";
  out << ", " << link.collisions.size() << " shape" << (link.collisions.size() == 1 ? "" : "s");
  for (const MergedLink& merged : link.merged) out << " + " << merged.name;
  out << "\n";
}

}  // namespace

std::string sceneText(const SceneDef& scene) {
  std::ostringstream out;
  int moving = 0, shapes = 0;
  for (const ArticulationDef& articulation : scene.world.articulations) {
    for (const LinkDef& link : articulation.links) {
      moving += link.joint.type != JointType::kFixed;
      shapes += static_cast<int>(link.collisions.size());
    }
  }
  const WorldSettings& settings = scene.world.settings;
  out << "scene '" << scene.world.name << "' from " << scene.file << "\n";
  out << "  " << scene.world.articulations.size() << " bodies and trees, " << moving << " moving links, "
      << scene.joints << " joints in the files, " << scene.world.loops.size() << " loops";
  if (!scene.world.forces.empty()) out << ", " << scene.world.forces.size() << " forces";
  out << "\n";
  out << "  collisions: " << scene.collisions_loaded << " of " << scene.collisions_tried << " loaded as "
      << shapes << " convex shapes, " << scene.world.filters.size() << " filtered pairs\n";
  out << "  step " << settings.step << " s, gravity " << settings.gravity.transpose() << " m/s²\n";
  for (const ArticulationDef& articulation : scene.world.articulations) {
    out << "  " << articulation.name << " at " << articulation.X_WA.p.transpose() << " m\n";
    for (const LinkDef& link : articulation.links) printLink(link, articulation, out);
  }
  for (const CollisionReport& collision : scene.collisions) {
    out << "  collision of " << collision.link << ": " << collision.text << "\n";
    const std::string values = contactText(collision.material, settings.default_material);
    out << "    contact: " << values << (values.empty() ? "" : "; ")
        << "source: " << collision.material_source << "\n";
  }
  for (std::size_t m = 0; m < scene.world.motions.size(); ++m) {
    const MotionDef& motion = scene.world.motions[m];
    out << "  " << motion.name << " is led along ";
    if (motion.time.empty()) {
      const auto told = std::find_if(scene.told_motions.begin(), scene.told_motions.end(),
                                     [&](const ToldMotion& t) { return t.motion == static_cast<int>(m); });
      if (told == scene.told_motions.end()) out << "what it is told";
      else out << (told->topic.empty() ? "tf frame " + told->frame : "topic " + told->topic);
    } else {
      out << motion.time.size() << " poses from " << motion.time.front() << " to " << motion.time.back() << " s"
          << (motion.repeat ? ", over and over" : "");
    }
    out << "\n";
  }
  for (const HandDef& hand : scene.hands) {
    const PointerDef& pointer = scene.world.pointers[hand.pointer];
    out << "  device '" << hand.device << "' moves "
        << scene.world.articulations[pointer.articulation].links[pointer.link].name << " ("
        << (pointer.coupling.mode == PointerCoupling::Mode::kDirect ? "direct" : "virtual")
        << " coupling), base at " << hand.workspace.X_WB.p.transpose() << " m, scale " << hand.workspace.scale
        << "\n";
  }
  for (const std::string& part : scene.replaced) out << "  replaced: " << part << "\n";
  for (const std::string& note : scene.notes) out << "  note: " << note << "\n";
  for (const std::string& warning : scene.warnings) out << "  warning: " << warning << "\n";
  return out.str();
}

}  // namespace haptic
