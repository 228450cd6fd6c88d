/// What the first picture of a scene shows: the bodies that the hand may touch, large enough, and nothing before the hand.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "haptic_bridge/panel/camera_fit.h"
#include "scene/resource_path.h"
#include "scene/scene_view.h"

namespace haptic {
namespace scene_view_test {

constexpr double kWidth = 900, kHeight = 780;  // of the picture in a window of rviz that its panel leaves [pixels]
const double kHalfHeight = std::tan(0.7853981852531433 / 2);  // of the field of view of the shipped views

Eigen::Vector2d pixelsOf(const CameraFit& camera, const std::vector<Vector3>& corners) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (const Vector3& corner : corners) low = low.cwiseMin(camera.seen(corner)), high = high.cwiseMax(camera.seen(corner));
  return kHeight / 2 / kHalfHeight * (high - low);
}

TEST(SceneView, LargestBodyInReachIsLarge) {
  double least = 1e9;
  int scenes = 0;
  for (const char* folder : {"", "/large"}) {
    for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTIC_SCENES) + folder)) {
      const std::string kind = entry.path().extension();
      const bool ground = entry.path().stem().string().find("_ground") != std::string::npos;  // a part of another scene
      if ((kind != ".urdf" && kind != ".yaml") || ground) continue;
      SceneDef scene;
      try {
        scene = loadScene(entry.path().string());
      } catch (const std::exception& error) {
        std::printf("%s is not looked at: %s\n", entry.path().stem().c_str(), error.what());
        continue;
      }
      const SceneView view = viewOf(scene);
      if (view.largest.empty()) continue;
      const CameraFit camera = fitCamera(view.hand, view.yaw, kViewPitch, kHalfHeight, kWidth / kHeight);
      for (const Vector3& corner : view.hand) {
        const Eigen::Vector2d at = camera.seen(corner) / kHalfHeight;
        EXPECT_LE(std::fabs(at.x()), kWidth / kHeight) << entry.path().stem();
        EXPECT_LE(std::fabs(at.y()), 1) << entry.path().stem();
      }
      const double side = pixelsOf(camera, view.largest).minCoeff();
      std::printf("%s: %.0f px, yaw %.2f\n", entry.path().stem().c_str(), side, view.yaw);
      EXPECT_GE(side, 120) << entry.path().stem();
      least = std::min(least, side);
      ++scenes;
    }
  }
  EXPECT_GE(scenes, 15);
  std::printf("figure rviz.grip_px_min %.4g px\n", least);
}

}  // namespace scene_view_test
}  // namespace haptic
