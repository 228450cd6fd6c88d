/// Files of a user, read whole.
#pragma once
#include <string>

namespace haptic {

/// Bytes of a file. Throws SetupError: not found, not a file, not readable, larger than `most` bytes, or a pointer of git-LFS that stands
/// in place of the file.
std::string readFile(const std::string& path, std::size_t most);

/// Text files of robots are below 1 MB; a limit keeps a wrong file (a mesh, a bag) from filling the memory [bytes].
inline constexpr std::size_t kMaxTextBytes = std::size_t{64} << 20;

/// Of up to kMaxTextBytes, without the byte-order mark that some editors put before UTF-8.
std::string readTextFile(const std::string& path);

/// `text` from its byte-order mark on; all of it where there is none.
std::string withoutByteOrderMark(std::string text);

}  // namespace haptic
