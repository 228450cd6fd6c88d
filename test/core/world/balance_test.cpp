/// What is reported is what was done: the momentum of a body is the sum of the wrenches that its contacts report.
#include <gtest/gtest.h>

#include "../../comparators/named_attempts.h"
#include "../../scenes/moving.h"

namespace haptic {
namespace balance_test {

using namespace scenes;

struct Momentum {
  Vector3 linear, angular;  ///< about W's origin
};

/// Of a free body whose frame is at its centre of mass.
Momentum momentumOf(const World& world, const LinkDef& body, int link) {
  const Pose X = world.linkPose(link);
  const Twist V = world.linkTwist(link);
  const double m = body.inertia.mass;
  return {m * V.linear, X.p.cross(m * V.linear) + X.R * body.inertia.I_C * X.R.transpose() * V.angular};
}

class Balance : public testing::TestWithParam<comparators::NamedAttempts> {};

/// Two crosses that tumble, meet, part and meet again without gravity, at a share of their speed: what brushes, parts or goes to
/// another place within a step differs from run to run.
void expectBalance(const comparators::NamedAttempts& method, double share) {
  WorldSettings settings;
  method.into(settings);
  const bool is_explicit = method.comparator != nullptr;
  WorldDef def = crosses(settings);
  def.articulations[0].V_WA.linear *= share;
  const LinkDef& body = def.articulations[0].links[0];
  World world(def);
  Momentum before = momentumOf(world, body, 1);
  int began = 0, ended = 0, touched = 0;
  double largest = 0;
  for (int step = 0; step < 600; ++step) {
    world.step();
    Vector3 impulse = Vector3::Zero(), turning = Vector3::Zero();
    int touching = 0;
    for (int i = 0; i < world.contactCount(); ++i) {
      const ContactReport& c = world.contact(i);
      touching += c.depth > 0;
      const double sign = c.link_b == 1 ? 1 : -1;
      impulse += sign * settings.step * c.F_BP_W.force;
      turning += sign * settings.step * (c.F_BP_W.torque + c.X_WP.p.cross(c.F_BP_W.force));
    }
    began += touching > 0 && touched == 0;
    ended += touching == 0 && touched > 0;
    touched = touching;
    const Momentum now = momentumOf(world, body, 1);
    largest = std::max(largest, impulse.norm());
    // Rounding of a velocity that is a thousand times what a step changes.
    const double rounding = 1e-12 * std::max(largest, body.inertia.mass);
    ASSERT_LE((now.linear - before.linear - impulse).norm(), rounding) << "step " << step << ", speed " << share;
    if (is_explicit) {
      // Explicit steps turn a body by its momentum: what turns it is the wrench, with the lever at the body's place before.
      ASSERT_LE((now.angular - before.angular - turning).norm(), rounding) << "step " << step << ", speed " << share;
    }
    before = now;
  }
  EXPECT_GE(began, 1);
  EXPECT_GE(ended, 1);
  EXPECT_GT(largest, 0);
}

TEST_P(Balance, OfTwoBodiesWithTheWrenchesReported) {
  for (int run = 0; run < 40; ++run) expectBalance(GetParam(), 1 + 1e-3 * run);
}

INSTANTIATE_TEST_SUITE_P(Methods, Balance, testing::ValuesIn(comparators::kNamedAttempts),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace balance_test
}  // namespace haptic
