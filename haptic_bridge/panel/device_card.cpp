#include "haptic_bridge/panel/device_card.h"

#include <haptic_msgs/Clutch.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <QGridLayout>
#include <QPushButton>
#include <QVBoxLayout>

#include "haptic_core/loop/stop_channel.h"

namespace haptic {
namespace {

constexpr std::chrono::milliseconds kStopPatience{300};  // a device that ticks answers within two ticks
constexpr double kSilence = 3;  // DeviceState comes at 1 Hz: this long without it, the state is not known [s]

}  // namespace

DeviceCard::DeviceCard(const std::string& name, ServiceCalls& calls, const Say& say, QWidget* parent)
    : QGroupBox(QString::fromStdString(name), parent),
      name_(name),
      calls_(calls),
      say_(say),
      state_(new QLabel(this)),
      advice_(new QLabel(this)) {
  setObjectName(QString::fromStdString("device_" + name));
  state_->setObjectName("state");
  state_->setAlignment(Qt::AlignCenter);
  advice_->setObjectName("advice");
  advice_->setWordWrap(true);
  advice_->setMinimumHeight(2 * advice_->fontMetrics().height());  // two lines: the card does not jump with its text
  advice_->setAlignment(Qt::AlignTop | Qt::AlignLeft);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(4, 4, 4, 4);
  column->setSpacing(3);
  column->addWidget(state_);
  column->addWidget(advice_);
  addButtons();
  showState({"UNKNOWN", Weight::kWarning}, "waits for the device's first word");
  heard_ = ros::SteadyTime::now();
  subscriber_ = nh_.subscribe<haptic_msgs::DeviceState>(
      "/" + name + "/state", 10, [this](const haptic_msgs::DeviceState::ConstPtr& m) { show(*m); });
}

void DeviceCard::addButtons() {
  auto* grid = new QGridLayout;
  grid->setSpacing(3);
  const std::string driver = "/" + name_ + "/driver/";
  addButton(*grid, 0, 0, "Enable", "Force on, where it can come on at once", [this, driver] {
    std_srvs::SetBool on;
    on.request.data = true;
    calls_.ask(name_ + ": enable", driver + "enable_force", on);
  });
  addButton(*grid, 0, 1, "Calibrate", "The grip is held at home now: its pose is taken from there", [this, driver] {
    calls_.ask(name_ + ": calibrate", driver + "calibrate", std_srvs::Trigger());
  });
  addButton(*grid, 0, 2, "Recover", "Leaves a fault; the force stays off", [this, driver] {
    calls_.ask(name_ + ": recover", driver + "recover", std_srvs::Trigger());
  });
  const auto clutch = [this](bool hold) {
    haptic_msgs::Clutch request;
    request.request.device = name_;
    request.request.hold = hold;
    calls_.ask(name_ + (hold ? ": clutch" : ": follow"), "/bridge/clutch", request);
  };
  addButton(*grid, 1, 0, "Clutch", "The pointer stands while the grip moves on", [clutch] { clutch(true); });
  addButton(*grid, 1, 1, "Follow", "The pointer follows the grip again", [clutch] { clutch(false); });
  addButton(*grid, 1, 2, "Force off", "Of this device alone: its strings keep their least tension", [this, driver] {
    std_srvs::SetBool off;
    off.request.data = false;
    calls_.ask(name_ + ": force off", driver + "enable_force", off);
  });
  static_cast<QVBoxLayout*>(layout())->addLayout(grid);
}

void DeviceCard::addButton(QGridLayout& grid, int row, int column, const char* text, const char* help,
                           std::function<void()> press) {
  auto* button = new QPushButton(text, this);
  button->setObjectName(text);
  button->setToolTip(help);
  button->setMinimumWidth(0);
  connect(button, &QPushButton::clicked, this, [press] { press(); });
  grid.addWidget(button, row, column);
}

/// On the driver's machine without the master, which may be gone or slow; else by the service, whose address it knows.
void DeviceCard::stop() {
  const std::string socket = stop_socket_, service = "/" + name_ + "/driver/stop";
  calls_.start(ServiceCalls::Lane::kStop, [this, socket, service] {
    const std::vector<Stopped> here = sayStop({socket}, kStopPatience);
    std_srvs::Trigger call;
    const bool off = !here.empty() && here[0].answer.off;
    const bool reached = off || (ros::service::call(service, call) && call.response.success);
    const std::string said = off ? here[0].answer.message : call.response.message;
    QMetaObject::invokeMethod(&calls_, [this, reached, said] {
      if (reached) return calls_.tell(said, true);
      calls_.tell("STOP DID NOT REACH " + name_ + ": cut the power of its motors. " + said, false);
    });
  });
}

void DeviceCard::show(const haptic_msgs::DeviceState& state) {
  heard_ = ros::SteadyTime::now();
  stop_socket_ = state.stop_socket;
  showState(wordOf(state), state.message);
  say_("device " + name_, tell(name_, state));
}

void DeviceCard::showState(const DeviceWord& word, const std::string& advice) {
  state_->setText(word.word);
  state_->setStyleSheet(QString("color: white; font-weight: bold; padding: 4px; background: %1").arg(groundOf(word.weight)));
  advice_->setText(QString::fromStdString(advice));
  advice_->setToolTip(advice_->text());
}

void DeviceCard::age() {
  if ((ros::SteadyTime::now() - heard_).toSec() < kSilence) return;
  const DeviceWord word{"NO NEWS", Weight::kAlarm};
  const std::string advice =
      "nothing heard for 3 s: the driver has ended, or the network does not bring its topics (is ROS_IP set on both machines?)";
  showState(word, advice);
  say_("device " + name_, {{word.weight, name_ + " " + word.word + ": " + advice}});
}

}  // namespace haptic
