#include "haptic_core/spidar/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace calibration_test {

DeviceDef device(const std::string& name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

/// A device whose exits are 5 mm and whose lengths are 10 mm from what its file says, waved for 20 s.
struct Wave {
  DeviceDef nominal, truth;
  StringVector true_zero, guessed_zero;
  std::vector<CalibrationSample> samples;

  explicit Wave(const std::string& name, unsigned seed) : nominal(device(name)), truth(nominal) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    for (StringDef& s : truth.strings)
      s.p_BE += 5e-3 * Vector3(u(generator), u(generator), u(generator)).normalized();
    true_zero = StringKinematics(truth).lengths(GripPose{});
    guessed_zero = true_zero;
    for (int i = 0; i < guessed_zero.size(); ++i) guessed_zero[i] += u(generator) > 0 ? 0.01 : -0.01;
    TwinSettings settings;
    settings.path = handPath("wave");
    DeviceTwin twin(truth, settings);
    DriveCommand wound;
    for (std::size_t i = 0; i < truth.strings.size(); ++i)
      wound.voltage[i] = truth.strings[i].min_tension * truth.strings[i].volt_per_newton;
    const StringKinematics kinematics(nominal);
    GripPose pose;
    for (int tick = 0; tick < 20000; ++tick) {
      const DeviceSample counts = twin.exchange(wound);
      if (tick % 10) continue;
      CalibrationSample sample;
      sample.counts = counts.counts;
      StringVector length = guessed_zero;
      for (int i = 0; i < length.size(); ++i)
        length[i] += counts.counts[i] * nominal.strings[i].length_per_count;
      pose = kinematics.solvePose(length, pose).pose;
      sample.guess = pose;
      samples.push_back(sample);
    }
  }

  /// Largest distance of the refined exits from the true ones, after the best rigid alignment or without it.
  double exitError(const Calibration& calibration, bool align) const {
    const int n = static_cast<int>(truth.strings.size());
    Eigen::MatrixXd found(3, n), real(3, n);
    for (int i = 0; i < n; ++i) {
      found.col(i) = calibration.p_BE[i];
      real.col(i) = truth.strings[i].p_BE;
    }
    if (align) {
      const Eigen::Matrix4d X = Eigen::umeyama(found, real, false);
      found = (X.topLeftCorner<3, 3>() * found).colwise() + X.topRightCorner<3, 1>();
    }
    return (found - real).colwise().norm().maxCoeff();
  }
};

TEST(Calibration, FindsExitsAndLengthsFromAWave) {
  const Wave wave("spidar_g6x3r", 1);
  const Calibration calibration = calibrateFromWave(wave.nominal, wave.guessed_zero, wave.samples);
  EXPECT_TRUE(calibration.converged);
  // Rounding of a count to the nearest: rms step / √12, less what the fit absorbs.
  EXPECT_LT(calibration.residual, 1.66555e-5 / std::sqrt(12));
  EXPECT_LT(wave.exitError(calibration, true), 0.05e-3);
  // Five standard deviations over √3 coordinates of 8 exits: the covariance tells the truth.
  EXPECT_LT(wave.exitError(calibration, true), 5 * std::sqrt(3) * calibration.exit_sigma);
  EXPECT_GT(wave.exitError(calibration, false), 0.5e-3) << "the rigid part cannot be seen in a wave";
  EXPECT_LT((calibration.zero_length - wave.true_zero).cwiseAbs().maxCoeff(), 0.05e-3);
}

TEST(Calibration, AKnownPoseFixesTheRigidPart) {
  Wave wave("spidar_g6x3r", 2);
  wave.samples.front().known = true;  // the wave starts at home, at rest
  wave.samples.front().guess = GripPose{};
  const Calibration calibration = calibrateFromWave(wave.nominal, wave.guessed_zero, wave.samples);
  EXPECT_TRUE(calibration.converged);
  // A quarter count in that pose turns the frame by about 8 µm / r · |exit|.
  EXPECT_LT(wave.exitError(calibration, false), 0.1e-3);
}

