#include "haptic_bridge/device_bases.h"

#include <haptic_msgs/conversions.h>
#include <ros/console.h>
#include <ros/this_node.h>

#include <cmath>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

const ros::WallDuration kPeriod(0.1);      // a base that is carried about is followed ten times a second
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

/// Old nodes write frames with a leading slash.
std::string plain(const std::string& frame) { return frame.substr(!frame.empty() && frame[0] == '/' ? 1 : 0); }

}  // namespace

DeviceBases::DeviceBases(ros::NodeHandle& nh, const std::string& name, const std::string& world_frame, RealtimeThread& loop)
    : name_(name),
      world_frame_(world_frame),
      loop_(loop),
      listening_since_(ros::WallTime::now()),
      publisher_(nh.advertise<tf2_msgs::TFMessage>("/tf_static", kQueue, true)) {
  const auto listen = [&](const char* topic, bool is_static) {
    const boost::function<void(const Event&)> callback = [this, is_static](const Event& event) { receive(event, is_static); };
    return nh.subscribe<tf2_msgs::TFMessage, const Event&>(topic, kQueue, callback);
  };
  moving_ = listen("/tf", false);
  static_ = listen("/tf_static", true);
  timer_ = nh.createWallTimer(kPeriod, [this](const ros::WallTimerEvent&) { update(); });
}

DeviceBases::~DeviceBases() {
  timer_.stop();
  moving_.shutdown();
  static_.shutdown();
}

/// Links of the scene may carry a device, so what this process says counts too, except of what others place; moving links
/// only once a base hangs on something that others do not tell.
void DeviceBases::receive(const Event& event, bool is_static) {
  const bool own = event.getPublisherName() == ros::this_node::getName();
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const std::string child = plain(transform.child_frame_id);
    if (own && (placed_.count(child) > 0 || (!is_static && !carried_))) continue;
    if (!own) placed_[child] = plain(transform.header.frame_id);
    buffer_.setTransform(transform, event.getPublisherName(), is_static);
  }
}

/// The hands of the session that ticks now. False: none does.
bool DeviceBases::meetHands() {
  if (loop_.phase() != RealtimeThread::Phase::kTicking) return false;
  if (session_ == loop_.sessions() && bases_.size() == loop_.deviceNames().size()) return true;
  const unsigned session = loop_.sessions();
  LoopSession::View view;
  if (!loop_.send(LoopSession::Look{&view})) return false;
  bases_.clear();
  for (const auto& hand : view.hands) bases_.push_back({hand.name, hand.defined.workspace.X_WB, hand.settings.workspace.X_WB});
  session_ = session;
  return true;
}

void DeviceBases::update() {
  if (!meetHands() || ros::WallTime::now() - listening_since_ < kListenFirst) return;
  for (Base& base : bases_) {
    const Pose X_WB = wanted(base);
    if (moved(base.X_WB, X_WB)) apply(base, X_WB);
  }
  publishOthers();
}

Pose DeviceBases::wanted(const Base& base) {
  const auto placed = placed_.find(frameOf(base.device));
  if (placed == placed_.end()) return base.scene;
  std::string problem;
  if (buffer_.canTransform(world_frame_, placed->first, ros::Time(0), &problem)) {
    const Pose X_WB = fromTransform(buffer_.lookupTransform(world_frame_, placed->first, ros::Time(0)).transform);
    if (finite(X_WB)) return X_WB;
    problem = "it is not finite";
  }
  if (!carried_) {
    carried_ = true;  // its parent may be a link that moves
  } else if (told_[placed->first] != placed->second) {
    told_[placed->first] = placed->second;
    ROS_WARN_STREAM_NAMED(name_, placed->first << " is placed in " << placed->second << ", but not in " << world_frame_ << ": "
                                               << problem << "; it stays where it was");
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
    if (ran) base.X_WB = X_WB;
  } catch (const SetupError& error) {
    ROS_WARN_STREAM_NAMED(name_, error.what());
  }
}

void DeviceBases::publishOthers() {
  tf2_msgs::TFMessage message;
  std::vector<std::string> frames;
  for (const Base& base : bases_) {
    if (placed_.count(frameOf(base.device)) > 0) continue;
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
