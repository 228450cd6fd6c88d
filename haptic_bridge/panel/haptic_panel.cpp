#include "haptic_bridge/panel/haptic_panel.h"

#include <ros/this_node.h>
#include <rviz/visualization_manager.h>
#include <rviz/window_manager_interface.h>

#include <QApplication>
#include <QKeyEvent>
#include <QMainWindow>
#include <QLabel>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QTime>
#include <QTimer>
#include <QVBoxLayout>
#include <pluginlib/class_list_macros.hpp>

#include "haptic_bridge/panel/history_strips.h"
#include "haptic_bridge/panel/tuning_box.h"

namespace haptic {
namespace {

constexpr int kSmaller = 1;    // letters than rviz has them [points]: everything is seen without scrolling
constexpr int kLines = 100;  // that are kept to scroll back to

}  // namespace

HapticPanel::HapticPanel(QWidget* parent)
    : rviz::Panel(parent), calls_(new ServiceCalls(nullptr)), camera_(new Camera(this)), row_(new StateRow(this)) {
  QFont small = font();
  small.setPointSize(small.pointSize() - kSmaller);
  setFont(small);
  calls_->tellBy([this](const std::string& line, bool well) { tell(line, well); });
  auto* stop = new QPushButton("STOP   (Esc)", this);
  stop->setObjectName("STOP");
  stop->setToolTip("Switches the force of every device off, from anywhere: also the key Esc");
  stop->setStyleSheet("QPushButton { background: #b3123f; border: none; color: white; font-size: 22px; font-weight: bold; padding: 10px; }"
                      "QPushButton:pressed { background: #8e0000; }");
  auto* inside = new QWidget;
  auto* column = new QVBoxLayout(inside);
  column->setContentsMargins(2, 2, 2, 2);
  column->setSpacing(2);
  devices_ = new DeviceList(*calls_, [this](const std::string& source, const std::vector<Told>& told) { row_->say(source, told); }, inside);
  scene_ = new SceneBox(*calls_, inside);
  column->addWidget(devices_);
  column->addWidget(scene_);
  column->addWidget(new TuningBox(*calls_, inside));
  column->addWidget(new HistoryStrips(inside));
  auto* legend = new QLabel("Patches: blue 0, yellow 10, red 20 kPa and more; a dashed ring slides. Strings: blue slack, red 5 N. Arrows: "
                            "15 mm per newton.", inside);
  legend->setObjectName("legend");
  legend->setWordWrap(true);
  column->addWidget(legend);
  column->addStretch(1);
  auto* scroll = new QScrollArea(this);
  scroll->setWidget(inside);
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  lines_ = new QListWidget(this);
  lines_->setObjectName("lines");
  lines_->setWordWrap(true);
  lines_->setFixedHeight(3 * lines_->fontMetrics().height() + 4);
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(2, 2, 2, 2);
  all->addWidget(stop);
  all->addWidget(row_);
  all->addWidget(camera_);
  all->addWidget(scroll, 1);
  all->addWidget(lines_);
  connect(stop, &QPushButton::pressed, this, [this] { devices_->stopAll(); });  // on the press, not the release
  const auto fit = [inside, scroll] {  // nothing is cut off at the right
    scroll->setMinimumWidth(inside->minimumSizeHint().width() + scroll->verticalScrollBar()->sizeHint().width());
  };
  fit();
  devices_->tellBy([this, fit] {
    scene_->setDevices(devices_->names());
    QTimer::singleShot(0, this, fit);
  });
  log_ = nh_.subscribe<rosgraph_msgs::Log>("/rosout", 50, [this](const rosgraph_msgs::Log::ConstPtr& m) { onLog(*m); });
  qApp->installEventFilter(this);
}

HapticPanel::~HapticPanel() {
  qApp->removeEventFilter(this);
  delete row_;
  delete calls_;  // first: what it still does refers to the rest
}

void HapticPanel::onInitialize() {
  rviz::WindowManagerInterface* const window = vis_manager_->getWindowManager();
  if (auto* const frame = qobject_cast<QMainWindow*>(window ? window->getParentWindow() : nullptr)) {
    frame->addToolBarBreak(Qt::TopToolBarArea);
    frame->addToolBar(Qt::TopToolBarArea, row_);  // above the picture
    row_->setVisible(true);
  }
  row_->subscribe();
  camera_->attach(*vis_manager_);
  plan_ = nh_.subscribe<haptic_msgs::ScenePlan>("scene_plan", 2,
                                                [this](const haptic_msgs::ScenePlan::ConstPtr& plan) { camera_->see(*plan); });
}

/// A shortcut would be silent when another one claims the same key.
bool HapticPanel::eventFilter(QObject* receiver, QEvent* event) {
  if (event->type() == QEvent::KeyPress || event->type() == QEvent::ShortcutOverride) {
    const auto* key = static_cast<QKeyEvent*>(event);
    // A press comes as both, and to every widget on the way up, with one time stamp: once is enough.
    if (key->key() == Qt::Key_Escape && !key->isAutoRepeat() && key->timestamp() != stopped_at_) {
      stopped_at_ = key->timestamp();
      devices_->stopAll();
    }
  }
  return rviz::Panel::eventFilter(receiver, event);
}

void HapticPanel::tell(const std::string& line, bool well) {
  const QString text = QTime::currentTime().toString("HH:mm:ss  ") + QString::fromStdString(line);
  auto* item = new QListWidgetItem(text, lines_);
  if (!well) item->setForeground(HistoryStrip::colours(palette().color(QPalette::Base).lightness() < 128)[0]);
  item->setToolTip(text);
  while (lines_->count() > kLines) delete lines_->takeItem(0);
  lines_->scrollToBottom();
}

/// What the stack's nodes complain of, the reason of a refused parameter among it.
void HapticPanel::onLog(const rosgraph_msgs::Log& log) {
  if (log.level >= rosgraph_msgs::Log::ERROR && log.name != ros::this_node::getName()) tell(log.msg, false);
}

}  // namespace haptic

PLUGINLIB_EXPORT_CLASS(haptic::HapticPanel, rviz::Panel)
