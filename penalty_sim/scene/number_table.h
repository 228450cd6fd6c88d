/// Tables of numbers over time, as CSV.
#pragma once
#include <string>
#include <vector>

namespace haptic {

/// A table of numbers over time.
struct NumberTable {
  std::string path;                       ///< of the file
  std::string where_head;                 ///< "path:line" of the line that names the columns
  std::vector<std::string> columns;       ///< as it names them, `time` first
  /// A row.
  struct Row {
    std::string where;                    ///< "path:line"
    std::vector<double> numbers;          ///< a finite number for each column; times rise from row to row
  };
  std::vector<Row> rows;                  ///< at least one
};

/// First line: `time` and the names of the other columns, separated by commas; then a row per time [s]. Empty lines and lines that begin
/// with # are left out. `head` says in a message what the first line should be. Throws SetupError that names file, line and column.
NumberTable readNumberTable(const std::string& path, const std::string& head);

}  // namespace haptic
