/// xacro files, by the program of this name.
#pragma once
#include <string>

#include "scene/scene_options.h"
#include "scene/xml_file.h"

namespace haptic {

/// Whether the file has an element of xacro, or its name ends with .xacro.
bool isXacro(const XmlFile& file);

/// What `xacro FILE ARGUMENTS` prints; SceneOptions::text, when there is one, goes to it as a file. Its messages are not shown. Throws
/// SetupError: there is no such program on PATH, or it fails (with its last line).
std::string expandXacro(const std::string& path, const XmlFile& file, const SceneOptions& options);

}  // namespace haptic
