/// Robots and scenes as users have them: what loads, how, and how fast.
#pragma once
#include <string>
#include <vector>

namespace haptic::bench {

/// Paths of every .urdf and .xacro below shared/example-robot-data and shared/cases beside the repository and the folder HAPTIC_ROBOTS.
std::vector<std::string> robotFiles();

/// Prints a line `robot PATH|...` for each of robotFiles (robots_table.py makes a table of them) and robots.tried, loaded,
/// replaced_parts, refused_with_reason,
/// silent_over_3s, surface_err_mm_unsaid, load_s_max, load_cached_s_max, invariants_err_max, step_us_max.
void measureRobotFiles();

/// 200 random stacks without tags: chosen.sink_share_max of those without a warning, chosen.warned, chosen.settled.
void measureChosenStiffness();

}  // namespace haptic::bench
