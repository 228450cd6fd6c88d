#include "scene/joint_motion.h"

#include "haptic_core/base/error.h"
#include "scene/number_table.h"

namespace haptic {
namespace {

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
  const NumberTable table = readNumberTable(path, "time,JOINT,JOINT...");
  JointPathDef motion;
  motion.name = path;
  for (std::size_t c = 1; c < table.columns.size(); ++c) {
    motion.joints.push_back(findJoint(world, first, prefix + table.columns[c]));
    if (motion.joints.back().first < 0) {
      throw SetupError(table.where_head, "the model has no joint '" + table.columns[c] + "'", "mend the name");
    }
  }
  for (const NumberTable::Row& row : table.rows) {
    motion.time.push_back(row.numbers[0]);
    motion.position.insert(motion.position.end(), row.numbers.begin() + 1, row.numbers.end());
  }
  return motion;
}

}  // namespace haptic
