#include "scene/resource_path.h"

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

bool isFile(const fs::path& path) {
  std::error_code code;
  return fs::is_regular_file(path, code);
}

std::vector<fs::path> packagePath() {
  std::vector<fs::path> folders;
  const char* variable = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream list(variable ? variable : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    if (!folder.empty()) folders.emplace_back(folder);
  }
  return folders;
}

bool packageXmlSays(const fs::path& folder, const std::string& name) {
  std::ifstream stream(folder / "package.xml");
  const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const std::size_t begin = text.find("<name>");
  if (begin == std::string::npos) return false;
  std::istringstream inside(text.substr(begin + 6, text.find("</name>", begin) - begin - 6));
  std::string word;
  return inside >> word && word == name;  // without the blanks around it
}

/// The folder of package `name` below one entry of ROS_PACKAGE_PATH: itself, a child or a grandchild.
fs::path packageBelow(const fs::path& entry, const std::string& name) {
  std::error_code code;
  if (entry.filename() == name || packageXmlSays(entry, name)) return entry;
  if (fs::is_directory(entry / name, code)) return entry / name;
  for (fs::directory_iterator child(entry, code), end; !code && child != end; child.increment(code)) {
    std::error_code inner;
    if (!child->is_directory(inner)) continue;
    if (packageXmlSays(child->path(), name)) return child->path();
    if (fs::is_directory(child->path() / name, inner)) return child->path() / name;
  }
  return {};
}

/// Where Debian packages put ROS packages: found without ROS_PACKAGE_PATH, as rospack finds them.
const fs::path kSystemPackages = "/usr/share";

std::string resolvePackage(const std::string& name, const std::string& rest, const fs::path& from_file) {
  for (const fs::path& entry : packagePath()) {
    const fs::path package = packageBelow(entry, name);
    if (!package.empty() && isFile(package / rest)) return (package / rest).string();
  }
  for (fs::path folder = from_file.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    if (isFile(folder / name / rest)) return (folder / name / rest).string();
    if (isFile(folder / rest)) return (folder / rest).string();  // the package's folder under another name
    std::error_code code;
    for (fs::directory_iterator child(folder, code), end; !code && child != end; child.increment(code)) {
      if (isFile(child->path() / name / rest)) return (child->path() / name / rest).string();
    }
    if (folder == folder.root_path()) break;
  }
  return isFile(kSystemPackages / name / rest) ? (kSystemPackages / name / rest).string() : std::string();
}

constexpr char kPackage[] = "package://";
/// Packages of robots that the shipped scenes name. Debian has none of them.
const std::map<std::string, std::string> kWhereFrom = {
    {"example-robot-data",
     "get it by python3 -m pip install --no-deps --target robots example-robot-data, then export "
     "ROS_PACKAGE_PATH=$PWD/robots/cmeel.prefix/share"}};

const std::vector<std::string> kEndings = {".urdf", ".yaml", ".yml", ".xml"};
const char* const kLarge = "large";  // folder of large scenes, below that of the others: lists, beside the models that they are made of

std::vector<fs::path> sceneFolders(const std::vector<std::string>& given) {
  std::vector<fs::path> folders(given.begin(), given.end());
  for (const fs::path& entry : packagePath()) {
    const fs::path package = packageBelow(entry, "haptic_description");
    if (!package.empty()) folders.push_back(package / "scenes");
  }
  std::error_code code;
  for (fs::path folder = fs::current_path(code); !folder.empty(); folder = folder.parent_path()) {
    folders.push_back(folder / "urdf" / "scenes");
    if (folder == folder.root_path()) break;
  }
  folders.push_back(kSystemPackages / "haptic_description" / "scenes");
  return folders;
}

