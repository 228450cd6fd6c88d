/// The ports that the bridge holds, and the loop between them, from claim to release.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_bridge/bridge_parameters.h"
#include "haptic_bridge/tick_sample.h"
#include "haptic_core/loop/ports.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {

class DeviceTwin;

class LoopSession {
 public:
  /// Claims the world and its devices. Empty, with `missing` telling what is not there yet, when one of them cannot
  /// be had now. Throws SetupError when they do not fit together (rates, pointers).
  static std::unique_ptr<LoopSession> open(const BridgeParameters& parameters, std::string& missing);
  ~LoopSession();  ///< zero drive, and the ports back to their owners

  /// (in realtime) One tick: exchange, loop, records.
  void tick(const PeriodicWake::Wake& wake, std::uint64_t index, double h, TickSample& sample) noexcept;

  bool recalled() const noexcept;                      ///< (in realtime) the world, or the last device, must go back
  bool dropsDevice() const noexcept;                   ///< (in realtime) one of several devices must go back
  void dropRecalledDevices();                          ///< between ticks: goes on with the others
  const TickReport& report() const { return loop_->report(); }
  std::vector<std::string> deviceNames() const;
  std::vector<std::string> pointerNames() const;
  std::string worldName() const { return world_name_; }

 private:
  struct Hand {
    PortLease<DevicePort> lease;
    std::string name;
    HandPlacement placement;
    DeviceTwin* twin = nullptr;                        ///< when the device is simulated: its truth is known
    std::unique_ptr<TensionDistribution> exact;        ///< λ → 0: tells what the bounds alone admit
  };
  LoopSession(const BridgeParameters& parameters, PortLease<WorldPort> world, std::string world_name);
  static bool claimDevices(const BridgeParameters& parameters, LoopSession& session, std::string& missing);
  void connect();
  void exchange(std::int64_t& io_ns, std::int64_t& twin_ns) noexcept;
  void rest(double h) noexcept;
  void observe(Hand& hand, HandSample& sample) const noexcept;

  BridgeParameters parameters_;
  PortLease<WorldPort> world_;
  std::string world_name_;
  std::vector<Hand> hands_;
  std::unique_ptr<HapticLoop> loop_;
  std::array<DeviceSample, kMaxHands> samples_;
  unsigned seen_jumps_ = 0;
  bool was_paused_ = false;
};

}  // namespace haptic
