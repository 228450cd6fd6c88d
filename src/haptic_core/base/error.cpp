#include "haptic_core/base/error.h"

#include "haptic_core/base/plain_text.h"

namespace haptic {

std::string SetupError::oneLine(const std::string& text) {
  if (text.size() <= kLongest) return plainText(text);
  const std::string valid = validUtf8(text);
  const auto begins = [&](std::size_t at) { return (static_cast<unsigned char>(valid[at]) & 0xc0) != 0x80; };
  std::size_t first = kLongest / 2, last = valid.size() - kLongest / 2;
  while (!begins(first)) --first;
  while (last < valid.size() && !begins(last)) ++last;
  return plainText(valid.substr(0, first) + " … " + valid.substr(last));
}

}  // namespace haptic
