#include "spidar_driver/authority/commanders.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "haptic_core/base/error.h"
#include "spidar_driver/authority/addresses.h"

namespace haptic {
namespace {

constexpr std::size_t kLongestFile = 65536;  // [byte] a thousand addresses; a longer file is another one

/// Text of a file that only root and this user may write; the open file is judged, not its name. Empty: there is none.
std::string readGuarded(const std::string& path, bool must_exist) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) {
    if (errno == ENOENT && !must_exist) return {};
    throw SetupError(path, std::string("cannot be read: ") + std::strerror(errno), "name a file with one address a line");
  }
  struct stat status {};
  const bool known = ::fstat(file, &status) == 0;
  const bool guarded = known && S_ISREG(status.st_mode) && (status.st_uid == 0 || status.st_uid == ::geteuid()) &&
                       (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
  std::string text(kLongestFile + 1, '\0');
  const ssize_t size = guarded ? ::read(file, text.data(), text.size()) : 0;
  ::close(file);
  if (!guarded) {
    throw SetupError(path, "others than root and this user may write it",
                     "chown root and chmod go-w a plain file: it says who may move motors");
  }
  if (size < 0 || static_cast<std::size_t>(size) > kLongestFile) throw SetupError(path, "is too long", "one address a line");
  text.resize(static_cast<std::size_t>(size));
  return text;
}

}  // namespace

Commanders Commanders::ofMachine() {
  const char* named = std::getenv(kVariable);
  const std::string path = named ? named : kFile;
  std::istringstream lines(readGuarded(path, named != nullptr));
  std::vector<std::string> allowed;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string address, more;
    if (!(words >> address)) continue;
    if (!isAddress(address) || words >> more) {
      throw SetupError(path + ":" + std::to_string(number), "'" + line + "' is no address", "give one number a line, as 192.168.1.20");
    }
    allowed.push_back(address);
  }
  return Commanders(std::move(allowed));
}

bool Commanders::allows(const std::string& address) const {
  return std::find(allowed_.begin(), allowed_.end(), address) != allowed_.end() || isOwnAddress(address);
}

std::string Commanders::allowedAmong(const std::vector<std::string>& addresses) const {
  for (const std::string& address : addresses) {
    if (allows(address)) return address;
  }
  return {};
}

std::string Commanders::refusal(const std::string& who, const std::string& address) {
  const std::string where = address.empty() ? " at an unknown address" : " at " + address + ", another machine";
  const char* named = std::getenv(kVariable);
  return who + where + ": write its address into " + (named ? named : kFile) + " and start again if it may move motors";
}

}  // namespace haptic
