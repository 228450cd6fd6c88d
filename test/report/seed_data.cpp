/// Data of the seeds' figures that are no runs of scenes.
///   seed_data lambda DEVICE_FILE            tensions and presented force along a diagonal, by λ; CSV
///   seed_data stages SCENE_FILE SECONDS     mean time of each stage of a step; one CSV line
///   seed_data gear SCENE_FILE STIFFNESS RATE  path of a pointer that a hand draws over a gear: first the gear's shapes
///                                           (`shape,x,y,...`), then x,y,z,force of the pointer every millisecond
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/convex_polyhedron.h"
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
  choice.integrator = Integrator::kSymplecticEuler;
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

/// A hand of 0.1 kg that feels the pointer's contact wrench and is drawn around the gear at 0.05 m/s by a spring along
/// r = 52 mm, pressed inward by 2 N. `stiffness` [N/m] is what 2 N meet at the ball's tip: k = 2 N/(π r d²), d = 2 N/stiffness.
class GearHand {
 public:
  GearHand(const std::string& file, double stiffness, double rate) : scene_(loadScene(file)), h_(1 / rate) {
    constexpr double kBall = 2e-3, kPress = 2;  // [m], [N]
    const double depth = kPress / stiffness;
    WorldDef& def = scene_.world;
    def.settings.step = h_;
    def.settings.substeps = 1;
    def.settings.default_material.stiffness = kPress / (M_PI * kBall * depth * depth);
    def.settings.default_material.dissipation = 1;
    for (ArticulationDef& articulation : def.articulations) {
      for (LinkDef& link : articulation.links) {
        for (CollisionDef& collision : link.collisions) collision.material = ContactMaterial{};
      }
    }
    def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0.5;
    world_ = std::make_unique<World>(def);
    p_ = world_->linkPose(world_->pointerLink(0)).p;
  }

  void printShapes() const {
    for (const ArticulationDef& articulation : scene_.world.articulations) {
      const LinkDef& link = articulation.links[0];
      if (link.joint.type != JointType::kFixed) continue;
      for (const CollisionDef& collision : link.collisions) {
        std::printf("shape");
        for (const Vector3& vertex : collision.shape->vertices()) {
          const Vector3 p = articulation.X_WA * (link.joint.X_PJ * (collision.X_LS * vertex));
          std::printf(",%.6g,%.6g", p.x(), p.y());
        }
        std::printf("\n");
      }
    }
  }

  void step() {
    constexpr double kRadius = 0.052, kSpeed = 0.05, kMass = 0.1, kPress = 2;  // [m], [m/s], [kg], [N]
    constexpr double kAlong = 500, kDamper = 5, kHeight = 2000;  // of the hand [N/m], [N s/m], across the gear's plane [N/m]
    if (start_ < -10) start_ = std::atan2(p_.y(), p_.x());
    const double goal = start_ + kSpeed / kRadius * world_->time();
    const Vector3 radial = Vector3(p_.x(), p_.y(), 0).normalized(), tangent(-radial.y(), radial.x(), 0);
    const double behind = std::remainder(goal - std::atan2(p_.y(), p_.x()), 2 * M_PI) * kRadius;
    Vector3 F = world_->pointerWrench(0).force - kPress * radial + kAlong * behind * tangent;
    F -= kDamper * (v_ - kSpeed * tangent) + Vector3(0, 0, kHeight * p_.z());
    v_ += h_ / kMass * F;
    p_ += h_ * v_;
    world_->setPointerTarget(0, Pose(world_->linkPose(world_->pointerLink(0)).R, p_), Twist{Vector3::Zero(), v_});
    world_->step();
  }
  void printRow() const {
    std::printf("%.6g,%.6g,%.6g,%.6g\n", p_.x(), p_.y(), p_.z(), world_->pointerWrench(0).force.norm());
  }
  double time() const { return world_->time(); }

 private:
  SceneDef scene_;
  double h_, start_ = -100;
  std::unique_ptr<World> world_;
  Vector3 p_, v_ = Vector3::Zero();
};

void gear(const std::string& file, double stiffness, double rate) {
  GearHand hand(file, stiffness, rate);
  hand.printShapes();
  const long every = std::max(1L, std::lround(1e-3 * rate));
  for (long i = 0; hand.time() < 1.5; ++i) {
    hand.step();
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
