#include "browser/picture.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/model.h"

namespace haptic {
namespace {

/// Text within quotes of JSON.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : SetupError::oneLine(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

template <class Numbers>
std::string listOf(const Numbers& numbers, int count) {
  std::ostringstream out;
  out.precision(9);
  for (int i = 0; i < count; ++i) out << (i ? "," : "[") << numbers[i];
  return out.str() + "]";
}
std::string listOf(const Vector3& v) { return listOf(v, 3); }

std::array<double, 7> numbersOf(const Pose& X) {
  const Quaternion q(X.R);
  return {X.p.x(), X.p.y(), X.p.z(), q.x(), q.y(), q.z(), q.w()};
}
std::string listOf(const Pose& X) { return listOf(numbersOf(X), 7); }

/// [item, item...] of JSON.
template <class List, class Text>
std::string each(const List& list, Text text) {
  std::string out = "[";
  for (std::size_t i = 0; i < list.size(); ++i) out += (i ? "," : "") + text(list[i], i);
  return out + "]";
}

std::string textOf(const StringDef& string) {
  return "{\"exit\":" + listOf(string.p_BE) + ",\"knot\":" + listOf(string.p_GK) + ",\"travel\":" + listOf(string.dp_GK) + "}";
}

std::string textOf(const DrawnHand& hand) {
  std::ostringstream out;
  out << "{\"name\":" << quoted(hand.name) << ",\"scale\":" << hand.workspace.scale << ",\"pose\":" << listOf(hand.workspace.X_WB)
      << ",\"radius\":" << hand.device.grip_radius << ",\"mostForce\":" << hand.device.max_force << ",\"strings\":"
      << each(hand.device.strings, [](const StringDef& string, std::size_t) { return textOf(string); }) << "}";
  return out.str();
}

void append(std::vector<double>& out, const Vector3& v) { out.insert(out.end(), {v.x(), v.y(), v.z()}); }
void append(std::vector<double>& out, const Pose& X) {
  const auto numbers = numbersOf(X);
  out.insert(out.end(), numbers.begin(), numbers.end());
}

void appendHand(std::vector<double>& out, const HandReport& hand, const Spidar& device) {
  append(out, hand.X_BG);
  append(out, hand.F_asked_B.force);
  append(out, hand.F_achieved_B.force);
  out.insert(out.end(), {hand.stiffness, device.stableStiffness(), hand.stiffness_share, static_cast<double>(hand.in_contact),
                         static_cast<double>(device.state() == DeviceState::kEnabled), hand.port_energy});
  for (Eigen::Index s = 0; s < hand.tension.size(); ++s) out.push_back(hand.tension[s]);
}

}  // namespace

std::string pictureText(const SceneDef& scene, const World& world, const std::vector<DrawnHand>& hands, const std::string& about) {
  std::ostringstream out;
  const Model& model = world.model();
  out << "{\"name\":" << quoted(scene.world.name) << ",\"about\":" << quoted(about) << ",\"step\":" << world.settings().step
      << ",\"layout\":{\"head\":" << Picture::kHead << ",\"perHand\":" << Picture::kPerHand << ",\"patchNumbers\":"
      << Picture::kPatchNumbers << ",\"mostPatches\":" << Picture::kMostPatches << "},\"links\":"
      << each(model.links, [&](const auto& link, std::size_t i) {
           return "{\"name\":" + quoted(world.linkName(static_cast<int>(i))) + ",\"moves\":" + (link.moves ? "true" : "false") +
                  ",\"pose\":" + listOf(world.linkPose(static_cast<int>(i))) + "}";
         })
      << ",\"visuals\":" << each(scene.visuals, [&](const VisualDef& visual, std::size_t i) {
           return "{\"link\":" + std::to_string(model.link(visual.articulation, visual.link)) + ",\"shape\":\"" + nameOf(visual.shape) +
                  "\",\"mesh\":" + std::to_string(i) + ",\"size\":" + listOf(visual.size) + ",\"pose\":" + listOf(visual.X_LV) +
                  ",\"colour\":" + listOf(visual.colour, 4) + "}";
         })
      << ",\"hands\":" << each(hands, [](const DrawnHand& hand, std::size_t) { return textOf(hand); }) << "}";
  return out.str();
}

void Picture::draw(HapticLoop& loop, const std::vector<DrawnHand>& hands, std::vector<double>& out) {
  const World& world = loop.world();
  const StepReport& step = world.report();
  const int patches = std::min(world.contactCount(), kMostPatches);
  out.clear();
  out.insert(out.end(), {world.time(), static_cast<double>(world.linkCount()), static_cast<double>(hands.size()),
                         static_cast<double>(patches), static_cast<double>(world.contactCount()),
                         static_cast<double>(step.implicit_islands), static_cast<double>(step.finite), static_cast<double>(step.flags),
                         step.energy.total(), step.energy.numerical, step.energy.balance()});
  for (int i = 0; i < world.linkCount(); ++i) append(out, world.linkPose(i));
  for (std::size_t i = 0; i < hands.size(); ++i) {
    const std::size_t end = out.size() + kPerHand + hands[i].device.strings.size();
    if (static_cast<int>(i) < loop.handCount()) {
      appendHand(out, loop.report().hand[i], loop.hand(static_cast<int>(i)).device());
    } else {
      append(out, Pose());
    }
    out.resize(end);
  }
  for (int i = 0; i < patches; ++i) {
    const ContactReport& c = world.contact(i);
    append(out, c.X_WP.p);
    append(out, Vector3(c.X_WP.R.col(2)));
    append(out, c.F_BP_W.force);
    out.insert(out.end(), {std::sqrt(c.area / M_PI), c.area > 0 ? c.normal_force / c.area : 0, static_cast<double>(c.sticking)});
  }
}

}  // namespace haptic
