#include "replay/bag_reader.h"

#include <fcntl.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// What the reader may take, for a bag of `size` bytes. Chunks are compressed by a tenth at most, and one is in memory at a time with the
/// index; 20 MB are read in a second on a busy machine. Less: long recordings are refused. More: a wrong length takes the machine's memory.
constexpr rlim_t kMemory = rlim_t{1} << 31, kMemoryOfByte = 16;  // [byte]
constexpr rlim_t kSeconds = 4, kBytesInSecond = 20 << 20;

/// Before each piece on the way from the reader.
struct Head {
  enum : std::uint32_t { kEnd = 1u << 31, kRefused };  // of `what`; other values: the kind of a message
  std::uint32_t what = 0, size = 0;
};

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

void writeAll(int to, const void* bytes, std::size_t size) {
  for (const char* next = static_cast<const char*>(bytes); size > 0;) {
    const ssize_t written = ::write(to, next, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);  // who wanted it has ended
    next += written, size -= static_cast<std::size_t>(written);
  }
}

void send(int to, std::uint32_t what, const std::string& bytes) {
  const Head head{what, static_cast<std::uint32_t>(bytes.size())};
  writeAll(to, &head, sizeof head);
  writeAll(to, bytes.data(), bytes.size());
}

bool readAll(int from, void* bytes, std::size_t size) {
  for (char* next = static_cast<char*>(bytes); size > 0;) {
    const ssize_t got = ::read(from, next, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    next += got, size -= static_cast<std::size_t>(got);
  }
  return true;
}

void limit(decltype(RLIMIT_AS) what, rlim_t most) {
  const rlimit limits{most, most};
  ::setrlimit(what, &limits);
}

/// In the reader's process. A refusal is what is wrong, and on its last line the remedy.
void read(const std::string& path, const std::vector<RecordedKind>& kinds, int to) {
  std::uint32_t others = 0;
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    const auto kindOfTopic = [&](const std::string& topic) {
      return std::find_if(kinds.begin(), kinds.end(), [&](const RecordedKind& kind) { return endsWith(topic, kind.topic_ends); });
    };
    rosbag::View view(bag, [&](const rosbag::ConnectionInfo* connection) { return kindOfTopic(connection->topic) != kinds.end(); });
    std::string bytes;
    for (const rosbag::MessageInstance& message : view) {
      const auto kind = kindOfTopic(message.getTopic());
      if (kind == kinds.end() || message.getMD5Sum() != kind->md5) {
        ++others;
        continue;
      }
      bytes.resize(message.size());
      auto* first = reinterpret_cast<std::uint8_t*>(bytes.data());
      ros::serialization::OStream stream(first, static_cast<std::uint32_t>(bytes.size()));
      message.write(stream);
      kind->take_apart(first, static_cast<std::uint32_t>(bytes.size()));
      send(to, static_cast<std::uint32_t>(kind - kinds.begin()), bytes);
    }
  } catch (const rosbag::BagUnindexedException&) {
    return send(to, Head::kRefused, "is truncated: it has no index\nmend it by: rosbag reindex " + path);
  } catch (const std::exception& error) {
    const std::string what = error.what();
    return send(to, Head::kRefused, "cannot be read as a bag: " + what + "\ngive a bag that --record has written, complete");
  }
  const Head end{Head::kEnd, others};
  writeAll(to, &end, sizeof end);
}

}  // namespace

std::size_t readBag(const std::string& path, const std::vector<RecordedKind>& kinds,
                    const std::function<void(std::size_t kind, std::string& bytes)>& take) {
  struct stat file {};
  const auto size = static_cast<rlim_t>(::stat(path.c_str(), &file) == 0 ? file.st_size : 0);
  int way[2];
  if (::pipe2(way, O_CLOEXEC) != 0) throw SetupError(path, "cannot be read: too many open files", "close some");
  const pid_t reader = ::fork();
  if (reader == 0) {
    for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGTRAP}) std::signal(signal, SIG_DFL);
    limit(RLIMIT_AS, kMemory + kMemoryOfByte * size);
    limit(RLIMIT_CPU, kSeconds + size / kBytesInSecond);
    limit(RLIMIT_CORE, 0);
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    ::dup2(nowhere, STDOUT_FILENO), ::dup2(nowhere, STDERR_FILENO);  // what an assertion prints helps nobody here
    read(path, kinds, way[1]);
    ::_exit(0);
  }
  ::close(way[1]);
  Head head;
  std::string bytes;
  bool complete = false;
  while (reader > 0 && !complete && readAll(way[0], &head, sizeof head)) {
    complete = head.what == Head::kEnd;
    if (complete) break;
    bytes.resize(head.size);
    if (!readAll(way[0], bytes.data(), bytes.size())) break;
    if (head.what >= kinds.size()) break;
    take(head.what, bytes);
  }
  ::close(way[0]);
  int status = 0;
  if (reader > 0) ::waitpid(reader, &status, 0);
  if (complete) return head.size;
  const std::size_t line = bytes.rfind('\n');
  if (head.what == Head::kRefused && line != std::string::npos) throw SetupError(path, bytes.substr(0, line), bytes.substr(line + 1));
  throw SetupError(path, "is damaged: the library of bags does not come to its end", "give a copy that is whole");
}

}  // namespace haptic
