/// Reads one YAML mapping strictly: an unknown key and a key written twice are errors, and every message names file and line.
#pragma once
#include <yaml-cpp/yaml.h>

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/base/spatial.h"

namespace haptic {

/// The file's only document. Throws SetupError: it cannot be opened, is no YAML, or holds a second document.
YAML::Node loadYaml(const std::string& path);

/// Reads keys of one mapping. Set-up; all of it throws SetupError.
class YamlMap {
 public:
  /// `what` names the mapping in messages. Refuses nodes that are no mapping, keys that are not in `known`, and
  /// keys that stand twice.
  YamlMap(const std::string& path, const YAML::Node& node, const std::string& what, const std::set<std::string>& known);

  /// "path:line" of a part of the file.
  std::string where(const YAML::Node& node) const;
  std::string where() const { return where(node_) + ": " + what_; }  ///< of the mapping
  /// Of a key's value, or of the mapping where there is none.
  std::string where(const char* key) const;

  YAML::Node operator[](const char* key) const { return node_[key]; }             ///< as it is written
  bool has(const char* key) const { return static_cast<bool>(node_[key]); }       ///< it is there
  /// A word.
  std::string text(const char* key, const std::string& otherwise = "") const;
  /// True or false.
  bool flag(const char* key, bool otherwise) const;
  /// Finite numbers, as a list or in one text.
  std::vector<double> numbers(const char* key) const;
  /// One of them, from `least` to `most`.
  double number(const char* key, double otherwise, double least = -std::numeric_limits<double>::infinity(),
                double most = std::numeric_limits<double>::infinity()) const;
  /// Three of them, each of a size up to `most`; zero where there are none.
  Vector3 vector(const char* key, double most = std::numeric_limits<double>::infinity()) const;
  /// Refuses a mapping without the key; `meaning` tells what to write.
  void require(const char* key, const std::string& meaning) const;

 private:
  std::string path_;
  YAML::Node node_;
  std::string what_;
};

}  // namespace haptic
