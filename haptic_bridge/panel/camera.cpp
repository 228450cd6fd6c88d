#include "haptic_bridge/panel/camera.h"

#include <rviz/properties/vector_property.h>
#include <rviz/render_panel.h>
#include <rviz/view_controller.h>
#include <rviz/view_manager.h>
#include <rviz/visualization_manager.h>

#include <QEvent>

namespace haptic {
namespace {

constexpr double kPitch = 0.45;       // [rad]
constexpr double kNearClip = 0.001;   // a point nearer to the camera is not drawn [m]
constexpr int kFitted = 2;            // views before those of the configuration
constexpr double kRounding = 1e-4;    // rviz keeps its cameras in floats [1]
constexpr const char* kOrbit = "rviz/Orbit";

std::vector<Vector3> pointsOf(const std::vector<geometry_msgs::Point>& given) {
  std::vector<Vector3> points;
  for (const geometry_msgs::Point& p : given) points.emplace_back(p.x, p.y, p.z);
  return points;
}

double number(rviz::ViewController& view, const char* name) { return view.subProp(name)->getValue().toDouble(); }

}  // namespace

Camera::Camera(QWidget* parent) : QComboBox(parent) {
  setObjectName("views");
  setToolTip("Where the camera looks; the mouse turns, moves and zooms it");
  addItem("View: the hand and what it may touch");
  addItem("View: the whole scene");
  connect(this, QOverload<int>::of(&QComboBox::activated), this, [this](int view) { choose(view); });
}

void Camera::attach(rviz::VisualizationManager& manager) {
  manager_ = &manager;
  const rviz::ViewManager& views = *manager.getViewManager();
  for (int i = 0; i < views.getNumViews(); ++i) addItem("View: " + views.getViewAt(i)->getName());
  manager.getRenderPanel()->installEventFilter(this);
  fit();
}

void Camera::see(const haptic_msgs::ScenePlan& plan) {
  const std::vector<Vector3> hand = pointsOf(plan.hand_view), scene = pointsOf(plan.scene_view);
  if (hand == hand_ && scene == scene_) return;  // the plan comes once more, with its certificate
  hand_ = hand, scene_ = scene, yaw_ = plan.view_yaw;
  fit();
}

void Camera::choose(int view) {
  view_ = view;
  if (view < kFitted) return fit();
  rviz::ViewManager& views = *manager_->getViewManager();
  views.setCurrentFrom(views.getViewAt(view - kFitted));
}

void Camera::fit() {
  const std::vector<Vector3>& points = view_ == 0 && !hand_.empty() ? hand_ : scene_;
  if (!manager_ || view_ >= kFitted || points.empty()) return;
  rviz::ViewManager& views = *manager_->getViewManager();
  if (views.getCurrent()->getClassId() != kOrbit) views.setCurrentViewControllerType(kOrbit);
  rviz::ViewController& camera = *views.getCurrent();
  const rviz::RenderPanel& panel = *manager_->getRenderPanel();
  fitted_ = fitCamera(points, yaw_, kPitch, std::tan(number(camera, "Field of View") / 2),
                      static_cast<double>(panel.width()) / std::max(1, panel.height()));
  camera.subProp("Target Frame")->setValue("<Fixed Frame>");  // a view that followed the grip has left its own
  camera.subProp("Near Clip Distance")->setValue(kNearClip);
  camera.subProp("Yaw")->setValue(fitted_.yaw);
  camera.subProp("Pitch")->setValue(fitted_.pitch);
  camera.subProp("Distance")->setValue(fitted_.distance);
  const Vector3& focus = fitted_.focus;
  static_cast<rviz::VectorProperty*>(camera.subProp("Focal Point"))
      ->setVector(Ogre::Vector3(static_cast<float>(focus.x()), static_cast<float>(focus.y()), static_cast<float>(focus.z())));
}

bool Camera::stands() const {
  rviz::ViewController& view = *manager_->getViewManager()->getCurrent();
  if (view.getClassId() != kOrbit) return false;
  const auto as = [&](const char* name, double value) { return std::fabs(number(view, name) - value) <= kRounding * std::fabs(value); };
  return as("Distance", fitted_.distance) && as("Yaw", fitted_.yaw) && as("Pitch", fitted_.pitch);
}

bool Camera::eventFilter(QObject* receiver, QEvent* event) {
  if (event->type() == QEvent::Resize && view_ < kFitted && stands()) fit();
  return QComboBox::eventFilter(receiver, event);
}

}  // namespace haptic