TEST(Calibration, MakesThePoseRight) {
  Wave wave("spidar_g6x3r", 3);
  wave.samples.front().known = true;
  wave.samples.front().guess = GripPose{};
  const Calibration calibration = calibrateFromWave(wave.nominal, wave.guessed_zero, wave.samples);
  TwinSettings settings;
  settings.path = handPath("wave");
  DeviceTwin twin(wave.truth, settings);
  Spidar refined(calibration.applied(wave.nominal)), nominal(wave.nominal);
  refined.restoreCalibration(calibration.zero_length);
  nominal.calibrateAtHome();
  double refined_error = 0, nominal_error = 0;
  for (int tick = 0; tick < 20000; ++tick) {
    const DeviceSample sample = twin.exchange(refined.drive());
    refined.sense(sample, 1e-3);
    nominal.sense(sample, 1e-3);
    refined_error = std::max(refined_error, (refined.pose().p - twin.latchedPose().X_BG.p).norm());
    nominal_error = std::max(nominal_error, (nominal.pose().p - twin.latchedPose().X_BG.p).norm());
  }
  EXPECT_LT(refined_error, 0.1e-3);
  EXPECT_GT(nominal_error, 1e-3) << "without calibration the error is of the size of the exits'";
}

TEST(Calibration, SurvivesItsFile) {
  Calibration calibration;
  const DeviceDef def = device("spidar_g6x3r");
  calibration.device = def.name;
  calibration.time = "2024-05-06T07:08:09Z";
  calibration.residual = 1e-5;
  calibration.samples = 2000;
  calibration.zero_length = StringVector::Constant(8, 0.1 + 1e-17);
  for (int i = 0; i < 8; ++i) calibration.p_BE.push_back(Vector3(0.1 / 3, i, -1e-9));
  const std::string path = ::testing::TempDir() + "calibration.yaml";
  saveCalibration(calibration, path);
  const Calibration read = loadCalibration(def, path);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(read.p_BE[i], calibration.p_BE[i]);
  EXPECT_EQ(read.zero_length, calibration.zero_length);
  EXPECT_EQ(read.time, calibration.time);
  EXPECT_EQ(calibration.applied(def).strings[3].p_BE, calibration.p_BE[3]);
  EXPECT_THROW(loadCalibration(device("spidar_g6x4"), path), SetupError);
  std::ofstream(path) << "nothing: here\n";
  EXPECT_THROW(loadCalibration(def, path), SetupError);
  EXPECT_THROW(saveCalibration(calibration, "/nowhere/calibration.yaml"), SetupError);
}

TEST(Calibration, RefusesTooFewSamples) {
  Wave wave("spidar_g6x3r", 4);
  wave.samples.resize(10);
  EXPECT_THROW(calibrateFromWave(wave.nominal, wave.guessed_zero, wave.samples), SetupError);
}

TEST(Calibration, ByAJigStartsFromItsPose) {
  const DeviceDef def = device("spidar_g6x3r");
  GripPose jig;
  jig.X_BG = Pose(rotationFromVector(Vector3(0.1, -0.2, 0.05)), Vector3(0.01, 0.02, -0.01));
  TwinSettings settings;
  settings.hand = false;
  settings.first_count = 777;
  DeviceTwin twin(def, settings);
  twin.place(jig);
  Spidar spidar(def);
  spidar.calibrateAt(jig);
  spidar.sense(twin.exchange(DriveCommand{}), 1e-3);
  ASSERT_TRUE(spidar.calibrated());
  EXPECT_LT((spidar.pose().p - jig.X_BG.p).norm(), 1e-12);
  GripPose moved;
  twin.place(moved);
  spidar.sense(twin.exchange(DriveCommand{}), 1e-2);
  EXPECT_LT((spidar.pose().p - moved.X_BG.p).norm(), 33e-6);
}

}  // namespace calibration_test
}  // namespace haptic
