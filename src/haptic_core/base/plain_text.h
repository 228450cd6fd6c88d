/// Texts of users and files as messages, JSON, ROS and Python can carry them.
#pragma once
#include <string>

namespace haptic {

/// Valid UTF-8. A byte that belongs to no character is read as Latin-1, which old files are mostly in. Line
/// breaks stay where they are.
std::string validUtf8(const std::string& text);

/// Valid UTF-8 in one line: control characters and line separators, Unicode's included, become spaces.
std::string plainText(const std::string& text);

}  // namespace haptic
