/// Parameters of a node: the one place that reads them, for all wrappers. Whatever is wrong is a SetupError, one line with
/// the parameter's full name, what it is, and what to give; nothing falls back in silence because its type is wrong.
#pragma once
#include <ros/node_handle.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/realtime.h"

namespace haptic {

/// Reads the parameters of a node, and refuses what is out of bounds.
class ParameterReader {
 public:
  explicit ParameterReader(const ros::NodeHandle& nh) : nh_(nh) {}  ///< reads below the namespace of `nh`

  /// A number within bounds, in `unit`; roscpp reads integers as doubles too.
  double number(const std::string& key, double fallback, double low, double high, const char* unit) const {
    std::ostringstream bounds;
    bounds << "give " << low << " to " << high << " " << unit;
    const double value = typed(key, fallback, "is not a number", bounds.str());
    if (value >= low && value <= high) return value;
    std::ostringstream is;
    is << "is " << value;
    throw SetupError(nh_.resolveName(key), is.str(), bounds.str());
  }

  /// A whole number within bounds, in `unit`.
  int whole(const std::string& key, int fallback, int low, int high, const char* unit) const {
    const double value = number(key, fallback, low, high, unit);
    if (value == std::floor(value)) return static_cast<int>(value);
    std::ostringstream is;
    is << "is " << value;
    throw SetupError(nh_.resolveName(key), is.str(), "give a whole number");
  }

  /// True or false.
  bool flag(const std::string& key, bool fallback) const {
    return typed(key, fallback, "is neither true nor false", "give one of: true, false");
  }

  /// A string, which may be empty.
  std::string text(const std::string& key, const std::string& fallback) const {
    return typed(key, fallback, "is no text", "give it in quotes, or as type str");
  }

  /// One of `choices`.
  std::string word(const std::string& key, const std::string& fallback, const std::vector<std::string>& choices) const {
    std::string known;
    for (const std::string& choice : choices) known += (known.empty() ? "" : ", ") + choice;
    const std::string value = typed(key, fallback, "is no word", "give one of, in quotes: " + known);
    if (std::find(choices.begin(), choices.end(), value) != choices.end()) return value;
    throw SetupError(nh_.resolveName(key), "is '" + value + "'", "give one of: " + known);
  }

  /// A list, empty where nothing is set; `remedy` says in errors what to give.
  template <class T>
  std::vector<T> list(const std::string& key, const std::string& remedy) const {
    return typed(key, std::vector<T>(), "is no such list", remedy);
  }

  /// ~priority, ~cpu, ~lock_memory.
  RealtimeSettings realtime(int priority) const {
    RealtimeSettings settings;
    settings.priority = whole("priority", priority, 0, 98, "(SCHED_FIFO; 0: none)");
    settings.cpu = whole("cpu", -1, -1, 1023, "(core; -1: any)");
    settings.lock_memory = flag("lock_memory", true);
    return settings;
  }

 private:
  template <class T>
  T typed(const std::string& key, T value, const char* problem, const std::string& remedy) const {
    if (nh_.hasParam(key) && !nh_.getParam(key, value)) throw SetupError(nh_.resolveName(key), problem, remedy);
    return value;
  }
  ros::NodeHandle nh_;
};

}  // namespace haptic
