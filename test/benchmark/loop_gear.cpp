// The gear experiment: a ball is drawn over the teeth of a gear at 2 N/mm, 1 kHz and at 20 N/mm, 10 kHz. How far its
// path lies from that on a rigid gear, and how much friction deflects it.
#include <cmath>
#include <cstdio>
#include <fstream>

#include "figure.h"
#include "haptic_core/geometry/shapes.h"
#include "haptic_core/loop/hand.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

constexpr double kBall = 0.002, kPress = 2, kSpeed = 0.05, kRadius = 0.052;  // [m], [N], [m/s], [m]

/// Distance of a point from a convex polygon given by its corners in order; negative inside.
double distanceTo(const std::vector<Vector2>& polygon, const Vector2& p) {
  double outside = INFINITY, inside = -INFINITY;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 a = polygon[i], b = polygon[(i + 1) % polygon.size()], along = b - a;
    const double s = std::min(1.0, std::max(0.0, (p - a).dot(along) / along.squaredNorm()));
    outside = std::min(outside, (p - a - s * along).norm());
    inside = std::max(inside, Vector2(along.y(), -along.x()).normalized().dot(p - a));  // counter-clockwise: outward
  }
  return inside <= 0 ? inside : outside;
}

/// Cross-sections of the gear's pieces (prisms along z) in the world.
std::vector<std::vector<Vector2>> sections(const WorldDef& world) {
  std::vector<std::vector<Vector2>> all;
  for (const CollisionDef& collision : world.articulations[0].links[0].collisions) {
    std::vector<Vector2> points;
    for (const Vector3& v : collision.shape->vertices()) {
      const Vector3 p = world.articulations[0].X_WA * (collision.X_LS * v);
      if (p.z() > 0) points.push_back(p.head<2>());
    }
    Vector2 middle = Vector2::Zero();
    for (const Vector2& p : points) middle += p / static_cast<double>(points.size());
    std::sort(points.begin(), points.end(), [&](const Vector2& a, const Vector2& b) {
      return std::atan2(a.y() - middle.y(), a.x() - middle.x()) < std::atan2(b.y() - middle.y(), b.x() - middle.x());
    });
    all.push_back(points);
  }
  return all;
}

/// Foundation stiffness at which a ball pressed with kPress sinks by kPress / stiffness: k·V(d) = F with the cap's
/// volume V = π d² (R - d/3).
double foundation(double stiffness) {
  const double d = kPress / stiffness;
  return kPress / (M_PI * d * d * (kBall - d / 3));
}

struct GearResult {
  double shape_error = 0;  ///< rms distance of the ball's centre from its path on a rigid gear, while in touch [m]
  double lateral = 0;      ///< mean of friction's share of the force on the ball
  double touching = 0;     ///< share of the time
};

GearResult explore(double stiffness, double rate, const char* csv) {
  SceneDef scene = sceneNamed("gear", rate);
  const double k = foundation(stiffness);
  for (ArticulationDef& articulation : scene.world.articulations) {
    for (LinkDef& link : articulation.links) {
      for (CollisionDef& collision : link.collisions) collision.material.stiffness = k;
    }
  }
  const auto gear = sections(scene.world);
  // The hand is drawn along r = 52 mm and pressed inward: its goal lies deeper by F over the hand's stiffness.
  HandPath& path = scene.hands[0].path;
  path.keys.clear();
  TwinSettings hand;
  const double inward = kPress / hand.hand_stiffness, from = -0.5, to = 0.5, start = 1;
  const Vector3 p_WB = scene.hands[0].workspace.X_WB.p;
  const Matrix3 R_BW = scene.hands[0].workspace.X_WB.R.transpose();
  const auto goal = [&](double angle, double radius) {
    return Vector3(R_BW * (radius * Vector3(std::cos(angle), std::sin(angle), 0) - p_WB));
  };
  path.keys.push_back({0.3, Vector3::Zero(), Vector3::Zero(), 0});
  path.keys.push_back({0.7, goal(from, kRadius + 0.006), Vector3::Zero(), 0});
  const int parts = 400;
  for (int i = 0; i <= parts; ++i) {
    const double angle = from + (to - from) * i / parts;
    path.keys.push_back({start + kRadius * (angle - from) / kSpeed, goal(angle, kRadius - inward), Vector3::Zero(), 0});
  }
  RigSettings settings;
  settings.rate = rate;
  Rig rig(scene, settings);
  const double end = start + kRadius * (to - from) / kSpeed;
  const int pointer = rig.world.pointerLink(0);
  std::ofstream trace(csv);
  trace << "x,y,fx,fy\n";
  GearResult result;
  long touching = 0, all = 0;
  for (int i = 0; i < static_cast<int>(end * rate); ++i) {
    rig.run(1);
    if (i < (start + 0.1) * rate) continue;
    ++all;
    const Vector3 p = rig.world.linkPose(pointer).p, F = rig.world.pointerWrench(0).force;
    if (i % static_cast<int>(rate / 1000) == 0) trace << p.x() << "," << p.y() << "," << F.x() << "," << F.y() << "\n";
    if (F.norm() == 0) continue;
    ++touching;
    double distance = INFINITY;
    for (const auto& piece : gear) distance = std::min(distance, distanceTo(piece, p.head<2>()));
    result.shape_error += (distance - kBall) * (distance - kBall);
    double normal = 0;
    for (int c = 0; c < rig.world.contactCount(); ++c) normal += rig.world.contact(c).normal_force;
    result.lateral += normal > 0 ? std::sqrt(std::max(0.0, F.squaredNorm() - normal * normal)) / normal : 0;
  }
  result.shape_error = std::sqrt(result.shape_error / static_cast<double>(touching));
  result.lateral /= static_cast<double>(touching);
  result.touching = static_cast<double>(touching) / static_cast<double>(all);
  return result;
}

}  // namespace

void measureGear() {
  const GearResult soft = explore(2000, 1000, "gear_2n_1k.csv"), stiff = explore(20000, 10000, "gear_20n_10k.csv");
  std::printf("gear, 2 N/mm 1 kHz: touching %.2f, friction over normal force %.2f; 20 N/mm 10 kHz: %.2f, %.2f\n",
              soft.touching, soft.lateral, stiff.touching, stiff.lateral);
  figure("gear.shape_error_um_2n_1k", 1e6 * soft.shape_error, "um");
  figure("gear.shape_error_um_20n_10k", 1e6 * stiff.shape_error, "um");
  figure("gear.friction_ratio_2n_1k", soft.lateral, "1");
  figure("gear.friction_ratio_20n_10k", stiff.lateral, "1");
}

}  // namespace haptic::bench
