/// What the loader reads of a URDF against urdfdom, the parser of ROS: inertias, dynamics, visuals with their
/// colours.
#include <console_bridge/console.h>
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <filesystem>

#include "scene/joint_reading.h"
#include "scene/link_inertia.h"
#include "scene/link_visuals.h"
#include "temporary_files.h"

namespace haptic {
namespace urdfdom_test {

// A sine, a quaternion and two products of rotations [1].
constexpr double kRounding = 40 * 2.2e-16;

/// Materials by all roads that both readers know: global, inline, referred to, replaced by a global one,
/// nameless, without a colour.
std::string colouredRobot() {
  const auto visual = [](const std::string& material) {
    return "<visual><origin xyz=\"1 2 3\" rpy=\"0.1 -0.2 0.3\"/><geometry><box size=\"1 2 3\"/></geometry>" +
           material + "</visual>";
  };
  const std::string own = "<color rgba=\"0.1 0.2 0.3 0.4\"/>";
  return robot("<material name=\"red\"><color rgba=\"1 0 0 1\"/></material><link name=\"a\">" +
               visual("<material name=\"red\"/>") + visual("<material name=\"mine\">" + own + "</material>") +
               visual("<material name=\"red\">" + own + "</material>") + visual("") +
               "</link><link name=\"b\">" + visual("<material name=\"mine\"/>") +
               visual("<material name=\"mine\"><color rgba=\"0 0 0 1\"/></material>") +
               visual("<material name=\"\">" + own + "</material>") + visual("<material name=\"nowhere\"/>") +
               "<inertial><origin xyz=\"1 2 3\" rpy=\"0.4 0.5 -0.6\"/><mass value=\"3\"/><inertia ixx=\"1\" "
               "iyy=\"2\" izz=\"2.5\" "
               "ixy=\"0.1\" ixz=\"0.2\" iyz=\"0.3\"/></inertial></link>" +
               joint("j", "revolute", "a", "b",
                     "<axis xyz=\"0 0 1\"/><limit effort=\"1\" velocity=\"1\" upper=\"1\"/><dynamics "
                     "damping=\"0.25\" friction=\"0.5\"/>"));
}

Pose poseOf(const urdf::Pose& pose) {
  const auto& q = pose.rotation;
  return {Quaternion(q.w, q.x, q.y, q.z).normalized(),
          Vector3(pose.position.x, pose.position.y, pose.position.z)};
}

void compareInertia(const urdf::Link& theirs, const RobotFile& robot, const LinkXml& link) {
  const LinkInertia ours = readInertia(robot, link);
  if (!theirs.inertial) {
    EXPECT_EQ(ours.mass, 0);
    return;
  }
  const urdf::Inertial& i = *theirs.inertial;
  const Pose X_LC = poseOf(i.origin);
  Matrix3 I;
  I << i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz;
  EXPECT_EQ(ours.mass, i.mass);
  EXPECT_EQ(ours.p_LC, X_LC.p);
  EXPECT_LE((ours.I_C - X_LC.R * I * X_LC.R.transpose()).cwiseAbs().maxCoeff(),
            kRounding * I.cwiseAbs().sum());
}

void compareVisuals(const urdf::Link& theirs, const RobotFile& robot, const LinkXml& link,
                    const MaterialColours& colours) {
  std::vector<std::string> missing;
  LoadReport said;
  const std::vector<VisualDef> ours = readVisuals(robot, link, colours, missing, said);
  if (!missing.empty() || !said.warnings.empty()) return;  // drawn by one of them alone
  ASSERT_EQ(ours.size(), theirs.visual_array.size());
  for (std::size_t v = 0; v < ours.size(); ++v) {
    const urdf::Visual& visual = *theirs.visual_array[v];
    const Pose X_LV = poseOf(visual.origin);
    EXPECT_LE((ours[v].X_LV.R - X_LV.R).cwiseAbs().maxCoeff(), kRounding);
    EXPECT_EQ(ours[v].X_LV.p, X_LV.p);
    Colour colour = VisualDef().colour;
    if (visual.material) {
      const urdf::Color& c = visual.material->color;
      colour = {c.r, c.g, c.b, c.a};
    }
    EXPECT_EQ(ours[v].colour, colour) << link.name << ", visual " << v;
  }
}

/// False: urdfdom refuses the file.
bool compare(const std::string& path) {
  const auto model = urdf::parseURDFFile(path);
  if (!model) return false;
  const auto robot = readRobot(path, {});
  LoadReport said;
  const MaterialColours colours(*robot, said);
  EXPECT_EQ(robot->name, model->getName());
  EXPECT_EQ(robot->links.size(), model->links_.size());
  EXPECT_EQ(robot->joints.size(), model->joints_.size());
  for (const LinkXml& link : robot->links) {
    const auto theirs = model->getLink(link.name);
    compareInertia(*theirs, *robot, link);
    compareVisuals(*theirs, *robot, link, colours);
  }
  for (const JointXml& joint : robot->joints) {
    const auto theirs = model->getJoint(joint.name);
    std::vector<std::string> warnings;
    const JointDef ours = readJoint(*robot, joint, ModelSettings(), warnings);
    EXPECT_EQ(ours.damping, theirs->dynamics ? theirs->dynamics->damping : 0);
    EXPECT_EQ(ours.friction, theirs->dynamics ? theirs->dynamics->friction : 0);
    EXPECT_EQ(robot->links[joint.parent].name, theirs->parent_link_name);
  }
  return true;
}

TEST(Urdfdom, ReadsTheSame) {
  console_bridge::noOutputHandler();  // it complains of what it does not know
  const TemporaryFiles files;
  EXPECT_TRUE(compare(files.write("coloured.urdf", colouredRobot())));
  int compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(HAPTIC_SCENES)) {
    if (entry.path().extension() == ".urdf") compared += compare(entry.path().string());
  }
  EXPECT_GE(compared, 20);
  console_bridge::restorePreviousOutputHandler();
}

}  // namespace urdfdom_test
}  // namespace haptic
