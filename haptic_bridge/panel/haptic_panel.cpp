#include "haptic_bridge/panel/haptic_panel.h"

#include <ros/this_node.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_manager.h>

#include <QApplication>
#include <QKeyEvent>
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

HapticPanel::HapticPanel(QWidget* parent) : rviz::Panel(parent), calls_(new ServiceCalls(nullptr)), views_(new QComboBox(this)) {
  QFont small = font();
  small.setPointSize(small.pointSize() - kSmaller);
  setFont(small);
  calls_->tellBy([this](const std::string& line, bool well) { tell(line, well); });
  auto* stop = new QPushButton("STOP   (Esc)", this);
  stop->setObjectName("STOP");
  stop->setToolTip("Switches the force of every device off, from anywhere: also the key Esc");
  stop->setStyleSheet("QPushButton { background: #c62828; color: white; font-size: 22px; font-weight: bold; padding: 10px; }"
                      "QPushButton:pressed { background: #8e0000; }");
  views_->setObjectName("views");
  views_->setToolTip("A view that the configuration keeps");
  auto* inside = new QWidget;
  auto* column = new QVBoxLayout(inside);
  column->setContentsMargins(2, 2, 2, 2);
  column->setSpacing(2);
  devices_ = new DeviceList(*calls_, inside);
  scene_ = new SceneBox(*calls_, inside);
  column->addWidget(devices_);
  column->addWidget(scene_);
  column->addWidget(new TuningBox(*calls_, inside));
  column->addWidget(new HistoryStrips(inside));
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
  all->addWidget(views_);
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
  delete calls_;  // first: what it still does refers to the rest
}

void HapticPanel::onInitialize() {
  rviz::ViewManager* views = vis_manager_->getViewManager();
  for (int i = 0; i < views->getNumViews(); ++i) views_->addItem("View: " + views->getViewAt(i)->getName());
  views_->setVisible(views_->count() > 0);
  connect(views_, QOverload<int>::of(&QComboBox::activated), this, [views](int i) { views->setCurrentFrom(views->getViewAt(i)); });
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
  if (!well) item->setForeground(QColor("#d32f2f"));
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
