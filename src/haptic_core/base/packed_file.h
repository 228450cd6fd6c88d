/// A record as a whole file: a line that names the format, the fields (packed_fields.h), and a hash of both.
#pragma once
#include <cstdint>
#include <string>

#include "haptic_core/base/packed_fields.h"
#include "haptic_core/base/word_hash.h"

namespace haptic {

/// Of bytes of any number: hashWords wants whole words.
inline std::uint64_t hashBytes(std::string bytes) {
  bytes.resize((bytes.size() + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t) * sizeof(std::uint64_t));
  return hashWords(kHashStart, bytes.data(), bytes.size());
}

/// The bytes of a file. `format` ends with a line break.
template <class T>
std::string packFile(const std::string& format, const T& record) {
  std::string bytes = format;
  FieldWriter write(bytes);
  write(record);
  write(hashBytes(bytes));
  return bytes;
}

/// The record again. `where` is for messages. Throws SetupError: of another format, cut or altered.
template <class T>
T unpackFile(const std::string& format, const std::string& bytes, const std::string& where) {
  const std::size_t head = format.size(), tail = sizeof(std::uint64_t);
  if (bytes.compare(0, head, format) != 0) {
    throw SetupError(where, "does not begin with '" + format.substr(0, head - 1) + "'", "write it again, by this version");
  }
  const std::string body = bytes.substr(head, bytes.size() < head + tail ? 0 : bytes.size() - head - tail);
  FieldReader read(body, where);
  std::uint64_t sum = 0;
  if (bytes.size() < head + tail) read.cut();
  std::memcpy(&sum, bytes.data() + bytes.size() - tail, tail);
  if (sum != hashBytes(bytes.substr(0, bytes.size() - tail))) read.cut();
  T record;
  read(record);
  if (!read.atEnd()) read.cut();
  return record;
}

}  // namespace haptic
