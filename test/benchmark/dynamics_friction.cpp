#include <cmath>
#include <cstdio>

#include "../comparators/velocity_verlet.h"
#include "../scenes/motions.h"
#include "dynamics_figures.h"
#include "figure.h"
#include "haptic_core/contact/sliding_friction.h"

namespace haptic::bench {
namespace {

using namespace scenes;

WorldSettings verlet(double h) {
  WorldSettings s;
  s.step = h;
  s.comparator = comparators::velocityVerlet;
  s.energy_ledger = false;
  return s;
}

/// Tangent of the slope at which the cube slides faster than 1 mm/s on the slab.
double slipTangent(double size) {
  CubeParameters c;
  c.size = size;
  c.mass = 0.1 * std::pow(size / 0.1, 2);
  c.mu_dynamic = 0.35;
  World world(Slope::scene(c, verlet(1e-3)));
  for (double tangent = 0; tangent < 1; tangent += 1e-4) {
    Slope::step(world, c, tangent, 0.1);
    const Twist slab = world.linkTwist(0), cube = world.linkTwist(1);
    const Vector3 arm = world.linkPose(1).p - world.linkPose(0).p;
    // The start of the turn shakes the cube; nothing slides before 0.2.
    if (tangent > 0.2 && (cube.linear - slab.shifted(arm).linear).norm() > 1e-3) return tangent;
  }
  return 1;
}

/// Creep over 10 s on a slope at 0.9 of the limit [m/s], after 1 s of settling.
double creep() {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, verlet(1e-3));
  const double angle = std::atan(0.9 * c.mu_static);
  def.settings.gravity = kGravity * Vector3(std::sin(angle), 0, -std::cos(angle));
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  const Vector3 start = world.linkPose(1).p;
  for (int i = 0; i < 10000; ++i) world.step();
  return (world.linkPose(1).p - start).norm() / 10;
}

/// Depth while sliding against the static depth, worst of 0.1 and 1 m/s.
double slidingDepthError() {
  double worst = 0;
  for (double speed : {0.1, 1.0}) {
    CubeParameters c;
    WorldDef def = cubeOnFloor(c, verlet(1e-3));
    def.articulations[0] = floorBox(20);
    // Faster by what friction takes in 0.2 s: by then the tilt that friction gives the cube has settled. It acts below
    // the centre of mass; the mean depth under the patch is what carries the weight.
    def.articulations[1].V_WA.linear.x() = speed + 0.2 * c.mu_dynamic * kGravity;
    World world(def);
    double before = world.linkTwist(1).linear.x();
    for (int i = 0; i < 4000; ++i) {
      world.step();
      const double v = world.linkTwist(1).linear.x();
      if (before > speed && v <= speed && world.contactCount() == 1) {
        const double mean = world.contact(0).volume / c.area();
        worst = std::max(worst, std::abs(mean / c.restDepth() - 1));
        break;
      }
      before = v;
    }
  }
  return worst;
}

/// Cube that slides over the joint of two floor boxes: largest change of the wrench between steps beyond that on
/// one floor, over the weight, in units of depth/size.
double seamJump() {
  const auto jump = [](bool seam) {
    CubeParameters c;
    WorldDef def = cubeOnFloor(c, verlet(1e-3));
    if (seam) {
      def.articulations[0] = staticBox("floor left", Vector3(2, 4, 0.5), Pose(Vector3(-1, 0, -0.25)));
      def.articulations.push_back(staticBox("floor right", Vector3(2, 4, 0.5), Pose(Vector3(1, 0, -0.25))));
    }
    def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0;
    def.articulations[1].X_WA.p.x() = -0.1 + 1e-5;
    def.articulations[1].V_WA.linear.x() = 0.1;
    World world(def);
    Vector3 last = Vector3::Zero();
    double largest = 0;
    for (int i = 0; i < 2000; ++i) {
      world.step();
      Vector3 sum = Vector3::Zero();
      for (int j = 0; j < world.contactCount(); ++j) {
        const ContactReport& contact = world.contact(j);
        sum += contact.link_b == 1 ? contact.F_BP_W.force : Vector3(-contact.F_BP_W.force);
      }
      if (i > 0) largest = std::max(largest, (sum - last).norm());
      last = sum;
    }
    return largest / (c.mass * kGravity) / (c.restDepth() / c.size);
  };
  return jump(true) - jump(false);
}

}  // namespace

