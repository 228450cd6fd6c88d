#include "scene/sound_numbers.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "haptic_core/base/parse_numbers.h"
#include "scene/joint_reading.h"
#include "scene/number_bounds.h"
#include "scene/sound_shape.h"

namespace haptic {
namespace {

using Numbers = std::vector<double>;

constexpr double kRoundedMoment = 1e-9;  // of all three: exporters that turn axes leave −5e-20 in place of 0 [1]

std::string written(const Numbers& numbers) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  for (std::size_t i = 0; i < numbers.size(); ++i) text << (i > 0 ? " " : "") << numbers[i];
  return text.str();
}

std::string shortly(double number) {
  std::ostringstream text;
  text.precision(4);
  text << number;
  return text.str();
}

/// Empty: it is absent, or no `count` numbers, which its reader refuses.
Numbers numbersOf(const XmlElement& element, const char* attribute, std::size_t count) {
  const char* text = element.Attribute(attribute);
  const auto numbers = text ? parseNumbers(text) : std::nullopt;
  return numbers && numbers->size() == count ? *numbers : Numbers();
}

bool isPossible(double number, const NumberBounds& bounds) {
  return std::abs(number) <= bounds.largest && (number >= 0 || bounds.negative);
}

bool isImprobable(double number, const NumberBounds& bounds) {
  const double size = std::abs(number);
  return size > 0 && size < kUnlimited && (size < bounds.least || size > bounds.most);
}

/// One link or joint under judgement.
class Judge {
 public:
  Judge(RobotFile& robot, std::string where) : robot_(robot), where_(std::move(where)) {}

  /// "file:line: link 'x': <box> size="0 0 0"".
  std::string named(const XmlElement& element, const char* attribute) const {
    const char* text = element.Attribute(attribute);
    return where_ + ": <" + element.Name() + ">" + (text ? std::string(" ") + attribute + "=\"" + text + "\"" : std::string(" has no ")
        + attribute);
  }
  void replaced(const XmlElement& element, const char* attribute, const std::string& by) const {
    robot_.replaced.push_back(named(element, attribute) + ": " + by);
  }
  void warn(const XmlElement& element, const char* attribute, const std::string& what) const {
    robot_.warnings.push_back(named(element, attribute) + ": " + what);
  }

  /// Each impossible number of the attribute becomes that of its bounds.
  void judge(XmlElement* element, const char* attribute, std::size_t count, const NumberBounds& bounds) const {
    Numbers numbers = element ? numbersOf(*element, attribute, count) : Numbers(), possible;
    const Numbers given = numbers;
    for (double& number : numbers) {
      if (isPossible(number, bounds)) {
        possible.push_back(number);
      } else {
        number = std::strtod(bounds.otherwise, nullptr);
      }
    }
    if (!std::equal(numbers.begin(), numbers.end(), given.begin())) {
      replaced(*element, attribute, isUnlimited(bounds) ? "no limit is taken" : std::string(bounds.otherwise) + " is taken in its place");
      element->SetAttribute(attribute, written(numbers).c_str());
    }
    warnOf(element, attribute, possible, bounds);
  }

  void warnOf(const XmlElement* element, const char* attribute, const Numbers& numbers, const NumberBounds& bounds) const {
    for (const double number : numbers) {
      if (!isImprobable(number, bounds)) continue;
      const bool small = std::abs(number) < bounds.least, angle = std::strcmp(bounds.unit, "rad") == 0;
      warn(*element, attribute,
           (std::strchr("aeiou", bounds.name[0]) ? "an " : "a ") + std::string(bounds.name) + " of " + shortly(number) + " " + bounds.unit
               + (small ? " is less than " : " is more than ") +
               shortly(small ? bounds.least : bounds.most) + ", which robots have; " + bounds.expected +
               (angle ? ": " + shortly(number * M_PI / 180) + " if it is in degrees" : ""));
      return;
    }
    const auto isNoLimit = [](double number) { return std::abs(number) >= kUnlimited && std::isfinite(number); };
    if (std::any_of(numbers.begin(), numbers.end(), isNoLimit)) robot_.notes.push_back(named(*element, attribute) + ": no limit");
  }

