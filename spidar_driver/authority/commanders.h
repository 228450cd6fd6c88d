/// Which machines may move motors: this one, and those that a file of this machine names.
///
/// The file is /etc/haptics/allowed_addresses, or the one that the environment variable HAPTICS_ALLOWED_ADDRESSES names: one
/// numeric address a line, `#` begins a comment. It is read once in the life of a process. It must belong to root or to the
/// user of the process, and nobody else may write it: the parameter server is open to everyone who reaches it, this is not.
#pragma once
#include <string>
#include <vector>

namespace haptic {

/// Addresses that may command.
class Commanders {
 public:
  static constexpr char kFile[] = "/etc/haptics/allowed_addresses";
  static constexpr char kVariable[] = "HAPTICS_ALLOWED_ADDRESSES";

  /// Reads the machine's file; without one, this machine alone may command. Throws SetupError with file and line.
  static Commanders ofMachine();
  /// This machine and `allowed` (numeric).
  explicit Commanders(std::vector<std::string> allowed) : allowed_(std::move(allowed)) {}

  /// `address` (numeric) is this machine's or allowed. Empty, hence unknown: no.
  bool allows(const std::string& address) const;
  /// The one of a host's addresses that may command, numeric: a later look-up of the name could answer otherwise. Empty: none may.
  std::string allowedAmong(const std::vector<std::string>& addresses) const;
  /// Says who was refused, and what to do.
  static std::string refusal(const std::string& who, const std::string& address);

 private:
  std::vector<std::string> allowed_;
};

}  // namespace haptic
