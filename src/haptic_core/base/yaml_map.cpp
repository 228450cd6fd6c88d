#include "haptic_core/base/yaml_map.h"

#include <cmath>
#include <sstream>

#include "haptic_core/base/parse_numbers.h"

namespace haptic {
namespace {

std::string countText(const std::vector<double>& numbers) { return "has " + std::to_string(numbers.size()) + " numbers"; }

}  // namespace

YAML::Node loadYaml(const std::string& path) {
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAllFromFile(path);
    if (documents.size() > 1) {
      throw SetupError(path + ":" + std::to_string(documents[1].Mark().line + 1), "begins a second document", "keep one, without ---");
    }
    return documents.empty() ? YAML::Node() : documents.front();
  } catch (const YAML::BadFile&) {
    throw SetupError(path, "cannot be read", "check the path and its permissions");
  } catch (const YAML::Exception& error) {
    throw SetupError(path + ":" + std::to_string(error.mark.line + 1), "malformed YAML (" + error.msg + ")",
                     "mend this line");
  }
}

YamlMap::YamlMap(const std::string& path, const YAML::Node& node, const std::string& what,
                 const std::set<std::string>& known)
    : path_(path), node_(node), what_(what) {
  if (!node.IsMap()) throw SetupError(where(node), what + " is not a mapping", "write key: value lines");
  std::string list;
  for (const std::string& key : known) list += (list.empty() ? "" : ", ") + key;
  std::set<std::string> met;
  for (const auto& entry : node) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (!met.insert(key).second) throw SetupError(where(entry.first), "key '" + key + "' stands twice in " + what, "keep one of them");
    if (!known.count(key)) throw SetupError(where(entry.first), "unknown key '" + key + "' in " + what, "known: " + list);
  }
}

std::string YamlMap::where(const YAML::Node& node) const { return path_ + ":" + std::to_string(node.Mark().line + 1); }

std::string YamlMap::where(const char* key) const { return where(has(key) ? node_[key] : node_) + ": " + what_ + ": " + key; }

void YamlMap::require(const char* key, const std::string& meaning) const {
  if (!has(key)) throw SetupError(where(), std::string("has no ") + key, "add the " + meaning);
}

std::string YamlMap::text(const char* key, const std::string& otherwise) const {
  if (!has(key)) return otherwise;
  const YAML::Node value = node_[key];
  if (!value.IsScalar()) throw SetupError(where(key), "is not a single value", "write one word or number");
  return value.Scalar();
}

bool YamlMap::flag(const char* key, bool otherwise) const {
  if (!has(key)) return otherwise;
  try {
    return node_[key].as<bool>();
  } catch (const YAML::Exception&) {
    throw SetupError(where(key), "is neither true nor false", "write true or false");
  }
}

std::vector<double> YamlMap::numbers(const char* key) const {
  const YAML::Node value = node_[key];
  std::string all;
  if (value.IsScalar()) all = value.Scalar();
  if (value.IsSequence()) {
    for (const YAML::Node& item : value) all += (item.IsScalar() ? item.Scalar() : "?") + " ";
  }
  const auto parsed = parseNumbers(all);
  bool finite = parsed && !parsed->empty();
  if (finite) {
    for (const double number : *parsed) finite = finite && std::isfinite(number);
  }
  if (!finite) throw SetupError(where(key), "holds no finite numbers", "write a number, or [x, y, z]");
  return *parsed;
}

double YamlMap::number(const char* key, double otherwise, double least, double most) const {
  if (!has(key)) return otherwise;
  const std::vector<double> all = numbers(key);
  if (all.size() != 1) throw SetupError(where(key), countText(all), "write one number");
  if (!(all[0] >= least && all[0] <= most)) {
    std::ostringstream bound;
    bound << "give " << (std::isinf(most) ? "at least " : "") << least;
    if (!std::isinf(most)) bound << " to " << most;
    throw SetupError(where(key), "is " + text(key), bound.str());
  }
  return all[0];
}

Vector3 YamlMap::vector(const char* key, double most) const {
  if (!has(key)) return Vector3::Zero();
  const std::vector<double> all = numbers(key);
  if (all.size() != 3) throw SetupError(where(key), countText(all), "write three: [x, y, z]");
  for (const double number : all) {
    if (std::fabs(number) <= most) continue;
    std::ostringstream is, bound;
    is << "holds " << number;
    bound << "give numbers of a size up to " << most;
    throw SetupError(where(key), is.str(), bound.str());
  }
  return {all[0], all[1], all[2]};
}

}  // namespace haptic
