/// Every parameter of the bridge, in one place.
#pragma once
#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {

struct BridgeParameters {
  double rate = 1000;                 ///< ~rate [Hz]
  double seconds = 0;                 ///< ~seconds [s]: execute exactly seconds · rate ticks, then shut down; 0: run on
  std::string figures;                ///< ~figures: file for the figures of a run of ~seconds; empty: none
  std::string world;                  ///< ~world: name of the world's port; empty: the one there is
  std::vector<std::string> devices;   ///< ~devices: names of ports; empty: those that the scene's hands name
  double port_timeout = 0;            ///< ~port_timeout [s]: give up when a port does not appear; 0: wait
  double deadline_share = 0;          ///< ~deadline_share: of a tick, that a step of the world may take (analysis/deadline.h); 0: no budget
  double soft_start = 0.5;            ///< ~soft_start [s]: the force fades in over this time
  bool silent = false;                ///< ~silent as it was set last: the next scene begins without a force
  PassivityMode passivity = PassivityMode::kObserve;  ///< ~passivity: off, observe or act
  int clutch_button = -1;             ///< ~clutch_button: grip button that holds the pointer while pressed; -1: none
  int grab_button = -1;               ///< ~grab_button: grip button that grabs the body in touch and lets it go
  bool record = false;                ///< ~record: publish recorded/*; the first tick waits for who records them
  std::string flight_folder;          ///< ~flight_folder: where the last seconds before a fault are kept; empty: nowhere
  std::string world_frame;            ///< ~world_frame
  RealtimeSettings realtime;          ///< ~priority, ~cpu, ~lock_memory

  bool keepsTicks() const { return record || !flight_folder.empty(); }
  std::uint64_t tickLimit() const { return static_cast<std::uint64_t>(seconds * rate + 0.5); }
};

/// Throws SetupError naming parameter, unit and bounds.
BridgeParameters readBridgeParameters(const ros::NodeHandle& priv);

}  // namespace haptic
