#include "haptic_bridge/hand_limits.h"

#include <haptic_msgs/HandLimits.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>

#include "haptic_core/analysis/hand_certificate.h"

namespace haptic {
namespace {

constexpr std::chrono::milliseconds kPoll{100};  // a user who changes the scene does not notice a tenth of a second

}  // namespace

HandLimits::HandLimits(ros::NodeHandle& nh, const std::string& world_frame, RealtimeThread& loop,
                       std::function<void()> restarted)
    : world_frame_(world_frame),
      loop_(loop),
      restarted_(std::move(restarted)),
      publisher_(nh.advertise<haptic_msgs::HandLimits>("hand_limits", 1, true)),
      thread_([this] { run(); }) {}

HandLimits::~HandLimits() {
  stop_ = true;
  thread_.join();
}

void HandLimits::run() {
  unsigned started = 0, judged = 0;
  for (; !stop_; std::this_thread::sleep_for(kPoll)) {
    const unsigned sessions = loop_.sessions(), changes = loop_.changes();
    if ((sessions == started && changes == judged) || loop_.phase() != RealtimeThread::Phase::kTicking) continue;
    const bool restarted = sessions != started && sessions > 1;
    started = sessions, judged = changes;
    if (restarted) restarted_();
    publish(loop_.felt());
  }
}

void HandLimits::publish(const RealtimeThread::Felt& felt) {
  if (!felt.definition) return;
  haptic_msgs::HandLimits m;
  m.header.frame_id = world_frame_;
  m.header.stamp = ros::Time::now();
  for (std::size_t i = 0; i < felt.devices.size() && !stop_; ++i) {
    const HandPlacement& hand = felt.placements[i];
    const DeviceDef& device = felt.devices[i];
    HandCertificate certificate;
    try {
      const HandMapping mapping{hand.settings.workspace.scale, hand.settings.force_scale, hand.settings.delay.total()};
      certificate = certifyHand(*felt.definition, hand.pointer, mapping, device);
    } catch (const std::exception& error) {
      ROS_WARN_STREAM("hand_limits: none for " << hand.device << ": " << error.what());
      continue;
    }
    const std::string text = certificate.text();
    if (certificate.changes() && text != said_[hand.device]) ROS_INFO_STREAM(text.substr(0, text.find('\n')));
    if (certificate.changes()) said_[hand.device] = text;
    const bool touches = !certificate.against.empty() && certificate.foundation > 0;
    m.devices.push_back(hand.device);
    m.stiffness_scale.push_back(touches ? certificate.bearable / certificate.foundation : std::numeric_limits<double>::infinity());
    m.wall.push_back(certificate.held);
    m.max_force.push_back(device.max_force);
    m.text.push_back(text);
  }
  publisher_.publish(m);
}

}  // namespace haptic
