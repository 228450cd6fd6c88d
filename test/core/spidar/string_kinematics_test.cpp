#include "haptic_core/spidar/string_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "haptic_core/base/error.h"

namespace haptic {
namespace string_kinematics_test {

std::string deviceFile(const std::string& name) {
  return std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml";
}

Vector3 randomVector(std::mt19937& generator, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  return {u(generator), u(generator), u(generator)};
}

GripPose randomPose(std::mt19937& generator, int dof, double shift, double turn) {
  GripPose x;
  x.X_BG.p = randomVector(generator, shift);
  if (dof >= 6) x.X_BG.R = rotationFromVector(randomVector(generator, turn)).toRotationMatrix();
  if (dof == 7) x.opening = randomVector(generator, 0.3 * shift).x();
  return x;
}

class KinematicsOfDevice : public ::testing::TestWithParam<const char*> {
 protected:
  DeviceDef def = loadDevice(deviceFile(GetParam()));
  StringKinematics kinematics{def};
  double reach = 0.15 * def.strings[0].p_BE.norm();
};

TEST_P(KinematicsOfDevice, FindsThePoseAgain) {
  std::mt19937 generator(1);
  for (int trial = 0; trial < 2000; ++trial) {
    const GripPose truth = randomPose(generator, def.dof, reach, 0.28);
    GripPose guess = truth;
    guess.X_BG.p += randomVector(generator, 1e-3);
    if (def.dof >= 6)
      guess.X_BG.R = rotationFromVector(randomVector(generator, 0.02)).toRotationMatrix() * truth.X_BG.R;
    const PoseSolution found = kinematics.solvePose(kinematics.lengths(truth), guess);
    ASSERT_EQ(found.status, PoseStatus::kConverged);
    // Rounding of lengths of `size` through the smallest singular value (0.05 at worst), and the last step's
    // square.
    const double size = def.strings[0].p_BE.norm(), tolerance = 1e-12 + 100 * 1e-16 * size / 0.05;
    ASSERT_LT((found.pose.X_BG.p - truth.X_BG.p).norm(), tolerance);
    ASSERT_LT((found.pose.X_BG.R - truth.X_BG.R).norm() * kinematics.knotRadius(), tolerance);
    ASSERT_LT(found.residual, tolerance);
  }
}

TEST_P(KinematicsOfDevice, StructureMatrixIsTheDerivativeOfTheLengths) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 50; ++trial) {
    const GripPose x = randomPose(generator, def.dof, reach, 0.4);
    const StructureMatrix A = kinematics.structure(x);
    const double step = 1e-6 * def.strings[0].p_BE.norm();
    for (int c = 0; c < def.dof; ++c) {
      GripPose plus = x, minus = x;
      for (const double sign : {1.0, -1.0}) {
        GripPose& y = sign > 0 ? plus : minus;
        if (c < 3)
          y.X_BG.p[c] += sign * step;
        else if (c < 6)
          y.X_BG.R = rotationFromVector(sign * step * Vector3::Unit(c - 3)).toRotationMatrix() * x.X_BG.R;
        else
          y.opening += sign * step;
      }
      const StringVector slope = (kinematics.lengths(plus) - kinematics.lengths(minus)) / (2 * step);
      // Central difference: rounding eps l / step = 2e-10, truncation step² / l² smaller.
      ASSERT_LT((slope + A.col(c)).norm(), 1e-8) << c;
    }
  }
}

