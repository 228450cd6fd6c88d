#include "penalty_sim/world_topics.h"

#include <haptic_msgs/ScenePlan.h>
#include <sensor_msgs/JointState.h>

#include <boost/make_shared.hpp>
#include <cmath>

#include "haptic_core/analysis/certificate.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/conversions.h"
#include "scene/resource_path.h"

namespace haptic {
namespace {

template <class Message>
void publishConst(const ros::Publisher& publisher, const boost::shared_ptr<Message>& message) {
  publisher.publish(boost::shared_ptr<const Message>(message));  // const: subscribers in this process share it
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, const Pose& X,
                                          const ros::Time& stamp) {
  geometry_msgs::TransformStamped m;
  m.header.frame_id = parent;
  m.header.stamp = stamp;
  m.child_frame_id = child;
  m.transform = toTransform(X);
  return m;
}

/// Messages that may wait for a subscriber that is kept from its core, as of the device's topics (spidar_driver/device_topics.cpp): 1 s at
/// 1 kHz. With 2 a recorder on a busy machine lost some twenty an hour.
constexpr int kQueue = 1000;

bool allFixedAbove(const ArticulationDef& articulation, int link) {
  for (int i = link; i >= 0; i = articulation.links[i].parent) {
    if (articulation.links[i].joint.type != JointType::kFixed) return false;
  }
  return true;
}

}  // namespace

WorldTopics::WorldTopics(ros::NodeHandle& nh, const SimulationParameters& parameters, const SceneDef& scene,
                         WorldPort& port, PortOffer& offer)
    : parameters_(parameters),
      port_(port),
      offer_(offer),
      fixed_(port.world.linkCount(), false),
      step_(port.world.settings().step),
      contacts_(nh.advertise<haptic_msgs::Contacts>("contacts", kQueue)),
      step_report_(nh.advertise<haptic_msgs::StepReport>("step_report", kQueue)),
      joint_states_(nh.advertise<sensor_msgs::JointState>("joint_states", kQueue)),
      model_(nh.advertise<haptic_msgs::ScenePlan>("scene_plan", 1, true)),
      outline_(port.world.model()),
      sensors_(nh, port, offer),
      markers_(nh, scene, port.world, parameters.world_frame),
      live_(nh, scene.world, parameters.world_frame, port, offer) {
  for (int i = 0; i < port.world.linkCount(); ++i) links_.push_back(port.world.linkName(i));
  for (int i = 0; i < port.world.jointCount(); ++i) joints_.push_back(port.world.jointName(i));
  publishStatic(scene);
  definition_ = scene.world;
  publishPlan(scene);
  thread_ = std::thread([this] { run(); });
  // Bodies that came stand where others started: what is certified is the scene as it was loaded.
  if (port.bodiesChanged() == 0) certifier_ = std::thread([this] { publishCertificate(); });
}

WorldTopics::~WorldTopics() {
  stop();
  if (certifier_.joinable()) certifier_.join();
}

void WorldTopics::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void WorldTopics::publishStatic(const SceneDef& scene) {
  std::vector<geometry_msgs::TransformStamped> frames;
  const ros::Time now = ros::Time::now();
  for (const ArticulationDef& articulation : scene.world.articulations) {
    const std::vector<Pose> X_WL = initialPoses(articulation);
    for (std::size_t l = 0; l < articulation.links.size(); ++l) {
      const LinkDef& link = articulation.links[l];
      const int index = port_.world.linkIndex(link.name);
      if (index >= 0 && allFixedAbove(articulation, static_cast<int>(l))) {
        fixed_[index] = true;
        frames.push_back(transform(parameters_.world_frame, link.name, X_WL[l], now));
      }
      for (const MergedLink& merged : link.merged) {
        frames.push_back(transform(link.name, merged.name, merged.X_LM, now));
      }
    }
  }
  for (const SensorDef& sensor : scene.world.sensors) {
    if (sensor.frame != sensor.name) continue;  // it is measured in the frame of a link
    const std::string& link = scene.world.articulations[sensor.articulation].links[sensor.link].name;
    frames.push_back(transform(link, sensor.frame, sensor.X_LS, now));
  }
  for (const HandDef& hand : scene.hands) {
    if (!parameters_.alone) break;  // a bridge will say where they stand
    frames.push_back(transform(parameters_.world_frame, hand.device + "_base", hand.workspace.X_WB, now));
  }
  // A link that bears the world frame's own name would be its own parent.
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [](const auto& f) { return f.header.frame_id == f.child_frame_id; }),
               frames.end());
  static_broadcaster_.sendTransform(frames);
}

