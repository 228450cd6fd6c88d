#include "haptic_bridge/loop_parameters.h"

#include <ros/console.h>

#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

using Config = haptic_bridge::LoopConfig;

dynamic_reconfigure::Config messageOf(const Config& config) {
  dynamic_reconfigure::Config message;
  config.__toMessage__(message);
  return message;
}

/// Refuses entries of a kind (doubles, ints) that are unknown or out of bounds.
template <class Entries>
void checkBounds(const Entries& asked, const Entries& least, const Entries& most) {
  for (const auto& entry : asked) {
    std::size_t i = 0;
    while (i < least.size() && least[i].name != entry.name) ++i;
    if (i == least.size()) throw SetupError(entry.name, "is no parameter of this kind", "see cfg/Loop.cfg");
    if (entry.value >= least[i].value && entry.value <= most[i].value) continue;
    std::ostringstream is, bounds;
    is << "is " << entry.value;
    bounds << "give " << least[i].value << " to " << most[i].value;
    throw SetupError(entry.name, is.str(), bounds.str());
  }
}

}  // namespace

LoopParameters::LoopParameters(ros::NodeHandle& priv, const std::string& name, const Config& start, Apply apply)
    : priv_(priv),
      name_(name),
      apply_(std::move(apply)),
      applied_(start),
      descriptions_(priv.advertise<dynamic_reconfigure::ConfigDescription>("parameter_descriptions", 1, true)),
      updates_(priv.advertise<dynamic_reconfigure::Config>("parameter_updates", 1, true)) {
  descriptions_.publish(Config::__getDescriptionMessage__());
  publish();
  set_ = priv.advertiseService("set_parameters", &LoopParameters::onSet, this);
}

LoopParameters::~LoopParameters() { set_.shutdown(); }

void LoopParameters::publish() {
  applied_.__toServer__(priv_);
  updates_.publish(messageOf(applied_));
}

bool LoopParameters::onSet(dynamic_reconfigure::Reconfigure::Request& request, dynamic_reconfigure::Reconfigure::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    const dynamic_reconfigure::ConfigDescription& known = Config::__getDescriptionMessage__();
    checkBounds(request.config.doubles, known.min.doubles, known.max.doubles);
    checkBounds(request.config.ints, known.min.ints, known.max.ints);
    Config wanted = applied_;
    wanted.__fromMessage__(request.config);
    change(wanted);
  } catch (const SetupError& error) {
    ROS_ERROR_STREAM_NAMED(name_, "parameters refused: " << error.what());
  }
  publish();
  response.config = messageOf(applied_);
  return true;
}

void LoopParameters::change(const Config& wanted) {
  try {
    if (!apply_(wanted)) throw SetupError("parameters", "the loop does not tick", "nothing has changed");
    applied_ = wanted;
  } catch (const SetupError&) {
    apply_(applied_);  // what came before the refused value may have been changed: put all of it back
    throw;
  }
}

void LoopParameters::reapply() {
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    apply_(applied_);
  } catch (const SetupError& error) {
    ROS_ERROR_STREAM_NAMED(name_, "parameters do not fit the new scene: " << error.what());
  }
}

}  // namespace haptic
