#include "spidar_driver/device_topics.h"

#include <boost/make_shared.hpp>

#include "haptic_core/loop/realtime.h"

namespace haptic {
namespace {

constexpr std::int64_t kSecondNs = 1000000000;
// With nobody listening to the fast topics the thread wakes as often as tf and state need it.
constexpr std::chrono::milliseconds kFastWake{1}, kSlowWake{15};


/// True once per period of `rate`; keeps its phase, and starts anew after a gap.
bool due(std::int64_t now, double rate, std::int64_t& next) {
  if (now < next) return false;
  const auto period = static_cast<std::int64_t>(kSecondNs / rate);
  next = now - next > period ? now + period : next + period;
  return true;
}

/// Messages that may wait for a subscriber that is kept from its core: 1 s at 1 kHz. With 10 a recorder on a busy machine lost some
/// thousands an hour.
constexpr int kQueue = 1000;

template <class Message>
void publishConst(const ros::Publisher& publisher, const boost::shared_ptr<Message>& message) {
  publisher.publish(boost::shared_ptr<const Message>(message));  // const: subscribers in this process share it
}

}  // namespace

DeviceTopics::DeviceTopics(ros::NodeHandle& nh, const DriverParameters& parameters, DevicePort& port,
                           CompleteState complete, SeeRecord see)
    : parameters_(parameters),
      port_(port),
      def_(port.device.def()),
      complete_(std::move(complete)),
      see_(std::move(see)),
      base_frame_(parameters.name + "_base"),
      grip_frame_(parameters.name + "_grip"),
      pose_(nh.advertise<geometry_msgs::PoseStamped>("pose", kQueue)),
      twist_(nh.advertise<geometry_msgs::TwistStamped>("twist", kQueue)),
      wrench_(nh.advertise<geometry_msgs::WrenchStamped>("wrench", kQueue)),
      joint_states_(nh.advertise<sensor_msgs::JointState>("joint_states", kQueue)),
      joy_(nh.advertise<sensor_msgs::Joy>("joy", kQueue)),
      state_(nh.advertise<haptic_msgs::DeviceState>("state", 1, true)),
      diagnostics_(nh, parameters.name, port.transport),
      markers_(nh, port.device.def(), base_frame_) {
  if (parameters.place_base) {
    geometry_msgs::TransformStamped base;
    base.header.frame_id = parameters.world_frame;
    base.header.stamp = ros::Time::now();
    base.child_frame_id = base_frame_;
    base.transform.rotation.w = 1;
    static_broadcaster_.sendTransform(base);
  }
  publishState(last_);
  thread_ = std::thread([this] { run(); });
}

DeviceTopics::~DeviceTopics() {
  stop_ = true;
  thread_.join();
}

bool DeviceTopics::motionWanted() const {
  return pose_.getNumSubscribers() + twist_.getNumSubscribers() + wrench_.getNumSubscribers() > 0;
}

void DeviceTopics::run() {
  while (!stop_) {
    DeviceRecord record;
    while (port_.records.pop(record)) handle(record);
    const std::int64_t now = steadyNow();
    if (now >= next_state_ns_) {
      next_state_ns_ = now + kSecondNs;
      publishState(last_);
      diagnostics_.publish(last_, standing(last_, def_.name), advice(last_, def_.name).empty());
    }
    std::this_thread::sleep_for(motionWanted() ? kFastWake : kSlowWake);
  }
}

void DeviceTopics::handle(const DeviceRecord& record) {
  see_(record);
  if (!bringsCounts(record.sample.status)) ++lost_exchanges_;
  constexpr unsigned kTold = kForceWaits | kUnguarded | kStopped | kReleased | kLinkLost | kDelayTooLong | kAnswersLost;
  const bool changed = record.state != last_.state || record.cause != last_.cause ||
                       record.link_lost != last_.link_lost || (record.flags & kTold) != (last_.flags & kTold);
  last_ = record;
  if (changed) publishState(record);
  if (record.sample.buttons != last_buttons_) publishJoy(record);
  // A pose has the stamp of its counts; without new ones there is no new pose.
  if (!record.pose_valid || !record.pose_new || !finite(record.X_BG)) return;
  std_msgs::Header header;
  header.frame_id = base_frame_;
  const bool motion = due(record.stamp_ns, parameters_.pose_rate, next_pose_ns_) && motionWanted();
  const bool joints =
      due(record.stamp_ns, parameters_.joint_state_rate, next_joints_ns_) && joint_states_.getNumSubscribers() > 0;
  if (motion || joints) header.stamp = toStamp(record.latched_ns);
  if (motion) publishMotion(record, header);
  if (joints) publishJointStates(record, header);
  if (due(record.stamp_ns, parameters_.frame_rate, next_frames_ns_)) publishFrames(record);
}

void DeviceTopics::publishMotion(const DeviceRecord& record, const std_msgs::Header& header) {
  if (pose_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<geometry_msgs::PoseStamped>();
    m->header = header;
    m->pose = toPose(record.X_BG);
    publishConst(pose_, m);
  }
  if (twist_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<geometry_msgs::TwistStamped>();
    m->header = header;
    m->twist = toTwist(record.V_BG);
    publishConst(twist_, m);
  }
  if (wrench_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<geometry_msgs::WrenchStamped>();
    m->header = header;
    m->wrench = toWrench(record.F_achieved_B);
    publishConst(wrench_, m);
  }
}

void DeviceTopics::publishJointStates(const DeviceRecord& record, const std_msgs::Header& header) {
  const auto m = boost::make_shared<sensor_msgs::JointState>();
  m->header = header;
  const double dt = 1e-9 * static_cast<double>(record.latched_ns - last_joints_ns_);
  for (int i = 0; i < static_cast<int>(record.length.size()); ++i) {
    m->name.push_back("string_" + std::to_string(i));
    m->position.push_back(record.length[i]);
    const bool known = last_length_.size() == record.length.size() && dt > 0;
    m->velocity.push_back(known ? (record.length[i] - last_length_[i]) / dt : 0.0);
    m->effort.push_back(record.tension[i]);
  }
  if (def_.dof == 7) {
    m->name.push_back("opening");
    m->position.push_back(record.opening);
    m->velocity.push_back(record.opening_rate);
    m->effort.push_back(record.grasp_force);
  }
  last_length_ = record.length;
  last_joints_ns_ = record.latched_ns;
  publishConst(joint_states_, m);
}

void DeviceTopics::publishFrames(const DeviceRecord& record) {
  geometry_msgs::TransformStamped grip;
  grip.header.frame_id = base_frame_;
  grip.header.stamp = toStamp(record.latched_ns);
  grip.child_frame_id = grip_frame_;
  grip.transform = toTransform(record.X_BG);
  broadcaster_.sendTransform(grip);
  if (markers_.wanted()) markers_.publish(record, grip.header.stamp);
}

void DeviceTopics::publishJoy(const DeviceRecord& record) {
  const auto m = boost::make_shared<sensor_msgs::Joy>();
  m->header.stamp = toStamp(record.stamp_ns);
  m->header.frame_id = grip_frame_;
  constexpr int kButtons = 8;  // the boards' four grip buttons and the rotary switch's four bits
  for (int i = 0; i < kButtons; ++i) m->buttons.push_back((record.sample.buttons >> i) & 1u);
  last_buttons_ = record.sample.buttons;
  publishConst(joy_, m);
}

void DeviceTopics::publishState(const DeviceRecord& record) {
  const auto m = boost::make_shared<haptic_msgs::DeviceState>(toState(record, def_));
  m->header.frame_id = base_frame_;
  m->header.stamp = ros::Time::now();
  m->lost_exchanges = lost_exchanges_;
  m->dead_man = !port_.dead_man.used ? m->NO_SWITCH : record.held ? m->SWITCH_HELD : m->SWITCH_RELEASED;
  complete_(*m, advice(record, def_.name).empty());
  publishConst(state_, m);
}

}  // namespace haptic
