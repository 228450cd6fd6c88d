#include "haptic_bridge/panel/scene_box.h"

#include <haptic_msgs/Grab.h>
#include <haptic_msgs/LoadScene.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QGridLayout>
#include <QPushButton>

namespace haptic {
namespace {

QComboBox* picker(const char* name, const char* help, bool editable, QWidget* parent) {
  auto* box = new QComboBox(parent);
  box->setObjectName(name);
  box->setToolTip(help);
  box->setEditable(editable);
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setMinimumContentsLength(6);
  return box;
}

/// Other names, the same choice where it is still there.
void fill(QComboBox& box, const std::vector<std::string>& names, const std::string& current) {
  box.clear();
  for (const std::string& name : names) box.addItem(QString::fromStdString(name));
  const int index = box.findText(QString::fromStdString(current));
  if (index >= 0) box.setCurrentIndex(index);
}

}  // namespace

SceneBox::SceneBox(ServiceCalls& calls, QWidget* parent)
    : QGroupBox("Scene", parent),
      calls_(calls),
      scenes_(picker("scenes", "A scene by its name, or the path of a file on the simulation's machine", true, this)),
      hands_(picker("hands", "The hand that grabs", false, this)),
      links_(picker("links", "The body that is grabbed", false, this)) {
  setObjectName("scene");
  auto* grid = new QGridLayout(this);
  grid->setContentsMargins(4, 4, 4, 4);
  grid->setSpacing(3);
  const auto pause = [this](bool on) {
    std_srvs::SetBool request;
    request.request.data = on;
    calls_.ask(on ? "pause" : "go on", "simulation/pause", request);
  };
  grid->addWidget(button("Pause", "The world stands; strings rest at minimum tension", [pause] { pause(true); }), 0, 0);
  grid->addWidget(button("Go on", "The world goes on; the force fades in", [pause] { pause(false); }), 0, 1);
  grid->addWidget(button("Step", "One step of the paused world",
                         [this] { calls_.ask("step", "simulation/step", std_srvs::Trigger()); }), 0, 2);
  grid->addWidget(button("Reset", "The scene as it was loaded",
                         [this] { calls_.ask("reset", "simulation/reset", std_srvs::Trigger()); }), 0, 3);
  grid->addWidget(scenes_, 1, 0, 1, 3);
  grid->addWidget(button("Load", "This scene in place of the running one", [this] {
    haptic_msgs::LoadScene request;
    request.request.scene = scenes_->currentText().toStdString();
    calls_.ask("load", "simulation/load_scene", request);
  }), 1, 3);
  grid->addWidget(hands_, 2, 0);
  grid->addWidget(links_, 2, 1);
  grid->addWidget(button("Grab", "This body becomes the hand's pointer", [this] { grab(links_->currentText().toStdString()); }), 2, 2);
  grid->addWidget(button("Release", "The pointer is again the one that the scene names", [this] { grab(""); }), 2, 3);
  subscriber_ = nh_.subscribe<haptic_msgs::ScenePlan>(
      "scene_plan", 2, [this](const haptic_msgs::ScenePlan::ConstPtr& plan) { show(*plan); });
}

QPushButton* SceneBox::button(const char* text, const char* help, std::function<void()> press) {
  auto* button = new QPushButton(text, this);
  button->setObjectName(text);
  button->setToolTip(help);
  button->setMinimumWidth(0);
  connect(button, &QPushButton::clicked, this, [press] { press(); });
  return button;
}

void SceneBox::setDevices(const std::vector<std::string>& names) { fill(*hands_, names, hands_->currentText().toStdString()); }

/// The plan comes twice: at once, and with its certificate. The second must not undo a choice.
void SceneBox::show(const haptic_msgs::ScenePlan& plan) {
  const QString title = "Scene: " + QString::fromStdString(plan.scene);
  const std::string chosen = title == this->title() ? scenes_->currentText().toStdString() : plan.scene;
  const std::string link = links_->currentText().toStdString();
  setTitle(title);
  setToolTip(QString::fromStdString(plan.text));
  fill(*scenes_, plan.known_scenes, chosen);
  scenes_->setEditText(QString::fromStdString(chosen));
  fill(*links_, plan.links, link);
}

void SceneBox::grab(const std::string& link) {
  haptic_msgs::Grab request;
  request.request.device = hands_->currentText().toStdString();
  request.request.link = link;
  calls_.ask(link.empty() ? "release" : "grab " + link, "simulation/grab", request);
}

}  // namespace haptic
