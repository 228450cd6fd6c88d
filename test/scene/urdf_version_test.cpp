/// URDF 1.0 to 1.2: what each adds is read rightly whatever version a file says, and other versions are
/// refused.
#include <gtest/gtest.h>

#include <cmath>

#include "temporary_files.h"

namespace haptic {
namespace urdf_version_test {

/// A joint, an inertial, a visual and a collision that are turned alike.
std::string turned(const std::string& rotation, const std::string& version = "") {
  const std::string origin = "<origin xyz=\"0.1 0.2 0.3\" " + rotation + "/>";
  return "<robot name=\"v\" " + version + "><link name=\"base\"/><link name=\"a\"><inertial>" + origin +
         "<mass value=\"1\"/><inertia ixx=\".01\" iyy=\".02\" izz=\".025\" ixy=\"0\" ixz=\"0\" "
         "iyz=\"0\"/></inertial><visual>" +
         origin + "<geometry><box size=\"1 2 3\"/></geometry></visual><collision>" + origin +
         "<geometry><box size=\"1 2 3\"/></geometry></collision></link>"
         "<joint name=\"j\" type=\"revolute\"><parent link=\"base\"/><child link=\"a\"/>" +
         origin +
         "<axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\" "
         "acceleration=\"1\" deceleration=\"1\" "
         "jerk=\"1\"/></joint></robot>\n";
}

/// Largest difference of all that `turned` turns, and of where it lies.
double difference(const SceneDef& a, const SceneDef& b) {
  const LinkDef &x = a.world.articulations[0].links[1], &y = b.world.articulations[0].links[1];
  double most = 0;
  const auto compare = [&](const auto& one, const auto& other) {
    most = std::max(most, (one - other).cwiseAbs().maxCoeff());
  };
  compare(x.joint.X_PJ.R, y.joint.X_PJ.R), compare(x.joint.X_PJ.p, y.joint.X_PJ.p);
  compare(x.inertia.I_C, y.inertia.I_C), compare(x.inertia.p_LC, y.inertia.p_LC);
  compare(x.collisions[0].X_LS.R, y.collisions[0].X_LS.R),
      compare(x.collisions[0].X_LS.p, y.collisions[0].X_LS.p);
  compare(a.visuals[0].X_LV.R, b.visuals[0].X_LV.R), compare(a.visuals[0].X_LV.p, b.visuals[0].X_LV.p);
  return most;
}

std::string quaternion(const Vector3& axis, double angle, double length) {
  std::ostringstream text;
  text.precision(17);
  const Vector3 v = length * std::sin(angle / 2) * axis.normalized();
  text << "quat_xyzw=\"" << v.transpose() << " " << length * std::cos(angle / 2) << "\"";
  return text.str();
}

TEST(UrdfVersion, QuaternionsTurnAsAnglesDo) {
  // Sines, products and the division by the length round once each; sizes below 3.
  constexpr double kTolerance = 3 * 20 * 2.2e-16;
  const char* const axes[] = {"r 0 0", "0 r 0", "0 0 r"};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {0.0, 0.3, -1.2, 1.5707963267948966, 3.0}) {
      std::ostringstream number;
      number.precision(17);
      number << angle;
      std::string rpy = axes[axis];
      rpy.replace(rpy.find('r'), 1, number.str());
      const SceneDef expected = loadText(turned("rpy=\"" + rpy + "\""));
      for (const double length : {1.0, -1.0, 0.7, 1e-200, 1e200}) {
        for (const char* version : {"", "version=\"1.0\"", "version=\"1.1\"", "version=\"1.2\""}) {
          EXPECT_LT(
              difference(expected, loadText(turned(quaternion(Vector3::Unit(axis), angle, length), version))),
              kTolerance);
        }
      }
    }
  }
}

TEST(UrdfVersion, QuaternionOfAFileWithoutVersion) {
  const SceneDef scene = loadText(
      "<robot name=\"v\"><link name=\"base\"/><link name=\"a\"><inertial><mass value=\"1\"/><inertia "
      "ixx=\".01\" iyy=\".01\" izz=\".01\" "
      "ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"j\" type=\"revolute\"><parent "
      "link=\"base\"/><child link=\"a\"/>"
      "<origin xyz=\"0 0 1\" quat_xyzw=\"0 0 0.7071068 0.7071068\"/><axis xyz=\"0 0 1\"/>"
      "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>");
  Matrix3 quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((scene.world.articulations[0].links[1].joint.X_PJ.R - quarter).cwiseAbs().maxCoeff(), 4e-16);
}

TEST(UrdfVersion, WrongRotationsAreRefused) {
  const struct {
    const char *rotation, *words;
  } wrong[] = {{"rpy=\"0 0 1\" quat_xyzw=\"0 0 0 1\"", "has both rpy and quat_xyzw"},
               {"quat_xyzw=\"0 0 0 0\"", "quat_xyzw is zero"},
               {"quat_xyzw=\"0 0 nan 1\"", "quat_xyzw=\"0 0 nan 1\" is not finite"},
               {"quat_xyzw=\"0 0 0 1e999\"", "is not finite"},
               {"quat_xyzw=\"0 0 1\"", "quat_xyzw=\"0 0 1\" is not 4 numbers"}};
  for (const auto& [rotation, words] : wrong) {
    const std::string message = refusal(turned(rotation));
    EXPECT_NE(message.find(":1: <origin>"), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }
}

TEST(UrdfVersion, KnownVersionsLoadAndOthersDoNot) {
  for (const char* known : {"1", "1.0", "1.1", "1.2"}) {
    EXPECT_EQ(refusal(turned("rpy=\"0 0 0\"", "version=\"" + std::string(known) + "\"")), "") << known;
  }
  for (const char* other : {"", "0.9", "1.3", "2.0", "1.0.0", "%s%n"}) {
    const std::string message = refusal(turned("rpy=\"0 0 0\"", "version=\"" + std::string(other) + "\""));
    EXPECT_NE(message.find("robot.urdf:1: version '" + std::string(other) +
                           "' of URDF is unknown; known: 1.0, 1.1 and 1.2"),
              std::string::npos)
        << message;
  }
}

}  // namespace urdf_version_test
}  // namespace haptic
