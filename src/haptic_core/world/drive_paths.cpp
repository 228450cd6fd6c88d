#include "haptic_core/world/drive_paths.h"

#include <algorithm>
#include <functional>

#include "haptic_core/base/error.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

std::vector<DrivePath> drivePaths(const WorldDef& def, const Model& model) {
  std::vector<DrivePath> paths;
  for (const JointPathDef& path : def.joint_paths) {
    DrivePath added;
    added.time = path.time;
    added.position = path.position;
    for (const auto& [articulation, local] : path.joints) {
      const int link = model.link(articulation, local);
      const auto joint = std::find_if(model.joints.begin(), model.joints.end(),
                                      [&](const ModelJoint& j) { return j.link == link && j.driven; });
      if (joint == model.joints.end()) {
        throw SetupError(path.name, "the joint of link " + model.links[link].name + " has no drive",
                         "give it an effort limit, or <haptic:joint drive=\"position\" drive_stiffness=\"...\"/>");
      }
      added.commands.push_back(model.trees[model.links[link].articulation].command + model.links[link].local);
    }
    const bool rising = std::is_sorted(path.time.begin(), path.time.end(), std::less_equal<double>());
    if (path.time.empty() || !rising || path.position.size() != path.time.size() * path.joints.size()) {
      throw SetupError(path.name, "its times do not rise, or a row lacks a position", "give one row per time, in order");
    }
    paths.push_back(std::move(added));
  }
  return paths;
}

void followDrivePaths(const Model& model, State& state) noexcept {
  const double t = state.time + model.settings.step;
  for (const DrivePath& path : model.drive_paths) {
    if (t > path.time.back() + model.settings.step) continue;  // told its last row; others may command now
    const int rows = static_cast<int>(path.time.size()), columns = static_cast<int>(path.commands.size());
    const int next = static_cast<int>(std::upper_bound(path.time.begin(), path.time.end(), t) - path.time.begin());
    const int a = std::max(next - 1, 0), b = std::min(next, rows - 1);
    const double width = path.time[b] - path.time[a];
    for (int c = 0; c < columns; ++c) {
      const double from = path.position[a * columns + c], to = path.position[b * columns + c];
      const double rate = width > 0 ? (to - from) / width : 0;
      state.commands[path.commands[c]] = {JointDef::Drive::kPosition, from + rate * (t - path.time[a]) * (width > 0),
                                          rate, 0};
    }
  }
}

}  // namespace haptic
