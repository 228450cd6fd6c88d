/// Where package://, file:// and relative names of meshes and models lie.
#pragma once
#include <string>
#include <vector>

namespace haptic {

/// Absolute path of `uri` as written in `from_file`. package://NAME/REST is looked up in the folders of
/// ROS_PACKAGE_PATH (NAME or */NAME below them, or a folder whose package.xml says NAME), then beside the
/// file, in every folder above it and in /usr/share. Relative names are relative to the file. `%20`
/// and its like stand for a byte where no file is called as written. Empty when nothing is found.
std::string resolveResource(const std::string& uri, const std::string& from_file);

/// How to come by a file that `resolveResource` did not find: one sentence, for a SetupError.
std::string remedyFor(const std::string& uri);

/// Absolute path of the scene `file_or_name`. Throws SetupError that lists the scenes it knows.
std::string findScene(const std::string& file_or_name, const std::vector<std::string>& folders);

/// Names of the scenes that `findScene` finds without a path, sorted.
std::vector<std::string> knownScenes(const std::vector<std::string>& folders = {});

}  // namespace haptic
