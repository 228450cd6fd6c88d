/// Frames of tf as this process hears them, by its own steady clock. For those who link tf2.
///
/// tf2 keeps what it hears by the stamps and takes the newest stamp for the newest word: where stamps go back, by a system's clock that
/// is set or a bag that begins anew, it holds to the old word until they have caught up. Here each frame has a SenderClock, and the
/// buffer below gets own times; the rest (chains, interpolation to a common time) is tf2's.
#pragma once
#include <geometry_msgs/TransformStamped.h>
#include <haptic_msgs/conversions.h>
#include <ros/node_handle.h>
#include <ros/this_node.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptic_core/base/sender_clock.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {

/// What others say of a frame wins over what this process says. Runs in the callbacks of one queue, which come one at a time.
class HeardFrames {
 public:
  /// Where a frame is, and since when that is known.
  struct Place {
    Pose X_WF;             ///< of the frame
    std::int64_t at = 0;   ///< when it was measured, by the own clock; of static frames: when it was heard that they changed [ns]
  };

  /// `own_motion`: whether frames on /tf that this process itself publishes count from the start.
  HeardFrames(ros::NodeHandle& nh, bool own_motion) : own_motion_(own_motion) {
    const auto listen = [&](const char* topic, bool is_static) {
      const boost::function<void(const Event&)> callback = [this, is_static](const Event& event) { hear(event, is_static); };
      return nh.subscribe<tf2_msgs::TFMessage, const Event&>(topic, kQueue, callback, ros::VoidConstPtr(),
                                                             ros::TransportHints().tcpNoDelay());
    };
    moving_ = listen("/tf", false);
    static_ = listen("/tf_static", true);
  }

  /// From now on frames on /tf that this process itself publishes count too.
  void hearOwnMotion() { own_motion_ = true; }
  /// The frame that another process places `frame` in; none: nobody does.
  std::optional<std::string> placedIn(const std::string& frame) const {
    const auto sender = senders_.find(frame);
    if (sender == senders_.end() || sender->second.own) return std::nullopt;
    return sender->second.parent;
  }
  /// The newest word on where `frame` is in `world`; none: `problem` says why.
  std::optional<Place> find(const std::string& world, const std::string& frame, std::string* problem) const {
    if (!buffer_.canTransform(world, plain(frame), ros::Time(0), problem)) return std::nullopt;
    const geometry_msgs::TransformStamped found = buffer_.lookupTransform(world, plain(frame), ros::Time(0));
    Place place{fromTransform(found.transform), static_cast<std::int64_t>(found.header.stamp.toNSec())};
    const bool all_static = place.at == 0;
    for (const auto& sender : between(world, plain(frame))) {
      if (all_static || sender->second.is_static) place.at = std::max(place.at, sender->second.at);
    }
    if (finite(place.X_WF)) return place;
    *problem = "it is not finite";
    return std::nullopt;
  }

 private:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;
  /// Who says where a frame is.
  struct Sender {
    std::string parent;
    bool own = false, is_static = false;
    SenderClock clock;
    std::int64_t at = 0, heard = 0;       ///< the last measurement, and when something was heard last [ns]
    geometry_msgs::Transform transform;   ///< of static frames
  };
  using Senders = std::map<std::string, Sender>;  ///< by child frame
  friend class SilenceWatch;

  /// As tf2_ros. A process has one outbox per topic, as long as its first publisher asked for.
  static constexpr std::uint32_t kQueue = 100;

  /// Old nodes write frames with a leading slash.
  static std::string plain(const std::string& frame) { return frame.substr(!frame.empty() && frame[0] == '/' ? 1 : 0); }

  void hear(const Event& event, bool is_static) {
    const bool own = event.getPublisherName() == ros::this_node::getName();
    if (own && !is_static && !own_motion_) return;
    const std::int64_t now = steadyNow();
    for (geometry_msgs::TransformStamped told : event.getConstMessage()->transforms) {
      const std::string child = plain(told.child_frame_id), parent = plain(told.header.frame_id);
      Sender& sender = senders_.try_emplace(child).first->second;
      const bool is_new = sender.heard == 0;
      if (own && !is_new && !sender.own) continue;
      if (own != sender.own) sender = Sender{};  // another clock
      sender.heard = now;
      // Who adds a static frame latches all of its others again: what did not change is no news.
      const bool same = sender.is_static && sender.parent == parent && sender.transform == told.transform;
      if (is_static && sender.at != 0 && same) continue;
      const std::int64_t at = is_static ? now : sender.clock.own(static_cast<std::int64_t>(told.header.stamp.toNSec()), now);
      if (at == sender.at) continue;  // the same measurement again
      sender.parent = parent, sender.own = own, sender.is_static = is_static, sender.at = at, sender.transform = told.transform;
      told.header.stamp.fromNSec(static_cast<std::uint64_t>(at));
      buffer_.setTransform(told, event.getPublisherName(), is_static);
    }
  }

  /// `frame` and what it hangs on, without the last: the root of its tree.
  std::vector<Senders::const_iterator> upFrom(std::string frame) const {
    std::vector<Senders::const_iterator> up;
    for (auto sender = senders_.find(frame); sender != senders_.end() && up.size() <= senders_.size();
         sender = senders_.find(sender->second.parent)) {
      up.push_back(sender);
    }
    return up;
  }

  /// All whose word decides where `frame` is in `world`.
  std::vector<Senders::const_iterator> between(const std::string& world, const std::string& frame) const {
    std::vector<Senders::const_iterator> way = upFrom(frame), other = upFrom(world);
    while (!way.empty() && !other.empty() && way.back() == other.back()) way.pop_back(), other.pop_back();
    way.insert(way.end(), other.begin(), other.end());
    return way;
  }

  bool own_motion_;
  tf2::BufferCore buffer_;
  Senders senders_;
  ros::Subscriber moving_, static_;
};

/// Notices when a frame that moves is no longer told, once each time; at most one line in kSpoken, for a sender that is always so slow.
class SilenceWatch {
 public:
  /// Looks at where `frame` is in `world`: the line to say now; empty: nothing is new.
  std::string look(const HeardFrames& frames, const std::string& world, const std::string& frame) {
    const std::int64_t now = steadyNow();
    const std::string* silent = nullptr;
    std::int64_t longest = kSilence;
    for (const auto& sender : frames.between(world, HeardFrames::plain(frame))) {
      if (sender->second.is_static || sender->second.own || now - sender->second.heard <= longest) continue;
      silent = &sender->first;
      longest = now - sender->second.heard;
    }
    const bool was_silent = silent_;
    silent_ = silent != nullptr;
    if (silent_ == was_silent) return "";
    if (!silent_) return std::exchange(said_, false) ? "its frame is told again" : "";
    if (spoke_ != 0 && now - spoke_ < kSpoken) return "";
    spoke_ = now, said_ = true;
    char line[64];
    std::snprintf(line, sizeof line, "has been silent for %.2f s", 1e-9 * static_cast<double>(longest));
    return "frame " + *silent + " " + line;
  }

 private:
  /// A frame that was not told for so long is silent [ns]. Longer: with the period of who looks (0.02 s at most) and a busy machine it
  /// would be said later than half a second after the last word. Shorter: frames of 5 Hz would be called silent.
  static constexpr std::int64_t kSilence = 300'000'000;
  static constexpr std::int64_t kSpoken = 10'000'000'000;  ///< between two lines on one frame [ns]; less floods the log

  bool silent_ = false, said_ = false;
  std::int64_t spoke_ = 0;
};

}  // namespace haptic
