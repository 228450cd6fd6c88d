#include "scene/stiffness_choice.h"

#include <cmath>
#include <map>
#include <sstream>

#include "haptic_core/analysis/chosen_stiffness.h"

namespace haptic {
namespace {

/// Sets a value, and where it comes from, of every collision of the link that gives no stiffness. False: none is in a file.
bool give(LoadContext& context, int articulation, int link, double ContactMaterial::*field, double value,
          const std::string& reason) {
  SceneDef& scene = context.scene;
  for (CollisionDef& collision : scene.world.articulations[articulation].links[link].collisions) {
    if (std::isnan(collision.material.stiffness)) collision.material.*field = value;
  }
  bool listed = false;
  for (const SilentCollision& silent : context.silent) {
    if (silent.articulation != articulation || silent.link != link) continue;
    listed = true;
    CollisionReport& report = scene.collisions[silent.report];
    report.material.*field = value;
    report.material_source += "; stiffness chosen: " + reason;
  }
  return listed;
}

void makeOf(const GivenSolid& solid, LoadContext& context) {
  for (const SilentCollision& silent : context.silent) {
    CollisionReport& report = context.scene.collisions[silent.report];
    std::string reason;
    report.material.stiffness = stiffnessOf(solid, silent.extent, reason);
    report.material_source += "; the scene's material: " + reason;
    std::vector<CollisionDef>& all = context.scene.world.articulations[silent.articulation].links[silent.link].collisions;
    for (std::size_t i = 0; i < silent.count; ++i) all[silent.first + i].material.stiffness = report.material.stiffness;
  }
}

void chooseTouch(const HandDef& hand, LoadContext& context) {
  const WorldDef& world = context.scene.world;
  const PointerDef& pointer = world.pointers[hand.pointer];
  const double k = touchStiffness(world, hand.pointer, {hand.workspace.scale, hand.force_scale});
  if (!(k > 0)) return;
  std::ostringstream reason;
  reason.precision(4);
  reason << k << " N/m³ with what gives none, as stiff as a relaxed hand bears that presses with 2 N at "
         << 1 / world.settings.step << " Hz";
  if (give(context, pointer.articulation, pointer.link, &ContactMaterial::touch_stiffness, k, reason.str())) return;
  context.scene.notes.push_back("contact of the added pointer: stiffness " + reason.str());  // it is in no listing
}

void chooseRest(int articulation, int link, LoadContext& context) {
  const WorldDef& world = context.scene.world;
  const ArticulationDef& tree = world.articulations[articulation];
  const double weight = carriedWeight(tree, link, world.settings.gravity.norm());
  const RestingStiffness rest = restingStiffness(tree.links[link], weight);
  if (!(rest.stiffness > 0)) return;
  const double k = std::fmax(rest.stiffness, DefaultMaterial::kStiffness);
  std::ostringstream reason;
  reason.precision(3);
  reason << "rests at most " << 100 * kSink << " % of its least extent deep, " << 1e3 * kSink * rest.extent << " mm, with "
         << rest.stiffness << " N/m³ under " << weight << " N" << (k > rest.stiffness ? "; the default is stiffer" : "");
  give(context, articulation, link, &ContactMaterial::rest_stiffness, k, reason.str());
}

}  // namespace

void chooseStiffness(LoadContext& context) {
  SceneDef& scene = context.scene;
  if (context.solid) return makeOf(context.solid, context);
  if (!std::isnan(scene.world.settings.default_material.stiffness)) return;
  std::map<std::pair<int, int>, bool> held;
  for (const HandDef& hand : scene.hands) {
    const PointerDef& pointer = scene.world.pointers[hand.pointer];
    held[{pointer.articulation, pointer.link}] = true;
    chooseTouch(hand, context);
  }
  for (int a = 0; a < static_cast<int>(scene.world.articulations.size()); ++a) {
    const ArticulationDef& tree = scene.world.articulations[a];
    for (int l = 0; l < static_cast<int>(tree.links.size()); ++l) {
      bool silent = false;
      for (const CollisionDef& collision : tree.links[l].collisions) silent |= std::isnan(collision.material.stiffness);
      if (silent && !held.count({a, l})) chooseRest(a, l, context);
    }
  }
}

}  // namespace haptic
