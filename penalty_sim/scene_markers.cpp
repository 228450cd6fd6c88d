#include "penalty_sim/scene_markers.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <numeric>

#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/conversions.h"

namespace haptic {
namespace {

using visualization_msgs::Marker;

constexpr double kMetresPerNewton = 0.015;    // length of a force's arrow, as for the device
constexpr double kLongestArrow = 0.3;         // [m]
constexpr double kThinnestPatch = 0.0005;     // a disc thinner than this flickers in rviz [m]
constexpr double kRimWidth = 0.0015;          // [m]
constexpr double kRimSize = 1.2;              // times the patch's radius: it stands out of the bodies like a collar
constexpr double kLeastRim = 0.004;           // radius of a ring that can still be seen [m]
constexpr double kCell = 0.05;                // of the grid, at least [m]
constexpr int kCells = 40;                    // of the grid along each axis [1]
constexpr double kDimmed = 0.4, kGrey = 0.45;  // of what stands: share of its own colour, the rest of a grey
constexpr double kFullColourPressure = 2e4;   // a patch under this mean pressure is drawn red [Pa]; 1 N on 0.5 cm²

std_msgs::ColorRGBA colour(double r, double g, double b, double a) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(r);
  c.g = static_cast<float>(g);
  c.b = static_cast<float>(b);
  c.a = static_cast<float>(a);
  return c;
}

/// Blue through yellow to red with the share of kFullColourPressure: each stands out from a dark and from a light ground.
std_msgs::ColorRGBA pressureColour(double share, double alpha) {
  const double s = std::min(1.0, std::max(0.0, share));
  return s < 0.5 ? colour(0.1 + 1.6 * s, 0.4 + 0.7 * s, 1 - 1.8 * s, alpha) : colour(0.9, 1.4 - 1.3 * s, 0.1, alpha);
}

/// A circle around a patch in its own frame: closed while it sticks, dashed while it slides.
void makeRim(double radius, bool sticking, Marker& rim) {
  constexpr int kCorners = 48, kDash = 4;  // corners of a circle; of a dash and of a gap
  rim.type = Marker::LINE_LIST;
  rim.scale.x = kRimWidth;
  rim.scale.y = rim.scale.z = 0;
  rim.color.a = 1;
  const auto corner = [&](int i) {
    const double angle = 2 * M_PI * i / kCorners;
    return toPoint(radius * Vector3(std::cos(angle), std::sin(angle), 0));
  };
  for (int i = 0; i < kCorners; ++i) {
    if (!sticking && (i / kDash) % 2 == 1) continue;
    rim.points.push_back(corner(i));
    rim.points.push_back(corner(i + 1));
  }
}

int shapeType(VisualShape shape) {
  switch (shape) {
    case VisualShape::kBox:
      return Marker::CUBE;
    case VisualShape::kCylinder:
      return Marker::CYLINDER;
    case VisualShape::kSphere:
      return Marker::SPHERE;
    case VisualShape::kMesh:
      return Marker::MESH_RESOURCE;
    case VisualShape::kTriangles:
      return Marker::TRIANGLE_LIST;
  }
  return Marker::CUBE;
}

}  // namespace

SceneMarkers::SceneMarkers(ros::NodeHandle& nh, const SceneDef& scene, const World& world, const std::string& world_frame)
    : visuals_(scene.visuals),
      view_(viewOf(scene)),
      world_frame_(world_frame),
      publisher_(nh.advertise<visualization_msgs::MarkerArray>("markers", 2)) {
  for (const VisualDef& v : visuals_) {
    frames_.push_back(scene.world.articulations[v.articulation].links[v.link].name);
    links_.push_back(world.model().link(v.articulation, v.link));
  }
  dimmed_.resize(visuals_.size());
}

int SceneMarkers::contactCapacity(const World& world) { return 16 + 8 * world.linkCount(); }

visualization_msgs::Marker SceneMarkers::bodyMarker(std::size_t i) const {
  const VisualDef& v = visuals_[i];
  Marker m;
  m.header.frame_id = frames_[i];  // stamp 0 and locked: rviz moves it with the link's frame
  m.frame_locked = true;
  m.ns = "bodies";
  m.id = static_cast<int>(i);
  m.type = shapeType(v.shape);
  m.pose = toPose(v.X_LV);
  m.scale = toVector(v.size);
  for (const Vector3& corner : v.corners) m.points.push_back(toPoint(corner));
  const auto shade = [&](int c) { return dimmed_[i] ? kDimmed * v.colour[c] + (1 - kDimmed) * kGrey : v.colour[c]; };
  m.color = colour(shade(0), shade(1), shade(2), v.colour[3]);
  if (v.shape == VisualShape::kMesh) {
    m.mesh_resource = v.mesh_uri;
    m.mesh_use_embedded_materials = v.own_colours;
    if (v.own_colours) m.color = colour(0, 0, 0, 0);  // rviz: all zero means the file's own colours
  }
  return m;
}

