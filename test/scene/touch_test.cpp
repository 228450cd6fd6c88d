// What the page in the browser runs: the hand goes where it is led and no farther than it is let, and a session comes to its bits.
#include "browser/touch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/base/error.h"
#include "short_session.h"

namespace haptic {
namespace touch_test {

PackedScene packed(const std::string& name) { return {0, loadScene(name), short_session::device(), "said \"so\""}; }

void run(Touch& touch, int ticks) {
  for (int i = 0; i < ticks; ++i) touch.tick();
}

/// At rest the strings pull as the hand's spring does: its stiffness times the way that the grip was kept from where it is led.
TEST(Touch, TheForceIsTheHandsSpringTimesTheWayItIsHeldBack) {
  Touch touch(packed("touch_cube"));
  const WorkspaceSettings& workspace = touch.packed().scene.hands.at(0).workspace;
  const Vector3 home = touch.aimed(0), below = home - Vector3(0, 0, 0.0155 * workspace.scale);
  EXPECT_FALSE(touch.led(0));
  run(touch, 700);
  touch.aim(0, below);
  EXPECT_TRUE(touch.led(0));
  EXPECT_LT((touch.aimed(0) - below).norm(), 1e-12);
  run(touch, 2000);
  const HandReport& hand = touch.loop().report().hand[0];
  ASSERT_TRUE(hand.in_contact);
  const Vector3 target = workspace.X_WB.R.transpose() * (below - workspace.X_WB.p) / workspace.scale;
  const Vector3 spring = TwinSettings().hand_stiffness * (hand.X_BG.p - target);
  const double count = std::fabs(short_session::device().strings[0].length_per_count);
  const double speed = 1e-3;  // [m/s], more than what is left of the motion
  const double tolerance = 2 * count * TwinSettings().hand_stiffness + speed * TwinSettings().hand_damping;
  EXPECT_GT(spring.norm(), 1);
  EXPECT_LT((hand.F_achieved_B.force - spring).norm(), tolerance);
  touch.letGo(0);
  EXPECT_FALSE(touch.led(0));
}

TEST(Touch, TheHandIsLedWithinTheFrame) {
  Touch touch(packed("touch_cube"));
  const WorkspaceSettings& workspace = touch.packed().scene.hands.at(0).workspace;
  Vector3 half = Vector3::Zero();
  for (const StringDef& string : short_session::device().strings) half = half.cwiseMax(string.p_BE.cwiseAbs());
  touch.aim(0, Vector3(10, -10, 10));
  const Vector3 p_BG = workspace.X_WB.R.transpose() * (touch.aimed(0) - workspace.X_WB.p) / workspace.scale;
  EXPECT_TRUE((p_BG.cwiseAbs().array() < half.array()).all());
  EXPECT_TRUE((p_BG.cwiseAbs().array() > 0.5 * half.array()).all());
  const Vector3 before = touch.aimed(0);
  touch.aim(0, Vector3(0, NAN, 0)), touch.aim(1, Vector3::Zero()), touch.aim(-1, Vector3::Zero());
  EXPECT_EQ(touch.aimed(0), before);
}

TEST(Touch, StiffnessIsTunedWithinItsBounds) {
  Touch touch(packed("touch_cube"));
  touch.tune(0.5, 2);
  EXPECT_EQ(touch.loop().world().tuning().stiffness_scale, 0.5);
  EXPECT_EQ(touch.loop().world().tuning().friction_scale, 2);
  EXPECT_THROW(touch.tune(1000, 1), SetupError);
}

TEST(Touch, APictureHasTheNumbersThatItsTextAnnounces) {
  for (const char* scene : {"touch_cube", "d_two_hands"}) {
    Touch touch(packed(scene));
    run(touch, 50);
    std::vector<double> numbers;
    Picture::draw(touch.loop(), touch.hands(), numbers);
    const World& world = touch.loop().world();
    const std::size_t hands = touch.hands().size(), strings = short_session::device().strings.size();
    EXPECT_EQ(numbers.size(), Picture::kHead + 7u * static_cast<std::size_t>(world.linkCount()) + hands * (Picture::kPerHand + strings) +
                                  static_cast<std::size_t>(world.contactCount()) * Picture::kPatchNumbers);
    for (int link = 0; link < world.linkCount(); ++link) {
      const double* pose = &numbers[static_cast<std::size_t>(Picture::kHead + 7 * link)];
      EXPECT_EQ(Vector3(pose[0], pose[1], pose[2]), world.linkPose(link).p);
    }
    const std::string text = pictureText(touch.packed().scene, world, touch.hands(), touch.packed().about);
    EXPECT_NE(text.find("\"about\":\"said \\\"so\\\"\""), std::string::npos) << text.substr(0, 200);
  }
}

TEST(Again, EveryTickComesToItsBits) {
  Again again(short_session::session());
  for (int i = 0; i <= again.ticks(); ++i) again.tick();  // once more than there are
  EXPECT_EQ(again.done(), again.ticks());
  EXPECT_EQ(again.compared(), again.ticks());
  EXPECT_EQ(again.same(), again.ticks());
}

TEST(Again, AnAlteredCountIsSeen) {
  PackedSession session = short_session::session();
  session.ticks[300].sample[0].counts[2] += 3;
  Again again(session);
  for (int i = 0; i < again.ticks(); ++i) again.tick();
  EXPECT_GE(again.same(), 300);
  EXPECT_LT(again.same(), again.ticks());
}

}  // namespace touch_test
}  // namespace haptic
