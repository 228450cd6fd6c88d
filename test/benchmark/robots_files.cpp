#include "robots_files.h"

#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/world.h"
#include "random_stack.h"
#include "robots_kdl.h"
#include "scene/mesh_file.h"
#include "scene/mesh_shapes.h"
#include "scene/robot_file.h"
#include "scene/scene_file.h"

namespace haptic::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// A loaded file, and the longest that its loader was silent [s].
struct Loaded {
  SceneDef scene;
  std::string refused;
  double seconds = 0, silent = 0;
};

Loaded load(const std::string& file) {
  Loaded loaded;
  const Clock::time_point start = Clock::now();
  Clock::time_point told = start;
  SceneOptions options;
  options.default_density = 1000;
  options.missing = MissingMeshes::kBox;
  const auto heard = [&] {
    loaded.silent = std::max(loaded.silent, secondsSince(told));
    told = Clock::now();
  };
  options.progress = [&](const std::string&) { heard(); };
  try {
    loaded.scene = loadScene(file, options);
  } catch (const SetupError& error) {
    loaded.refused = error.what();
  }
  heard();
  loaded.seconds = secondsSince(start);
  return loaded;
}

/// How deep a point lies in the piece that has it deepest: what is felt there is at least so far outside [m].
double buriedBy(const std::vector<const CollisionDef*>& pieces, const Vector3& p) {
  double deepest = 0;
  for (const CollisionDef* piece : pieces) {
    const ConvexPolyhedron* solid = piece->shape->polyhedron();
    if (!solid) continue;
    double depth = INFINITY;
    for (const auto& face : solid->faces()) depth = std::min(depth, face.offset - face.normal.dot(p));
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

/// Largest distance of a mesh from what collides for it, beyond what its line says; what is said to be replaced is said [m].
double unsaid(const std::string& file, const SceneDef& scene) {
  const auto robot = readRobot(file, {});
  double worst = 0;
  for (const LinkXml& link : robot->links) {
    for (std::size_t c = 0; c < link.collisions.size(); ++c) {
      const XmlElement& collision = *link.collisions[c];
      const XmlElement* shape = collision.FirstChildElement("geometry")->FirstChildElement();
      if (std::string(shape->Name()) != "mesh" || collision.FirstChildElement("haptic:shape")) continue;
      const std::string path = meshPath(*robot, file, *shape);
      const char* given = collision.Attribute("name");
      const std::string name = link.name + "/" + (given && *given ? given : "collision" + std::to_string(c));
      std::vector<const CollisionDef*> pieces;
      for (const ArticulationDef& tree : scene.world.articulations) {
        for (const LinkDef& each : tree.links) {
          for (const CollisionDef& piece : each.collisions) {
            if (piece.name == name || piece.name.rfind(name + "/", 0) == 0) pieces.push_back(&piece);
          }
        }
      }
      double said = 0;
      bool replaced = path.empty();
      for (const CollisionReport& report : scene.collisions) {
        const std::size_t at = report.text.find(" mm from the mesh");
        if (report.link == link.name && at != std::string::npos) {
          said = std::max(said, 1e-3 * std::atof(report.text.c_str() + report.text.rfind(", ", at) + 2));
        }
      }
      for (const std::string& line : scene.replaced) replaced |= line.find("'" + link.name + "'") != std::string::npos;
      if (replaced) continue;
      const TriangleMesh mesh = readMesh(path, meshScale(*robot, *shape), file);
      for (std::size_t i = 0; i < mesh.triangles.size(); i += 1 + mesh.triangles.size() / 3000) {
        const auto& t = mesh.triangles[i];
        const Vector3 middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
        // Three digits of the line.
        worst = std::max(worst, std::max(buriedBy(pieces, middle), buriedBy(pieces, mesh.vertices[t[0]])) - said * 1.006 - 1e-9);
      }
    }
  }
  return worst;
}

/// Median of blocks of 20 steps of 0.4 s [s]; 0: it stopped.
double stepSeconds(const SceneDef& scene) {
  World world(scene.world);
  const double seconds = secondsPerCall([&](int) { world.step(); }, 20, 20);
  return world.report().finite ? seconds : 0;
}

}  // namespace

std::vector<std::string> robotFiles() {
  const fs::path shared = fs::path(HAPTIC_SOURCE_DIR) / ".." / "shared";
  std::vector<fs::path> folders = {shared / "example-robot-data", shared / "cases"};
  if (const char* more = std::getenv("HAPTIC_ROBOTS")) folders.emplace_back(more);
  std::vector<std::string> files;
  for (const fs::path& folder : folders) {
    std::error_code code;
    for (fs::recursive_directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
      const std::string ending = entry->path().extension().string();
      if (ending == ".urdf" || ending == ".xacro") files.push_back(fs::canonical(entry->path()).string());
    }
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

void measureRobotFiles() {
  const fs::path cache = fs::temp_directory_path() / "haptic_robots_bench";
  fs::remove_all(cache);
  setenv("XDG_CACHE_HOME", cache.c_str(), 1);  // the first load finds nothing, the second all
  int tried = 0, loaded = 0, replaced = 0, refused = 0, silent = 0;
  double first = 0, cached = 0, invariants = 0, step = 0, error = 0;
  for (const std::string& file : robotFiles()) {
    ++tried;
    const Loaded once = load(file);
    silent += once.silent > 3;
    if (!once.refused.empty()) {
      refused += once.refused.find('\n') == std::string::npos;
      std::printf("robot %s|refused|%s\n", file.c_str(), once.refused.c_str());
      continue;
    }
    ++loaded;
    const SceneDef& scene = once.scene;
    const double again = load(file).seconds, off = unsaid(file, scene), seconds = stepSeconds(scene);
    double difference = 0;
    for (const ArticulationDef& tree : scene.world.articulations) {
      if (tree.links.size() > 1 && kdlKnows(tree)) difference = std::max(difference, differenceFromKdl(tree));
    }
    replaced += static_cast<int>(scene.replaced.size());
    first = std::max(first, once.seconds), cached = std::max(cached, again), error = std::max(error, off);
    invariants = std::max(invariants, difference), step = std::max(step, seconds);
    std::printf("robot %s|loaded|%d|%d of %d|%.2f|%.2f|%.3g|%.3g|%.1f\n", file.c_str(), scene.joints, scene.collisions_loaded,
                scene.collisions_tried, once.seconds, again, 1e3 * off, difference, 1e6 * seconds);
    for (const std::string& line : scene.replaced) std::printf("replaced %s\n", line.c_str());
  }
  fs::remove_all(cache);
  figure("robots.tried", tried, "1");
  figure("robots.loaded", loaded, "1");
  figure("robots.replaced_parts", replaced, "1");
  figure("robots.refused_with_reason", refused, "1");
  figure("robots.silent_over_3s", silent, "1");
  figure("robots.surface_err_mm_unsaid", 1e3 * error, "mm");
  figure("robots.load_s_max", first, "s");
  figure("robots.load_cached_s_max", cached, "s");
  figure("robots.invariants_err_max", invariants, "1");
  figure("robots.step_us_max", step * 1e6, "us");
}

void measureChosenStiffness() {
  std::mt19937 random(1);
  double worst = 0;
  int warned = 0, settled = 0;
  for (int i = 0; i < 200; ++i) {
    SceneOptions options;
    options.add_pointer = false;
    options.text = randomStack(random);
    const SceneDef scene = loadScene("stack", options);

    const bool told = std::any_of(scene.warnings.begin(), scene.warnings.end(),
                                  [](const std::string& line) { return line.find("of the least extent") != std::string::npos; });
    warned += told;
    World world(scene.world);
    for (int s = 0; s < 4000; ++s) world.step();
    std::vector<double> extent;  // by link, of its one collision
    for (const ArticulationDef& tree : scene.world.articulations) {
      for (const LinkDef& link : tree.links) {
        const auto box = link.collisions.empty() ? ConvexShape::Box{} : link.collisions[0].shape->aabb();
        extent.push_back(link.collisions.empty() ? INFINITY : (box.upper - box.lower).minCoeff());
      }
    }
    bool rests = world.report().finite;
    for (int l = 0; l < world.linkCount(); ++l) {
      rests &= world.linkTwist(l).linear.norm() < 1e-3 && world.linkTwist(l).angular.norm() < 2e-2;
    }
    settled += rests;
    if (told || !rests) continue;
    for (int c = 0; c < world.contactCount(); ++c) {
      const ContactReport& contact = world.contact(c);
      const double share = contact.depth / std::min(extent[contact.link_a], extent[contact.link_b]);
      worst = std::max(worst, share);
      if (share <= 0.01) continue;
      std::printf("stack %d: %s in %s by %.3g of the least extent, %.3g N on %.3g m²\n", i, world.linkName(contact.link_a).c_str(),
                  world.linkName(contact.link_b).c_str(), share, contact.normal_force, contact.area);
    }
  }
  figure("chosen.stacks", 200, "1");
  figure("chosen.settled", settled, "1");
  figure("chosen.sink_share_max", worst, "1");
  figure("chosen.warned", warned, "1");
}

}  // namespace haptic::bench
