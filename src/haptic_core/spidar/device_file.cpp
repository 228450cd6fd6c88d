#include <cmath>

#include "haptic_core/base/yaml_map.h"
#include "haptic_core/spidar/device_check.h"
#include "haptic_core/spidar/device_def.h"
#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {
namespace {

// Two strings closer than this at the home pose rub or share a pulley: the device cannot be built like this
// [m].
constexpr double kClosestStrings = 1e-4;
// Exits closer than this are one hole: their strings carry one equation instead of two [m].
constexpr double kClosestExits = 1e-3;
// Singular values of the scaled structure matrix below this share of the largest count as zero: the pose
// would be uncertain by 1000 times the encoder step.
constexpr double kRankTolerance = 1e-3;

// Bounds of numbers: far beyond every device that a person can hold, far within what squares and products of them bear in
// double precision. A number outside is a slip of unit or of the pen.
constexpr double kFarthest = 100;                           // of an exit or a knot from its origin [m]
constexpr double kFinestCount = 1e-9, kCoarsestCount = 0.1;  // string per encoder count [m]
constexpr double kLeastVolt = 1e-6, kMostVolt = 1e3;        // drive per tension [V/N]
constexpr double kLeastTension = 1e-3;                      // [N] below it a string lies slack on its reel
constexpr double kMostTension = 1e4;                        // [N]; a force likewise
constexpr double kMostTorque = 1e3;                         // [N·m]
constexpr double kMostWeight = 1e3;                         // λ [1]: at 1 the tensions count as much as the wrench
constexpr double kMostRate = 1e6;                           // of a wire [Hz]
constexpr double kMostDelay = 1;                            // [s]

/// Of one string, or of all of them.
const std::set<std::string> kDriveKeys = {"length_per_count", "volt_per_newton", "min_tension",
                                          "max_tension",      "invert_count",    "invert_drive"};

/// Rows turn the file's axes into REP-103. Makers' axes are x right, y up, z depth: z away from the user
/// makes them left-handed (forward = z), z towards the user right-handed (forward = -z).
Matrix3 axesToRep103(const std::string& axes, Handedness handedness, const YamlMap& map) {
  if (axes == "rep103") return Matrix3::Identity();
  if (axes != "makers")
    throw SetupError(map.where("axes"), "is '" + axes + "'",
                     "write makers (x right, y up, z depth) or rep103 (x forward, y left, z up)");
  const bool left = handedness == Handedness::kLeft || handedness == Handedness::kGuessedLeft;
  Matrix3 m;
  m << 0, 0, left ? 1 : -1, -1, 0, 0, 0, 1, 0;
  return m;
}

Handedness readHandedness(const YamlMap& map) {
  map.require("handedness", "handedness of the table's axes: right, left, guessed_right or guessed_left");
  const std::string word = map.text("handedness");
  if (word == "right") return Handedness::kRight;
  if (word == "left") return Handedness::kLeft;
  if (word == "guessed_right") return Handedness::kGuessedRight;
  if (word == "guessed_left") return Handedness::kGuessedLeft;
  throw SetupError(map.where("handedness"), "is '" + word + "'", "write right, left, guessed_right or guessed_left");
}

StringDef readDrive(const YamlMap& map, const StringDef& fallback) {
  StringDef s = fallback;
  s.length_per_count = map.number("length_per_count", s.length_per_count, -kCoarsestCount, kCoarsestCount);
  s.volt_per_newton = map.number("volt_per_newton", s.volt_per_newton, -kMostVolt, kMostVolt);
  s.min_tension = map.number("min_tension", s.min_tension, 0, kMostTension);
  s.max_tension = map.number("max_tension", s.max_tension, 0, kMostTension);
  if (map.flag("invert_count", false)) s.length_per_count *= -1;  // the counter falls while the string pays out
  if (map.flag("invert_drive", false)) s.volt_per_newton *= -1;   // a negative voltage pulls
  return s;
}

StringDef readString(const std::string& path, const YAML::Node& node, int index, const StringDef& defaults,
                     const Matrix3& axes) {
  std::set<std::string> known = kDriveKeys;
  known.insert({"exit", "knot", "knot_per_opening"});
  const YamlMap map(path, node, "strings[" + std::to_string(index) + "]", known);
  StringDef s = readDrive(map, defaults);
  map.require("exit", "string's exit on the frame [m]");
  map.require("knot", "knot on the grip [m]");
  s.p_BE = axes * map.vector("exit", kFarthest);
  s.p_GK = axes * map.vector("knot", kFarthest);
  s.dp_GK = axes * map.vector("knot_per_opening", kFarthest);
  if (std::fabs(s.length_per_count) < kFinestCount)
    throw SetupError(map.where("length_per_count"), "is zero, or next to it", "give metres per encoder count");
  if (std::fabs(s.volt_per_newton) < kLeastVolt)
    throw SetupError(map.where("volt_per_newton"), "is zero, or next to it", "give volts per newton");
  if (!(s.min_tension >= kLeastTension))
    throw SetupError(map.where("min_tension"), "is zero, or next to it",
                     "a string needs a little tension to stay wound, e.g. 0.3");
  if (!(s.max_tension > s.min_tension))
    throw SetupError(map.where("max_tension"), "is not above min_tension", "give min_tension < max_tension in newtons");
  return s;
}

void checkArrangement(const DeviceDef& def) {
  const int n = static_cast<int>(def.strings.size());
  for (int i = 0; i < n; ++i) {
    const StringDef& a = def.strings[i];
    const std::string where = def.file + ": strings[" + std::to_string(i) + "]";
    if ((a.p_BE - a.p_GK).norm() < kClosestExits)
      throw SetupError(where, "has its exit at its knot", "exit and knot must be apart at the home pose");
    for (int j = 0; j < i; ++j) {
      const StringDef& b = def.strings[j];
      const std::string pair = where + " and strings[" + std::to_string(j) + "]";
      if ((a.p_BE - b.p_BE).norm() < kClosestExits)
        throw SetupError(pair, "have coincident exits",
                         "give each string its own exit, at least 1 mm from the others");
      const bool one_knot = (a.p_GK - b.p_GK).norm() < kClosestStrings;
      if (!one_knot && segmentDistance(a.p_BE, a.p_GK, b.p_BE, b.p_GK) < kClosestStrings)
        throw SetupError(pair, "cross at the home pose", "swap their exits or knots");
    }
  }
  const StringKinematics kinematics(def);
  const Eigen::VectorXd values = kinematics.singularValues(GripPose{});
  int rank = 0;
  for (int k = 0; k < values.size(); ++k) rank += values[k] > kRankTolerance * values[0];
  if (rank < def.dof)
    throw SetupError(def.file + ": strings",
                     "hold only " + std::to_string(rank) + " of " + std::to_string(def.dof) +
                         " degrees of freedom at the home pose (rank)",
                     "move exits or knots so that no motion leaves all lengths unchanged");
}

std::vector<std::string> readBoards(const YamlMap& map) {
  if (!map.has("boards")) return {};
  try {
    return map["boards"].as<std::vector<std::string>>();
  } catch (const YAML::Exception&) {
    throw SetupError(map.where("boards"), "is no list of words", "write the board models in channel order");
  }
}

void readGrip(const std::string& path, const YAML::Node& node, DeviceDef& def) {
  const YamlMap grip(path, node, "grip", {"mass", "radius", "damping"});
  def.grip_mass = grip.number("mass", def.grip_mass, 1e-4, 100);
  def.grip_radius = grip.number("radius", def.grip_radius, 1e-4, 10);
  def.grip_damping = grip.number("damping", def.grip_damping, 0, 1e4);
}

void readStrings(const std::string& path, const YamlMap& map, const Matrix3& axes, DeviceDef& def) {
  StringDef defaults;
  if (map.has("string_defaults")) {
    defaults = readDrive(YamlMap(path, map["string_defaults"], "string_defaults", kDriveKeys), defaults);
  }
  map.require("strings", "strings: one {exit, knot} each");
  const YAML::Node strings = map["strings"];
  if (!strings.IsSequence()) throw SetupError(map.where("strings"), "is no list", "list one {exit, knot} per string");
  const int n = static_cast<int>(strings.size());
  if (n < def.dof || n > kMaxStrings)
    throw SetupError(map.where("strings"), "lists " + std::to_string(n) + " strings",
                     "give " + std::to_string(def.dof) + " to " + std::to_string(kMaxStrings));
  for (int i = 0; i < n; ++i) def.strings.push_back(readString(path, strings[i], i, defaults, axes));
}

DeviceDef readDevice(const std::string& path, const YAML::Node& root) {
  const YamlMap map(path, root, "device",
                    {"name", "source", "note", "dof", "handedness", "axes", "lambda", "border_lambda", "max_rate", "delay",
                     "max_force", "max_torque", "grip", "transport", "boards", "string_defaults", "strings"});
  DeviceDef def;
  def.file = path;
  map.require("name", "device's name");
  map.require("source", "source of the table");
  map.require("dof", "degrees of freedom: 3, 6 or 7");
  def.name = map.text("name");
  def.source = map.text("source");
  def.note = map.text("note");
  const double dof = map.number("dof", 0);
  if (dof != 3 && dof != 6 && dof != 7) throw SetupError(map.where("dof"), "is " + map.text("dof"), "write 3, 6 or 7");
  def.dof = static_cast<int>(dof);
  def.handedness = readHandedness(map);
  const Matrix3 axes = axesToRep103(map.text("axes", "rep103"), def.handedness, map);
  def.lambda = map.number("lambda", def.lambda, 1e-9, kMostWeight);
  def.border_lambda = map.number("border_lambda", def.border_lambda, 0, kMostWeight);
  def.max_rate_hz = map.number("max_rate", def.max_rate_hz, 1, kMostRate);
  def.delay_s = map.number("delay", def.delay_s, 0, kMostDelay);
  def.max_force = map.number("max_force", def.max_force, 1e-3, kMostTension);
  def.max_torque = map.number("max_torque", def.max_torque, def.dof == 3 ? 0 : 1e-6, kMostTorque);
  if (map.has("grip")) readGrip(path, map["grip"], def);
  def.transport = map.text("transport", def.transport);
  def.boards = readBoards(map);
  readStrings(path, map, axes, def);
  return def;
}

}  // namespace

DeviceDef loadDevice(const std::string& path) {
  const DeviceDef def = readDevice(path, loadYaml(path));
  checkArrangement(def);
  return def;
}

}  // namespace haptic
