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

  /// Messages quote texts of files. Their control characters become spaces, bytes that are no UTF-8 are read
  /// as Latin-1, and the middle of more than `kLongest` bytes is left out: where it is and the remedy stay.
  static std::string oneLine(const std::string& text);

  /// A list of all meshes that a robot misses fits; a text of megabytes would fill logs and screens [bytes].
  static constexpr std::size_t kLongest = 16384;
};

}  // namespace haptic
