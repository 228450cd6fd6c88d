#include <yaml-cpp/yaml.h>

#include <Eigen/SVD>
#include <cmath>
#include <fstream>
#include <set>

#include "haptic_core/base/error.h"
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

/// One mapping of the file; remembers which keys it was asked for, so that a misspelt one is an error.
class Section {
 public:
  Section(const std::string& where, const YAML::Node& node) : where_(where), node_(node) {
    if (!node_ || !node_.IsMap())
      throw SetupError(where_, "is not a mapping of keys to values", "see urdf/devices/README.md");
  }

  bool has(const std::string& key) {
    known_.insert(key);
    return static_cast<bool>(node_[key]);
  }

  YAML::Node node(const std::string& key) {
    known_.insert(key);
    return node_[key];
  }

  std::string path(const std::string& key) const { return where_ + ": " + key; }

  template <class T>
  T required(const std::string& key, const char* meaning) {
    if (!has(key)) throw SetupError(path(key), "is missing", std::string("add the ") + meaning);
    try {
      return node_[key].as<T>();
    } catch (const YAML::Exception&) {
      throw SetupError(path(key), "cannot be read", std::string("write the ") + meaning);
    }
  }

  template <class T>
  T optional(const std::string& key, const T& fallback, const char* meaning) {
    return has(key) ? required<T>(key, meaning) : fallback;
  }

  double number(const std::string& key, double fallback, double least, const char* meaning) {
    const double value = optional<double>(key, fallback, meaning);
    if (!std::isfinite(value) || value < least)
      throw SetupError(path(key), "is " + std::to_string(value),
                       std::string("give the ") + meaning + ", at least " + std::to_string(least));
    return value;
  }

  Vector3 vector(const std::string& key, const char* meaning) {
    const auto values = required<std::vector<double>>(key, meaning);
    if (values.size() != 3)
      throw SetupError(path(key), "has " + std::to_string(values.size()) + " numbers",
                       "give three: x, y, z in metres");
    const Vector3 v(values[0], values[1], values[2]);
    if (!v.allFinite()) throw SetupError(path(key), "is not finite", "give three numbers in metres");
    return v;
  }

  void refuseUnknownKeys() const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.as<std::string>();
      if (!known_.count(key))
        throw SetupError(path(key), "is no key of a device file",
                         "remove it or correct its spelling (urdf/devices/README.md)");
    }
  }

 private:
  std::string where_;
  YAML::Node node_;
  std::set<std::string> known_;
};

/// Rows turn the file's axes into REP-103. Makers' axes are x right, y up, z depth: z away from the user
/// makes them left-handed (forward = z), z towards the user right-handed (forward = -z).
Matrix3 axesToRep103(const std::string& axes, Handedness handedness, const Section& section) {
  if (axes == "rep103") return Matrix3::Identity();
  if (axes != "makers")
    throw SetupError(section.path("axes"), "is '" + axes + "'",
                     "write makers (x right, y up, z depth) or rep103 (x forward, y left, z up)");
  const bool left = handedness == Handedness::kLeft || handedness == Handedness::kGuessedLeft;
  Matrix3 m;
  m << 0, 0, left ? 1 : -1, -1, 0, 0, 0, 1, 0;
  return m;
}

Handedness readHandedness(Section& section) {
  const std::string word = section.required<std::string>(
      "handedness", "handedness of the table's axes: right, left, guessed_right or guessed_left");
  if (word == "right") return Handedness::kRight;
  if (word == "left") return Handedness::kLeft;
  if (word == "guessed_right") return Handedness::kGuessedRight;
  if (word == "guessed_left") return Handedness::kGuessedLeft;
  throw SetupError(section.path("handedness"), "is '" + word + "'",
                   "write right, left, guessed_right or guessed_left");
}

StringDef readDrive(Section& section, const StringDef& fallback) {
  StringDef s = fallback;
  s.length_per_count =
      section.optional<double>("length_per_count", s.length_per_count, "metres per encoder count");
  s.volt_per_newton =
      section.optional<double>("volt_per_newton", s.volt_per_newton, "drive voltage per newton of tension");
  s.min_tension = section.optional<double>("min_tension", s.min_tension, "least tension [N]");
  s.max_tension = section.optional<double>("max_tension", s.max_tension, "greatest tension [N]");
  if (section.optional<bool>("invert_count", false, "true where the counter falls while the string pays out"))
    s.length_per_count *= -1;
  if (section.optional<bool>("invert_drive", false, "true where a negative voltage pulls"))
    s.volt_per_newton *= -1;
  return s;
}

