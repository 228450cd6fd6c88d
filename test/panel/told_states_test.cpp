/// Each state of devices, session and loop is told in the row above the picture, in words that can be read, with what to do.
#include <gtest/gtest.h>

#include <QApplication>
#include <QLabel>
#include <cmath>
#include <cstdio>
#include <set>

#include "haptic_msgs/flag_words.h"
#include "haptic_bridge/panel/history_strip.h"
#include "haptic_bridge/panel/state_row.h"

namespace haptic {
namespace told_states_test {

using haptic_msgs::DeviceState;

double luminance(const QColor& colour) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  return 0.2126 * linear(colour.redF()) + 0.7152 * linear(colour.greenF()) + 0.0722 * linear(colour.blueF());
}

/// Of WCAG 2.1.
double contrast(const QColor& a, const QColor& b) {
  const double one = luminance(a), other = luminance(b);
  return (std::max(one, other) + 0.05) / (std::min(one, other) + 0.05);
}

struct Row {
  StateRow row;
  std::string text() {
    row.refresh();
    return row.findChild<QLabel*>("row")->text().toStdString();
  }
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

haptic_msgs::ScenePlan plan() {
  haptic_msgs::ScenePlan plan;
  plan.scene = "touch_cube";
  plan.pointers = {"pointer"};
  return plan;
}

haptic_msgs::TickStatistics loop() {
  haptic_msgs::TickStatistics loop;
  loop.hands.resize(1);
  loop.hands[0].device = "spidar";
  loop.hands[0].pointer = "pointer";
  return loop;
}

haptic_msgs::StepReport step() {
  haptic_msgs::StepReport step;
  step.finite = true;
  return step;
}

int shown = 0, listed = 0;

void expect(Row&& row, const std::string& words) {
  const std::string text = row.text();
  ++listed;
  shown += has(text, words);
  EXPECT_TRUE(has(text, words)) << "'" << words << "' is not in: " << text;
}

TEST(ToldStates, OfDevices) {
  const char* words[] = {"UNCALIBRATED", "READY", "", "REDUCED", "FAULT", "DISCONNECTED"};
  for (std::uint8_t state = DeviceState::UNCALIBRATED; state <= DeviceState::DISCONNECTED; ++state) {
    DeviceState device;
    device.state = state;
    device.message = "do this";
    Row row;
    row.row.hear(loop());
    row.row.say("device spidar", tell("spidar", device));
    EXPECT_EQ(std::string(wordOf(device).word).find("UNKNOWN"), std::string::npos);
    if (state == DeviceState::ENABLED) {
      expect(std::move(row), "the hand touches nothing");  // the force is on: what is felt
    } else {
      EXPECT_TRUE(has(row.text(), "do this"));
      expect(std::move(row), words[state]);
    }
  }
  DeviceState released;
  released.state = DeviceState::READY;
  released.dead_man = DeviceState::SWITCH_RELEASED;
  Row row;
  row.row.say("device spidar", tell("spidar", released));
  expect(std::move(row), "dead-man switch");
}

TEST(ToldStates, OfTheSession) {
  const auto with = [](haptic_msgs::TickStatistics m, const std::string& words) {
    Row row;
    row.row.hear(plan(), "/simulation");
    row.row.hear(m);
    expect(std::move(row), words);
  };
  haptic_msgs::TickStatistics m = loop();
  m.paused = true;
  with(m, "press Go on");
  m = loop();
  m.hands[0].clutched = true;
  with(m, "press Follow");
  m = loop();
  m.hands[0].pointer = "cube";
  with(m, "HOLDS cube");
  Row replay;
  replay.row.hear(plan(), "/replay");
  expect(std::move(replay), "REPLAY");
}

TEST(ToldStates, OfTheLoopsFlags) {
  std::set<std::string> texts;
  for (unsigned bit = 0; (1u << bit) <= kForceWaits; ++bit) {
    haptic_msgs::TickStatistics m = loop();
    m.hands[0].flags = 1u << bit;
    const std::vector<Told> told = tell(m, {"pointer"});
    ASSERT_EQ(told.size(), 2u) << "device flag " << bit << " has no words";
    EXPECT_TRUE(texts.insert(told.back().text).second) << told.back().text;
    Row row;
    row.row.hear(plan(), "/simulation");
    row.row.hear(m);
    expect(std::move(row), told.back().text);
  }
  for (unsigned bit = 0; (1u << bit) <= kGaveWay; ++bit) {
    haptic_msgs::StepReport m = step();
    m.flags = 1u << bit;
    const std::vector<Told> told = tell(m);
    ASSERT_EQ(told.size(), 2u) << "step flag " << bit << " has no words";
    EXPECT_TRUE(texts.insert(told.back().text).second) << told.back().text;
    Row row;
    row.row.hear(m);
    expect(std::move(row), told.back().text);
  }
  haptic_msgs::StepReport lost = step();
  lost.finite = false;
  Row row;
  row.row.hear(lost);
  expect(std::move(row), "THE WORLD STOPPED");
}

// A state that is over leaves the row, and one that flickers can be read.
TEST(ToldStates, ABannerStaysLongEnoughAndGoes) {
  Row row;
  row.row.hear(plan(), "/simulation");
  haptic_msgs::TickStatistics m = loop();
  m.paused = true;
  row.row.hear(m);
  row.row.hear(loop());
  EXPECT_TRUE(has(row.text(), "PAUSED"));
  ros::SteadyTime begin = ros::SteadyTime::now();
  while (has(row.text(), "PAUSED") && (ros::SteadyTime::now() - begin).toSec() < 60) QApplication::processEvents(QEventLoop::AllEvents, 50);
  EXPECT_GE((ros::SteadyTime::now() - begin).toSec(), 0.9 * StateRow::kStays);
  EXPECT_TRUE(has(row.text(), "touches nothing")) << row.text();
}

TEST(ToldStates, WordsStandOut) {
  for (const Weight weight : {Weight::kCalm, Weight::kNotice, Weight::kWarning, Weight::kAlarm}) {
    EXPECT_GE(contrast(QColor(Qt::white), QColor(groundOf(weight))), 4.5) << groundOf(weight);
  }
  const QColor light("#f3f3f3"), dark("#303030");  // darker than usual light grounds of strips, lighter than dark ones
  for (const QColor& colour : HistoryStrip::colours(false)) EXPECT_GE(contrast(colour, light), 4.5) << colour.name().toStdString();
  for (const QColor& colour : HistoryStrip::colours(true)) EXPECT_GE(contrast(colour, dark), 4.5) << colour.name().toStdString();
  EXPECT_LT(contrast(QColor("#7cb342"), light), 4.5) << "this measure can fail";
}

}  // namespace told_states_test
}  // namespace haptic

int main(int argc, char** argv) {
  setenv("QT_QPA_PLATFORM", "offscreen", 1);
  testing::InitGoogleTest(&argc, argv);
  QApplication application(argc, argv);
  const int result = RUN_ALL_TESTS();
  std::printf("figure panel.states_told %d of_%d\n", haptic::told_states_test::shown, haptic::told_states_test::listed);
  return result;
}
