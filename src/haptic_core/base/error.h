/// The one exception of the set-up phase. Nothing throws inside a tick.
#pragma once
#include <stdexcept>
#include <string>

namespace haptic {

/// One line for the user: the fault, its place (file, link, tag or parameter), and the remedy.
class SetupError : public std::runtime_error {
 public:
  /// The message is "where: what; remedy", without the last part where `remedy` is empty.
  SetupError(const std::string& where, const std::string& what, const std::string& remedy)
      : std::runtime_error(oneLine(where + ": " + what + (remedy.empty() ? "" : "; " + remedy))) {}

  /// Text of files is quoted in messages: its line breaks and other control characters become spaces.
  static std::string oneLine(std::string text) {
    for (char& c : text) c = static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    return text;
  }
};

}  // namespace haptic
