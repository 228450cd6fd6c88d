/// The scene as rviz shows it: bodies, contact patches, contact forces.
#pragma once
#include <ros/node_handle.h>
#include <visualization_msgs/MarkerArray.h>

#include <string>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "scene/scene_file.h"

namespace haptic {

/// Topic `markers`. Bodies are sent once per new subscriber in the frames of their links and follow tf by
/// themselves; patches, forces and a text of the energies are sent with every frame, at most kMaxPatches of them, the strongest first.
class SceneMarkers {
 public:
  SceneMarkers(ros::NodeHandle& nh, const SceneDef& scene, const std::string& world_frame);
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  void publish(const WorldSnapshot& snapshot, const ros::Time& stamp);

  static constexpr int kMaxPatches = 64;  ///< more arrows than this nobody can read, and rviz slows down

 private:
  void addBodies(visualization_msgs::MarkerArray& array) const;
  void addText(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot, const ros::Time& stamp) const;
  void addContacts(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot, const ros::Time& stamp);

  std::vector<VisualDef> visuals_;
  std::vector<std::string> frames_;  ///< of each visual's link
  std::string world_frame_;
  ros::Publisher publisher_;
  std::uint32_t bodies_sent_to_ = 0;
  int patches_shown_ = 0;
};

}  // namespace haptic
