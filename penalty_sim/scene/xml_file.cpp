#include "scene/xml_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "haptic_core/base/parse_numbers.h"
#include "haptic_core/base/plain_text.h"
#include "scene/text_file.h"

namespace haptic {
namespace {

constexpr char kSpace[] = " \t\r\n";

std::string elementAt(const XmlFile& file, const XmlElement& element) {
  return file.at(element) + ": <" + element.Name() + ">";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// The parser's error in words.
std::string reason(const tinyxml2::XMLDocument& document) {
  switch (document.ErrorID()) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "an element is not closed by its own end tag";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute is not name=\"value\", or stands there twice";
    case tinyxml2::XML_ERROR_PARSING_ELEMENT:
      return "an element is broken";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "a comment does not end";
    case tinyxml2::XML_ERROR_PARSING:
      return "text after the end of the root element, or a tag that does not end";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return "elements are nested too deeply";
    case tinyxml2::XML_ERROR_EMPTY_DOCUMENT:
      return "there is no element";
    default:
      return document.ErrorName();
  }
}

int lineAt(const std::string& text, std::size_t at) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// The end of what begins with '<' at `at` and is no element: comment, CDATA, declaration, end tag; `at`
/// itself for an element.
std::size_t endOfOther(const std::string& text, std::size_t at) {
  constexpr struct {
    const char *begin, *end;
  } kOthers[] = {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"<!", ">"}, {"</", ">"}};
  for (const auto& [begin, end] : kOthers) {
    if (text.compare(at, std::strlen(begin), begin) == 0) return text.find(end, at + std::strlen(begin));
  }
  return at;
}

/// In the order of the file; null behind the last.
XmlElement* nextOf(XmlElement& element) {
  if (XmlElement* child = element.FirstChildElement()) return child;
  for (tinyxml2::XMLNode* at = &element; at; at = at->Parent()) {
    if (XmlElement* next = at->NextSiblingElement()) return next;
  }
  return nullptr;
}

/// The parser takes a time quadratic in the attributes of one element, so they are counted before it begins.
void refuseManyAttributes(const std::string& path, const std::string& text) {
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::size_t other = endOfOther(text, at);
    if (other == std::string::npos) return;  // the parser says what does not end
    if (other != at) {
      at = other;
      continue;
    }
    int attributes = 0;
    std::size_t next = text.find_first_of("\"'>", at);
    for (; next != std::string::npos && text[next] != '>'; next = text.find_first_of("\"'>", next + 1)) {
      if (++attributes > XmlFile::kMaxAttributes) {
        throw SetupError(
            path + ":" + std::to_string(lineAt(text, at)),
            "an element has more than " + std::to_string(XmlFile::kMaxAttributes) + " attributes",
            "this is no robot description");
      }
      next = text.find(text[next], next + 1);
      if (next == std::string::npos) return;
    }
    if (next == std::string::npos) return;
    at = next;
  }
}

}  // namespace

XmlFile::XmlFile(const std::string& path) : XmlFile(path, readTextFile(path)) {}

XmlFile::XmlFile(const std::string& path, const std::string& text) : path_(path), text_(withoutByteOrderMark(text)) {
  takeZeroBytes();
  takeOtherEncodings();
  if (text_.find_first_not_of(kSpace) == std::string::npos) {
    throw SetupError(path, "is empty", "a scene needs a <robot> element");
  }
  refuseManyAttributes(path, text_);
  if (document_.Parse(text_.c_str(), text_.size()) != tinyxml2::XML_SUCCESS) {
    throw SetupError(path + ":" + std::to_string(document_.ErrorLineNum()),
                     "malformed XML (" + reason(document_) + ")", "mend the XML near this line");
  }
  if (!document_.RootElement())
    throw SetupError(path, "has no XML element", "a scene needs a <robot> element");
  makeAttributesPlain();
}

/// Zero bytes, which exporters in C leave at the end of a text or of a string, become blanks where the rest is XML.
void XmlFile::takeZeroBytes() {
  const std::size_t first = text_.find('\0');
  if (first == std::string::npos) return;
  if (text_.compare(0, 2, "\xff\xfe") == 0 || text_.compare(0, 2, "\xfe\xff") == 0)
    throw SetupError(path_, "is UTF-16", "save it as UTF-8");
  const std::size_t word = text_.find_first_not_of(kSpace);
  if (word == std::string::npos || text_[word] != '<')
    throw SetupError(path_, "is a binary file", "expected XML text");
  const auto zeros = std::count(text_.begin(), text_.end(), '\0');
  const int line = lineAt(text_, first);
  std::replace(text_.begin(), text_.end(), '\0', ' ');
  warnings_.push_back(path_ + ":" + std::to_string(line) + ": has " + std::to_string(zeros) + " NUL byte" +
                      (zeros > 1 ? "s, the first" : "") + " in this line, read as blanks; take them out");
}

