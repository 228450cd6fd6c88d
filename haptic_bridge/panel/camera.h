/// The views: the hand and what it may touch, the whole scene, and those that the configuration keeps.
#pragma once
#include <haptic_msgs/ScenePlan.h>

#include <QComboBox>
#include <vector>

#include "haptic_bridge/panel/camera_fit.h"

namespace rviz {
class ViewController;
class VisualizationManager;
}  // namespace rviz

namespace haptic {

/// The first two are fitted to the loaded scene and to the window, until somebody moves the camera.
class Camera : public QComboBox {
 public:
  explicit Camera(QWidget* parent);
  void attach(rviz::VisualizationManager& manager);
  void see(const haptic_msgs::ScenePlan& plan);

  bool eventFilter(QObject* receiver, QEvent* event) override;

 private:
  void choose(int view);
  void fit();
  bool stands() const;  ///< the camera is where `fit` has put it

  rviz::VisualizationManager* manager_ = nullptr;
  int view_ = 0;
  std::vector<Vector3> hand_, scene_;  ///< corners that the first two views hold, in W [m]
  double yaw_ = 0;
  CameraFit fitted_;
};

}  // namespace haptic