/// All of them, or those that came to stand or do so no more.
void SceneMarkers::addBodies(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot, bool all) {
  if (all) {
    Marker clear;  // of the scene before
    clear.header.frame_id = world_frame_;
    clear.action = Marker::DELETEALL;
    array.markers.push_back(clear);
    array.markers.push_back(gridMarker());
  }
  for (std::size_t i = 0; i < visuals_.size(); ++i) {
    const char stands = snapshot.stands[static_cast<std::size_t>(links_[i])];
    if (!all && stands == dimmed_[i]) continue;
    dimmed_[i] = stands;
    array.markers.push_back(bodyMarker(i));
  }
}

void SceneMarkers::addContacts(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot,
                               const ros::Time& stamp) {
  std::vector<int> order(snapshot.contacts);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return snapshot.contact[a].normal_force > snapshot.contact[b].normal_force;
  });
  int shown = 0;
  for (const int i : order) {
    const ContactReport& c = snapshot.contact[i];
    if (shown == kMaxPatches || !finite(c.X_WP) || !c.F_BP_W.allFinite()) break;
    Marker patch;
    patch.header.frame_id = world_frame_;
    patch.header.stamp = stamp;
    patch.ns = "patches";
    patch.id = shown;
    patch.type = Marker::CYLINDER;
    patch.pose = toPose(c.X_WP);
    patch.scale.x = patch.scale.y = std::max(1e-4, 2 * std::sqrt(c.area / M_PI));  // a disc of the patch's area
    patch.scale.z = std::max(c.depth, kThinnestPatch);
    patch.color = pressureColour(c.area > 0 ? c.normal_force / c.area / kFullColourPressure : 0, 0.85);
    Marker rim = patch;
    rim.ns = "patch_rims";
    makeRim(std::max(kLeastRim, kRimSize * patch.scale.x / 2), c.sticking, rim);
    Marker arrow = patch;
    arrow.ns = "contact_forces";
    arrow.type = Marker::ARROW;
    arrow.pose = geometry_msgs::Pose();
    arrow.pose.orientation.w = 1;
    const double length = std::min(kLongestArrow, kMetresPerNewton * c.F_BP_W.force.norm());
    const Vector3 tip = c.X_WP.p + length * c.F_BP_W.force.normalized();
    arrow.points = {toPoint(c.X_WP.p), toPoint(tip)};
    arrow.scale.x = 0.004;
    arrow.scale.y = 0.009;
    arrow.scale.z = 0;
    arrow.color = colour(0.9, 0.2, 0.2, 1);
    array.markers.push_back(patch);
    array.markers.push_back(rim);
    array.markers.push_back(arrow);
    ++shown;
  }
  for (int id = shown; id < patches_shown_; ++id) {
    for (const char* ns : {"patches", "patch_rims", "contact_forces"}) {
      Marker gone;
      gone.header.frame_id = world_frame_;
      gone.ns = ns;
      gone.id = id;
      gone.action = Marker::DELETE;
      array.markers.push_back(gone);
    }
  }
  patches_shown_ = shown;
}

/// Lines in W's x and y under the bodies: light enough on either ground.
visualization_msgs::Marker SceneMarkers::gridMarker() const {
  Marker grid;
  grid.header.frame_id = world_frame_;
  grid.ns = "grid";
  grid.type = Marker::LINE_LIST;
  grid.pose.orientation.w = 1;
  grid.color = colour(0.5, 0.55, 0.6, 0.5);
  Vector3 low = Vector3::Zero(), high = low;
  const std::vector<Vector3>& content = view_.hand.empty() ? view_.scene : view_.hand;
  if (!content.empty()) low = high = content[0];
  for (const Vector3& p : content) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = std::max(kCell, (high - low).head<2>().maxCoeff());
  const double cell = kCell * std::exp2(std::max(0.0, std::ceil(std::log2(size / (4 * kCell)))));  // the content spans 2 to 4 cells
  grid.scale.x = 0.012 * cell;
  const Vector3 middle = (low + high) / 2;
  const double half = kCells / 2 * cell, x = cell * std::round(middle.x() / cell), y = cell * std::round(middle.y() / cell);
  for (int i = -kCells / 2; i <= kCells / 2; ++i) {
    for (const auto& end : {Vector3(x + i * cell, y - half, view_.ground), Vector3(x + i * cell, y + half, view_.ground),
                            Vector3(x - half, y + i * cell, view_.ground), Vector3(x + half, y + i * cell, view_.ground)}) {
      grid.points.push_back(toPoint(end));
    }
  }
  return grid;
}

void SceneMarkers::publish(const WorldSnapshot& snapshot, const ros::Time& stamp) {
  const auto array = boost::make_shared<visualization_msgs::MarkerArray>();
  const std::uint32_t subscribers = publisher_.getNumSubscribers();
  addBodies(*array, snapshot, subscribers != bodies_sent_to_);
  bodies_sent_to_ = subscribers;
  addContacts(*array, snapshot, stamp);
  publisher_.publish(boost::shared_ptr<const visualization_msgs::MarkerArray>(array));
}

}  // namespace haptic
