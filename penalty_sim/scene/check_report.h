/// What `check` says of a scene: the verdict first, then what a user asks next.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/analysis/certificate.h"
#include "scene/scene_file.h"

namespace haptic {

/// A scene as a user judges it. Lists of lines; an empty list is not printed.
struct CheckReport {
  std::string verdict;                    ///< one line
  std::vector<std::string> replaced;      ///< parts that are not as the files have them
  std::vector<std::string> warnings;      ///< what a user should mend
  std::vector<std::string> hands;         ///< what each hand will feel and carry, and how it was tried
  std::vector<std::string> weak_drives;   ///< that cannot hold the start pose: asked against limit
  std::vector<std::string> start;         ///< contacts and limits that are violated at the start
  std::vector<std::string> chosen;        ///< what the loader decided, and why
  std::vector<std::string> size;          ///< counts of bodies, joints, shapes; step and gravity
  std::vector<std::string> collisions;    ///< one line for all that are alike
  std::vector<std::string> cost;          ///< of a step on this machine, by collision: costLines of step_cost.h
  std::vector<std::string> deadline;      ///< DeadlineReport::text, of a tick at the scene's step
  std::vector<std::string> stability;     ///< of the certificate: its verdict, and islands that do not pass
};

/// Without the hands, which want a device, and without the cost, which is measured. `certificate` of the scene's world.
CheckReport checkReport(const SceneDef& scene, const Certificate& certificate);

/// Sets the verdict from the lists and from whether a hand rings.
void judge(const SceneDef& scene, const Certificate& certificate, bool rings, CheckReport& report);

/// Sections of at most kMostLines lines, longer ones with the number of lines that are left out.
std::string checkText(const CheckReport& report);
/// One JSON object with the fields of CheckReport.
std::string checkJson(const CheckReport& report);

inline constexpr std::size_t kMostLines = 8;  ///< of a section: all of them fit on one screen

}  // namespace haptic