void XmlFile::takeOtherEncodings() {
  const std::string valid = validUtf8(text_);
  if (valid == text_) return;
  const auto first = std::mismatch(text_.begin(), text_.end(), valid.begin()).first - text_.begin();
  warnings_.push_back(
      path_ + ":" + std::to_string(lineAt(text_, static_cast<std::size_t>(first))) +
      ": has bytes that are no UTF-8, the first in this line, read as Latin-1; save it as UTF-8");
  text_ = valid;
}

/// XML reads line breaks within attributes as blanks, which the parser does not. References such as &#1; bring other
/// control characters.
void XmlFile::makeAttributesPlain() {
  bool said = false;
  for (XmlElement* element = root(); element; element = nextOf(*element)) {
    for (const auto* attribute = element->FirstAttribute(); attribute; attribute = attribute->Next()) {
      const std::string given = attribute->Value(), plain = plainText(given);
      if (plain == given) continue;
      element->SetAttribute(std::string(attribute->Name()).c_str(), plain.c_str());
      std::string unbroken = given;
      std::replace_if(
          unbroken.begin(), unbroken.end(), [](char c) { return c == '\t' || c == '\r' || c == '\n'; }, ' ');
      if (unbroken == plain || said) continue;
      said = true;
      warnings_.push_back(at(*element) + ": <" + element->Name() + "> has control characters in " +
                          attribute->Name() + ", read as blanks; take them out");
    }
  }
}

std::optional<std::vector<double>> readNumbers(const XmlFile& file, const XmlElement& element,
                                               const char* attribute, std::size_t count) {
  const char* text = element.Attribute(attribute);
  if (!text) return std::nullopt;
  const auto numbers = parseNumbers(text);
  const std::string expected = count == 1 ? "one number" : std::to_string(count) + " numbers";
  if (!numbers || numbers->size() != count) {
    throw SetupError(elementAt(file, element),
                     std::string(attribute) + "=\"" + text + "\" is not " + expected,
                     "write " + expected + " separated by spaces");
  }
  for (double number : *numbers) {
    if (!std::isfinite(number)) {
      throw SetupError(elementAt(file, element), std::string(attribute) + "=\"" + text + "\" is not finite",
                       "write a finite number");
    }
  }
  return numbers;
}

std::optional<double> readNumber(const XmlFile& file, const XmlElement& element, const char* attribute) {
  const auto numbers = readNumbers(file, element, attribute, 1);
  return numbers ? std::optional<double>((*numbers)[0]) : std::nullopt;
}

std::optional<Vector3> readVector(const XmlFile& file, const XmlElement& element, const char* attribute) {
  const auto numbers = readNumbers(file, element, attribute, 3);
  return numbers ? std::optional<Vector3>(Vector3((*numbers)[0], (*numbers)[1], (*numbers)[2]))
                 : std::nullopt;
}

Pose readPose(const XmlFile& file, const XmlElement& element, const char* xyz, const char* rpy) {
  const Vector3 p = readVector(file, element, xyz).value_or(Vector3::Zero());
  return {rotationFromRpy(readVector(file, element, rpy).value_or(Vector3::Zero())), p};
}

Pose readOrigin(const XmlFile& file, const XmlElement& parent) {
  const XmlElement* origin = parent.FirstChildElement("origin");
  if (!origin) return Pose();
  const auto xyzw = readNumbers(file, *origin, "quat_xyzw", 4);
  if (!xyzw) return readPose(file, *origin);
  if (origin->Attribute("rpy")) {
    throw SetupError(elementAt(file, *origin), "has both rpy and quat_xyzw", "take one of them out");
  }
  // Scaled first: the square of 1e200 is no number.
  const Eigen::Vector4d given(xyzw->data());
  const double largest = given.cwiseAbs().maxCoeff();
  if (largest == 0)
    throw SetupError(elementAt(file, *origin), "quat_xyzw is zero, which is no rotation",
                     "write 0 0 0 1 for none");
  const Eigen::Vector4d unit = (given / largest).normalized();
  return {Quaternion(unit[3], unit[0], unit[1], unit[2]),
          readVector(file, *origin, "xyz").value_or(Vector3::Zero())};
}

std::string readName(const XmlFile& file, const XmlElement& element, const char* attribute) {
  const char* text = element.Attribute(attribute);
  if (!text || !*text) {
    throw SetupError(elementAt(file, element), std::string("has no ") + attribute,
                     std::string("give it ") + attribute + "=\"...\"");
  }
  return text;
}

std::string readOwnName(const XmlFile& file, const XmlElement& element) {
  const std::string name = readName(file, element, "name");
  if (name.size() > kMaxNameBytes) {
    throw SetupError(elementAt(file, element), "its name has " + std::to_string(name.size()) + " bytes",
                     "write at most " + std::to_string(kMaxNameBytes));
  }
  return name;
}

void refuseUnknownAttributes(const XmlFile& file, const XmlElement& element,
                             const std::vector<std::string>& known) {
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    if (std::find(known.begin(), known.end(), attribute->Name()) == known.end()) {
      throw SetupError(elementAt(file, element), std::string("unknown attribute '") + attribute->Name() + "'",
                       "known: " + joined(known));
    }
  }
}

}  // namespace haptic
