#include "scene/xacro_run.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "haptic_core/base/error.h"
#include "scene/text_file.h"

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

/// Why a program ended, from what it said. xacro gives its reason first, and then where it was ("when processing file ..."); a traceback
/// ends with it. Warnings, blanks and colours are left out.
std::string reasonOf(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\x1b' && i + 1 < text.size() && text[i + 1] == '[') {
      i = text.find('m', i);
      if (i == std::string::npos) break;
    } else {
      plain += text[i];
    }
  }
  std::vector<std::string> lines;
  bool traceback = false;
  std::istringstream in(plain);
  for (std::string line; std::getline(in, line);) {
    line.erase(0, line.find_first_not_of(" \t\r"));
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
    traceback |= line.rfind("Traceback", 0) == 0;
    const bool warns = line.rfind("warning", 0) == 0 || line.find("Warning:") != std::string::npos || line.rfind("xacro: in-order", 0) == 0;
    if (!line.empty() && !warns) lines.push_back(line);
  }
  if (lines.empty()) return "it says nothing";
  if (traceback) return lines.back();
  constexpr std::size_t kMost = 4;  // where it was, from the inside: enough to find it
  std::string reason = lines[0];
  for (std::size_t i = 1; i < std::min(lines.size(), kMost); ++i) reason += ", " + lines[i];
  return reason;
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
    throw SetupError(where, "xacro fails: " + reasonOf(readTextFile(scratch.file("errors"))),
                     "mend the file, or give its arguments: " + options.words.xacro);
  }
  return readTextFile(scratch.file("out"));
}

}  // namespace haptic
