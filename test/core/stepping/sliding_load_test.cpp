// Friction whose limit follows normal forces that several sliding patches share.
#include <gtest/gtest.h>

#include "haptic_core/world/world.h"
#include "../../scenes/wedge.h"

namespace haptic {
namespace sliding_load_test {

// The wedge slides on two sides at once: its pull is that of statics, whatever the stiffness. A Newton step that took each side's change of
// load for the other's ended unconverged at 1e12 N/m³.
TEST(SlidingLoad, AWedgeIsPulledAsStaticsSay) {
  for (const double stiffness : {1e10, 1e11, 1e12}) {
    scenes::Wedge w;
    w.stiffness = stiffness;
    World world(scenes::wedge(w));
    double most = 0;
    int unconverged = 0;
    for (int i = 0; i < 5000; ++i) {
      world.step();
      unconverged += (world.report().flags & kNotConverged) != 0;
      if (i >= 4000) most = std::max(most, std::abs(scenes::pullOf(world) - w.pull()));
    }
    EXPECT_EQ(unconverged, 0) << stiffness;
    // At 1e12 N/m³, 2e5 of the wedge's mass in a step, its yaw is still swinging then.
    EXPECT_LT(most, (stiffness > 1e11 ? 0.03 : 1e-3) * w.pull()) << stiffness;
  }
}

}  // namespace sliding_load_test
}  // namespace haptic
