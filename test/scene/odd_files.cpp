/// Files with odd texts (odd_texts.h), for `./run bench robots`: written into a folder, or loaded one by one,
/// each in a process of its own, so that a crash is counted and ends nothing else.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "haptic_core/base/error.h"
#include "haptic_core/base/plain_text.h"
#include "haptic_core/world/world.h"
#include "odd_texts.h"
#include "scene/scene_file.h"

namespace haptic {
namespace {

constexpr unsigned kLimit =
    60;  // [s] of a file that is neither loaded nor refused; a busy machine needs 2 s for the slowest

std::string textOf(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Robots in turns: the one of all elements each second time, between them shipped scenes.
class OddFiles {
 public:
  OddFiles() : all_(robotOfAllElements()) {
    for (const char* scene : {"conveyor", "door", "four_bar", "gear", "terrain", "touch_cube"}) {
      const std::string text = textOf(std::string(HAPTIC_SCENES) + "/" + scene + ".urdf");
      if (!text.empty()) scenes_.emplace_back(text);
    }
  }
  std::string file(std::size_t i) const {
    if (i % 2 == 0 || scenes_.empty()) return oddFile(all_, i / 2);
    return oddFile(scenes_[i / 2 % scenes_.size()], i / 2 / scenes_.size());
  }

 private:
  OddPlaces all_;
  std::vector<OddPlaces> scenes_;
};

enum Outcome { kLoaded = 0, kRefused = 1, kIllSaid = 2 };

Outcome load(const std::string& text) {
  SceneOptions options;
  options.default_density = 1000;
  options.missing = MissingMeshes::kSkip;
  options.text = text;
  try {
    const SceneDef scene = loadScene(std::string(HAPTIC_SCENES) + "/odd.urdf", options);
    const World world(scene.world);
    const std::string said = sceneText(scene) + world.planText();
    return validUtf8(said) == said ? kLoaded : kIllSaid;
  } catch (const SetupError& error) {
    return plainText(error.what()) == error.what() ? kRefused : kIllSaid;
  }
}

/// 0: the file of number i is loaded or refused in one line.
int failureOf(const OddFiles& files, std::size_t i, long counts[2]) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) {
    std::perror("odd_files");
    std::exit(1);
  }
  if (child == 0) {
    alarm(kLimit);
    _exit(load(files.file(i)));
  }
  int status = 0;
  waitpid(child, &status, 0);
  const bool done = WIFEXITED(status) && WEXITSTATUS(status) <= kRefused;
  if (done) ++counts[WEXITSTATUS(status)];
  return done ? 0 : status;
}

int loadAll(std::size_t count) {
  const OddFiles files;
  long counts[2] = {0, 0}, crashes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const int status = failureOf(files, i, counts);
    if (status == 0) continue;
    ++crashes;
    std::printf("file %zu: ended with status %d, signal %d\n", i, WEXITSTATUS(status),
                WIFSIGNALED(status) ? WTERMSIG(status) : 0);
  }
  std::printf("loaded %ld\nrefused %ld\ncrashes %ld\n", counts[kLoaded], counts[kRefused], crashes);
  return crashes == 0 ? 0 : 1;
}

int writeAll(std::size_t count, const std::string& folder) {
  const OddFiles files;
  for (std::size_t i = 0; i < count; ++i) {
    std::ofstream(folder + "/odd_" + std::to_string(i) + ".urdf", std::ios::binary) << files.file(i);
  }
  return 0;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  const std::string verb = argc > 1 ? argv[1] : "";
  const long count = argc > 2 ? std::atol(argv[2]) : 0;
  if (verb == "load" && argc == 3 && count > 0) return haptic::loadAll(static_cast<std::size_t>(count));
  if (verb == "write" && argc == 4 && count > 0)
    return haptic::writeAll(static_cast<std::size_t>(count), argv[3]);
  std::fputs("usage: odd_files load COUNT | write COUNT FOLDER\n", stderr);
  return 2;
}
