// Oracles: the closed form of the energy that a sampled spring gives away, and the bound of one sample.
#include "haptic_core/loop/passivity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace haptic {
namespace passivity_test {

constexpr double kPeriod = 1e-3;      // [s]
constexpr double kStiffness = 2000;   // [N/m]
constexpr double kGripMass = 1e9;     // [kg]: moved along a path, whatever pulls

StringVector one(double value) { return StringVector::Constant(1, value); }

const StringVector kExact = one(0);   // quantum of lengths that no count rounds [m]
constexpr double kCount = 2e-5;       // quantum of those that counts round [m]

// A grip on one string along x, which grows shorter as x grows, is moved by `x(t)` against the sampled wall
// F = -K min(x, 0); returns the lowest energy observed.
template <class Path>
double lowestEnergy(PassivityController& port, Path&& x, int ticks, double* largest_sample = nullptr) {
  double last = x(0.0);
  port.start(one(-last));
  for (int n = 1; n <= ticks; ++n) {
    const double now = x(n * kPeriod);
    port.observe(one(-now));
    const Twist V{Vector3::Zero(), Vector3((now - last) / kPeriod, 0, 0)};
    Wrench F{Vector3::Zero(), Vector3(-kStiffness * std::min(now, 0.0), 0, 0)};
    if (largest_sample) *largest_sample = std::max(*largest_sample, std::abs(F.force.x() * (now - last)));
    const Wrench asked = port.act(F, V, kPeriod);
    port.hold(asked, one(asked.force.x()));
    last = now;
  }
  return port.lowestEnergy();
}

TEST(PassivityObserver, MeasuresWhatASampledSpringGivesAway) {
  PassivityController port({PassivityMode::kObserve, 0.02, 20}, kGripMass, kExact);
  // In to 10 mm and out again at 0.1 m/s, N = d/(v T) intervals each way, each under the force of the sample before its
  // start. In: K (v T)² (0 + 0 + 1 + … + N-2); out: N-1, N, N-1, …, 2. The difference is -3 N + 3.
  const double v = 0.1, d = 0.01;
  const auto x = [&](double t) { return t < d / v ? -v * t : -2 * d + v * t; };
  lowestEnergy(port, x, 200);
  const double way = v * kPeriod;
  EXPECT_NEAR(port.energy(), -3 * kStiffness * way * (d - way), 1e-12);
}

TEST(PassivityObserver, CountsTheTensionsThatWereInTheStrings) {
  PassivityController port({PassivityMode::kObserve, 0.02, 20}, kGripMass, kExact);
  port.start(one(1));
  port.hold(Wrench{}, one(0.3));
  port.observe(one(0.3));  // still without it: it goes out with this sample's exchange
  EXPECT_EQ(port.energy(), 0);
  port.observe(one(0.29));
  EXPECT_NEAR(port.energy(), -0.3 * 0.01, 1e-15);
}

// A grip trembles by a hundredth of a count across a count's edge; whenever it has come up, the string is told to pull, and
// whenever it has gone down, not to. In truth it gives t·ε a time, the counts say t·q; the reserve of one count aside,
// the observer must not believe more than the truth.
TEST(PassivityObserver, CreditsNoEnergyThatCountsInvent) {
  constexpr double kTremble = 0.01 * kCount, kPull = 3;
  constexpr int kTimes = 1000;
  PassivityController port({PassivityMode::kObserve, 0.02, 20}, kGripMass, one(kCount));
  port.start(one(0));
  double truth = 0, counted = 0, last_length = 0, pulls = 0, told = 0;
  for (int n = 0; n < 2 * kTimes; ++n) {
    const double length = kCount / 2 + (n % 2 == 0 ? 0.5 : -0.5) * kTremble;
    const double count = kCount * std::round(length / kCount);
    port.observe(one(count));
    if (n > 0) truth += pulls * (length - last_length);
    counted += n > 0 && n % 2 == 0 ? pulls * kCount : 0;
    last_length = length;
    pulls = told;
    told = n % 2 == 0 ? kPull : 0;
    port.hold(Wrench{}, one(told));
  }
  EXPECT_GT(counted, 10 * truth);  // the counts do invent
  EXPECT_LE(port.energy(), truth + kPull * kCount);
  EXPECT_GE(port.energy(), -kPull * kCount);
}

/// A hand that shakes on the wall; the controller's damper may be `cap` [N·s/m].
void expectKeptPassive(double cap) {
  const auto x = [](double t) { return 0.004 * std::sin(2 * M_PI * 5 * t) - 0.001 * std::sin(2 * M_PI * 31 * t); };
  double sample = 0;
  PassivityController observing({PassivityMode::kObserve, 0.02, cap}, kGripMass, kExact);
  const double without = lowestEnergy(observing, x, 3000, &sample);
  PassivityController acting({PassivityMode::kAct, 0.02, cap}, kGripMass, kExact);
  const double with = lowestEnergy(acting, x, 3000);
  EXPECT_LT(without, -2 * sample);  // the wall alone is not passive: the test can fail
  EXPECT_GE(with, -sample);
  EXPECT_GT(acting.dissipated(), 0);
}

TEST(PassivityController, KeepsThePortWithinOneSampleOfPassive) { expectKeptPassive(1e3); }

// A cap of 1 N·s/m is far too low for this wall: what the damper may not do, less force does.
TEST(PassivityController, TakesTheForceBackWhereItsDamperIsCapped) { expectKeptPassive(1); }

// Nothing is asked, and 3 mJ are owed: a grip at 0.1 m/s pays them in one tick by α = 3 mJ/(h V²) = 300 N·s/m, or as much
// as the cap allows.
TEST(PassivityController, DampsByWhatIsOwed) {
  for (const double cap : {1e3, 20.0}) {
    PassivityController port({PassivityMode::kAct, 0.02, cap}, kGripMass, kExact);
    port.start(one(1));
    port.hold(Wrench{}, one(0.3));
    port.observe(one(1));
    port.hold(Wrench{}, one(0));
    port.observe(one(0.99));
    const Wrench F = port.act(Wrench{}, {Vector3::Zero(), Vector3(0.1, 0, 0)}, kPeriod);
    EXPECT_NEAR(F.force.x(), -std::min(300.0, cap) * 0.1, 1e-12) << "cap " << cap;
  }
}

TEST(PassivityController, LeavesAPassivePortAlone) {
  PassivityController port({PassivityMode::kAct, 0.02, 20}, kGripMass, kExact);
  const Twist V{Vector3(0, 0.2, 0), Vector3(0.1, 0, 0)};
  const Wrench damper{Vector3(0, -0.01, 0), Vector3(-0.5, 0, 0)};
  port.start(one(1));
  for (int n = 0; n < 100; ++n) {
    port.observe(one(1 - 0.1 * kPeriod * (n + 1)));
    const Wrench F = port.act(damper, V, kPeriod);
    EXPECT_EQ(F.force, damper.force);
    EXPECT_EQ(F.torque, damper.torque);
    port.hold(F, one(F.force.x()));
  }
  EXPECT_GT(port.energy(), 0);
}

}  // namespace passivity_test
}  // namespace haptic
