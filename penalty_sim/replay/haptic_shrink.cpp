// Reduces a recorded session that shows a fault, and writes what is left.
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/program_version.h"
#include "replay/replay_run.h"
#include "replay/shrink.h"

namespace haptic {
namespace {

constexpr char kUsage[] = "usage: haptic_shrink BAG OUTPUT.bag [--fault NAME | --test COMMAND]";

struct Options {
  std::string bag, output, fault, test;
};

Options readOptions(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    std::string* const value = word == "--fault" ? &options.fault : word == "--test" ? &options.test : nullptr;
    if (value && i + 1 < argc) {
      *value = argv[++i];
    } else if (word[0] != '-' && options.output.empty()) {
      (options.bag.empty() ? options.bag : options.output) = word;
    } else {
      throw SetupError(word, "is not understood", kUsage);
    }
  }
  if (options.output.empty()) throw SetupError("haptic_shrink", "a bag and an output are needed", kUsage);
  return options;
}

/// A command of the user's that gets the bag of each attempt as its last word; where it ends with 0 the fault is there.
Fault faultOfCommand(const std::string& command, const RecordedSession& like, const std::string& output) {
  const std::string path = output + ".attempt.bag";
  Fault fault{"'" + command + "' ends with 0", [command, path, &like](const ShrinkAttempt& attempt) {
                writeAttempt(attempt, like, false, path);
                const std::string line = command + " \"$HAPTIC_ATTEMPT\" >/dev/null 2>&1 </dev/null";
                ::setenv("HAPTIC_ATTEMPT", path.c_str(), 1);
                const int code = std::system(line.c_str());
                ::unlink(path.c_str());
                if (WIFSIGNALED(code) || (WIFEXITED(code) && WEXITSTATUS(code) >= 126)) {
                  throw std::runtime_error("--test " + command + ": cannot be run; give a command that takes a bag as its last word");
                }
                return code == 0 ? static_cast<int>(attempt.ticks.size()) - 1 : -1;
              }};
  fault.end_unknown = true;
  return fault;
}

/// The written bag is replayed as anybody would, and shows the fault again.
void verify(const std::string& path, const Fault& fault) {
  const std::vector<RecordedSession> sessions = readSessions(path);
  const RecordedSession& session = sessions.front();
  const ReplayReport report = ReplayRun(session).run();
  if (!fault.bodies_stay && report.mismatches > 0) throw std::runtime_error(path + ": is not replayed bit for bit: " + report.first_part);
  if (fault.first(attemptOf(session)) < 0) throw std::runtime_error(path + ": does not show the fault any more once it is read back");
}

double kilobytes(const std::string& path) {
  struct stat file {};
  return ::stat(path.c_str(), &file) == 0 ? 1e-3 * static_cast<double>(file.st_size) : 0;
}

int main(int argc, char** argv) {
  const Options options = readOptions(argc, argv);
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<RecordedSession> sessions = readSessions(options.bag);
  if (sessions.size() > 1) std::printf("the bag holds %zu sessions; the last one is reduced\n", sessions.size());
  const RecordedSession& session = sessions.back();
  const ShrinkAttempt whole = attemptOf(session);
  const Fault fault = options.test.empty() ? faultNamed(options.fault, whole) : faultOfCommand(options.test, session, options.output);
  const Shrunk shrunk = shrink(whole, fault);
  writeAttempt(shrunk.attempt, session, fault.bodies_stay, options.output);
  verify(options.output, fault);
  const double before = static_cast<double>(whole.links() * whole.ticks.size());
  const double after = static_cast<double>(shrunk.attempt.links() * shrunk.attempt.ticks.size());
  std::string plain;
  for (const std::string& name : shrunk.plain) plain += (plain.empty() ? "; plain: " : ", ") + name;
  std::printf("%s: %zu of %zu bodies, %zu of %zu ticks, %zu of %zu commands%s; %.1f kB, replayed bit for bit, %d attempts\n",
              fault.name.c_str(), shrunk.attempt.links(), whole.links(), shrunk.attempt.ticks.size(), whole.ticks.size(),
              shrunk.attempt.events.size(), whole.events.size(), plain.c_str(), kilobytes(options.output), shrunk.attempts);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("figure shrink.ratio %.4g 1\nfigure shrink.minutes %.3g min\n", after / before, seconds / 60);
  return 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  if (haptic::toldVersion(argc, argv, "haptic_shrink")) return 0;
  try {
    return haptic::main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "shrink: " << error.what() << "\n";
    return 2;
  }
}
