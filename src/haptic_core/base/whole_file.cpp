#include "haptic_core/base/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// All of it is on the disk. Leaves the reason in errno when it is not.
bool writeAll(int file, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t size = ::write(file, text.data() + done, text.size() - done);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    done += static_cast<std::size_t>(size);
  }
  return ::fsync(file) == 0 || errno == EINVAL;  // EINVAL: a kind of file that has no disk
}

}  // namespace

void writeWholeFile(const std::string& path, const std::string& text) {
  // A link stays a link. Devices and pipes are written as they are: no file can take their place.
  char* real = ::realpath(path.c_str(), nullptr);
  const std::string target = real ? real : path;
  std::free(real);
  struct stat status {};
  const bool replaced = ::stat(target.c_str(), &status) != 0 || S_ISREG(status.st_mode);
  const std::string written_to = replaced ? target + "." + std::to_string(::getpid()) + ".new" : target;
  const int file = ::open(written_to.c_str(), O_WRONLY | O_CLOEXEC | (replaced ? O_CREAT | O_TRUNC : 0), 0644);
  int reason = file < 0 || !writeAll(file, text) ? errno : 0;
  if (file >= 0 && ::close(file) != 0 && reason == 0) reason = errno;
  if (reason == 0 && replaced && std::rename(written_to.c_str(), target.c_str()) != 0) reason = errno;
  if (reason == 0) return;
  if (file >= 0 && replaced) ::unlink(written_to.c_str());
  throw SetupError(path, std::string("cannot be written: ") + std::strerror(reason),
                   "give a path in a folder that is writable and has room");
}

}  // namespace haptic
