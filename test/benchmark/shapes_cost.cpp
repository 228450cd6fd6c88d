// Instructions of a contact of two rods over those of a contact of two boxes, in one program.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "instruction_count.h"
#include "shapes_figures.h"

namespace haptic::bench {
namespace {

Matrix3 turnOf(double angle, const Vector3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// A class of poses of two shapes.
struct PoseClass {
  const char* name;
  std::shared_ptr<const ConvexShape> a, b;
  std::vector<Pose> poses;
};

std::shared_ptr<const Rod> rodOf(double r, double half, bool round) {
  return std::make_shared<Rod>(r, 2 * half, round ? Rod::Ends::kRound : Rod::Ends::kFlat);
}

/// A has radius 1 and half length 3, B 0.8 and 2.5, as in the measurements that the bounds come from; depths
/// 1e-6…0.1. `only`: no other class but this, since rods are dear to make under callgrind; empty: all.
std::vector<PoseClass> classes(const std::string& only = "") {
  std::vector<PoseClass> out;
  const auto box = std::make_shared<ConvexPolyhedron>(makeBox(Vector3(0.1, 0.1, 0.1)));
  out.push_back({"box", box, box, {Pose(turnOf(0.3, Vector3::UnitZ()), Vector3(0.01, 0.02, 0.099))}});
  constexpr double kDepths[] = {1e-6, 1e-3, 0.1};
  const auto add = [&](const char* name, bool round_a, bool round_b, auto pose, double half_a = 3, double half_b = 2.5) {
    if (!only.empty() && only != name) return;
    PoseClass c{name, rodOf(1, half_a, round_a), rodOf(0.8, half_b, round_b), {}};
    for (const double depth : kDepths) pose(depth, c.poses);
    out.push_back(c);
  };
  // B's axis from A's, z, turned about x by the angle; B beyond A along x, and `along` A's axis.
  const auto beside = [](double depth, double angle, double along, double across = 0) {
    return Pose(turnOf(angle, Vector3::UnitX()), Vector3(1.8 - depth, across, along));
  };
  constexpr double kDegree = M_PI / 180;
  const auto crossing = [=](double depth, std::vector<Pose>& poses) {
    for (const double angle : {90, 60, 30, 10, 5}) poses.push_back(beside(depth, angle * kDegree, 0.3));
  };
  // So long that at 5 degrees no end lies in the patch.
  add("sides", false, false, crossing, 12, 12);
  add("capsule_sides", true, true, crossing, 12, 12);
  for (const bool round_a : {false, true}) {
    for (const bool round_b : {false, true}) {
      if (round_b && !round_a) continue;
      const std::string kind = !round_a ? "cylinder_" : round_b ? "capsule_" : "mixed_";
      static std::vector<std::string> names;
      names.reserve(64);
      const auto named = [&](const char* what) {
        names.push_back(kind + what);
        return names.back().c_str();
      };
      add(named("parallel"), round_a, round_b, [=](double depth, std::vector<Pose>& poses) {
        for (const double along : {0.0, 1.0, 3.5}) poses.push_back(beside(depth, 0, along));
      });
      add(named("nearly_parallel"), round_a, round_b, [=](double depth, std::vector<Pose>& poses) {
        for (const double along : {0.0, 1.0, 2.8}) poses.push_back(beside(depth, 0.5 * kDegree, along));
      });
      add(named("over_end"), round_a, round_b, [=](double depth, std::vector<Pose>& poses) {
        for (const double angle : {90, 30, 5}) poses.push_back(beside(depth, angle * kDegree, 3.0));
      });
      add(named("end_on_side"), round_a, round_b,
          [=](double depth, std::vector<Pose>& poses) {  // T, and tilted
            for (const double tilt : {0.0, 10.0, 35.0}) {
              const Matrix3 R =
                  turnOf(tilt * kDegree, Vector3(0.3, 0, 1)) * turnOf(M_PI / 2, Vector3::UnitY());
              const Rod B(0.8, 5, round_b ? Rod::Ends::kRound : Rod::Ends::kFlat);
              const Vector3 lowest =
                  R * B.core(R.transpose() * -Vector3::UnitX()) - B.rounding() * Vector3::UnitX();
              poses.push_back(Pose(R, Vector3(1 - depth, 0, 0.5) - lowest));
            }
          });
      add(named("end_on_end"), round_a, round_b, [=](double depth, std::vector<Pose>& poses) {
        for (const double tilt : {0.0, 0.01, 3.0}) {
          for (const double off : {0.0, 0.4}) {
            // Flat ends side by side, round ones at an angle.
            const Matrix3 R = turnOf(tilt * kDegree, Vector3::UnitY());
            const Vector3 way = Vector3(round_b ? off : 0, 0, 1).normalized(),
                          beside_it(round_b ? 0 : off, 0, 0);
            const Rod A(1, 6, round_a ? Rod::Ends::kRound : Rod::Ends::kFlat),
                B(0.8, 5, round_b ? Rod::Ends::kRound : Rod::Ends::kFlat);
            const Vector3 a = A.core(way) + A.rounding() * way,
                          b = R * B.core(R.transpose() * -way) - B.rounding() * way;
            poses.push_back(Pose(R, a - b - depth * way + (round_a ? Vector3(Vector3::Zero()) : beside_it)));
          }
        }
      });
    }
  }
  return out;
}

}  // namespace

void countRodPass(const char* name, int passes) {
  for (const PoseClass& c : classes(name)) {
    if (std::string(name) != c.name) continue;
    ContactWorkspace workspace;
    workspace.reserve(*c.a, *c.b);
    std::vector<PairCache> cache(c.poses.size());
    ContactVolume out;
    const auto pass = [&] {
      for (std::size_t i = 0; i < c.poses.size(); ++i)
        contactVolume(*c.a, *c.b, c.poses[i], cache[i], workspace, out);
    };
    pass();
    for (const Pose& X : c.poses) {
      PairCache fresh;
      contactVolume(*c.a, *c.b, X, fresh, workspace, out);
      if (out.status == ContactVolume::Status::kOverlap) continue;
      std::printf("a pose of %s has no overlap: counts would be too small\n", c.name);
      std::exit(1);
    }
    if (passes > 0)
      countedPass([&] {
        for (int i = 0; i < passes; ++i) pass();
      });
  }
}

void measureRodCost() {
  double box = 0, sides = 0, cylinders = 0, capsules = 0;
  std::size_t poses = 0;
  for (const PoseClass& c : classes()) {
    constexpr int kPasses = 4;
    const double each = instructionsOf("--count " + std::string(c.name) + " " + std::to_string(kPasses)) /
                        (kPasses * c.poses.size());
    instructionFigure(std::string("rod_rod.instructions.") + c.name, each);
    const std::string name = c.name;
    if (name == "box") box = each;
    if (name == "sides") sides = each;
    if (name.rfind("cylinder_", 0) == 0) cylinders += each * c.poses.size(), poses += c.poses.size();
    if (name.rfind("capsule_", 0) == 0 || name.rfind("mixed_", 0) == 0) capsules = std::max(capsules, each);
  }
  if (!std::isfinite(box)) return;
  figure("rod_rod.sides_vs_box", sides / box, "");
  figure("rod_rod.cylinder_ends_vs_box", cylinders / poses / box, "");
  figure("rod_rod.capsules_vs_box", capsules / box, "");
}

}  // namespace haptic::bench
