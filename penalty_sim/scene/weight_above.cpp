#include "scene/weight_above.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "haptic_core/analysis/chosen_stiffness.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

constexpr double kNear = 0.5;  // of the lower height: a gap that closes as bodies settle, or an overlap of leaning boxes

/// The span of a collision along gravity and across it.
struct Span {
  int articulation, link;
  double extent;
  Vector3 lower, upper;  ///< z: up
};

Matrix3 upwards(const Vector3& gravity) {
  const Vector3 up = -gravity.normalized();
  const Vector3 across = (std::abs(up.x()) < 0.5 ? Vector3::UnitX() : Vector3::UnitY()).cross(up).normalized();
  Matrix3 R;  // rows: across, across, up
  R << across.transpose(), up.cross(across).transpose(), up.transpose();
  return R;
}

std::vector<Span> spansOf(const WorldDef& world, const std::vector<std::vector<std::vector<double>>>& extents) {
  const Matrix3 R = upwards(world.settings.gravity);
  std::vector<Span> spans;
  for (std::size_t a = 0; a < world.articulations.size(); ++a) {
    const std::vector<Pose> X_WL = initialPoses(world.articulations[a]);
    for (std::size_t l = 0; l < X_WL.size(); ++l) {
      const auto& collisions = world.articulations[a].links[l].collisions;
      for (std::size_t c = 0; c < collisions.size(); ++c) {
        if (!collisions[c].shape->bounded()) continue;
        const auto box = collisions[c].shape->aabb(Pose(R, Vector3::Zero()) * X_WL[l] * collisions[c].X_LS);
        spans.push_back({static_cast<int>(a), static_cast<int>(l), extents[a][l][c], box.lower, box.upper});
      }
    }
  }
  return spans;
}

bool isAbove(const Span& a, const Span& b) {
  for (int k = 0; k < 2; ++k) {
    if (a.lower[k] > b.upper[k] || b.lower[k] > a.upper[k]) return false;
  }
  const double near = kNear * std::min(a.upper.z() - a.lower.z(), b.upper.z() - b.lower.z());
  return std::abs(a.lower.z() - b.upper.z()) <= near;
}

bool floats(const ArticulationDef& tree) { return tree.links[0].joint.type == JointType::kFloating; }

double weightOf(const ArticulationDef& tree, double gravity) {
  double mass = 0;
  for (const LinkDef& link : tree.links) mass += link.inertia.mass;
  return gravity * mass;
}

}  // namespace

std::vector<std::vector<LinkLoad>> loadsOf(const WorldDef& world, const std::vector<std::vector<std::vector<double>>>& extents) {
  const double g = world.settings.gravity.norm();
  const std::size_t count = world.articulations.size();
  std::vector<std::vector<LinkLoad>> loads(count);
  std::vector<std::vector<std::vector<char>>> on_link(count);  // on_link[a][l][b]: body b stands on that link
  for (std::size_t a = 0; a < count; ++a) {
    const std::size_t links = world.articulations[a].links.size();
    on_link[a].assign(links, std::vector<char>(count, 0));
    for (std::size_t l = 0; l < links; ++l) {
      loads[a].push_back({carriedWeight(world.articulations[a], static_cast<int>(l), g), INFINITY});
    }
  }
  if (!(g > 0)) return loads;
  const std::vector<Span> spans = spansOf(world, extents);
  std::vector<std::vector<int>> on_body(count);
  for (const Span& upper : spans) {
    for (const Span& lower : spans) {
      if (upper.articulation == lower.articulation || !isAbove(upper, lower)) continue;
      double& above = loads[upper.articulation][upper.link].thinnest;
      above = std::min(above, lower.extent);
      if (!floats(world.articulations[upper.articulation])) continue;
      on_link[lower.articulation][lower.link][upper.articulation] = 1;
      on_body[lower.articulation].push_back(upper.articulation);
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t l = 0; l < loads[a].size(); ++l) {
      if (!(loads[a][l].weight > 0)) continue;
      std::vector<int> open;
      std::vector<char> counted(count, 0);
      counted[a] = 1;
      const auto take = [&](int b) {
        if (!counted[b]) counted[b] = 1, open.push_back(b);
      };
      for (std::size_t b = 0; b < count; ++b) {
        if (on_link[a][l][b]) take(static_cast<int>(b));
      }
      if (floats(world.articulations[a])) {
        for (const int b : on_body[a]) take(b);
      }
      while (!open.empty()) {
        const int b = open.back();
        open.pop_back();
        loads[a][l].weight += weightOf(world.articulations[b], g);
        for (const int c : on_body[b]) take(c);
      }
    }
  }
  return loads;
}

}  // namespace haptic
