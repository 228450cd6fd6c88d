/// Reads a bag that may be damaged.
///
/// The library of bags believes what a file says of itself: where a length or an index is wrong it ends in an assertion, a segmentation
/// fault, or takes all of the memory. So a process of its own reads, with bounds on memory and time, takes each message apart once, and
/// passes its bytes on; when that process does not come to its end, the bag is refused. A flipped bit within a message is not seen here:
/// the hashes of the ticks tell it, when they are replayed.
#pragma once
#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace haptic {

/// Messages that are wanted: of topics with this ending.
struct RecordedKind {
  std::string topic_ends, md5;
  std::function<void(std::uint8_t* bytes, std::uint32_t size)> take_apart;  ///< throws what is no such message
};

/// Of a type of messages.
template <class Message>
RecordedKind kindOf(const std::string& topic_ends) {
  return {topic_ends, ros::message_traits::md5sum<Message>(), [](std::uint8_t* bytes, std::uint32_t size) {
            Message message;
            ros::serialization::IStream stream(bytes, size);
            ros::serialization::deserialize(stream, message);
          }};
}

/// Calls `take` with the index of its kind and the bytes of each message, in the order of the bag; how many messages of these topics are
/// of another type. Throws SetupError: no bag, not complete, damaged. It forks: before the process has other threads.
std::size_t readBag(const std::string& path, const std::vector<RecordedKind>& kinds,
                    const std::function<void(std::size_t kind, std::string& bytes)>& take);

}  // namespace haptic
