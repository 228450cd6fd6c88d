/// How well the running world is computed: the error by step doubling on shadow worlds, time per stage.
#pragma once
#include <haptic_msgs/LiveReport.h>
#include <ros/node_handle.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "haptic_core/analysis/error_estimate.h"

namespace haptic {

/// Topic `live_report`, in a thread of its own, twice a second or as often as a twentieth of a core allows. It is made
/// while somebody subscribes to it; otherwise the loop pays nothing, and no shadow exists before the first
/// time. The world is read through the port: whoever runs it fills a copy between two ticks.
class LiveReport {
 public:
  LiveReport(ros::NodeHandle& nh, const WorldDef& definition, const std::string& world_frame, WorldPort& port,
             PortOffer& offer);
  ~LiveReport();

 private:
  void run();
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  bool takeCopy();
  void report(const WorldCopy& copy);
  void sleep(double seconds);

  WorldDef definition_;
  std::string world_frame_;
  WorldPort& port_;
  PortOffer& offer_;
  WorldCopy copy_;                        ///< with room for the greatest state
  std::int64_t seen_ns_ = 0;              ///< stamp of the last report
  std::vector<std::string> links_;
  std::unique_ptr<ErrorEstimator> estimator_;
  std::uint64_t estimates_ = 0;
  double shadow_time_ = 0;                ///< of the last estimate [s]
  ros::Publisher publisher_;
  std::mutex mutex_;              ///< of what follows
  std::condition_variable woken_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace haptic
