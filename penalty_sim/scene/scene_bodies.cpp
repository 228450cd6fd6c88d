#include "scene/scene_bodies.h"

#include <algorithm>
#include <map>
#include <set>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_shape.h"

namespace haptic {
namespace {

template <class T, class Drop>
void eraseIf(std::vector<T>& all, Drop&& drop) {
  all.erase(std::remove_if(all.begin(), all.end(), drop), all.end());
}

/// Names of links, merged ones too.
std::vector<std::string> linksOf(const ArticulationDef& articulation) {
  std::vector<std::string> names;
  for (const LinkDef& link : articulation.links) {
    names.push_back(link.name);
    for (const MergedLink& merged : link.merged) names.push_back(merged.name);
  }
  return names;
}

void refuseTaken(const SceneDef& scene, const SceneDef& model) {
  std::set<std::string> links, joints;
  for (const ArticulationDef& articulation : scene.world.articulations) {
    for (const std::string& name : linksOf(articulation)) links.insert(name);
    for (const LinkDef& link : articulation.links) joints.insert(link.joint.name);
  }
  for (const ArticulationDef& articulation : model.world.articulations) {
    for (const std::string& name : linksOf(articulation)) {
      if (links.count(name)) throw SetupError("link '" + name + "'", "is in the scene already", "give the model another name");
    }
    for (const LinkDef& link : articulation.links) {
      if (isScalar(link.joint.type) && joints.count(link.joint.name))
        throw SetupError("joint '" + link.joint.name + "'", "is in the scene already", "give the model another name");
    }
  }
  for (const SensorDef& sensor : model.world.sensors) {
    const auto& taken = scene.world.sensors;
    const bool known = std::any_of(taken.begin(), taken.end(), [&](const SensorDef& other) { return other.name == sensor.name; });
    if (known) throw SetupError("sensor '" + sensor.name + "'", "is in the scene already", "rename it in the model's file");
  }
}

/// Everything that names articulations, with new indices by `to`; what one without refers to goes, −1 of a loop or a sensor stays.
void renumber(const std::vector<int>& to, SceneDef& scene) {
  WorldDef& world = scene.world;
  const auto now = [&](int articulation) { return articulation < 0 ? articulation : to[static_cast<std::size_t>(articulation)]; };
  const auto gone = [&](int articulation) { return articulation >= 0 && now(articulation) < 0; };
  eraseIf(world.loops, [&](const LoopDef& l) { return gone(l.articulation_a) || gone(l.articulation_b); });
  for (LoopDef& l : world.loops) l.articulation_a = now(l.articulation_a), l.articulation_b = now(l.articulation_b);
  eraseIf(world.forces, [&](const ForceDef& f) { return gone(f.articulation_a) || gone(f.articulation_b); });
  for (ForceDef& f : world.forces) f.articulation_a = now(f.articulation_a), f.articulation_b = now(f.articulation_b);
  eraseIf(world.filters, [&](const CollisionFilter& f) { return gone(f.articulation_a) || gone(f.articulation_b); });
  for (CollisionFilter& f : world.filters) f.articulation_a = now(f.articulation_a), f.articulation_b = now(f.articulation_b);
  eraseIf(world.sensors, [&](const SensorDef& s) { return gone(s.articulation) || gone(s.with_articulation); });
  for (SensorDef& s : world.sensors) s.articulation = now(s.articulation), s.with_articulation = now(s.with_articulation);
  for (PointerDef& p : world.pointers) {
    if (gone(p.articulation)) throw SetupError("the link of device " + p.device, "is moved by a hand", "delete what no hand moves");
    p.articulation = now(p.articulation);
  }
  for (JointPathDef& path : world.joint_paths) {
    JointPathDef left = path;
    left.joints.clear(), left.position.clear();
    const std::size_t columns = path.joints.size();
    for (std::size_t row = 0; row < path.time.size(); ++row) {
      for (std::size_t c = 0; c < columns; ++c) {
        if (!gone(path.joints[c].first)) left.position.push_back(path.position[row * columns + c]);
      }
    }
    for (const auto& [articulation, link] : path.joints) {
      if (!gone(articulation)) left.joints.emplace_back(now(articulation), link);
    }
    path = left;
  }
  eraseIf(world.joint_paths, [](const JointPathDef& path) { return path.joints.empty(); });
  std::vector<int> motions;
  for (const MotionDef& motion : world.motions) {
    const int before = static_cast<int>(std::count_if(motions.begin(), motions.end(), [](int m) { return m >= 0; }));
    motions.push_back(gone(motion.articulation) ? -1 : before);
  }
  eraseIf(scene.told_motions, [&](const ToldMotion& told) { return motions[static_cast<std::size_t>(told.motion)] < 0; });
  for (ToldMotion& told : scene.told_motions) told.motion = motions[static_cast<std::size_t>(told.motion)];
  eraseIf(world.motions, [&](const MotionDef& motion) { return gone(motion.articulation); });
  for (MotionDef& motion : world.motions) motion.articulation = now(motion.articulation);
  eraseIf(scene.visuals, [&](const VisualDef& visual) { return gone(visual.articulation); });
  for (VisualDef& visual : scene.visuals) visual.articulation = now(visual.articulation);
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

ChangedScene withModel(const SceneDef& scene, const SceneDef& model) {
  if (!model.world.pointers.empty()) {
    throw SetupError(model.file, "has a <haptic:pointer>: hands come with the scene alone", "take it out of the model");
  }
  const auto runs = [](const auto& path) { return !path.time.empty(); };
  const auto motion = std::find_if(model.world.motions.begin(), model.world.motions.end(), runs);
  if (motion != model.world.motions.end() || !model.world.joint_paths.empty()) {
    throw SetupError(model.file, "has a path over time, which counts from the scene's start: the model would begin in its middle",
                     "lead it by a topic or tf, or put it into the scene");
  }
  refuseTaken(scene, model);
  ChangedScene changed{scene, {}, {}};
  SceneDef& next = changed.scene;
  const int count = static_cast<int>(scene.world.articulations.size());
  for (int a = 0; a < count; ++a) changed.kept.push_back(a);
  SceneDef moved = model;
  std::vector<int> to;
  for (std::size_t a = 0; a < model.world.articulations.size(); ++a) {
    to.push_back(count + static_cast<int>(a));
    changed.kept.push_back(-1);
    for (const std::string& name : linksOf(model.world.articulations[a])) changed.links.push_back(name);
  }
  renumber(to, moved);
  for (ToldMotion& told : moved.told_motions) told.motion += static_cast<int>(scene.world.motions.size());
  append(next.world.articulations, moved.world.articulations);
  append(next.world.loops, moved.world.loops);
  append(next.world.forces, moved.world.forces);
  append(next.world.joint_paths, moved.world.joint_paths);
  append(next.world.motions, moved.world.motions);
  append(next.world.filters, moved.world.filters);
  append(next.world.sensors, moved.world.sensors);
  append(next.visuals, moved.visuals);
  append(next.told_motions, moved.told_motions);
  append(next.collisions, moved.collisions);
  append(next.replaced, moved.replaced);
  append(next.warnings, moved.warnings);
  append(next.notes, moved.notes);
  next.collisions_tried += moved.collisions_tried;
  next.collisions_loaded += moved.collisions_loaded;
  next.joints += moved.joints;
  return changed;
}

ChangedScene withoutModel(const SceneDef& scene, const std::string& name) {
  ChangedScene changed{scene, {}, {}};
  std::vector<int> to;
  std::string known;
  changed.scene.world.articulations.clear();
  for (std::size_t a = 0; a < scene.world.articulations.size(); ++a) {
    const ArticulationDef& articulation = scene.world.articulations[a];
    const std::vector<std::string> links = linksOf(articulation);
    const bool goes = std::any_of(links.begin(), links.end(), [&](const std::string& link) {
      return link == name || link.rfind(name + "/", 0) == 0;
    });
    to.push_back(goes ? -1 : static_cast<int>(changed.kept.size()));
    if (goes) {
      append(changed.links, links);
      continue;
    }
    known += (known.empty() ? "" : ", ") + links.front();
    changed.kept.push_back(static_cast<int>(a));
    changed.scene.world.articulations.push_back(articulation);
  }
  if (changed.links.empty()) throw SetupError("'" + name + "'", "is no model and no link of this scene", "there are: " + known);
  if (changed.kept.empty()) throw SetupError("'" + name + "'", "is all that there is", "load another scene");
  renumber(to, changed.scene);
  const std::set<std::string> gone(changed.links.begin(), changed.links.end());
  eraseIf(changed.scene.collisions, [&](const CollisionReport& report) { return gone.count(report.link) > 0; });
  return changed;
}

SceneDef withBodies(const SceneDef& scene, const WorldDef& def) {
  std::map<std::string, std::pair<int, int>> before;
  for (std::size_t a = 0; a < scene.world.articulations.size(); ++a) {
    const auto& links = scene.world.articulations[a].links;
    for (std::size_t l = 0; l < links.size(); ++l) before[links[l].name] = {static_cast<int>(a), static_cast<int>(l)};
  }
  SceneDef next = scene;
  next.world = def;
  next.world.name = scene.world.name;
  next.visuals.clear();
  next.told_motions.clear();
  next.collisions.clear();
  for (std::size_t a = 0; a < def.articulations.size(); ++a) {
    for (std::size_t l = 0; l < def.articulations[a].links.size(); ++l) {
      LinkDef& link = next.world.articulations[a].links[l];
      const auto known = before.find(link.name);
      if (known == before.end()) {
        for (const CollisionDef& collision : link.collisions) {
          VisualDef visual;
          visual.articulation = static_cast<int>(a), visual.link = static_cast<int>(l);
          visual.name = link.name;
          visual.shape = VisualShape::kTriangles;
          visual.X_LV = collision.X_LS;
          const TriangleMesh mesh = collision.shape->triangles();
          for (const auto& triangle : mesh.triangles) {
            for (const int corner : triangle) visual.corners.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
          }
          next.visuals.push_back(visual);
        }
        continue;
      }
      const auto [articulation, index] = known->second;
      link.merged = scene.world.articulations[static_cast<std::size_t>(articulation)].links[static_cast<std::size_t>(index)].merged;
      for (VisualDef visual : scene.visuals) {
        if (visual.articulation != articulation || visual.link != index) continue;
        visual.articulation = static_cast<int>(a), visual.link = static_cast<int>(l);
        next.visuals.push_back(visual);
      }
    }
  }
  return next;
}

}  // namespace haptic
