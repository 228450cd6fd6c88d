#include "haptic_bridge/bridge_nodelet.h"

#include <pluginlib/class_list_macros.hpp>

#include "haptic_core/base/build_info.h"
#include "haptic_core/base/error.h"

namespace haptic {

void BridgeNodelet::onInit() {
  try {
    NODELET_INFO_STREAM("core: " << programVersion() << ", " << buildFlags());
    const BridgeParameters parameters = readBridgeParameters(getPrivateNodeHandle());
    loop_ = std::make_unique<RealtimeThread>(parameters);
    telemetry_ = std::make_unique<Telemetry>(getNodeHandle(), getPrivateNodeHandle(), getName(), parameters, *loop_);
    services_ = std::make_unique<LoopServices>(getPrivateNodeHandle(), getName(), parameters, *loop_);
    limits_ = std::make_unique<HandLimits>(getNodeHandle(), parameters.world_frame, *loop_, [this] { services_->reapply(); });
    bases_ = std::make_unique<DeviceBases>(getNodeHandle(), getName(), parameters.world_frame, *loop_);
  } catch (const SetupError& error) {
    NODELET_FATAL_STREAM(error.what());
    throw;  // the manager drops the nodelet, and who loaded it fails
  }
}

BridgeNodelet::~BridgeNodelet() {
  bases_.reset();
  limits_.reset();
  services_.reset();
  if (loop_) loop_->stop();
  telemetry_.reset();
}

}  // namespace haptic

PLUGINLIB_EXPORT_CLASS(haptic::BridgeNodelet, nodelet::Nodelet)
