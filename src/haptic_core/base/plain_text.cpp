#include "haptic_core/base/plain_text.h"

#include <algorithm>
#include <cstdint>

namespace haptic {
namespace {

/// A character of a text: its code point and the bytes that it takes; 0 bytes: what stands there is no UTF-8.
struct Utf8Character {
  std::uint32_t code;
  std::size_t bytes;
};

/// RFC 3629: the shortest form alone, no surrogates, nothing beyond U+10FFFF.
Utf8Character characterAt(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || at + bytes > text.size()) return {first, 0};
  std::uint32_t code = first & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xc0) != 0x80) return {first, 0};
    code = code << 6 | (byte(at + i) & 0x3f);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return {code, code < kLeast[bytes] || surrogate || code > 0x10ffff ? 0 : bytes};
}

void appendLatin1(unsigned char byte, std::string& out) {
  out += static_cast<char>(0xc0 | byte >> 6);
  out += static_cast<char>(0x80 | (byte & 0x3f));
}

bool isControl(std::uint32_t code) {
  constexpr std::uint32_t kLineSeparator = 0x2028, kParagraphSeparator = 0x2029;
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == kLineSeparator ||
         code == kParagraphSeparator;
}

}  // namespace

std::string validUtf8(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = characterAt(text, at).bytes;
    if (bytes > 0) {
      out.append(text, at, bytes);
    } else {
      appendLatin1(static_cast<unsigned char>(text[at]), out);
    }
    at += std::max<std::size_t>(bytes, 1);
  }
  return out;
}

std::string plainText(const std::string& text) {
  const std::string valid = validUtf8(text);
  std::string out;
  out.reserve(valid.size());
  for (std::size_t at = 0; at < valid.size();) {
    const Utf8Character character = characterAt(valid, at);
    if (isControl(character.code)) {
      out += ' ';
    } else {
      out.append(valid, at, character.bytes);
    }
    at += character.bytes;
  }
  return out;
}

}  // namespace haptic
