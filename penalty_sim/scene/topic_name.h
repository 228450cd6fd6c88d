/// Names that files give to topics of ROS.
#pragma once
#include <string>

namespace haptic {

/// Begins with a letter or /, and has only letters, digits, _ and /: roscpp throws in the node for any other.
inline bool isTopicName(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto other = [](char c) { return (c >= '0' && c <= '9') || c == '_' || c == '/'; };
  if (name.empty() || !(letter(name[0]) || name[0] == '/')) return false;
  for (const char c : name) {
    if (!letter(c) && !other(c)) return false;
  }
  return true;
}

/// What to write in place of another name.
inline constexpr char kTopicNameRemedy[] = "begin with a letter or /, and use letters, digits, _ and /";

}  // namespace haptic
