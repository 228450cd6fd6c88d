#include "spidar_driver/device_markers.h"

#include <algorithm>
#include <boost/make_shared.hpp>

#include "spidar_driver/conversions.h"

namespace haptic {
namespace {

using visualization_msgs::Marker;

constexpr double kLineWidth = 0.0015;       // of the frame and the strings [m]
constexpr double kMetresPerNewton = 0.015;  // length of a force's arrow, as in the scene: 10 N reach out of the frame
constexpr double kLeastForce = 0.05;        // an arrow shorter than its head's width is a blot [N]
constexpr double kFullColourTension = 5;    // a string this tense is drawn red [N]; the usual range of a hand

std_msgs::ColorRGBA colour(double r, double g, double b, double a = 1) {
  std_msgs::ColorRGBA c;
  c.r = static_cast<float>(r);
  c.g = static_cast<float>(g);
  c.b = static_cast<float>(b);
  c.a = static_cast<float>(a);
  return c;
}

/// Light blue at rest, through yellow, to red at full tension: each stands out from a dark and from a light background.
std_msgs::ColorRGBA tensionColour(double tension) {
  const double s = std::min(1.0, std::max(0.0, tension / kFullColourTension));
  return s < 0.5 ? colour(0.3 + 1.3 * s, 0.65 + 0.3 * s, 1 - 1.4 * s) : colour(0.95, 1.5 - 1.4 * s, 0.55 - 0.5 * s);
}

}  // namespace

DeviceMarkers::DeviceMarkers(ros::NodeHandle& nh, const DeviceDef& def, const std::string& base_frame)
    : def_(def),
      base_frame_(base_frame),
      publisher_(nh.advertise<visualization_msgs::MarkerArray>("markers", 1)) {}

Marker DeviceMarkers::marker(const char* ns, int type, const ros::Time& stamp) const {
  Marker m;
  m.header.frame_id = base_frame_;
  m.header.stamp = stamp;
  m.ns = ns;
  m.type = type;
  m.pose.orientation.w = 1;
  m.scale.x = m.scale.y = m.scale.z = kLineWidth;
  m.color = colour(0.6, 0.6, 0.6);
  return m;
}

void DeviceMarkers::addFrame(visualization_msgs::MarkerArray& array, const ros::Time& stamp) const {
  Vector3 low = Vector3::Constant(1e9), high = -low;
  Marker exits = marker("frame", Marker::SPHERE_LIST, stamp);
  exits.id = 1;
  exits.scale.x = exits.scale.y = exits.scale.z = 4 * kLineWidth;
  for (const StringDef& s : def_.strings) {
    low = low.cwiseMin(s.p_BE);
    high = high.cwiseMax(s.p_BE);
    exits.points.push_back(toPoint(s.p_BE));
  }
  Marker box = marker("frame", Marker::LINE_LIST, stamp);
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      if (corner & (1 << axis)) continue;
      Vector3 a, b;
      for (int i = 0; i < 3; ++i) a[i] = (corner & (1 << i)) ? high[i] : low[i];
      b = a;
      b[axis] = high[axis];
      box.points.push_back(toPoint(a));
      box.points.push_back(toPoint(b));
    }
  }
  array.markers.push_back(box);
  array.markers.push_back(exits);
}

void DeviceMarkers::addStrings(visualization_msgs::MarkerArray& array, const DeviceRecord& record,
                               const ros::Time& stamp) const {
  Marker strings = marker("strings", Marker::LINE_LIST, stamp);
  for (std::size_t i = 0; i < def_.strings.size(); ++i) {
    const StringDef& s = def_.strings[i];
    strings.points.push_back(toPoint(s.p_BE));
    strings.points.push_back(toPoint(record.X_BG * Vector3(s.p_GK + s.dp_GK * record.opening)));
    strings.colors.insert(strings.colors.end(), 2, tensionColour(record.tension[static_cast<int>(i)]));
  }
  array.markers.push_back(strings);
}

void DeviceMarkers::addGrip(visualization_msgs::MarkerArray& array, const DeviceRecord& record,
                            const ros::Time& stamp) const {
  Marker grip = marker("grip", Marker::SPHERE, stamp);
  grip.pose = toPose(record.X_BG);
  grip.scale.x = grip.scale.y = grip.scale.z = 2 * def_.grip_radius;
  grip.color = record.state == DeviceState::kEnabled ? colour(0.9, 0.7, 0.2, 0.3) : colour(0.6, 0.6, 0.6, 0.3);
  array.markers.push_back(grip);
  Marker knots = marker("grip", Marker::SPHERE_LIST, stamp);
  knots.id = 1;
  knots.pose = grip.pose;
  knots.scale.x = knots.scale.y = knots.scale.z = 3 * kLineWidth;
  knots.color = colour(0.35, 0.37, 0.4);
  for (const StringDef& s : def_.strings) knots.points.push_back(toPoint(s.p_GK + s.dp_GK * record.opening));
  array.markers.push_back(knots);
}

void DeviceMarkers::addForces(visualization_msgs::MarkerArray& array, const DeviceRecord& record,
                              const ros::Time& stamp) const {
  const auto arrow = [&](const char* ns, const Vector3& force, double width, const std_msgs::ColorRGBA& c) {
    Marker m = marker(ns, Marker::ARROW, stamp);
    if (force.norm() < kLeastForce) m.action = Marker::DELETE;
    m.points = {toPoint(record.X_BG.p), toPoint(record.X_BG.p + kMetresPerNewton * force)};
    m.scale.x = width;
    m.scale.y = 2 * width;
    m.scale.z = 0;
    m.color = c;
    array.markers.push_back(m);
  };
  arrow("force", record.F_achieved_B.force, 2 * kLineWidth, colour(0.95, 0.25, 0.2));
  arrow("force_asked", record.F_asked_B.force, 4 * kLineWidth, colour(0.5, 0.52, 0.55, 0.4));  // a shell around the other
}

void DeviceMarkers::publish(const DeviceRecord& record, const ros::Time& stamp) {
  const auto array = boost::make_shared<visualization_msgs::MarkerArray>();
  addFrame(*array, stamp);
  if (record.calibrated && record.X_BG.p.allFinite() && record.X_BG.R.allFinite()) {  // rviz aborts on NaN
    addStrings(*array, record, stamp);
    addGrip(*array, record, stamp);
    addForces(*array, record, stamp);
  }
  publisher_.publish(boost::shared_ptr<const visualization_msgs::MarkerArray>(array));
}

}  // namespace haptic