void stickSlip() {
  CubeParameters c;
  c.mass = StickSlip::kMass;
  c.stiffness = StickSlip::kStiffness;
  const double height = c.size / 2 - c.restDepth(), h = 1e-3;
  World world(StickSlip::scene(verlet(h)));
  double squares = 0, last_stretch = 0, release = 0, stuck = 0, first_release = 0, last_release = 0;
  int releases = 0, sticks = 0;
  bool was_sticking = true;
  for (int i = 0; i < 10000; ++i) {
    const double t0 = world.time();
    StickSlip::step(world, height);
    const double x = world.linkPose(1).p.x();
    squares += std::pow(x - StickSlip::position(world.time()), 2);
    const double stretch = StickSlip::kSpring * (StickSlip::kSpeed * world.time() - x);
    const ContactReport& contact = world.contact(0);
    if (contact.sticking != was_sticking && contact.event < 1) {
      const double at = t0 + contact.event * h, force = last_stretch + contact.event * (stretch - last_stretch);
      if (was_sticking) {
        if (releases++ == 0) first_release = at;
        last_release = at;
        release += force;
      } else {
        stuck += force;
        ++sticks;
      }
    }
    was_sticking = contact.sticking;
    last_stretch = stretch;
  }
  std::printf("stick-slip: %d releases, %d times stuck\n", releases, sticks);
  figure("stickslip.release_n", release / releases, "N");
  figure("stickslip.period_s", (last_release - first_release) / (releases - 1), "s");
  figure("stickslip.drop_n", release / releases - stuck / sticks, "N");
  figure("stickslip.position_rms_mm", 1e3 * std::sqrt(squares / 10000), "mm");
}

void slopeAndSliding() {
  figure("ramp.slip_tan_err", std::max(std::abs(slipTangent(0.1) - 0.5), std::abs(slipTangent(2) - 0.5)), "1");
  figure("ramp.creep_nm_per_s", 1e9 * creep(), "nm/s");
  figure("sliding.depth_rel_err", slidingDepthError(), "1");
  figure("seam.wrench_jump_over_dl", seamJump(), "d/L");
}

void spinFriction() {
  // A cube tilted by 0.2 mrad in a floor: pressure linear over the square patch, the same in 1000 × 1000 points.
  const auto floor = box(Vector3(1, 1, 0.2)), block = box(Vector3(0.1, 0.1, 0.1));
  ContactWorkspace workspace;
  workspace.reserve(*floor, *block);
  const double depth = 2e-4, tilt = 2e-4;
  const Pose X_AB(rotationY(tilt), Vector3(0.02, -0.01, 0.1 + 0.05 - depth));
  PairCache cache;
  ContactVolume contact;
  contactVolume(*floor, *block, X_AB, cache, workspace, contact);
  const PressureField field{1e6, Vector2::Zero(), 0, Vector2::Zero()};
  const PressureMoments moments{1e6 * contact.volume, Vector2::Zero(), 1e6 * contact.V2};
  double worst = 0;
  for (int i = 0; i <= 24; ++i) {
    const double w = std::pow(10, -3 + 0.25 * i), angle = 0.7 * i;
    const Vector2 v = 0.05 * Vector2(std::cos(angle), std::sin(angle));
    const SlidingIntegral closed = slidingIntegral(workspace, contact, field, moments, v, w, 0.075);
    constexpr int kCells = 1000;
    Vector2 force = Vector2::Zero();
    double torque = 0;
    for (int ix = 0; ix < kCells; ++ix) {
      for (int iy = 0; iy < kCells; ++iy) {
        // Cell on the cube's lower face, and its depth under the floor.
        const Vector3 p_B((ix + 0.5) / kCells * 0.1 - 0.05, (iy + 0.5) / kCells * 0.1 - 0.05, -0.05);
        const Vector3 p_A = X_AB * p_B;
        const Vector2 r = (contact.X_AP.R.transpose() * (p_A - contact.X_AP.p)).head<2>();
        const double p = 1e6 * std::max(0.0, 0.1 - p_A.z()) * (0.1 / kCells) * (0.1 / kCells);
        const Vector2 slip = v + w * Vector2(-r.y(), r.x());
        const Vector2 t = slip.normalized();
        force += p * t;
        torque += p * (r.x() * t.y() - r.y() * t.x());
      }
    }
    const double radius = 0.04;
    worst = std::max(worst, ((closed.force - force).norm() + std::abs(closed.torque - torque) / radius) / moments.force);
  }
  figure("spin.friction_rel_err", worst, "1");
}

}  // namespace haptic::bench
