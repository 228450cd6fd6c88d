/// Faults of every kind, one at a time, into a device that is in use.
#pragma once
#include <random>
#include <string>
#include <vector>

#include "fault_rig.h"
#include "fault_tally.h"

namespace haptic::bench {

/// One kind: the order that does it, drawn with `random`, and the one that undoes it.
struct FaultKind {
  const char* name;
  std::string (*order)(std::mt19937& random, const FaultRig& rig);
  const char* undo = "";     ///< first word of the order; the target is that of the fault's
  int patience = 300;        ///< ticks for which the device is watched
  bool misread = false;      ///< the boards may take in other currents than the driver sent
  bool inside = false;       ///< anywhere in a cycle on its way to the boards, not at its first byte
};

const std::vector<FaultKind>& faultKinds();

class FaultCampaign {
 public:
  FaultCampaign(FaultRig& rig, unsigned seed) : rig_(rig), random_(seed) {}
  FaultTally inject(const FaultKind& kind);

 private:
  FaultRig& rig_;
  std::mt19937 random_;
};

/// A wave that asks much of hand and strings: up to 1 m/s and 10 m/s², changed at random every 0.3 to 1 s.
HandPath hardUse(unsigned seed, double seconds);
/// The command of a simulation that rubs and knocks.
Wrench hardCommand(double time);

}  // namespace haptic::bench
