#include "scene/xacro_run.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "haptic_core/base/error.h"

extern char** environ;

namespace haptic {
namespace {

const XmlElement* firstXacro(const XmlElement* element) {
  for (; element; element = element->NextSiblingElement()) {
    if (std::strncmp(element->Name(), "xacro:", 6) == 0) return element;
    if (const XmlElement* inner = firstXacro(element->FirstChildElement())) return inner;
  }
  return nullptr;
}

/// A folder for a program's input and output, gone with this object.
class Scratch {
 public:
  explicit Scratch(const std::string& where) {
    std::string pattern = (std::filesystem::temp_directory_path() / "haptic_xacro_XXXXXX").string();
    if (!mkdtemp(pattern.data())) throw SetupError(where, "no folder can be made for the output of xacro", "free some space in " + pattern);
    folder_ = pattern;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string file(const char* name) const { return folder_ + "/" + name; }

 private:
  std::string folder_;
};

/// Exit code of a program of PATH; 127: there is none.
int run(std::vector<std::string> words, const std::string& out, const std::string& errors) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, arguments[0], &files, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (failed) return 127;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

/// Of a program's messages the last one that says something: a traceback ends with its reason.
std::string lastLine(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  if (end == std::string::npos) return "it says nothing";
  const std::size_t before = text.find_last_of('\n', end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, end + 1 - begin);
}

}  // namespace

bool isXacro(const XmlFile& file) {
  return firstXacro(file.root()) || std::filesystem::path(file.path()).extension() == ".xacro";
}

std::string expandXacro(const std::string& path, const XmlFile& file, const SceneOptions& options) {
  const XmlElement* element = firstXacro(file.root());
  const std::string where = file.at(element ? *element : *file.root());
  const Scratch scratch(where);
  std::string input = path;
  if (options.text) {
    input = scratch.file("text.xacro");
    std::ofstream(input, std::ios::binary) << *options.text;
  }
  std::vector<std::string> words = {"xacro", input};
  words.insert(words.end(), options.xacro.begin(), options.xacro.end());
  const int code = run(words, scratch.file("out"), scratch.file("errors"));
  if (code == 127) {
    throw SetupError(where, "is xacro, not URDF, and there is no program xacro on the path",
                     "install it (pip install xacro), or expand the file elsewhere: xacro FILE > robot.urdf");
  }
  if (code != 0) {
    throw SetupError(where, "xacro fails: " + lastLine(readTextFile(scratch.file("errors"))),
                     "mend the file, or give its arguments: --xacro name:=value");
  }
  return readTextFile(scratch.file("out"));
}

}  // namespace haptic
