/// Finding the boards on a bus and teaching them each other's packet lengths. Set-up only.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/spidar/device_def.h"
#include "spidar_driver/transport/board_model.h"
#include "spidar_driver/transport/byte_link.h"

namespace haptic {

struct FoundBoard {
  int id = 0;
  const BoardShape* shape = nullptr;
  bool operator==(const FoundBoard& o) const { return id == o.id && shape == o.shape; }
};

/// What a scan of the ids 0–7 heard.
struct BusScan {
  std::vector<FoundBoard> boards;  ///< in order of id
  std::size_t foreign_bytes = 0;   ///< bytes that are no board's answer: wrong baud rate or another device
  std::string unknown;             ///< "id 3: model 9, 5 motors" of a board of unknown model; else empty
};

/// Probes each id with BOARD_INFO, behind enough zeros to end any packet that a board may be inside of. Takes
/// about 0.2 s.
BusScan scanBus(ByteLink& link);

/// SET_CMDLEN for every board: without it, a board of one model loses step at a command for another model.
/// False when the line does not take the bytes.
bool teachLengths(ByteLink& link, const std::vector<FoundBoard>& boards);

/// The same bytes, for a caller that sends them itself.
std::vector<std::uint8_t> lengthLesson(const std::vector<FoundBoard>& boards);

/// Throws SetupError, naming `port`, unless the scan found what the device needs: boards at all, known
/// models, the models of its file in order, enough motors for its strings. Returns the boards to use, in
/// channel order.
std::vector<FoundBoard> matchBoards(const BusScan& scan, const DeviceDef& device, const std::string& port);

}  // namespace haptic
