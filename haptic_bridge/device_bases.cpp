#include "haptic_bridge/device_bases.h"

#include <haptic_msgs/conversions.h>
#include <ros/console.h>
#include <ros/this_node.h>

#include <cmath>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

const ros::WallDuration kPeriod(0.02);      // a base that moves at last is followed at once
// A base that is carried about is followed ten times a second. Each time the pointer's glide begins anew: more often it hardly gets on.
const ros::WallDuration kBetweenMoves(0.1);
const ros::WallDuration kListenFirst(0.5);  // what others have latched arrives within this time
// As tf2_ros. A process has one outbox per topic, as long as its first publisher asked for: with room for one message a
// late listener would get what only one of the publishers of /tf_static has latched.
constexpr int kQueue = 100;
// Below this a base stands still: tf's own rounding, and the noise of a tracker, must not fill recordings with events.
constexpr double kStill = 1e-5;            // [m] and [rad]

bool moved(const Pose& a, const Pose& b) {
  const Pose X = relativePose(a, b);
  return X.p.norm() > kStill || vectorFromRotation(Quaternion(X.R)).norm() > kStill;
}

std::string frameOf(const std::string& device) { return device + "_base"; }

}  // namespace

DeviceBases::DeviceBases(ros::NodeHandle& nh, const std::string& name, const std::string& world_frame, RealtimeThread& loop)
    : name_(name),
      world_frame_(world_frame),
      loop_(loop),
      frames_(nh, false),
      listening_since_(ros::SteadyTime::now()),
      publisher_(nh.advertise<tf2_msgs::TFMessage>("/tf_static", kQueue, true)) {
  timer_ = nh.createSteadyTimer(kPeriod, [this](const ros::SteadyTimerEvent&) { update(); });
}

DeviceBases::~DeviceBases() { timer_.stop(); }

/// The hands of the session that ticks now. False: none does.
bool DeviceBases::meetHands() {
  if (loop_.phase() != RealtimeThread::Phase::kTicking) return false;
  if (session_ == loop_.sessions() && bases_.size() == loop_.deviceNames().size()) return true;
  const unsigned session = loop_.sessions();
  LoopSession::View view;
  if (!loop_.send(LoopSession::Look{&view})) return false;
  bases_.clear();
  for (const auto& hand : view.hands) bases_.push_back({hand.name, hand.defined.workspace.X_WB, hand.settings.workspace.X_WB, {}});
  session_ = session;
  return true;
}

void DeviceBases::update() {
  if (!meetHands() || ros::SteadyTime::now() - listening_since_ < kListenFirst) return;
  for (Base& base : bases_) {
    const Pose X_WB = wanted(base);
    if (ros::SteadyTime::now() - base.since >= kBetweenMoves && moved(base.X_WB, X_WB)) apply(base, X_WB);
  }
  publishOthers();
}

Pose DeviceBases::wanted(const Base& base) {
  const std::string frame = frameOf(base.device);
  const auto parent = frames_.placedIn(frame);
  if (!parent) return base.scene;
  const std::string line = silences_[base.device].look(frames_, world_frame_, frame);
  if (!line.empty()) ROS_WARN_STREAM_NAMED(name_, "place of " << frame << ": " << line);
  std::string problem;
  if (const auto place = frames_.find(world_frame_, frame, &problem)) return place->X_WF;
  if (!carried_) {
    carried_ = true;  // its parent may be a link that moves
    frames_.hearOwnMotion();
  } else if (told_[frame] != *parent) {
    told_[frame] = *parent;
    ROS_WARN_STREAM_NAMED(name_, frame << " is placed in " << *parent << ", but not in " << world_frame_ << ": " << problem
                                       << "; it stays where it was");
  }
  return base.X_WB;
}

void DeviceBases::apply(Base& base, const Pose& X_WB) {
  try {
    const bool ran = loop_.change([&](const LoopSession::View& view) {
      std::vector<LoopCommand> commands;
      for (std::size_t i = 0; i < view.hands.size(); ++i) {
        if (view.hands[i].name != base.device) continue;
        commands.push_back({ChangeHand{view.hands[i].settings}, static_cast<int>(i)});
        std::get<ChangeHand>(commands.back().kind).settings.workspace.X_WB = X_WB;
      }
      return commands;
    });
    if (ran) base.X_WB = X_WB, base.since = ros::SteadyTime::now();
  } catch (const SetupError& error) {
    ROS_WARN_STREAM_NAMED(name_, error.what());
  }
}

void DeviceBases::publishOthers() {
  tf2_msgs::TFMessage message;
  std::vector<std::string> frames;
  for (const Base& base : bases_) {
    if (frames_.placedIn(frameOf(base.device))) continue;
    frames.push_back(frameOf(base.device));
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = world_frame_;
    transform.header.stamp = ros::Time::now();
    transform.child_frame_id = frames.back();
    transform.transform = toTransform(base.scene);
    message.transforms.push_back(transform);
  }
  if (frames == published_) return;
  published_ = frames;
  publisher_.publish(message);
}

}  // namespace haptic
