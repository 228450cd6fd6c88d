/// Heights of the ground from a text file or an attribute.
#pragma once
#include <string>

#include "haptic_core/geometry/hulls/ground.h"

namespace haptic {

/// Rows of heights [m] from a file: a line each, numbers apart by white space or commas, lines that begin with # and empty ones left
/// out. `size` stays 0. Throws SetupError that names file and line: it cannot be read, a row has another number of heights than the
/// first one, a height is no finite number, there are more than kMostHeights.
HeightGrid readHeights(const std::string& path);

/// The same from text whose rows are apart by semicolons; `where` names it.
HeightGrid parseHeights(const std::string& text, const std::string& where);

constexpr int kMostHeights = 1000000;  ///< a wrong file must not fill the memory

}  // namespace haptic
