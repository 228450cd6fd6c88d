#include "scene/number_table.h"

#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/parse_numbers.h"
#include "scene/text_file.h"

namespace haptic {
namespace {

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t\r"), last = cell.find_last_not_of(" \t\r");
    all.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return all;
}

}  // namespace

NumberTable readNumberTable(const std::string& path, const std::string& head) {
  std::istringstream file(readTextFile(path));
  NumberTable table;
  table.path = path;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    const std::string where = path + ":" + std::to_string(number);
    const std::vector<std::string> cells = cellsOf(line);
    if (table.columns.empty()) {
      if (cells[0] != "time" || cells.size() < 2) throw SetupError(where, "is no head line", "begin with " + head);
      table.where_head = where;
      table.columns = cells;
      continue;
    }
    if (cells.size() != table.columns.size()) {
      throw SetupError(where, "has " + std::to_string(cells.size()) + " columns, the head " + std::to_string(table.columns.size()),
                       "give a number for every column");
    }
    NumberTable::Row row{where, {}};
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const auto value = parseNumbers(cells[c]);
      if (!value || value->size() != 1 || !std::isfinite((*value)[0])) {
        throw SetupError(where, "column " + std::to_string(c + 1) + " is not a finite number", "write e.g. 0.5");
      }
      row.numbers.push_back((*value)[0]);
    }
    if (!table.rows.empty() && !(row.numbers[0] > table.rows.back().numbers[0])) {
      throw SetupError(where, "its time does not rise", "put the rows in order");
    }
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) throw SetupError(path, "has no row of positions", "write " + head + " and rows below");
  return table;
}

}  // namespace haptic
