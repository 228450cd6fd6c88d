/// What the page of `./run check DEVICE --report` shows of one device, as JSON.
#pragma once
#include <string>

#include "haptic_core/design/workspace.h"

namespace haptic {

/// Certified regions with their sections, and force, isotropy and stiffness along those. Set-up: seconds. Lengths in mm, angles in degrees.
std::string deviceReport(const DeviceDef& def, const RequiredWrench& required);

/// What is required where the user asks for nothing: 1 N, or a tenth of the greatest tension, with the torque that it makes at the knots.
RequiredWrench leastFeedback(const DeviceDef& def);

}  // namespace haptic
