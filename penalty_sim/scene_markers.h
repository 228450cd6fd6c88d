/// The scene as rviz shows it: bodies on a grid, contact patches, contact forces.
#pragma once
#include <ros/node_handle.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "scene/scene_file.h"
#include "scene/scene_view.h"

namespace haptic {

/// Topic `markers`. Bodies are sent once per new subscriber in the frames of their links and follow tf by themselves; one that comes to
/// stand, or stands no more, is sent again: dimmed, or in its own colour.
/// Patches and forces, at most kMaxPatches of them, the strongest first, are sent with every frame; a grid once, with the bodies.
class SceneMarkers {
 public:
  SceneMarkers(ros::NodeHandle& nh, const SceneDef& scene, const World& world, const std::string& world_frame);
  /// Contacts that a snapshot can show: pairs of neighbours in a heap; what lies beyond is simulated, not drawn.
  static int contactCapacity(const World& world);
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  void publish(const WorldSnapshot& snapshot, const ros::Time& stamp);

  static constexpr int kMaxPatches = 64;  ///< more arrows than this nobody can read, and rviz slows down

 private:
  void addBodies(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot, bool all);
  visualization_msgs::Marker bodyMarker(std::size_t visual) const;
  visualization_msgs::Marker gridMarker() const;
  void addContacts(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot, const ros::Time& stamp);

  std::vector<VisualDef> visuals_;
  SceneView view_;
  std::vector<std::string> frames_;  ///< of each visual's link
  std::vector<int> links_;           ///< of the world, of each visual
  std::vector<char> dimmed_;         ///< by visual: as it was sent
  std::string world_frame_;
  ros::Publisher publisher_;
  std::uint32_t bodies_sent_to_ = 0;
  int patches_shown_ = 0;
};

}  // namespace haptic