  void origin(XmlElement& parent, bool anywhere) const {
    XmlElement* const origin = parent.FirstChildElement("origin");
    NumberBounds place = kPlaceBounds;
    if (anywhere) place.most = place.largest;
    judge(origin, "xyz", 3, place);
    judge(origin, "rpy", 3, kAngleBounds);
    // A quaternion that cannot be right is refused by its reader: any other would be a wrong pose.
  }

  /// A size of 0 beside others is a slab's; a negative one lost its sign. False: nothing sound is near.
  bool size(XmlElement& shape) const {
    const struct {
      const char *kind, *attributes[2];
      std::size_t count;
    } kinds[] = {{"box", {"size", nullptr}, 3},
                 {"sphere", {"radius", nullptr}, 1},
                 {"cylinder", {"radius", "length"}, 1},
                 {"capsule", {"radius", "length"}, 1},
                 {"drake:capsule", {"radius", "length"}, 1}};
    for (const auto& kind : kinds) {
      if (std::strcmp(shape.Name(), kind.kind) != 0) continue;
      double largest = 0;
      for (const char* attribute : kind.attributes) {
        for (const double number : attribute ? numbersOf(shape, attribute, kind.count) : Numbers()) {
          if (!(std::abs(number) <= kSizeBounds.largest)) return replaced(shape, attribute, "is no size: the shape is left out"), false;
          largest = std::max(largest, std::abs(number));
        }
      }
      for (const char* attribute : kind.attributes) {
        Numbers numbers = attribute ? numbersOf(shape, attribute, kind.count) : Numbers();
        if (numbers.empty()) continue;
        if (largest == 0) return replaced(shape, attribute, "has no extent: the shape is left out"), false;
        const Numbers given = numbers;
        for (double& number : numbers) number = number == 0 ? std::min(kSlabThickness, kSlabShare * largest) : std::abs(number);
        if (numbers != given) replaced(shape, attribute, written(numbers) + " is taken in its place");
        if (numbers != given) shape.SetAttribute(attribute, written(numbers).c_str());
        warnOf(&shape, attribute, numbers, kSizeBounds);
      }
    }
    return true;
  }

  /// A factor that is 0 or none becomes another of the three, or 1.
  void scale(XmlElement& mesh) const {
    Numbers numbers = numbersOf(mesh, "scale", 3);
    const Numbers given = numbers;
    double sound = 1;
    const auto isSound = [](double number) { return number != 0 && isPossible(number, kScaleBounds); };
    for (const double number : given) sound = isSound(number) ? std::abs(number) : sound;
    for (double& number : numbers) number = isSound(number) ? number : sound;
    if (numbers.empty()) return;
    if (!std::equal(numbers.begin(), numbers.end(), given.begin())) {
      replaced(mesh, "scale", written(numbers) + " is taken in its place");
      mesh.SetAttribute("scale", written(numbers).c_str());
    }
    warnOf(&mesh, "scale", numbers, kScaleBounds);
    const auto mirrors = [](double number) { return number < 0; };
    if (std::any_of(numbers.begin(), numbers.end(), mirrors)) robot_.notes.push_back(named(mesh, "scale") + ": the mesh is mirrored");
  }

  /// False: no shape is left of the <collision> or <visual>.
  bool shape(XmlElement& part, bool collides) const {
    origin(part, false);
    XmlElement* const geometry = part.FirstChildElement("geometry");
    XmlElement* const given = geometry ? geometry->FirstChildElement() : nullptr;
    if (!given) return true;
    if (std::strcmp(given->Name(), "mesh") == 0) scale(*given);
    return !collides || size(*given);  // who draws leaves out what has no size
  }

