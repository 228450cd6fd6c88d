// Where in its counts a string is: within the count, as counted in motion, at rest on an edge, and never more than the truth's swing.
#include "haptic_core/spidar/steady_lengths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

namespace haptic {
namespace steady_lengths_test {

constexpr double kStep = 1e-3, kCount = 2e-5;  // [s], [m]

DeviceDef oneString() {
  DeviceDef def;
  def.strings.resize(1);
  def.strings[0].length_per_count = -kCount;  // a counter that runs backwards
  return def;
}

double rounded(double length) { return kCount * std::round(length / kCount); }

struct Reader {
  SteadyLengths steady{oneString()};
  double read(double length) { return steady.read(StringVector::Constant(1, rounded(length)), kStep)[0]; }
};

TEST(SteadyLengths, StayWithinTheCount) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Reader reader;
  double length = 0.1, speed = 0;
  for (int i = 0; i < 20000; ++i) {
    speed = 0.99 * speed + std::exp(-7.0 + (i / 1000) % 6) * kCount / kStep * normal(random);
    length += kStep * speed;
    ASSERT_LE(std::fabs(reader.read(length) - rounded(length)), 0.5 * kCount * (1 + 1e-9));
  }
}

TEST(SteadyLengths, ReadAMovingStringAsCounted) {
  Reader reader;
  for (int i = 0; i < 200; ++i) {
    const double length = 0.1 + 0.7 * kCount * i;
    const double read = reader.read(length);
    // In half a window it moves by 17 counts, so the middle is more than four away.
    if (i > 30) { EXPECT_NEAR(read, rounded(length), 1e-15); }
  }
}

TEST(SteadyLengths, ComeToTheCountAtRest) {
  Reader reader;
  for (int i = 0; i < 3; ++i) reader.read(0.1 + i * kCount);
  double read = 0;
  for (int i = 0; i < 150; ++i) read = reader.read(0.1 + 3 * kCount);
  // After the window's 50 ms its middle comes nearer by e⁻¹⁰ of two counts.
  EXPECT_NEAR(read, rounded(0.1 + 3 * kCount), 2 * kCount * std::exp(-10.0) + 1e-15);
}

TEST(SteadyLengths, StandStillWhereAStringTremblesOnAnEdge) {
  Reader reader;
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < 2000; ++i) {
    const double read = reader.read(0.1 + (0.5 + (i % 2 ? 0.01 : -0.01)) * kCount);
    if (i < 1000) continue;
    low = std::min(low, read);
    high = std::max(high, read);
  }
  EXPECT_LT(high - low, 1e-9 * kCount + 1e-15);
}

/// The largest describing function of a reading: of swings of 0.3 to 10 counts about any place, fundamental over amplitude.
template <class Read>
double mostGain(double rate, Read&& make) {
  double most = 0;
  for (double swing = 0.3; swing < 10; swing *= 1.07) {
    for (const double place : {0.0, 0.2, 0.5}) {
      auto read = make();
      std::complex<double> fundamental = 0;
      constexpr int kTicks = 4000;
      for (int i = 0; i < 2 * kTicks; ++i) {
        const double phase = 2 * M_PI * rate * i * kStep;
        const double length = read(0.1 + (place + swing * std::sin(phase)) * kCount);
        if (i >= kTicks) fundamental += (length - 0.1) * std::exp(std::complex<double>(0, -phase));
      }
      most = std::max(most, 2 * std::abs(fundamental) / kTicks / (swing * kCount));
    }
  }
  return most;
}

// A hum at K_max grows where the reading swings more than the grip; rounding alone does, by up to 4/π.
TEST(SteadyLengths, SwingNoMoreThanTheString) {
  for (const double rate : {41.25, 51.75, 83.25}) {  // [Hz], whole periods in the window
    EXPECT_GT(mostGain(rate, [] { return rounded; }), 1.2) << rate;
    // Beside the fundamental of a function of the count: the middle's steps of half a count, once in a window.
    EXPECT_LT(mostGain(rate, [] { return [reader = Reader()](double length) mutable { return reader.read(length); }; }), 1.03) << rate;
  }
}

}  // namespace steady_lengths_test
}  // namespace haptic
