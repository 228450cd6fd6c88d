/// Data of the seeds' figures that are no runs of scenes.
///   seed_data lambda DEVICE_FILE            tensions and presented force along a diagonal, by λ; CSV
///   seed_data stages SCENE_FILE SECONDS     mean time of each stage of a step; one CSV line
///   seed_data gear SCENE_FILE STIFFNESS RATE  path of a ball that a hand leads along a gear's teeth: first the gear's shapes
///                                           (`shape,x,y,...`), then x,y,z,force of the pointer every millisecond
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "../comparators/velocity_verlet.h"
#include "../scenes/gear_path.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/spidar/device_def.h"
#include "haptic_core/spidar/tension_distribution.h"
#include "haptic_core/world/world.h"
#include "report_scene.h"
#include "scene/scene_file.h"

namespace {

using namespace haptic;

/// As on the seeds' slides 9-12: the same force all along a path, here 5 N against the diagonal of the frame.
void lambda(const std::string& file) {
  DeviceDef def = loadDevice(file);
  const StringKinematics kinematics(def);
  const Vector3 diagonal = Vector3::Ones().normalized();
  std::printf("lambda,position_m,force_n,tensions_n\n");
  for (const double value : {0.0, 0.1, 0.2, 0.3, 1.0}) {
    def.lambda = std::max(value, 1e-9);
    TensionDistribution distribution(def, kinematics);
    for (int i = -450; i <= 450; ++i) {
      GripPose x;
      x.X_BG.p = 1e-3 * i * diagonal;
      distribution.setStructure(kinematics.scaledStructure(x));
      Wrench F;
      F.force = -5 * diagonal;
      const TensionReport& report = distribution.solve(F);
      std::printf("%g,%g,%.9g", value, 1e-3 * i, -report.F_G_B.force.dot(diagonal));
      for (int k = 0; k < kinematics.strings(); ++k) std::printf(",%.9g", report.tension[k]);
      std::printf("\n");
    }
  }
}

void stages(const std::string& file, double seconds) {
  const report::Scene scene = report::fileScene(file);
  report::Choice choice;
  choice.comparator = comparators::velocityVerlet;
  World world(scene.make(choice));
  const double h = world.settings().step;
  world.measureStages(true);
  StageTimes sum{0, 0, 0, 0, 0};
  long steps = 0, contacts = 0, pairs = 0;
  for (; world.time() < seconds && world.report().finite; ++steps) {
    for (int i = 0; i < world.pointerCount() && scene.held; ++i) {
      const report::BodyState target = scene.held(i, world.time() + h);
      world.setPointerTarget(i, target.X_WL, target.V_WL);
    }
    world.step();
    const StageTimes& t = world.report().stages;
    sum.search += t.search;
    sum.detection += t.detection;
    sum.volume += t.volume;
    sum.force += t.force;
    sum.motion += t.motion;
    contacts += world.report().contacts;
    pairs += world.report().pairs;
  }
  const double us = 1e6 / static_cast<double>(steps);
  std::printf("%s,%ld,%.4g,%.4g,%.6g,%.6g,%.6g,%.6g,%.6g\n", scene.name.c_str(), steps, double(pairs) / double(steps),
              double(contacts) / double(steps), us * sum.search, us * sum.detection, us * sum.volume, us * sum.force,
              us * sum.motion);
}

/// A hand of 0.1 kg that feels the pointer's contact wrench and traces the gear's teeth at 0.05 m/s, led by a spring whose
/// goal lies as deep as presses 2 N. `stiffness` [N/m]: see gearFoundation.
class GearHand {
 public:
  GearHand(const std::string& file, double stiffness, double rate) : scene_(loadScene(file)), h_(1 / rate) {
    constexpr double kPress = 2;  // [N]
    WorldDef& def = scene_.world;
    def.settings.step = h_;
    def.settings.default_material.stiffness = scenes::gearFoundation(stiffness, kPress);
    def.settings.default_material.dissipation = 1;
    for (ArticulationDef& articulation : def.articulations) {
      for (LinkDef& link : articulation.links) {
        for (CollisionDef& collision : link.collisions) collision.material = ContactMaterial{};
      }
    }
    def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0.5;
    world_ = std::make_unique<World>(def);
    lane_ = scenes::goals(scenes::sections(def), scenes::Lead::kTraced, -0.5, 0.5, kPress / kHand);
    p_ = Vector3(1.15 * lane_[0].x(), 1.15 * lane_[0].y(), 0);
  }

  void printShapes() const {
    for (const ArticulationDef& articulation : scene_.world.articulations) {
      const LinkDef& link = articulation.links[0];
      if (link.joint.type != JointType::kFixed) continue;
      for (const CollisionDef& collision : link.collisions) {
        std::printf("shape");
        for (const Vector3& vertex : collision.shape->polyhedron()->vertices()) {
          const Vector3 p = articulation.X_WA * (link.joint.X_PJ * (collision.X_LS * vertex));
          std::printf(",%.6g,%.6g", p.x(), p.y());
        }
        std::printf("\n");
      }
    }
  }

  /// False at the end of the lane.
  bool step() {
    constexpr double kSpeed = 0.05, kMass = 0.1, kDamper = 30, kApproach = 0.3;  // [m/s], [kg], [N s/m], [s]
    if (world_->time() > kApproach) way_ += h_ * kSpeed;
    while (next_ + 1 < lane_.size() && way_ > (lane_[next_ + 1] - lane_[next_]).norm()) {
      way_ -= (lane_[next_ + 1] - lane_[next_]).norm();
      ++next_;
    }
    if (next_ + 1 >= lane_.size()) return false;
    const Vector2 goal = lane_[next_] + way_ * (lane_[next_ + 1] - lane_[next_]).normalized();
    const Vector3 pull = kHand * (Vector3(goal.x(), goal.y(), 0) - p_) - kDamper * v_;
    v_ += h_ / kMass * (world_->pointerWrench(0).force + pull);
    p_ += h_ * v_;
    world_->setPointerTarget(0, Pose(world_->linkPose(world_->pointerLink(0)).R, p_), Twist{Vector3::Zero(), v_});
    world_->step();
    return true;
  }
  void printRow() const {
    std::printf("%.6g,%.6g,%.6g,%.6g\n", p_.x(), p_.y(), p_.z(), world_->pointerWrench(0).force.norm());
  }

 private:
  SceneDef scene_;
  static constexpr double kHand = 3000;  // [N/m]: a firm grasp, so that the goal stays on this side of a tooth
  double h_, way_ = 0;                   // along the lane from its point `next_`
  std::size_t next_ = 0;
  std::vector<Vector2> lane_;
  std::unique_ptr<World> world_;
  Vector3 p_, v_ = Vector3::Zero();
};

void gear(const std::string& file, double stiffness, double rate) {
  GearHand hand(file, stiffness, rate);
  hand.printShapes();
  const long every = std::max(1L, std::lround(1e-3 * rate));
  for (long i = 0; hand.step(); ++i) {
    if (i % every == 0) hand.printRow();
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3 && std::strcmp(argv[1], "lambda") == 0) {
      lambda(argv[2]);
    } else if (argc == 4 && std::strcmp(argv[1], "stages") == 0) {
      stages(argv[2], std::atof(argv[3]));
    } else if (argc == 5 && std::strcmp(argv[1], "gear") == 0) {
      gear(argv[2], std::atof(argv[3]), std::atof(argv[4]));
    } else {
      throw SetupError("seed_data", "wrong usage", "see the head of seed_data.cpp");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seed_data: %s\n", error.what());
    return 2;
  }
}