void WorldTopics::publishPlan(const SceneDef& scene) {
  const auto m = boost::make_shared<haptic_msgs::ScenePlan>();
  m->header.frame_id = parameters_.world_frame;
  m->header.stamp = ros::Time::now();
  m->scene = scene.world.name;
  m->file = scene.file;
  m->step_size = step_;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (!fixed_[i]) m->links.push_back(links_[i]);
  }
  for (int i = 0; i < port_.world.pointerCount(); ++i) m->pointers.push_back(links_[port_.world.pointerLink(i)]);
  m->known_scenes = knownScenes();
  const SceneView view = viewOf(scene);
  for (const Vector3& corner : view.hand) m->hand_view.push_back(toPoint(corner));
  for (const Vector3& corner : view.scene) m->scene_view.push_back(toPoint(corner));
  m->view_yaw = view.yaw;
  m->warnings = scene.replaced;
  m->warnings.insert(m->warnings.end(), scene.warnings.begin(), scene.warnings.end());
  m->text = sceneText(scene) + port_.world.planText();
  if (port_.bodiesChanged() > 0) m->text += "certificate: none, bodies have come or gone since the scene was loaded\n";
  plan_message_ = *m;
  publishConst(model_, m);
}

/// Where the scene is stable, added to the plan as soon as it is known: a second of simulated settling, in a
/// thread of its own.
void WorldTopics::publishCertificate() {
  try {
    plan_message_.text += certify(definition_, 1, [this] { return !stop_; }).text();
  } catch (const std::exception& error) {
    plan_message_.text += std::string("certificate: none, ") + error.what() + "\n";
  }
  if (!stop_) publishConst(model_, boost::make_shared<haptic_msgs::ScenePlan>(plan_message_));
}

void WorldTopics::run() {
  WorldSnapshot snapshot = port_.first_snapshot;
  auto next = std::chrono::steady_clock::now();
  for (int since_frame = 0; !stop_;) {
    const bool wants_joints = !joints_.empty() && joint_states_.getNumSubscribers() > 0;
    const bool often = wants_joints || sensors_.wanted();
    const double rate = often ? std::max(parameters_.joint_rate, parameters_.frame_rate) : parameters_.frame_rate;
    const std::int64_t seen_ns = snapshot.stamp_ns;
    if (offer_.send(port_, WorldPort::Look{&snapshot}) && snapshot.stamp_ns > seen_ns) {
      if (wants_joints) publishJoints(snapshot);
      if (++since_frame >= std::lround(rate / parameters_.frame_rate)) {
        publish(snapshot);
        since_frame = 0;
      }
    }
    sensors_.publish();
    // Not after the runner's answer: it takes up to a tick.
    next = std::max(next + std::chrono::nanoseconds(std::llround(1e9 / rate)), std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
}

void WorldTopics::publishJoints(const WorldSnapshot& snapshot) {
  const auto m = boost::make_shared<sensor_msgs::JointState>();
  m->header.stamp = toStamp(snapshot.stamp_ns);
  m->name = joints_;
  for (const JointReading& joint : snapshot.joint) {
    m->position.push_back(joint.position);
    m->velocity.push_back(joint.velocity);
    m->effort.push_back(joint.effort);
  }
  publishConst(joint_states_, m);
}

void WorldTopics::publish(const WorldSnapshot& snapshot) {
  const ros::Time stamp = toStamp(snapshot.stamp_ns);
  publishFrames(snapshot, stamp);
  std_msgs::Header header;
  header.frame_id = parameters_.world_frame;
  header.stamp = stamp;
  if (contacts_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<haptic_msgs::Contacts>(toContacts(snapshot, links_, outline_));
    m->header = header;
    publishConst(contacts_, m);
  }
  if (step_report_.getNumSubscribers() > 0) {
    const auto m = boost::make_shared<haptic_msgs::StepReport>(toStepReport(snapshot, links_, step_));
    m->header = header;
    publishConst(step_report_, m);
  }
  if (markers_.wanted()) markers_.publish(snapshot, stamp);
}

void WorldTopics::publishFrames(const WorldSnapshot& snapshot, const ros::Time& stamp) {
  std::vector<geometry_msgs::TransformStamped> frames;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (fixed_[i] || !finite(snapshot.pose[i])) continue;  // rviz aborts on NaN
    frames.push_back(transform(parameters_.world_frame, links_[i], snapshot.pose[i], stamp));
  }
  if (!frames.empty()) broadcaster_.sendTransform(frames);
}

}  // namespace haptic