TEST_P(KinematicsOfDevice, ReportsTheStringThatContradictsTheOthers) {
  if (static_cast<int>(def.strings.size()) == def.dof) GTEST_SKIP() << "no redundancy";
  StringVector lengths = kinematics.lengths(GripPose{});
  lengths[1] -= 2e-3;
  const PoseSolution found = kinematics.solvePose(lengths, GripPose{});
  EXPECT_EQ(found.status, PoseStatus::kConverged);
  EXPECT_GT(found.residual, 1e-4);
  EXPECT_NEAR(found.residual, std::sqrt(found.length_error.squaredNorm() / kinematics.strings()), 1e-15);
  const StringVector again = kinematics.lengths(found.pose) - lengths;
  EXPECT_LT((again - found.length_error).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Devices, KinematicsOfDevice,
                         ::testing::Values("spidar_g6x3r", "spidar_g6x4", "spidar_g6x5r", "spidar_4",
                                           "spidar_g7"));

TEST(StringKinematics, RefusesLengthsThatAreNotFinite) {
  const StringKinematics kinematics(loadDevice(deviceFile("spidar_g6x3r")));
  StringVector lengths = kinematics.lengths(GripPose{});
  lengths[3] = std::nan("");
  EXPECT_EQ(kinematics.solvePose(lengths, GripPose{}).status, PoseStatus::kNotFinite);
}

// The makers' tables give the string lengths at calibration: a check of every sign and of the conversion of
// axes.
TEST(DeviceFile, HasTheMakersHomeLengths) {
  const StringKinematics x3(loadDevice(deviceFile("spidar_g6x3r"))),
      x4(loadDevice(deviceFile("spidar_g6x4")));
  const StringKinematics x5(loadDevice(deviceFile("spidar_g6x5r")));
  const auto expect = [](const StringKinematics& k, std::vector<double> lengths) {
    for (int i = 0; i < k.strings(); ++i)
      EXPECT_NEAR(k.lengths(GripPose{})[i], lengths[i], 6e-6) << i;  // 5 digits
  };
  expect(x3, {.10384, .10384, .10031, .10031, .10384, .10384, .10031, .10031});
  expect(x4, {.12157, .12629, .12629, .12157, .12157, .12629, .12629, .12157});
  expect(x5, {.12375, .12375, .12424, .12424, .12375, .12375, .12424, .12424});
}

TEST(DeviceFile, TurnsTheMakersAxesIntoRep103) {
  const DeviceDef def = loadDevice(deviceFile("spidar_g6x3r"));
  // Table: exit 1 at x 0, y -0.076 (down), z +0.0849 (depth). Left-handed: depth points forward.
  EXPECT_EQ(def.handedness, Handedness::kGuessedLeft);
  EXPECT_NEAR(def.strings[1].p_BE.x(), 0.0848528, 1e-7);
  EXPECT_NEAR(def.strings[1].p_BE.y(), 0, 1e-12);
  EXPECT_NEAR(def.strings[1].p_BE.z(), -0.076, 1e-12);
  // Exit 2 is at x +0.0849, to the right: y points left.
  EXPECT_NEAR(def.strings[2].p_BE.y(), -0.0848528, 1e-7);
}

TEST(DeviceFile, OfEveryVariantLoads) {
  int loaded = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(loadDevice(entry.path())) << entry.path();
    ++loaded;
  }
  EXPECT_GE(loaded, 26);
}