StringDef readString(const std::string& where, const YAML::Node& node, const StringDef& defaults,
                     const Matrix3& axes) {
  Section section(where, node);
  StringDef s = readDrive(section, defaults);
  s.p_BE = axes * section.vector("exit", "string exit on the frame [m]");
  s.p_GK = axes * section.vector("knot", "knot on the grip [m]");
  if (section.has("knot_per_opening"))
    s.dp_GK = axes * section.vector("knot_per_opening", "knot's travel per metre of opening");
  section.refuseUnknownKeys();
  if (!std::isfinite(s.length_per_count) || s.length_per_count == 0)
    throw SetupError(section.path("length_per_count"), "is zero or not finite",
                     "give metres per encoder count");
  if (!std::isfinite(s.volt_per_newton) || s.volt_per_newton == 0)
    throw SetupError(section.path("volt_per_newton"), "is zero or not finite", "give volts per newton");
  if (!(s.min_tension > 0))
    throw SetupError(section.path("min_tension"), "is not above zero",
                     "a string needs a little tension to stay wound, e.g. 0.3");
  if (!(s.max_tension > s.min_tension) || !std::isfinite(s.max_tension))
    throw SetupError(section.path("max_tension"), "is not above min_tension",
                     "give min_tension < max_tension in newtons");
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
  const StructureMatrix structure = kinematics.scaledStructure(GripPose{});
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(structure).singularValues();
  int rank = 0;
  for (int k = 0; k < values.size(); ++k) rank += values[k] > kRankTolerance * values[0];
  if (rank < def.dof)
    throw SetupError(def.file + ": strings",
                     "hold only " + std::to_string(rank) + " of " + std::to_string(def.dof) +
                         " degrees of freedom at the home pose (rank)",
                     "move exits or knots so that no motion leaves all lengths unchanged");
}

DeviceDef readDevice(const std::string& path, const YAML::Node& root) {
  Section section(path, root);
  DeviceDef def;
  def.file = path;
  def.name = section.required<std::string>("name", "device's name");
  def.source = section.required<std::string>("source", "source of the table");
  def.note = section.optional<std::string>("note", "", "remarks");
  def.dof = section.required<int>("dof", "degrees of freedom: 3, 6 or 7");
  if (def.dof != 3 && def.dof != 6 && def.dof != 7)
    throw SetupError(section.path("dof"), "is " + std::to_string(def.dof), "write 3, 6 or 7");
  def.handedness = readHandedness(section);
  const Matrix3 axes = axesToRep103(section.optional<std::string>("axes", "rep103", "axes of the table"),
                                    def.handedness, section);
  def.lambda = section.number("lambda", def.lambda, 1e-9, "weight of the squared tension");
  def.border_lambda = section.number("border_lambda", def.border_lambda, 0, "lambda where 1 N is missing");
  def.max_rate_hz = section.number("max_rate", def.max_rate_hz, 1, "highest exchange rate [Hz]");
  def.delay_s = section.number("delay", def.delay_s, 0, "delay of the wire [s]");
  def.max_force = section.number("max_force", def.max_force, 1e-3, "clamp on the force [N]");
  def.max_torque =
      section.number("max_torque", def.max_torque, def.dof == 3 ? 0 : 1e-6, "clamp on the torque [N·m]");
  if (section.has("grip")) {
    Section grip(section.path("grip"), section.node("grip"));
    def.grip_mass = grip.number("mass", def.grip_mass, 1e-4, "mass of the grip [kg]");
    def.grip_radius = grip.number("radius", def.grip_radius, 1e-4, "radius of the grip [m]");
    def.grip_damping = grip.number("damping", def.grip_damping, 0, "damping at the grip [N·s/m]");
    grip.refuseUnknownKeys();
  }
  def.transport = section.optional<std::string>("transport", def.transport,
                                                "transport: twin, uart, usb_sh4 or usb_simple");
  def.boards = section.optional<std::vector<std::string>>("boards", {}, "board models in channel order");

  Section defaults_section(section.path("string_defaults"), section.has("string_defaults")
                                                                ? section.node("string_defaults")
                                                                : YAML::Node(YAML::NodeType::Map));
  const StringDef defaults = readDrive(defaults_section, StringDef{});
  defaults_section.refuseUnknownKeys();
  const YAML::Node strings = section.node("strings");
  if (!strings || !strings.IsSequence())
    throw SetupError(section.path("strings"), "is no list", "list one {exit, knot} per string");
  const int n = static_cast<int>(strings.size());
  if (n < def.dof || n > kMaxStrings)
    throw SetupError(section.path("strings"), "lists " + std::to_string(n) + " strings",
                     "give " + std::to_string(def.dof) + " to " + std::to_string(kMaxStrings));
  for (int i = 0; i < n; ++i)
    def.strings.push_back(
        readString(section.path("strings[" + std::to_string(i) + "]"), strings[i], defaults, axes));
  section.refuseUnknownKeys();
  return def;
}

}  // namespace

DeviceDef loadDevice(const std::string& path) {
  if (!std::ifstream(path))
    throw SetupError(path, "cannot be opened",
                     "give the path of a device file, e.g. urdf/devices/spidar_g6x3r.yaml");
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::Exception& e) {
    throw SetupError(path,
                     std::string("is no YAML (line ") + std::to_string(e.mark.line + 1) + ": " + e.msg + ")",
                     "correct the file");
  }
  const DeviceDef def = readDevice(path, root);
  checkArrangement(def);
  return def;
}

}  // namespace haptic
