/// The figures of a run: what the loop did, how long it took, how true it was. Definitions: one per line below.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptic_bridge/tick_sample.h"
#include "haptic_core/spidar/tension_distribution.h"

namespace haptic {

/// Value at share `p` of `values` (nearest rank); NaN when empty. Reorders `values`.
double percentile(std::vector<float>& values, double p);

/// Times of some ticks [µs].
struct TickTimes {
  std::vector<float> tick, io, lateness;
  void reserve(std::size_t ticks);
  void add(const TickSample& sample);
  void clear();
};

class RunFigures {
 public:
  /// Storage for `ticks` ticks is taken at once, so that a long run's memory does not grow.
  explicit RunFigures(std::uint64_t ticks);

  void add(const TickSample& sample);
  /// The devices of the samples that follow, in their order. Allocates when they are others than before.
  void setDevices(const std::vector<DeviceDef>& devices);
  void setNodeletsTogether(bool together) { nodelets_together_ = together; }

  /// Lines `figure demo.NAME VALUE UNIT`; last, where there are some, `not measured: NAME... : REASON`.
  std::string text();

  std::uint64_t ticks() const { return ticks_; }
  std::uint64_t missed() const { return missed_; }

 private:
  /// Tells what the tensions' bounds alone admit, for one device.
  struct Exact {
    explicit Exact(const DeviceDef& def);
    bool presents(const HandSample& hand);
    std::string name;
    StringKinematics kinematics;
    TensionDistribution distribution;
  };
  /// Sums of squares of what the strings of a twin did beyond the wrench asked, and of that wrench, over some ticks.
  struct WrenchError {
    double force_error2 = 0, force2 = 0, torque_error2 = 0, torque2 = 0;
    std::uint64_t ticks = 0;
    void add(const Wrench& done, const Wrench& asked);
    double force() const, torque() const;  ///< [%]; NaN where none was asked
  };
  /// The wrench asked in the last tick, which the strings carry out during this one.
  struct Asked {
    Wrench F_B;
    bool known = false, presentable = false;
  };
  void addHand(const HandSample& hand, Exact* exact, bool settled, Asked& asked);
  void addPoseError(const HandSample& hand);
  void addEnergy(const EnergyLedger& energy);

  TickTimes times_;
  std::vector<std::unique_ptr<Exact>> exact_;
  std::uint64_t ticks_ = 0, missed_ = 0, clamps_exceeded_ = 0;
  double position_error_ = std::nan(""), rotation_error_ = std::nan("");  // largest inside the stated range [m], [rad]
  WrenchError all_, inside_;                            // after the first second: all ticks, and those that can be presented
  std::array<Asked, kMaxHands> asked_;
  std::int64_t first_ns_ = 0;                           // start of the first tick
  double contact_force_ = 0;                            // largest on a pointer [N]
  bool energy_known_ = false;
  double first_energy_ = 0, first_potential_ = 0, exchanged_ = 0, gain_ = 0;
  bool nodelets_together_ = false;
  bool simulated_ = false;  ///< a device told its truth
};

}  // namespace haptic
