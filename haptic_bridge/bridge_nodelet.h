/// The bridge: claims devices and a world, and closes the loop between them in a real-time thread.
#pragma once
#include <nodelet/nodelet.h>

#include <memory>

#include "haptic_bridge/device_bases.h"
#include "haptic_bridge/hand_limits.h"
#include "haptic_bridge/loop_services.h"
#include "haptic_bridge/realtime_thread.h"
#include "haptic_bridge/telemetry.h"

namespace haptic {

class BridgeNodelet : public nodelet::Nodelet {
 public:
  ~BridgeNodelet() override;

 private:
  void onInit() override;

  std::unique_ptr<RealtimeThread> loop_;
  std::unique_ptr<Telemetry> telemetry_;
  std::unique_ptr<LoopServices> services_;
  std::unique_ptr<HandLimits> limits_;
  std::unique_ptr<DeviceBases> bases_;
};

}  // namespace haptic
