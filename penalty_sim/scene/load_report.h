/// What the loader had to say of the files.
#pragma once
#include <string>
#include <vector>

namespace haptic {

/// Lines for people, each naming file, line and link. A message that a user should not miss stands in one of them alone.
struct LoadReport {
  std::vector<std::string> notes;     ///< what a user should know
  std::vector<std::string> warnings;  ///< what a user should mend
  std::vector<std::string> replaced;  ///< parts that could not be as the files have them, and what stands in their place
};

}  // namespace haptic
