/// Every action of the panel, by mouse and key in rviz with the shipped configuration; what came of it is read from the
/// topics of the running loop, not from the panel. HAPTIC_PANEL_PICTURE names a file for a picture of the window.
#include <dynamic_reconfigure/Config.h>
#include <gtest/gtest.h>
#include <haptic_msgs/DeviceState.h>
#include <haptic_msgs/ScenePlan.h>
#include <haptic_msgs/StepReport.h>
#include <haptic_msgs/TickStatistics.h>
#include <ros/ros.h>

#include <QAbstractButton>
#include <QApplication>
#include <QLabel>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>

#include "panel_user.h"

namespace {

using haptic_msgs::DeviceState;

/// What the stack says of itself.
class Loop {
 public:
  Loop() {
    hear("/spidar/state", device);
    hear("/scene_plan", plan);
    hear("/step_report", step);
    hear("/tick_statistics", ticks);
    hear("/bridge/parameter_updates", parameters);
  }
  double parameter(const std::string& name) const {
    for (const auto& entry : parameters.doubles) {
      if (entry.name == name) return entry.value;
    }
    return NAN;
  }
  bool clutched() const { return !ticks.hands.empty() && ticks.hands[0].clutched; }

  DeviceState device;
  haptic_msgs::ScenePlan plan;
  haptic_msgs::StepReport step;
  haptic_msgs::TickStatistics ticks;
  dynamic_reconfigure::Config parameters;

