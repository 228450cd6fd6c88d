/// A scene as MuJoCo's MJCF: body i + 1 of the model is link i, free bodies in their order have seven q and six v each.
#pragma once
#include "peer_world.h"

namespace haptic::peers {

/// Throws SetupError for what MuJoCo cannot be told.
std::string mujocoModel(const WorldDef& def, const std::vector<PeerBody>& bodies, const PeerSettings& settings);

}  // namespace haptic::peers
