/// An XML file with line numbers: opening it, and reading attributes as numbers, vectors and poses.
#pragma once
#include <tinyxml2.h>

#include <optional>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/base/spatial.h"

namespace haptic {

/// An element with its line number.
using XmlElement = tinyxml2::XMLElement;

/// A parsed file. Elements are owned by the document and live as long as it.
class XmlFile {
 public:
  /// Reads and parses `path`. Throws SetupError as readTextFile does (text_file.h), and: empty, malformed (with the line).
  explicit XmlFile(const std::string& path);
  /// Parses `text`, which `path` stands for in messages. Afterwards all attributes are valid UTF-8 without
  /// line breaks and other control characters, so that names can go to ROS, JSON and Python. Throws
  /// SetupError: empty, no text, malformed, or an element with more than kMaxAttributes attributes (with the
  /// line).
  XmlFile(const std::string& path, const std::string& text);

  /// As it was opened.
  const std::string& path() const { return path_; }
  /// The document's element, never null.
  XmlElement* root() { return document_.RootElement(); }
  /// The document's element, never null.
  const XmlElement* root() const { return document_.RootElement(); }
  /// What was parsed.
  const std::string& text() const { return text_; }
  /// Of bytes that no XML has, and how they were read.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// "path:line" of an element.
  std::string at(const XmlElement& element) const {
    return path_ + ":" + std::to_string(element.GetLineNum());
  }

  /// The parser compares each attribute with all before it: at 200 000 in one element it takes a minute. None
  /// of ours has 40.
  static constexpr int kMaxAttributes = 100;

 private:
  void takeZeroBytes();
  void takeOtherEncodings();
  void makeAttributesPlain();

  std::string path_, text_;
  std::vector<std::string> warnings_;
  tinyxml2::XMLDocument document_;
};

/// One attribute as `count` finite numbers. Nothing when it is absent. Throws SetupError naming file, line,
/// element and attribute when it is there and is not that.
std::optional<std::vector<double>> readNumbers(const XmlFile& file, const XmlElement& element,
                                               const char* attribute, std::size_t count);
/// One finite number; likewise.
std::optional<double> readNumber(const XmlFile& file, const XmlElement& element, const char* attribute);
/// Three finite numbers; likewise.
std::optional<Vector3> readVector(const XmlFile& file, const XmlElement& element, const char* attribute);

/// The pose in attributes `xyz` and `rpy` (URDF: fixed axes, roll about x first), or of a child <origin>.
Pose readPose(const XmlFile& file, const XmlElement& element, const char* xyz = "xyz",
              const char* rpy = "rpy");
/// The pose of a child `<origin>`, without one the identity. Its rotation is `rpy`, or `quat_xyzw` (URDF 1.1:
/// x y z w, of any length but 0), whatever version the file says. Throws SetupError as readNumbers does, and
/// for both rotations at once.
Pose readOrigin(const XmlFile& file, const XmlElement& parent);

/// A non-empty attribute. Throws SetupError when it is absent or empty.
std::string readName(const XmlFile& file, const XmlElement& element, const char* attribute);

/// Names of robots, links and joints become those of frames, topics and columns [bytes].
inline constexpr std::size_t kMaxNameBytes = 256;
/// The attribute `name` as readName reads it. Throws SetupError when it is longer than kMaxNameBytes.
std::string readOwnName(const XmlFile& file, const XmlElement& element);

/// Refuses attributes of `element` that are not in `known`; names them and the known ones.
void refuseUnknownAttributes(const XmlFile& file, const XmlElement& element,
                             const std::vector<std::string>& known);

}  // namespace haptic
