/// Simulators that are measured side by side: ours and all settings of the peers.
#pragma once
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "haptic_core/base/cpu_time.h"
#include "run_case.h"

namespace haptic::bench {

/// A simulator under its name in the table.
struct Rival {
  std::string name;
  report::Method method;
  bool ours() const { return !method.peer; }
  /// A process of its own: its times are not comparable.
  bool wasm() const { return method.peer && method.peer->peer == peers::Peer::kMujocoWasm; }
};

/// Ours with the stiffness that a scene says, ours rigid, then the peers' table.
inline std::vector<Rival> rivals() {
  std::vector<Rival> all(2);
  all[0].name = "ours", all[1].name = "ours_rigid";
  for (Rival& each : all) each.method.choice.attempts = WorldSettings{}.attempts;
  all[1].method.choice.rigid = true;
  for (const peers::NamedPeer& peer : peers::peerTable()) {
    all.push_back({peer.name, {}});
    all.back().method.peer = peer.settings;
  }
  return all;
}

inline double infinite() { return std::numeric_limits<double>::infinity(); }

/// In one line, why a setting has no row: it is not installed, it cannot take the scene, or its process ended.
inline void tellRefusal(const char* group, const Rival& rival, const std::string& reason) {
  std::printf("peers %s %-20s refused: %s\n", group, rival.name.c_str(), reason.c_str());
}

}  // namespace haptic::bench