/// %20 and its like as the bytes they stand for.
std::string decoded(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && std::isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
        std::isxdigit(static_cast<unsigned char>(uri[i + 2]))) {
      text += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

std::string resolveWritten(const std::string& uri, const std::string& from_file) {
  std::error_code code;
  const fs::path file = fs::absolute(from_file, code);
  for (const std::string scheme : {"package://", "model://"}) {
    if (uri.rfind(scheme, 0) == 0) {
      const std::string path = uri.substr(scheme.size());
      const std::size_t slash = path.find('/');
      if (slash == std::string::npos || slash == 0) return {};
      return resolvePackage(path.substr(0, slash), path.substr(slash + 1), file);
    }
  }
  fs::path path = uri.rfind("file://", 0) == 0 ? uri.substr(7) : uri;
  if (path.is_relative()) path = file.parent_path() / path;
  return isFile(path) ? path.lexically_normal().string() : std::string();
}

}  // namespace

std::string resolveResource(const std::string& uri, const std::string& from_file) {
  const std::string as_written = resolveWritten(uri, from_file);
  if (!as_written.empty() || uri.find('%') == std::string::npos) return as_written;
  return resolveWritten(decoded(uri), from_file);
}

std::vector<std::string> knownScenes(const std::vector<std::string>& folders) {
  std::set<std::string> known;
  std::error_code code;
  for (const fs::path& folder : sceneFolders(folders)) {
    for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
      const std::string extension = entry->path().extension().string();
      if (extension == ".urdf" || extension == ".yaml") known.insert(entry->path().stem().string());
    }
    for (fs::directory_iterator entry(folder / kLarge, code), end; !code && entry != end; entry.increment(code)) {
      if (entry->path().extension() == ".yaml") known.insert(entry->path().stem().string());
    }
    code.clear();  // few folders have large scenes
  }
  return {known.begin(), known.end()};
}

std::string remedyFor(const std::string& uri) {
  if (uri.rfind(kPackage, 0) != 0) return "mend the name, or put the file beside the one that names it";
  const std::string rest = uri.substr(sizeof(kPackage) - 1), package = rest.substr(0, rest.find('/'));
  for (const fs::path& entry : packagePath()) {
    const fs::path folder = packageBelow(entry, package);
    if (!folder.empty()) return "package " + package + " is " + folder.string()
        + " and has no such file: mend the name, or get the whole package";
  }
  const auto known = kWhereFrom.find(package);
  const std::string elsewhere = "set ROS_PACKAGE_PATH to the folder that holds it, or put it beside the file or above it";
  return "package " + package + " is not here: " + (known != kWhereFrom.end() ? known->second : elsewhere);
}

std::string findScene(const std::string& file_or_name, const std::vector<std::string>& folders) {
  if (file_or_name.empty())
    throw SetupError("scene", "no name given", "name a file or a scene, e.g. touch_cube");
  std::error_code code;
  if (isFile(file_or_name)) return fs::absolute(file_or_name, code).string();
  if (fs::is_directory(file_or_name, code)) {
    throw SetupError(file_or_name, "is a folder", "name a .urdf or .yaml file in it");
  }
  const fs::path asked(file_or_name);
  if (asked.has_parent_path() || asked.has_extension()) {
    throw SetupError(file_or_name, "file not found", "check the path");
  }
  for (const fs::path& folder : sceneFolders(folders)) {
    for (const std::string& ending : kEndings) {
      if (isFile(folder / (file_or_name + ending))) {
        return fs::absolute(folder / (file_or_name + ending), code).lexically_normal().string();
      }
    }
    const fs::path large = folder / kLarge / (file_or_name + ".yaml");
    if (isFile(large)) return fs::absolute(large, code).lexically_normal().string();
  }
  std::string list;
  for (const std::string& name : knownScenes(folders)) list += (list.empty() ? "" : ", ") + name;
  throw SetupError("scene '" + file_or_name + "'", "is neither a file nor a known scene",
                   list.empty() ? "no scene folder was found; give a path" : "known: " + list);
}

}  // namespace haptic
