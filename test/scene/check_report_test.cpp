// What `check` says: the verdict first, equal things once, and what a drive cannot hold as a number.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "haptic_core/base/error.h"
#include "scene/check_report.h"
#include "scene/joint_reading.h"
#include "scene/step_cost.h"
#include "temporary_files.h"

namespace haptic {
namespace check_report_test {

CheckReport reportOf(const SceneDef& scene) {
  const Certificate certificate = certify(scene.world, 0.05);
  CheckReport report = checkReport(scene, certificate);
  judge(scene, certificate, false, report);
  return report;
}

SceneDef load(const std::string& inside) {
  SceneOptions options;
  options.add_pointer = false;
  return loadText(robot(inside), options);
}

TEST(CheckReport, EqualCollisionsAreOneLine) {
  std::string pebbles = "<link name=\"world\"/>";
  for (int i = 0; i < 11; ++i) {
    const std::string name = "pebble" + std::to_string(i);
    pebbles += boxLink(name) + joint("j" + std::to_string(i), "floating", "world", name, "", std::to_string(i) + " 0 0");
  }
  const CheckReport report = reportOf(load(pebbles));
  ASSERT_EQ(report.collisions.size(), 1u);
  EXPECT_NE(report.collisions[0].find("pebble0, pebble1"), std::string::npos) << report.collisions[0];
  EXPECT_NE(report.collisions[0].find("(11): box 0.1"), std::string::npos) << report.collisions[0];
  const std::string text = checkText(report);
  EXPECT_EQ(text.find("PASS: 'r' loads"), 0u) << text;
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 20) << text;
}

/// A box of 2 kg whose centre is 0.3 m from a horizontal axis asks for m g 0.3.
TEST(CheckReport, ADriveThatCannotHoldIsNamedWithItsNumbers) {
  const auto arm = [](const std::string& effort) {
    return load(boxLink("base") +
                "<link name=\"arm\"><inertial><origin xyz=\"0.3 0 0\"/><mass value=\"2\"/><inertia ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" "
                "ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>" +
                joint("j", "revolute", "base", "arm",
                      "<axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"" + effort + "\"/>"));
  };
  const SceneDef weak = arm("3");
  const std::vector<HoldingEffort> efforts = holdingEfforts(weak.world.articulations[0], weak.world.settings.gravity);
  ASSERT_EQ(efforts.size(), 1u);
  EXPECT_NEAR(efforts[0].asked, 2 * weak.world.settings.gravity.norm() * 0.3, 1e-14);
  const CheckReport report = reportOf(weak);
  ASSERT_EQ(report.weak_drives.size(), 1u);
  EXPECT_NE(report.weak_drives[0].find("'j' asks for 5.88 N·m, its limit is 3"), std::string::npos) << report.weak_drives[0];
  EXPECT_NE(report.verdict.find("1 drive too weak"), std::string::npos) << report.verdict;
  EXPECT_TRUE(reportOf(arm("6")).weak_drives.empty());
}

TEST(CheckReport, TheStartIsJudged) {
  const std::string kAxis = "<axis xyz=\"0 0 1\"/>";
  const SceneDef scene = load("<link name=\"world\"/>" + boxLink("a") + boxLink("b") + boxLink("c") + boxLink("d") +
                              joint("f", "fixed", "world", "a", "", "0 0 0") + joint("g", "floating", "world", "b", "", "0 0 0.08") +
                              joint("h", "revolute", "a", "c", kAxis + "<limit lower=\"0.5\" upper=\"1\" effort=\"0\" velocity=\"1\"/>") +
                              joint("m", "revolute", "c", "d",
                                    kAxis + "<limit lower=\"-0.1\" upper=\"0.1\" effort=\"0\" velocity=\"1\"/><mimic joint=\"h\"/>"));
  const CheckReport report = reportOf(scene);
  EXPECT_TRUE(mentions(report.start, "'a' and 'b' overlap by 20 mm")) << checkText(report);
  EXPECT_TRUE(mentions(report.start, "joint 'm' at 0.5 is beyond its limits [-0.1, 0.1]")) << checkText(report);
}

TEST(CheckReport, LongSectionsSayHowMuchIsLeftOutAndJsonHasAll) {
  CheckReport report;
  report.verdict = "PASS: \"x\" \\ y";
  for (int i = 0; i < 30; ++i) report.warnings.push_back("line " + std::to_string(i));
  EXPECT_NE(checkText(report).find("… and 23 more: --all"), std::string::npos) << checkText(report);
  const std::string json = checkJson(report);
  EXPECT_EQ(json.find("{\"verdict\": \"PASS: \\\"x\\\" \\\\ y\", \"replaced\": [], \"warnings\": [\"line 0\", \"line 1\""), 0u) << json;
  EXPECT_NE(json.find("\"line 29\"]"), std::string::npos);
}

/// Each pair counts half for each of its two collisions, and nothing else counts.
TEST(CheckReport, CostIsTheCollisionsThatHaveIt) {
  const std::string scene = "<link name=\"world\"/>" + boxLink("floor", 1, 1) + boxLink("a") + boxLink("b") + boxLink("far") +
                            joint("f", "fixed", "world", "floor", "", "0 0 -0.5") + joint("g", "floating", "world", "a", "", "0 0 0.0499") +
                            joint("h", "floating", "world", "b", "", "0.3 0 0.0499") + joint("k", "floating", "world", "far", "", "0 0 5");
  const StepCost cost = stepCost(load(scene).world, 0.1);
  EXPECT_GT(cost.seconds, 0);
  ASSERT_EQ(cost.of.size(), 3u);
  EXPECT_EQ(cost.of[0].name, "floor/collision0");
  EXPECT_EQ(cost.of[0].pairs, 2);
  EXPECT_NEAR(cost.of[0].seconds, cost.of[1].seconds + cost.of[2].seconds, 1e-12);
  const std::vector<std::string> lines = costLines(cost);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_NE(lines[1].find("'floor/collision0': "), std::string::npos) << lines[1];
  EXPECT_NE(lines[1].find(" in 2 pairs"), std::string::npos) << lines[1];
  EXPECT_NE(costLines(stepCost(load("<link name=\"world\"/>" + boxLink("a") + joint("g", "floating", "world", "a")).world, 0.1))[0]
                .find("no collisions near each other"), std::string::npos);
}

}  // namespace check_report_test
}  // namespace haptic
