#include "scene/joint_motion.h"

#include <cmath>
#include <fstream>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/parse_numbers.h"
#include "scene/xml_file.h"

namespace haptic {
namespace {

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    const auto first = cell.find_first_not_of(" \t\r"), last = cell.find_last_not_of(" \t\r");
    all.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return all;
}

std::pair<int, int> findJoint(const WorldDef& world, std::size_t first, const std::string& name) {
  for (std::size_t a = first; a < world.articulations.size(); ++a) {
    for (std::size_t l = 0; l < world.articulations[a].links.size(); ++l) {
      if (world.articulations[a].links[l].joint.name == name)
        return {static_cast<int>(a), static_cast<int>(l)};
    }
  }
  return {-1, -1};
}

}  // namespace

JointPathDef readJointMotion(const std::string& path, const std::string& prefix, const WorldDef& world,
                             std::size_t first) {
  std::ifstream file(path);
  if (!file) throw SetupError(path, "cannot be read", "check the path and its permissions");
  JointPathDef motion;
  motion.name = path;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    const std::string where = path + ":" + std::to_string(number);
    const std::vector<std::string> row = cells(line);
    if (motion.joints.empty()) {
      if (row[0] != "time" || row.size() < 2) {
        throw SetupError(where, "is no head line", "begin with time,JOINT,JOINT...");
      }
      for (std::size_t c = 1; c < row.size(); ++c) {
        motion.joints.push_back(findJoint(world, first, prefix + row[c]));
        if (motion.joints.back().first < 0) {
          throw SetupError(where, "the model has no joint '" + row[c] + "'", "mend the name");
        }
      }
      continue;
    }
    if (row.size() != motion.joints.size() + 1) {
      throw SetupError(where,
                       "has " + std::to_string(row.size()) + " columns, the head " +
                           std::to_string(motion.joints.size() + 1),
                       "give a number for every joint");
    }
    for (std::size_t c = 0; c < row.size(); ++c) {
      const auto value = parseNumbers(row[c]);
      if (!value || value->size() != 1 || !std::isfinite((*value)[0])) {
        throw SetupError(where, "column " + std::to_string(c + 1) + " is not a finite number",
                         "write e.g. 0.5");
      }
      (c == 0 ? motion.time : motion.position).push_back((*value)[0]);
    }
    if (motion.time.size() > 1 && !(motion.time.back() > motion.time[motion.time.size() - 2])) {
      throw SetupError(where, "its time does not rise", "put the rows in order");
    }
  }
  if (motion.time.empty())
    throw SetupError(path, "has no row of positions", "write time,JOINT and rows below");
  return motion;
}

}  // namespace haptic