  /// True: the moments are to be those of the link's shapes. Without a mass there is no <inertial>.
  bool inertial(XmlElement& link) const {
    XmlElement* const given = link.FirstChildElement("inertial");
    if (!given) return false;
    origin(*given, false);
    const XmlElement* const mass = given->FirstChildElement("mass");
    const Numbers value = mass ? numbersOf(*mass, "value", 1) : Numbers();
    const bool text = mass && mass->Attribute("value") && value.empty();  // its reader refuses it
    if (!text && (value.empty() || !isPossible(value[0], kMassBounds))) {
      replaced(mass ? *mass : *given, mass ? "value" : "mass", "<inertial> is left out, and the link gets the mass of its shapes");
      link.DeleteChild(given);
      ++robot_.inertials_left_out;
      return false;
    }
    if (text) return false;
    warnOf(mass, "value", value, kMassBounds);
    return moments(*given, value[0]);
  }

  bool moments(XmlElement& inertial, double mass) const {
    XmlElement* inertia = inertial.FirstChildElement("inertia");
    const bool none = !inertia;
    if (none) inertia = inertial.InsertNewChildElement("inertia");
    double sum = 0;
    for (const char* entry : {"ixx", "iyy", "izz"}) {
      for (const double moment : numbersOf(*inertia, entry, 1)) sum += std::abs(moment);
    }
    if (mass == 0 && sum > 0) warn(*inertial.FirstChildElement("mass"), "value",
        "the link has moments of inertia and weighs nothing; write its mass in kg");
    bool sound = true;
    for (const char* entry : {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"}) {
      const bool absent = !inertia->Attribute(entry), diagonal = entry[1] == entry[2];
      const Numbers value = numbersOf(*inertia, entry, 1);
      if (!absent && value.empty()) return false;  // its reader refuses the text
      const bool possible = !absent && isPossible(value[0], kMomentBounds) && !(diagonal && value[0] < -kRoundedMoment * sum);
      if (absent ? !(diagonal && mass > 0) : possible) continue;
      if (sound) {
        const std::string by = "the link's mass is spread over its shapes, or over a ball of 20 mm where it has none";
        none ? robot_.replaced.push_back(where_ + ": <inertial> has no <inertia>: " + by) : replaced(*inertia, entry, by);
      }
      sound = false;
    }
    for (const char* entry : {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"}) {
      if (!sound || !inertia->Attribute(entry)) inertia->SetAttribute(entry, "0");
    }
    return !sound;
  }

  void axis(XmlElement& joint) const {
    XmlElement* const axis = joint.FirstChildElement("axis");
    Numbers numbers = axis ? numbersOf(*axis, "xyz", 3) : Numbers();
    if (numbers.empty()) return;
    double largest = 0;
    for (const double number : numbers) largest = std::isfinite(number) ? std::max(largest, std::abs(number)) : INFINITY;
    if (!(largest > 0) || std::isinf(largest)) {
      replaced(*axis, "xyz", "is no direction: URDF's default 1 0 0 is taken in its place");
      axis->SetAttribute("xyz", "1 0 0");
    } else if (largest < 1e-6 || largest > 1e6) {
      warn(*axis, "xyz", "its axis has length " + shortly(largest) + " and is normalised");
      for (double& number : numbers) number /= largest;
      axis->SetAttribute("xyz", written(numbers).c_str());
    }
  }

  void limits(XmlElement& joint, const std::string& type) const {
    XmlElement* const limit = joint.FirstChildElement("limit");
    if (!limit) return;
    const bool slides = type == "prismatic";
    judge(limit, "effort", 1, kEffortBounds);
    judge(limit, "velocity", 1, slides ? kSlideSpeedBounds : kTurnSpeedBounds);
    const Numbers effort = numbersOf(*limit, "effort", 1), velocity = numbersOf(*limit, "velocity", 1);
    if (!effort.empty() && effort[0] > 0 && velocity == Numbers{0}) warn(*limit, "velocity",
        "its drive may not move; write its largest velocity");
    if (type != "revolute" && !slides) return;
    Numbers ends[2];
    for (const char* end : {"lower", "upper"}) {
      NumberBounds bounds = slides ? kSlideLimitBounds : kTurnLimitBounds;
      if (*end == 'l') bounds.otherwise = "-1e9";
      judge(limit, end, 1, bounds);
      ends[*end == 'u'] = numbersOf(*limit, end, 1);
    }
    const double lower = ends[0].empty() ? 0 : ends[0][0], upper = ends[1].empty() ? 0 : ends[1][0];
    if (lower > upper) {
      replaced(*limit, "lower", "is above upper=\"" + shortly(upper)
          + "\": no limits are taken, as Bullet's files mean it; swap them if they are swapped");
      limit->SetAttribute("lower", "-1e9");
      limit->SetAttribute("upper", "1e9");
    } else if (lower < upper && upper - lower < (slides ? kLeastSlide : kLeastTurn)) {
      warn(*limit, "upper", "lies " + shortly(upper - lower) + (slides ? " m" : " rad") + " above the lower limit, too little to move; " +
                                (slides ? kSlideLimitBounds : kTurnLimitBounds).expected);
    }
  }

  void mimic(XmlElement& joint) const {
    XmlElement* const mimic = joint.FirstChildElement("mimic");
    if (!mimic) return;
    const Numbers multiplier = numbersOf(*mimic, "multiplier", 1);
    if (!multiplier.empty() && !isPossible(multiplier[0], kMultiplierBounds)) {
      replaced(*mimic, "multiplier", "cannot be followed: <mimic> is left out, and the joint moves by itself");
      joint.DeleteChild(mimic);
      return;
    }
    warnOf(mimic, "multiplier", multiplier, kMultiplierBounds);
    judge(mimic, "offset", 1, kOffsetBounds);
  }

 private:
  static bool isUnlimited(const NumberBounds& bounds) { return std::abs(std::strtod(bounds.otherwise, nullptr)) == kUnlimited; }

  RobotFile& robot_;
  std::string where_;
};

void makeLinkSound(RobotFile& robot, LinkXml& link) {
  const Judge judge(robot, robot.at(link));
  link.spread_inertia = judge.inertial(*link.element);
  const auto leftOut = [&](XmlElement* collision) {
    if (Judge(robot, robot.xml.at(*collision) + ": link '" + link.name + "'").shape(*collision, true)) return false;
    ++robot.collisions_left_out;
    return true;
  };
  link.collisions.erase(std::remove_if(link.collisions.begin(), link.collisions.end(), leftOut), link.collisions.end());
  for (XmlElement* visual = link.element->FirstChildElement("visual"); visual; visual = visual->NextSiblingElement("visual")) {
    Judge(robot, robot.xml.at(*visual) + ": link '" + link.name + "'").shape(*visual, false);
  }
}

}  // namespace

void makeNumbersSound(RobotFile& robot) {
  for (LinkXml& link : robot.links) makeLinkSound(robot, link);
  for (JointXml& joint : robot.joints) {
    const XmlElement* const limit = joint.element->FirstChildElement("limit");
    joint.says_effort = limit && limit->Attribute("effort");
    const Judge judge(robot, robot.at(joint));
    // Bodies of a scene lie where they are put.
    judge.origin(*joint.element, joint.type == "floating" || robot.links[joint.parent].name == "world");
    if (joint.type == "fixed") continue;  // published files leave zeros in what means nothing there
    if (const JointKind* kind = kindOf(joint); kind && hasAxis(*kind)) judge.axis(*joint.element);
    judge.limits(*joint.element, joint.type);
    XmlElement* const dynamics = joint.element->FirstChildElement("dynamics");
    judge.judge(dynamics, "damping", 1, kDampingBounds);
    judge.judge(dynamics, "friction", 1, kFrictionBounds);
    judge.mimic(*joint.element);
  }
}

}  // namespace haptic
