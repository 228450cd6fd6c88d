#include "penalty_sim/sensor_topics.h"

#include <geometry_msgs/WrenchStamped.h>
#include <haptic_msgs/conversions.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>

#include "haptic_core/world/world.h"

namespace haptic {
namespace {

/// As of the other topics: 1 s at 1 kHz (world_topics.cpp).
constexpr int kSensorQueue = 1000;

template <class Covariance>
void setVariance(double deviation, Covariance& covariance) {
  for (int k = 0; k < 3; ++k) covariance[4 * k] = deviation * deviation;
}

}  // namespace

SensorTopics::SensorTopics(ros::NodeHandle& nh, WorldPort& port, PortOffer& offer) : port_(port), offer_(offer) {
  SensorSample of_before;  // other bodies, other indices
  while (port.samples.pop(of_before)) continue;
  for (int i = 0; i < port.world.sensorCount(); ++i) {
    const SensorDef& sensor = port.world.sensor(i);
    const std::string topic = "sensors/" + sensor.name;
    sensors_.push_back(sensor);
    publishers_.push_back(sensor.kind == SensorDef::Kind::kImu ? nh.advertise<sensor_msgs::Imu>(topic, kSensorQueue)
                                                               : nh.advertise<geometry_msgs::WrenchStamped>(topic, kSensorQueue));
  }
}

bool SensorTopics::wanted() const {
  return std::any_of(publishers_.begin(), publishers_.end(), [](const ros::Publisher& p) { return p.getNumSubscribers() > 0; });
}

void SensorTopics::publish() {
  const bool wants = wanted();
  if (wants != streams_ && offer_.send(port_, WorldPort::StreamSensors{wants})) streams_ = wants;
  SensorSample sample;
  while (port_.samples.pop(sample)) publish(sample);
}

void SensorTopics::publish(const SensorSample& sample) const {
  const SensorDef& sensor = sensors_[sample.sensor];
  const ros::Publisher& publisher = publishers_[sample.sensor];
  if (publisher.getNumSubscribers() == 0) return;
  const SensorReading& r = sample.reading;
  std_msgs::Header header;
  header.stamp = toStamp(sample.stamp_ns);
  header.frame_id = sensor.frame;
  if (sensor.kind != SensorDef::Kind::kImu) {
    geometry_msgs::WrenchStamped m;
    m.header = header;
    m.wrench = toWrench(r.F_S);
    publisher.publish(m);
    return;
  }
  sensor_msgs::Imu m;
  m.header = header;
  m.orientation = toQuaternion(r.q_WS.toRotationMatrix());
  m.angular_velocity = toVector(r.omega_S);
  m.linear_acceleration = toVector(r.specific_force_S);
  setVariance(sensor.noise_orientation, m.orientation_covariance);
  setVariance(sensor.noise_rate, m.angular_velocity_covariance);
  setVariance(sensor.noise_specific_force, m.linear_acceleration_covariance);
  publisher.publish(m);
}

}  // namespace haptic
