#include "haptic_core/spidar/device_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic {
namespace device_check_test {

DeviceDef device(const std::string& name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

bool mentions(const DeviceReport& report, const std::string& word) {
  for (const std::string& problem : report.problems)
    if (problem.find(word) != std::string::npos) return true;
  return false;
}

// The four strings of SPIDAR-4 run along the diagonals of a tetrahedron: Σ d dᵀ = 4/3 · 1, all in closed
// form.
TEST(DeviceCheck, AgreesWithTheTetrahedron) {
  const DeviceDef def = device("spidar_4");
  const StringDef& s = def.strings[0];
  const double length = s.p_BE.norm();
  const DeviceReport report = examineDevice(def);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(report.singular_values[axis], std::sqrt(4.0 / 3), 1e-12);
    EXPECT_NEAR(report.resolution[axis], s.length_per_count / std::sqrt(12.0) / std::sqrt(4.0 / 3), 1e-15);
    EXPECT_NEAR(report.stiffness[axis], 4 * s.min_tension / length * (2.0 / 3), 1e-9);
  }
  // A pull along a string away from the exit needs the three others: f = t (1/3 + 1/3 + 1/3) - t_min. Along
  // its own string it is f = t - t_min. Half way between, more is possible; the worst of 26 directions is an
  // axis or a corner.
  EXPECT_GT(report.presentable_force, 0.7 * s.max_tension);
  EXPECT_LT(report.presentable_force, s.max_tension);
  EXPECT_GT(report.reach_max.minCoeff(), 0.8 * s.p_BE.cwiseAbs().minCoeff());
}

TEST(DeviceCheck, FindsTheDefaultDeviceSound) {
  const DeviceReport report = examineDevice(device("spidar_g6x3r"));
  EXPECT_EQ(report.problems, std::vector<std::string>());
  // Its file cannot know; a device whose file does has nothing left to do.
  ASSERT_EQ(report.to_do.size(), 1u);
  EXPECT_NE(report.to_do[0].find("handedness"), std::string::npos);
  DeviceDef settled = device("spidar_g6x3r");
  settled.handedness = Handedness::kLeft;
  EXPECT_TRUE(examineDevice(settled).to_do.empty());
  EXPECT_GE(report.force_share, 0.97);
  EXPECT_GE(report.torque_share, 0.97);
  // rms rounding 1.66555e-5 / √12 through singular values of about 1 to 2.
  EXPECT_LT(report.resolution.maxCoeff(), 5e-6);
}

TEST(DeviceCheck, NamesWhatIsWrong) {
  DeviceDef def = device("spidar_g6x3r");
  for (StringDef& s : def.strings)
    s.p_BE.z() = 0.05 + 0.02 * s.p_BE.z();  // all exits above: nothing pulls down
  EXPECT_TRUE(mentions(examineDevice(def), "surround"));
  def = device("spidar_g6x3r");
  def.border_lambda = 0.3;
  EXPECT_TRUE(mentions(examineDevice(def), "border_lambda"));
  def.border_lambda = 0;
  def.lambda = 0.3;
  EXPECT_TRUE(mentions(examineDevice(def), "lambda 0.3"));
  def = device("spidar_g6x3r");
  def.max_force = 100;
  EXPECT_TRUE(mentions(examineDevice(def), "max_force"));
  def = device("spidar_4");
  def.strings.resize(3);
  EXPECT_TRUE(mentions(examineDevice(def), "no more strings"));
}

// Every device has poses that its lengths hardly determine, as far out as its exits allow; they are no part of the workspace, and
// no fault of the device. A home like them is one: all knots on one line leave the turn about it free.
TEST(DeviceCheck, WorkspaceEndsWhereTheLengthsHardlyDetermineThePose) {
  DeviceDef def = device("spidar_g6x5r");
  const DeviceReport report = examineDevice(def);
  EXPECT_FALSE(mentions(report, "determine"));
  EXPECT_GT(report.uncertain_share, 0);
  EXPECT_LT(report.worst_singular_value, 0.1);
  const StringKinematics kinematics(def);
  for (int axis = 0; axis < 3; ++axis)
    for (const double end : {report.reach_min[axis], report.reach_max[axis]}) {
      GripPose x;
      x.X_BG.p[axis] = end;
      EXPECT_GE(kinematics.singularValues(x).minCoeff(), 0.1) << axis << " " << end;
    }
  for (StringDef& s : def.strings) s.p_GK.tail<2>().setZero();
  EXPECT_TRUE(mentions(examineDevice(def), "determine"));
}

TEST(DeviceCheck, TextHasTheFirstMotionTest) {
  const std::string text = checkDevice(device("spidar_g6x3r"));
  // Forward, away from exit 1 (which lies forward) ... its string shortens, and its counter is not inverted.
  EXPECT_NE(text.find("forward (+x): rise 4 5 7, fall 0 1 3"), std::string::npos) << text;
  EXPECT_NE(text.find("workspace"), std::string::npos);
}

TEST(DeviceCheck, SegmentDistanceInClosedForm) {
  const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ(), o = Vector3::Zero();
  EXPECT_NEAR(segmentDistance(-x, x, z - y, z + y), 1, 1e-15);  // skew, crossing above each other
  EXPECT_NEAR(segmentDistance(o, x, 2 * x, 3 * x), 1, 1e-15);   // in one line, apart
  EXPECT_NEAR(segmentDistance(o, x, y, y + x), 1, 1e-15);       // parallel
  EXPECT_NEAR(segmentDistance(o, x, 2 * x + y, 3 * x + 4 * y), std::sqrt(2.0), 1e-12);  // end to end
}

}  // namespace device_check_test
}  // namespace haptic