class BadDevice : public ::testing::Test {
 protected:
  /// What loading says when `from` is replaced by `to` in the default device's file.
  std::string complaint(const std::string& from, const std::string& to) {
    std::ifstream in(deviceFile("spidar_g6x3r"));
    std::string text((std::istreambuf_iterator<char>(in)), {});
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
    const std::string path = ::testing::TempDir() + "bad_device.yaml";
    std::ofstream(path) << text;
    try {
      loadDevice(path);
    } catch (const SetupError& error) {
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "";
  }
};

TEST_F(BadDevice, IsRefusedWithOneLine) {
  EXPECT_EQ(complaint("nothing of this", "is replaced"), "");
  EXPECT_NE(complaint("max_tension: 20", "max_tension: 0.1").find("min_tension"), std::string::npos);
  EXPECT_NE(complaint("min_tension: 0.3", "min_tension: -1").find("min_tension"), std::string::npos);
  EXPECT_NE(complaint("dof: 6", "dof: 5").find("dof"), std::string::npos);
  EXPECT_NE(complaint("dof: 6", "dof: six").find("dof"), std::string::npos);
  EXPECT_NE(complaint("lambda: 0.02", "lamda: 0.02").find("lamda"), std::string::npos);
  EXPECT_NE(complaint("exit: [0, -0.076, 0.0848528]", "exit: [0.0848528, -0.076, 0]").find("coincident"),
            std::string::npos);
  EXPECT_NE(complaint("exit: [0, -0.076, 0.0848528]", "exit: [0, -0.076]").find("2 numbers"),
            std::string::npos);
  EXPECT_NE(complaint("strings:", "strings: 3\nothers:").find("strings"), std::string::npos);
  EXPECT_NE(complaint("volt_per_newton: 0.365296803653", "volt_per_newton: 0").find("volt_per_newton"),
            std::string::npos);
  EXPECT_NE(complaint("name:", "name: [").find("YAML"), std::string::npos);
}

/// Every kind of number, written as 1e300 and as 1e-300: refused with its key, or of no consequence (a length or a time of zero).
TEST_F(BadDevice, NumbersOfNoDeviceAreRefusedWithTheirKey) {
  const struct {
    std::string key, value;
    bool zero_is_well;
  } numbers[] = {{"\nlambda", "0.02", false},
                 {"border_lambda", "0.0035", true},
                 {"max_force", "10", false},
                 {"max_torque", "0.3", false},
                 {"max_rate", "4000", false},
                 {"delay", "0.00025", true},
                 {"length_per_count", "1.66555e-05", false},
                 {"volt_per_newton", "0.365296803653", false},
                 {"min_tension", "0.3", false},
                 {"max_tension", "20", false},
                 {"mass", "0.05", false},
                 {"radius", "0.0225", false}};
  for (const auto& number : numbers) {
    const std::string key = number.key[0] == '\n' ? number.key.substr(1) : number.key;
    for (const char* huge : {"1e300", "-1e300"}) {
      EXPECT_NE(complaint(number.key + ": " + number.value, number.key + ": " + huge).find(key), std::string::npos) << key << " " << huge;
    }
    const std::string tiny = complaint(number.key + ": " + number.value, number.key + ": 1e-300");
    EXPECT_TRUE(number.zero_is_well || tiny.find(key) != std::string::npos) << key << ": " << tiny;
  }
  EXPECT_NE(complaint("exit: [0, -0.076, 0.0848528]", "exit: [0, -1e300, 0.0848528]").find("exit"), std::string::npos);
}

TEST_F(BadDevice, WithAKeyTwiceOrTwoDocumentsIsRefusedWithItsLine) {
  EXPECT_NE(complaint("\ndof: 6", "\ndof: 6\ndof: 6").find("'dof' stands twice"), std::string::npos);
  EXPECT_NE(complaint("exit: [0, -0.076, 0.0848528]", "exit: [0, -0.076, 0.0848528], exit: [0, 0, 1]").find("stands twice"),
            std::string::npos);
  const std::string message = complaint("\ndof: 6", "\n---\ndof: 6");
  EXPECT_NE(message.find("second document"), std::string::npos) << message;
  EXPECT_NE(message.find(".yaml:"), std::string::npos) << message;
}

TEST_F(BadDevice, ThatCannotHoldAPoseIsNamedByItsRank) {
  // With the knots of strings 2, 3, 6 and 7 in the centre, nothing resists a turn about the line of the
  // others.
  const std::string message = complaint("0.0225, 0]", "0, 0]");
  EXPECT_NE(message.find("rank"), std::string::npos) << message;
}

TEST_F(BadDevice, WithCrossingStringsIsNamed) {
  // String 1 goes through the middle of string 0, which runs from (-84.8528, -76, 0) to (-15.9099, 0,
  // -15.9099) mm.
  const std::string message =
      complaint("exit: [0, -0.076, 0.0848528], knot: [0.0159099, 0, 0.0159099]",
                "exit: [-0.05038135, -0.038, 0.08], knot: [-0.05038135, -0.038, -0.02]");
  EXPECT_NE(message.find("strings[1] and strings[0]"), std::string::npos) << message;
  EXPECT_NE(message.find("cross"), std::string::npos) << message;
}

TEST(DeviceFile, NamesAFileThatIsNotThere) {
  try {
    loadDevice("/nowhere/spidar.yaml");
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("/nowhere/spidar.yaml"), std::string::npos);
  }
}

}  // namespace string_kinematics_test
}  // namespace haptic
