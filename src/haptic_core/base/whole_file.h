/// Writes a file whole or not at all.
#pragma once
#include <string>

namespace haptic {

/// Writes `text` beside `path` and puts it in its place once the disk has all of it: a reader, a full disk or the end of the
/// process in between leave the file of before. Set-up; throws SetupError with the system's reason.
void writeWholeFile(const std::string& path, const std::string& text);

}  // namespace haptic
