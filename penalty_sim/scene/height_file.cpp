#include "scene/height_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/parse_numbers.h"
#include "scene/text_file.h"

namespace haptic {
namespace {

void addRow(const std::string& text, const std::string& where, HeightGrid& grid) {
  std::vector<double> row;
  std::istringstream in(text);
  for (std::string cell; std::getline(in, cell, ',');) {  // one without commas is one cell
    const auto values = parseNumbers(cell);
    const auto isFinite = [](double v) { return std::isfinite(v); };
    const bool numbers = values && !values->empty() && std::all_of(values->begin(), values->end(), isFinite);
    if (!numbers) throw SetupError(where, "'" + cell + "' is no finite height", "write numbers in metres, apart by spaces or commas");
    row.insert(row.end(), values->begin(), values->end());
  }
  if (grid.rows > 0 && static_cast<int>(row.size()) != grid.columns) {
    throw SetupError(where, "has " + std::to_string(row.size()) + " heights, the first row has " + std::to_string(grid.columns),
                     "give all rows equally many");
  }
  grid.columns = static_cast<int>(row.size());
  ++grid.rows;
  grid.heights.insert(grid.heights.end(), row.begin(), row.end());
  if (grid.heights.size() > static_cast<std::size_t>(kMostHeights)) {
    throw SetupError(where, "there are more than " + std::to_string(kMostHeights) + " heights", "make the grid coarser");
  }
}

}  // namespace

HeightGrid readHeights(const std::string& path) {
  std::istringstream file(readTextFile(path));
  HeightGrid grid;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    addRow(line, path + ":" + std::to_string(number), grid);
  }
  if (grid.rows == 0) throw SetupError(path, "has no heights", "write a row of numbers a line");
  return grid;
}

HeightGrid parseHeights(const std::string& text, const std::string& where) {
  HeightGrid grid;
  std::istringstream in(text);
  for (std::string row; std::getline(in, row, ';');) {
    addRow(row, where + ": row " + std::to_string(grid.rows + 1) + " of heights", grid);
  }
  return grid;
}

}  // namespace haptic
