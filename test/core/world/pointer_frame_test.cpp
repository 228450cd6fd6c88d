// A pointer that is a frame P of its link, against a world whose link frame is P itself: the same motion and the same wrench, whether the
// hand leads the link or pulls at it by spring and damper.
#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/blocks.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace pointer_frame_test {

const Vector3 kSize(0.04, 0.03, 0.06);
const Pose kToFrame(rotationAbout(Vector3(1, 2, -1).normalized(), 0.9), Vector3(0.02, -0.05, 0.11));  ///< X_LP

/// A block above a floor, moved by a hand at P. `at_link`: its link frame L is P, else L is the block's own.
WorldDef blockInHand(bool at_link, PointerCoupling::Mode mode) {
  WorldDef def;
  def.name = "block";
  def.settings.tolerance = 0;  // at rounding, so that the two differ by rounding alone
  def.articulations.push_back(scenes::floorBox());
  ArticulationDef block = scenes::freeBox("block", kSize, 0.2, Pose(Vector3(0, 0, 0.5 * kSize.z() + 0.004)));
  if (at_link) {
    const Pose X_PL = kToFrame.inverse();
    block.X_WA = block.X_WA * kToFrame;
    LinkDef& link = block.links[0];
    link.inertia.p_LC = X_PL * link.inertia.p_LC;
    link.inertia.I_C = X_PL.R * link.inertia.I_C * X_PL.R.transpose();
    link.collisions[0].X_LS = X_PL * link.collisions[0].X_LS;
  }
  def.articulations.push_back(block);
  PointerDef pointer;
  pointer.articulation = 1, pointer.link = 0;
  if (!at_link) pointer.X_LP = kToFrame;
  PointerCoupling& c = pointer.coupling;
  c.mode = mode;
  c.stiffness = 300, c.damping = 4, c.rotational_stiffness = 2, c.rotational_damping = 0.02;
  c.along_stiffness.share = Vector3(1, 0.5, 0.8), c.about_stiffness.share = Vector3(0.4, 1, 0.7);
  def.pointers.push_back(pointer);
  return def;
}

struct Way {
  const char* name;
  PointerCoupling::Mode mode;
};

class PointerFrame : public testing::TestWithParam<Way> {};
INSTANTIATE_TEST_SUITE_P(Ways, PointerFrame,
                         testing::Values(Way{"led", PointerCoupling::Mode::kDirect}, Way{"pulled", PointerCoupling::Mode::kVirtual}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(PointerFrame, IsAsGoodAsTheLinksOwn) {
  World in_link(blockInHand(false, GetParam().mode)), own(blockInHand(true, GetParam().mode));
  const Pose start = own.linkPose(1);
  ASSERT_LT((in_link.pointerPose(0).p - start.p).norm(), 1e-15);
  double force = 0, torque = 0;
  for (int i = 0; i < 400; ++i) {
    const double t = 1e-3 * (i + 1), down = 0.006 * std::min(1.0, 5 * t);  // 2 mm into the floor, then turned and pushed along
    const double turn = 0.05 * std::max(0.0, t - 0.25);
    const Pose target(rotationAbout(Vector3::UnitX(), turn) * start.R, start.p + Vector3(0.01 * t, 0, -down));
    const Twist V{Vector3(t > 0.25 ? 0.05 : 0, 0, 0), Vector3(0.01, 0, t < 0.2 ? -0.03 : 0)};
    for (World* world : {&in_link, &own}) {
      PointerBound bound;
      bound.stiffness = 2e3, bound.force = 8, bound.torque = 0.5, bound.turn_of_way = 1e-3;
      world->setPointerBound(0, bound);
      world->setPointerTarget(0, target, V);
      world->step();
    }
    const Pose P = in_link.pointerPose(0), Q = own.pointerPose(0);
    ASSERT_LT((P.p - Q.p).norm(), 1e-9) << i;
    ASSERT_LT((P.R - Q.R).norm(), 1e-8) << i;
    const Wrench difference = in_link.pointerWrench(0) - own.pointerWrench(0);
    ASSERT_LT(difference.force.norm(), 1e-6) << i;
    ASSERT_LT(difference.torque.norm(), 1e-7) << i;
    force = std::max(force, own.pointerWrench(0).force.norm()), torque = std::max(torque, own.pointerWrench(0).torque.norm());
  }
  EXPECT_GT(force, 0.5) << "it pulled";
  EXPECT_GT(torque, 0.01) << "the wrench is about P, off the contact";
}

TEST(PointerFrames, OfAGrabbedBodyIsItsOwn) {
  WorldDef def = blockInHand(false, PointerCoupling::Mode::kDirect);
  def.articulations.push_back(scenes::freeBox("other", kSize, 0.2, Pose(Vector3(0.2, 0, 0.1))));
  World world(def);
  world.grab(0, 2);
  EXPECT_EQ(world.pointerPose(0).p, world.linkPose(2).p);
  world.grab(0, world.pointerHome(0));
  EXPECT_LT((world.pointerPose(0).p - (world.linkPose(1) * kToFrame).p).norm(), 1e-15);
}

}  // namespace pointer_frame_test
}  // namespace haptic
