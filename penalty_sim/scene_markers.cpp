#include "penalty_sim/scene_markers.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "haptic_core/world/runaway.h"
#include "penalty_sim/conversions.h"

namespace haptic {
namespace {

using visualization_msgs::Marker;

constexpr double kMetresPerNewton = 0.01;     // length of a force's arrow, as for the device
constexpr double kLongestArrow = 0.3;         // [m]
constexpr double kThinnestPatch = 0.0005;     // a disc thinner than this flickers in rviz [m]
constexpr double kRimWidth = 0.001;           // [m]
constexpr double kTextBelow = 0.19;           // the lowest body [m]: about as far as a device's frame reaches
constexpr double kBodyAlpha = 0.75;           // opacity of bodies, at most: patches between them shine through
constexpr double kFullColourPressure = 2e4;   // a patch under this mean pressure is drawn red [Pa]; 1 N on 0.5 cm²

std_msgs::ColorRGBA colour(double r, double g, double b, double a) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(r);
  c.g = static_cast<float>(g);
  c.b = static_cast<float>(b);
  c.a = static_cast<float>(a);
  return c;
}

/// Blue to red with the mean pressure, greener while it sticks.
std_msgs::ColorRGBA patchColour(const ContactReport& c) {
  const double pressure = c.area > 0 ? c.normal_force / c.area : 0;
  const double s = std::min(1.0, pressure / kFullColourPressure);
  return colour(s, c.sticking ? 0.7 : 0.2, 1 - s, 0.7);
}

/// A circle around a patch in its own frame: green while it sticks, orange while it slides.
void makeRim(double radius, bool sticking, Marker& rim) {
  constexpr int kCorners = 32;
  rim.type = Marker::LINE_STRIP;
  rim.scale.x = kRimWidth;
  rim.scale.y = rim.scale.z = 0;
  rim.color = sticking ? colour(0.2, 0.95, 0.4, 1) : colour(1, 0.55, 0.1, 1);
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners;
    rim.points.push_back(toPoint(radius * Vector3(std::cos(angle), std::sin(angle), 0)));
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
  }
  return Marker::CUBE;
}

}  // namespace

SceneMarkers::SceneMarkers(ros::NodeHandle& nh, const SceneDef& scene, const std::string& world_frame)
    : visuals_(scene.visuals),
      world_frame_(world_frame),
      publisher_(nh.advertise<visualization_msgs::MarkerArray>("markers", 2)) {
  for (const VisualDef& v : visuals_) frames_.push_back(scene.world.articulations[v.articulation].links[v.link].name);
}

void SceneMarkers::addBodies(visualization_msgs::MarkerArray& array) const {
  for (std::size_t i = 0; i < visuals_.size(); ++i) {
    const VisualDef& v = visuals_[i];
    Marker m;
    m.header.frame_id = frames_[i];  // stamp 0 and locked: rviz moves it with the link's frame
    m.frame_locked = true;
    m.ns = "bodies";
    m.id = static_cast<int>(i);
    m.type = shapeType(v.shape);
    m.pose = toPose(v.X_LV);
    m.scale = toVector(v.size);
    m.color = colour(v.colour[0], v.colour[1], v.colour[2], std::min<double>(kBodyAlpha, v.colour[3]));
    if (v.shape == VisualShape::kMesh) {
      m.mesh_resource = v.mesh_uri;
      m.mesh_use_embedded_materials = v.own_colours;
      if (v.own_colours) m.color = colour(0, 0, 0, 0);  // rviz: all zero means the file's own colours
    }
    array.markers.push_back(m);
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
    patch.color = patchColour(c);
    Marker rim = patch;
    rim.ns = "patch_rims";
    makeRim(patch.scale.x / 2, c.sticking, rim);
    Marker arrow = patch;
    arrow.ns = "contact_forces";
    arrow.type = Marker::ARROW;
    arrow.pose = geometry_msgs::Pose();
    arrow.pose.orientation.w = 1;
    const double length = std::min(kLongestArrow, kMetresPerNewton * c.F_BP_W.force.norm());
    const Vector3 tip = c.X_WP.p + length * c.F_BP_W.force.normalized();
    arrow.points = {toPoint(c.X_WP.p), toPoint(tip)};
    arrow.scale.x = 0.003;
    arrow.scale.y = 0.006;
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

/// Where the energy is and went, what sticks and slides, what the pointers feel, and how well it is computed.
void SceneMarkers::addText(visualization_msgs::MarkerArray& array, const WorldSnapshot& snapshot,
                           const ros::Time& stamp, const std::string& report) const {
  int sticking = 0;
  double lowest = 0;
  for (int i = 0; i < snapshot.contacts; ++i) sticking += snapshot.contact[i].sticking;
  for (const Pose& X_WL : snapshot.pose) lowest = std::isfinite(X_WL.p.z()) ? std::min(lowest, X_WL.p.z()) : lowest;
  const EnergyLedger& e = snapshot.report.energy;
  char line[160];
  Marker text;
  text.header.frame_id = world_frame_;
  text.header.stamp = stamp;
  text.ns = "text";
  text.type = Marker::TEXT_VIEW_FACING;
  text.pose.orientation.w = 1;
  text.pose.position.z = lowest - kTextBelow;
  text.scale.z = 0.009;
  text.color = colour(0.85, 0.88, 0.95, 1);
  std::snprintf(line, sizeof line, "kinetic %.2f  elastic %.2f  hand's work %.2f  damped %.2f  rubbed %.2f mJ\n",
                1e3 * e.kinetic, 1e3 * (e.elastic + e.tangential), 1e3 * e.external, 1e3 * e.damping, 1e3 * e.friction);
  text.text = line;
  std::snprintf(line, sizeof line, "balance %.3f mJ  contacts %d, %d stick, %d slide", 1e3 * e.balance(), snapshot.contacts,
                sticking, snapshot.contacts - sticking);
  text.text += line;
  for (const Wrench& F : snapshot.pointer_wrench) {
    std::snprintf(line, sizeof line, "  pointer %.2f N", F.force.norm());
    text.text += line;
  }
  if (!report.empty()) text.text += "\n" + report;
  if (!snapshot.report.finite) text.text += std::string("\nthe world stopped: ") + whyStopped(snapshot.report);
  array.markers.push_back(text);
}

void SceneMarkers::publish(const WorldSnapshot& snapshot, const ros::Time& stamp, const std::string& report) {
  const auto array = boost::make_shared<visualization_msgs::MarkerArray>();
  const std::uint32_t subscribers = publisher_.getNumSubscribers();
  if (subscribers != bodies_sent_to_) addBodies(*array);
  bodies_sent_to_ = subscribers;
  addContacts(*array, snapshot, stamp);
  addText(*array, snapshot, stamp, report);
  publisher_.publish(boost::shared_ptr<const visualization_msgs::MarkerArray>(array));
}

}  // namespace haptic
