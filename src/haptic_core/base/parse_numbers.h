/// Numbers in a user's text, whatever the locale.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace haptic {

/// Numbers separated by white space; nothing when the text is anything else. Infinite and NaN are returned as
/// such.
std::optional<std::vector<double>> parseNumbers(const std::string& text);

}  // namespace haptic
