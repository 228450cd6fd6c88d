#include "scene/text_file.h"

#include <filesystem>
#include <fstream>

#include "haptic_core/base/error.h"

namespace haptic {

std::string readFile(const std::string& path, std::size_t most) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) throw SetupError(path, "file not found", "check the path");
  if (std::filesystem::is_directory(status)) throw SetupError(path, "is a folder", "name a file in it");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw SetupError(path, "cannot be read", "check its permissions");
  const auto size = std::filesystem::file_size(path, code);
  if (!code && size > most) throw SetupError(path, "is larger than " + std::to_string(most >> 20) + " MB",
      "this is no file of a robot or scene");
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  constexpr char kPointer[] = "version https://git-lfs.github.com/spec/";
  if (bytes.compare(0, sizeof kPointer - 1, kPointer) == 0) {
    throw SetupError(path, "is a pointer of git-LFS, not the file itself", "call git lfs pull in its repository");
  }
  return bytes;
}

std::string readTextFile(const std::string& path) { return withoutByteOrderMark(readFile(path, kMaxTextBytes)); }

std::string withoutByteOrderMark(std::string text) {
  if (text.compare(0, 3, "\xef\xbb\xbf") == 0) text.erase(0, 3);
  return text;
}

}  // namespace haptic