 private:
  template <class Message>
  void hear(const std::string& topic, Message& last) {
    subscribers_.push_back(nh_.subscribe<Message>(topic, 10, [&last](const boost::shared_ptr<const Message>& m) { last = *m; }));
  }
  ros::NodeHandle nh_;
  std::vector<ros::Subscriber> subscribers_;
};

PanelUser* user = nullptr;
std::set<std::string> tested;

/// Does something and waits for what must come of it.
void act(const std::string& what, const std::function<void()>& doing, const std::function<bool()>& outcome) {
  ASSERT_FALSE(outcome()) << what << ": it is so before anybody does anything";
  doing();
  ASSERT_TRUE(user->waitFor(outcome)) << what;
  tested.insert(what);
}

struct Panel : testing::Test {
  Loop loop;
  void SetUp() override {
    ASSERT_NE(user->find("STOP"), nullptr) << "the shipped configuration does not load the panel";
    ASSERT_TRUE(user->waitFor([this] {
      return user->find("device_spidar") && !loop.plan.scene.empty() && !loop.ticks.hands.empty() && loop.step.step > 0 &&
             !loop.parameters.doubles.empty();
    })) << "the loop does not run";
    user->forgetLines();
  }
  bool forceOn() const { return loop.device.state == DeviceState::ENABLED; }
  void enable() {
    if (forceOn()) return;
    user->click("Enable");
    ASSERT_TRUE(user->waitFor([this] { return forceOn(); }));
  }
  void answered(const std::string& button, const std::string& line) {
    act(button, [&] { user->click(button); }, [&] { return user->shows(line); });
  }
};

TEST_F(Panel, ForceOffByButtonAndKeyAndOnAgain) {
  enable();
  ASSERT_TRUE(user->waitFor([] { return user->find<QLabel>("state")->text() == "FORCE ON"; }));
  act("STOP", [] { user->click("STOP"); }, [this] { return loop.device.state == DeviceState::READY; });
  ASSERT_TRUE(user->waitFor([] { return user->find<QLabel>("state")->text() == "READY"; }));
  EXPECT_FALSE(user->find<QLabel>("advice")->text().isEmpty());
  act("Enable", [] { user->click("Enable"); }, [this] { return forceOn(); });
  act("Esc", [] { user->press("Escape"); }, [this] { return loop.device.state == DeviceState::READY; });
  enable();
  act("Force off", [] { user->click("Force off"); }, [this] { return loop.device.state == DeviceState::READY; });
  answered("Calibrate", "spidar: calibrate: ");
  answered("Recover", "spidar: recover: ");
  EXPECT_TRUE(user->waitFor([this] { return loop.device.state == DeviceState::READY; }));
  enable();
}

TEST_F(Panel, EscapeIsHeardWhileAFieldHasTheFocus) {
  enable();
  user->click("scenes");
  act("Esc in a field", [] { user->press("Escape"); }, [this] { return loop.device.state == DeviceState::READY; });
  enable();
}

TEST_F(Panel, PauseStepResetGoOn) {
  answered("Pause", "pause: done");
  std::uint64_t stood = 0;
  ASSERT_TRUE(user->waitFor([&, same = 0]() mutable {  // messages of before have come
    same = loop.step.step == stood ? same + 1 : 0;
    stood = loop.step.step;
    return same > 20;
  }));
  act("Step", [] { user->click("Step"); }, [&] { return loop.step.step == stood + 1; });
  EXPECT_TRUE(user->waitFor([n = 0]() mutable { return ++n > 20; }));
  EXPECT_EQ(loop.step.step, stood + 1) << "one step, no more";
  act("Reset", [] { user->click("Reset"); }, [&] { return loop.step.time < 0.5e-3; });
  act("Go on", [] { user->click("Go on"); }, [&] { return loop.step.time > 0.1; });
  user->forgetLines();
  act("Step refused while it runs", [] { user->click("Step"); }, [] { return user->shows("not paused"); });
}

TEST_F(Panel, ClutchAndFollow) {
  act("Clutch", [] { user->click("Clutch"); }, [this] { return loop.clutched(); });
  act("Follow", [] { user->click("Follow"); }, [this] { return !loop.clutched(); });
}

TEST_F(Panel, GrabAndRelease) {
  act("Pick a body", [] { user->click("links"); user->press("Home"); user->press("Return"); user->click("Grab"); },
      [this] { return user->shows("grab " + loop.plan.links[0] + ": done"); });
  answered("Release", "release: done");
}

TEST_F(Panel, SlidersTuneTheLoop) {
  act("Stiffness", [] { user->drag("stiffness_scale", 2.0 / 3, 0.75); }, [this] { return loop.parameter("stiffness_scale") > 1.5; });
  act("Friction", [] { user->drag("friction_scale", 1.0 / 3, 0.5); }, [this] { return loop.parameter("friction_scale") > 1.3; });
  act("Force limit", [] { user->drag("limit_share", 1, 0.5); }, [this] { return loop.parameter("limit_share") < 0.7; });
  act("Coupling", [] { user->drag("coupling_stiffness", 0, 0.4); }, [this] { return loop.parameter("coupling_stiffness") > 100; });
  const double kept = loop.parameter("coupling_stiffness");
  // A pointer of 50 g at 1 kHz cannot be held by 100 N/mm.
  act("Refused value", [] { user->drag("coupling_stiffness", 0.4, 1); },
      [] { return user->shows("Coupling: refused") || user->shows("coupling: refused"); });
  EXPECT_TRUE(user->waitFor([] { return user->shows("lower them"); })) << "the reason";
  EXPECT_EQ(loop.parameter("coupling_stiffness"), kept);
  answered("As the scene says", "as the scene says: set");
  EXPECT_TRUE(user->waitFor([this] { return loop.parameter("stiffness_scale") == 1; })) << "the topic may come after the answer";
}

TEST_F(Panel, AnotherSceneAndRefusedOnes) {
  const auto ask = [](const std::string& scene) {
    user->click("scenes");
    user->press("ctrl+a");
    user->type(scene);
    user->click("Load");
  };
  act("Scene", [&] { ask("blocks"); }, [this] { return loop.plan.scene == "blocks" && user->shows("load: blocks"); });
  EXPECT_TRUE(user->waitFor([this, before = loop.ticks.ticks] { return loop.ticks.ticks > before + 200; })) << "it ticks again";
  act("Unknown scene refused", [&] { ask("no_such_scene"); }, [] { return user->shows("known: "); });
  act("Scene of other devices refused", [&] { ask("d_two_hands"); }, [] { return user->shows("is for the devices"); });
  EXPECT_EQ(loop.plan.scene, "blocks");
  ask("touch_cube");
  EXPECT_TRUE(user->waitFor([this] { return loop.plan.scene == "touch_cube"; }));
}

double luminance(QRgb colour) {
  const auto linear = [](int byte) { return byte <= 10 ? byte / 255.0 / 12.92 : std::pow((byte / 255.0 + 0.055) / 1.055, 2.4); };
  return 0.2126 * linear(qRed(colour)) + 0.7152 * linear(qGreen(colour)) + 0.0722 * linear(qBlue(colour));
}

/// WCAG ratio between the most frequent colour of a widget's picture and the one that stands out most: its ground and its letters.
double contrastOf(QWidget& widget) {
  const QImage image = widget.grab().toImage();
  std::map<QRgb, int> count;
  for (int x = 0; x < image.width(); ++x) {
    for (int y = 0; y < image.height(); ++y) ++count[image.pixel(x, y)];
  }
  const auto ground = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  double most = 1;
  for (const auto& [colour, pixels] : count) {
    const double a = luminance(colour), b = luminance(ground->first);
    most = std::max(most, (std::max(a, b) + 0.05) / (std::min(a, b) + 0.05));
  }
  return most;
}

// The row's and the cards' colours for all states: told_states_test.
TEST_F(Panel, EachWordStandsOut) {
  double least = 21;
  int words = 0;
  QWidget* const window = user->panel()->window();
  for (QWidget* widget : window->findChildren<QWidget*>()) {
    const auto* label = qobject_cast<QLabel*>(widget);
    const auto* button = qobject_cast<QAbstractButton*>(widget);
    const bool ours = user->panel()->isAncestorOf(widget) || widget->objectName() == "row";
    if (!ours || !widget->isVisible() || !((label && !label->text().isEmpty()) || (button && !button->text().isEmpty()))) continue;
    const double contrast = contrastOf(*widget);
    EXPECT_GE(contrast, 4.5) << widget->objectName().toStdString() << " " << (label ? label->text() : button->text()).toStdString();
    least = std::min(least, contrast);
    ++words;
  }
  EXPECT_GT(words, 20);
  std::printf("figure rviz.contrast_min %.3g 1\n", least);
}

// The first picture is fitted to the hand and to what it may touch; a banner says what goes on in the whole window.
TEST_F(Panel, BannersStandAboveThePicture) {
  auto* row = user->panel()->window()->findChild<QLabel*>("row");
  ASSERT_NE(row, nullptr);
  const auto says = [row](const char* words) { return row->text().contains(words); };
  EXPECT_TRUE(row->isVisible());
  enable();
  ASSERT_TRUE(user->waitFor([&] { return says("touch_cube"); })) << row->text().toStdString();
  act("Banner of the pause", [] { user->click("Pause"); }, [&] { return says("PAUSED"); });
  if (const char* file = std::getenv("HAPTIC_PAUSED_PICTURE")) user->picture(file);
  act("Banner goes", [] { user->click("Go on"); }, [&] { return !says("PAUSED"); });
  act("Banner of the clutch", [] { user->click("Clutch"); }, [&] { return says("CLUTCH"); });
  user->click("Follow");
  ASSERT_TRUE(user->waitFor([&] { return !says("CLUTCH"); }));
}

TEST_F(Panel, AViewFollowsTheGrip) {
  const auto pick = [](const std::string& key) { user->click("views"); user->press(key); user->press("Return"); };
  act("View of the grip", [&] { pick("End"); }, [] { return user->view() == "rviz/ThirdPersonFollower"; });
  if (const char* file = std::getenv("HAPTIC_GRIP_PICTURE")) {
    user->waitFor([n = 0]() mutable { return ++n > 60; });
    user->picture(file);
  }
  act("View of the hand", [&] { pick("Home"); }, [] { return user->view() == "rviz/Orbit"; });
  EXPECT_EQ(user->viewFrame(), "<Fixed Frame>") << "not that of the view before";
}

TEST_F(Panel, StripsDraw) {
  for (const char* strip : {"strip_Force", "strip_Tick", "strip_Energy", "strip_Error"}) {
    SCOPED_TRACE(strip);
    EXPECT_TRUE(user->waitFor([strip] {
      const QImage image = user->find(strip)->grab().toImage();
      std::set<QRgb> colours;
      for (int x = 0; x < image.width(); ++x) {
        for (int y = image.height() / 2; y < image.height(); ++y) colours.insert(image.pixel(x, y));
      }
      return colours.size() > 4;  // below the words: the ground, the axis and curves with smooth edges
    }));
  }
  if (const char* file = std::getenv("HAPTIC_PANEL_PICTURE")) user->picture(file);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  const VirtualDisplay display;
  QApplication application(argc, argv);
  ros::init(argc, argv, "panel_test", ros::init_options::NoSigintHandler);
  if (argc < 2) return std::fputs("usage: panel_test CONFIGURATION.rviz\n", stderr), 2;
  int result = 1;
  {
    PanelUser somebody(application, argv[1]);
    user = &somebody;
    // Each waits for what comes of the one before: after a failure there is nothing to learn from the rest.
    testing::GTEST_FLAG(fail_fast) = true;
    result = RUN_ALL_TESTS();
    std::printf("figure panel.actions_tested %zu 1\n", tested.size());
  }
  return result;
}
