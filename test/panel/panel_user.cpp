#include "panel_user.h"

#include <rviz/panel.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_frame.h>
#include <rviz/visualization_manager.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <QApplication>
#include <QDockWidget>
#include <QListWidget>
#include <QProcess>
#include <QScrollArea>
#include <QThread>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

namespace {

constexpr std::chrono::seconds kPatience{60};  // what has not come by then never comes
constexpr int kWidth = 1440, kHeight = 1000;   // [pixels]

}  // namespace

VirtualDisplay::VirtualDisplay() {
  int number[2];
  if (pipe(number) != 0) throw std::runtime_error("no pipe");
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that aborts runs no destructor, and its output stays open for as long as this lives
    close(number[0]);
    const std::string fd = std::to_string(number[1]), size = std::to_string(kWidth) + "x" + std::to_string(kHeight) + "x24";
    execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", size.c_str(), "+extension", "GLX", "-nolisten", "tcp",
           static_cast<char*>(nullptr));
    _exit(127);
  }
  close(number[1]);
  std::string text;
  for (char c; read(number[0], &c, 1) == 1 && c != '\n';) text += c;
  close(number[0]);
  if (text.empty()) throw std::runtime_error("Xvfb does not start; install xvfb");
  setenv("DISPLAY", (":" + text).c_str(), 1);
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
  setenv("QT_X11_NO_MITSHM", "1", 1);
}

VirtualDisplay::~VirtualDisplay() {
  kill(pid_, SIGTERM);
  waitpid(pid_, nullptr, 0);
}

PanelUser::PanelUser(QApplication& application, const std::string& config) : frame_(std::make_unique<rviz::VisualizationFrame>()) {
  frame_->setApp(&application);
  frame_->setShowChooseNewMaster(false);
  frame_->initialize(QString::fromStdString(config));
  frame_->setGeometry(0, 0, kWidth, kHeight);
  frame_->show();
  frame_->activateWindow();
  waitFor([&] { return panel() && panel()->isVisible(); });
}

PanelUser::~PanelUser() = default;

bool PanelUser::waitFor(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    QCoreApplication::processEvents(QEventLoop::AllEvents, 50);
    QThread::msleep(5);
  }
  return true;
}

QWidget* PanelUser::panel() const {
  for (rviz::Panel* panel : frame_->findChildren<rviz::Panel*>()) {
    if (panel->getClassId() == "haptic_bridge/HapticPanel") return panel;
  }
  return nullptr;
}

void PanelUser::input(const std::string& words) {
  QProcess process;
  process.start("xdotool", QString::fromStdString(words).split(' '));
  waitFor([&] { return process.state() == QProcess::NotRunning; });
  if (process.exitStatus() != QProcess::NormalExit || process.exitCode() != 0) throw std::runtime_error("xdotool " + words + " failed");
}

void PanelUser::bringIntoView(QWidget& widget) {
  for (QWidget* above = widget.parentWidget(); above; above = above->parentWidget()) {
    if (auto* area = qobject_cast<QScrollArea*>(above)) area->ensureWidgetVisible(&widget);
  }
  waitFor([n = 0]() mutable { return ++n > 4; });  // a few turns of the window: it scrolls and draws
}

void PanelUser::click(const std::string& name) {
  auto* widget = find<QWidget>(name);
  if (!widget) throw std::runtime_error("the panel has no " + name);
  bringIntoView(*widget);
  const QPoint at = widget->mapToGlobal(widget->rect().center());
  input("mousemove " + std::to_string(at.x()) + " " + std::to_string(at.y()) + " click 1");
}

void PanelUser::press(const std::string& key) { input("key " + key); }

void PanelUser::type(const std::string& text) { input("type " + text); }

void PanelUser::drag(const std::string& name, double from_share, double to_share) {
  auto* slider = find<QWidget>(name);
  if (!slider) throw std::runtime_error("the panel has no " + name);
  bringIntoView(*slider);
  const auto at = [&](double share) {
    const int half_handle = 6;
    const QPoint p = slider->mapToGlobal(QPoint(half_handle + static_cast<int>(share * (slider->width() - 2 * half_handle)),
                                                slider->height() / 2));
    return std::to_string(p.x()) + " " + std::to_string(p.y());
  };
  input("mousemove " + at(from_share) + " mousedown 1");
  input("mousemove " + at(0.5 * (from_share + to_share)));
  input("mousemove " + at(to_share) + " mouseup 1");
}

bool PanelUser::shows(const std::string& part) const {
  const auto* lines = find<QListWidget>("lines");
  return lines && !lines->findItems(QString::fromStdString(part), Qt::MatchContains).empty();
}

void PanelUser::forgetLines() {
  if (auto* lines = find<QListWidget>("lines")) lines->clear();
}

std::string PanelUser::view() const {
  return frame_->getManager()->getViewManager()->getCurrent()->getClassId().toStdString();
}

std::string PanelUser::viewFrame() const {
  return frame_->getManager()->getViewManager()->getCurrent()->subProp("Target Frame")->getValue().toString().toStdString();
}

void PanelUser::picture(const std::string& file) {
  QProcess process;
  process.start("import", {"-window", "root", QString::fromStdString(file)});
  waitFor([&] { return process.state() == QProcess::NotRunning; });
}
