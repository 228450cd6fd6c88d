/// What friction holds on a moving carrier does not creep, whatever integrates the motion.
#include <gtest/gtest.h>

#include "../../scenes/carriers.h"

namespace haptic {
namespace carrier_test {

using namespace scenes;

constexpr double kDrift = 1e-6;  // [m] in some seconds; a thousandth of what an integrated slip gave

class OnCarrier : public ::testing::TestWithParam<Attempts> {
 protected:
  WorldSettings settings() const {
    WorldSettings s;
    s.attempts = GetParam();
    return s;
  }
  /// Mean place over a period, in which the elastic share comes and goes.
  static Vector3 meanPlace(World& world, const CarriedCube& cube, double period) {
    const int steps = static_cast<int>(std::lround(period / world.settings().step));
    Vector3 sum = Vector3::Zero();
    for (int i = 0; i < steps; ++i) {
      world.step();
      sum += placeOnCarrier(world, cube);
    }
    return sum / steps;
  }
};

TEST_P(OnCarrier, ATurntableKeepsItsCubeInPlace) {
  const CarriedCube cube;
  WorldDef def = carried(Carrier::kTurntable, cube, settings(), 3.0);  // 0.4 of the slip's acceleration
  def.articulations[0].links[0].joint.drive_effort = 0;
  World world(def);
  for (int i = 0; i < 500; ++i) world.step();
  const Vector3 first = placeOnCarrier(world, cube);
  for (int i = 0; i < 5000; ++i) world.step();
  EXPECT_LT((placeOnCarrier(world, cube) - first).head<2>().norm(), kDrift);
}

/// The faster it turns, the more the cube leans out and lifts its inner edge; until it slips it gives way by m a/(k_t A0) and by
/// nothing else.
TEST_P(OnCarrier, ATurntableThatSpinsUpKeepsWhatLeans) {
  const CarriedCube cube;
  World world(carried(Carrier::kTurntable, cube, settings()));
  const auto beyondElastic = [&] {
    const double omega = world.linkTwist(0).angular.z(), kt = DefaultMaterial::kTangentialRatio * cube.stiffness;
    const Vector3 force = cube.mass * cube.radius * Vector3(-omega * omega, kSpinUp, 0);
    return Vector3(placeOnCarrier(world, cube) + force / (kt * world.contact(0).area));
  };
  for (int i = 0; i < 1000; ++i) world.step();
  const Vector3 first = beyondElastic();
  while (world.time() < 23) world.step();  // 0.98 of the speed at which it slips
  EXPECT_LT(world.contact(0).area, 0.9 * cube.size * cube.size);
  EXPECT_LT((beyondElastic() - first).head<2>().norm(), kDrift);
}

TEST_P(OnCarrier, AShakenPlatformAndARampThatTiltsKeepTheirs) {
  for (const Carrier carrier : {Carrier::kPlatform, Carrier::kRamp}) {
    const CarriedCube cube;
    World world(carried(carrier, cube, settings()));
    const double period = periodOf(carrier);
    meanPlace(world, cube, period);
    const Vector3 first = meanPlace(world, cube, period);
    Vector3 last = first;
    for (double t = 2 * period; t < 8; t += period) last = meanPlace(world, cube, period);
    EXPECT_LT((last - first).head<2>().norm(), kDrift) << static_cast<int>(carrier);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, OnCarrier,
                         ::testing::Values(Attempts::kImplicitEuler,
                                           Attempts::kSdirk2, Attempts::kAll));

}  // namespace carrier_test
}  // namespace haptic
