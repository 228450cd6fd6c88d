#include "haptic_core/analysis/hand_certificate.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <vector>

#include "haptic_core/analysis/flat_wall.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/wall_bound.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/tuning.h"

namespace haptic {
namespace {

constexpr int kMostSides = 32;  ///< of a shape's faces; a ball's are alike
constexpr double kSoughtFoundations = 100;  ///< [1] times the scene's stiffness: a slider goes no further
constexpr double kStiffestFoundation = 1e13;  ///< [N/m³] stiffer than steel of 10 cm: no hand tells the difference

/// The stiffest pair of surfaces that the pointer can bring together.
struct Partner {
  int own = -1, other = -1;            ///< shapes
  double foundation = 0;               ///< [N/m³]
};

Partner stiffestPartner(const Model& model, int link) {
  Partner best;
  const int count = static_cast<int>(model.shapes.size());
  for (int own = 0; own < count; ++own) {
    for (int other = 0; model.shapes[own].link == link && other < count; ++other) {
      const int a = std::min(own, other), b = std::max(own, other);
      if (model.shapes[other].link == link || !model.mayCollide(a, b)) continue;
      const double k = model.law(a, b, a == own, b == own).material.stiffness;
      if (k > best.foundation) best = {own, other, k};
    }
  }
  return best;
}

/// How the pointer's contact feels at the grip.
class Press {
 public:
  Press(const ConvexShape& shape, const HandMapping& mapping, double coupling, double force)
      : mapping_(mapping), coupling_(coupling), force_(force / mapping.force_scale) {
    const std::vector<Vector3> sides = shape.sides();
    const std::size_t stride = 1 + (sides.size() - 1) / kMostSides;
    for (std::size_t i = 0; i < sides.size(); i += stride) sides_.push_back(std::make_unique<FlatWall>(shape, sides[i]));
  }

  /// K at the grip of the stiffest side [N/m].
  double stiffness(double k) {
    double most = 0;
    for (const auto& side : sides_) most = std::max(most, side->stiffness(k, force_));
    if (coupling_ > 0) most = most * coupling_ / (most + coupling_);
    return most * mapping_.scale * mapping_.force_scale;
  }

  /// Most force at the grip of the weakest side, where the hand bears `bound` [N/m] at the grip [N].
  double carried(double k, double bound) {
    double least = INFINITY;
    for (const auto& side : sides_) least = std::min(least, side->carried(k, bound / (mapping_.scale * mapping_.force_scale)));
    return least * mapping_.force_scale;
  }

  /// The k [N/m³] below `k` at which K is `bound`; 0: none.
  double foundationFor(double bound, double k) {
    double low = 1e-8 * k, high = k;
    if (stiffness(low) > bound) return 0;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = std::sqrt(low * high);
      (stiffness(middle) > bound ? high : low) = middle;
    }
    return low;
  }

 private:
  HandMapping mapping_;
  double coupling_, force_;
  std::vector<std::unique_ptr<FlatWall>> sides_;
};

/// Stiffness of a virtual coupling at the grip [N/m]; 0: the pointer is at the grip itself.
double couplingStiffness(const PointerDef& pointer, const HandMapping& mapping, double borne) {
  if (pointer.coupling.mode == PointerCoupling::Mode::kDirect) return 0;
  if (pointer.coupling.stiffness == PointerCoupling::kDerived) return borne;
  return pointer.coupling.stiffness * mapping.scale * mapping.force_scale;
}

/// One count of the coarsest string [m].
double countOf(const DeviceDef& device) {
  double count = 0;
  for (const StringDef& string : device.strings) count = std::max(count, std::fabs(string.length_per_count));
  return count;
}

/// The stiffest wall that a device bears with this damping [N·s/m] over this delay [s], at the grip [N/m].
double borneWall(const DeviceDef& device, double damping, double period, double delay) {
  return stiffestWall(largestWallStiffness(damping, 0, period, delay), countOf(device));
}

/// The stiffest coupling of a device held by a relaxed hand, at the grip [N/m].
double borneCoupling(const DeviceDef& device, double period, double delay) {
  const double count = countOf(device);
  const double filter = 1 / (2 * M_PI * SpidarSettings{}.velocity_cutoff_hz);
  return stiffestCoupling({device.grip_damping + kRelaxedHandDamping, 0.5 * period + delay, period, count, filter}).stiffness;
}

/// Factor on a foundation that lets it carry what a hand and the weight of its tool press with (world/hand_bound.h).
double firmerFor(const Model& model, const Partner& partner, const DeviceDef& device, const HandMapping& mapping, int link) {
  const ModelShape &own = model.shapes[partner.own], &other = model.shapes[partner.other];
  const double force = device.max_force / mapping.force_scale + model.links[link].mass * model.settings.gravity.norm();
  return firmer(force, *own.shape, *other.shape, own.width, other.width, partner.foundation);
}

}  // namespace

HandCertificate certifyHand(const WorldDef& def, int pointer, const HandMapping& mapping, const DeviceDef& device,
                            double press) {
  const Model model(def);
  const PointerDef& hand = def.pointers.at(static_cast<std::size_t>(pointer));
  const int link = model.link(hand.articulation, hand.link);
  const double period = def.settings.step, wire = loopDelay(period, device.delay_s), delay = wire + mapping.delay;
  HandCertificate c;
  c.pointer = hand.name.empty() ? model.links[link].name : hand.name;
  c.press = press;
  c.rate = 1 / period;
  c.alone = borneWall(device, device.grip_damping, period, delay);
  c.delay = mapping.delay;
  c.held_without = borneWall(device, device.grip_damping + kRelaxedHandDamping, period, wire);
  c.held = borneWall(device, device.grip_damping + kRelaxedHandDamping, period, delay);
  const Partner partner = stiffestPartner(model, link);
  if (partner.own < 0) return c;
  c.against = model.links[model.shapes[partner.other].link].name;
  c.foundation = partner.foundation;
  c.coupling_borne = borneCoupling(device, period, delay);
  c.coupling = couplingStiffness(hand, mapping, c.coupling_borne);
  if (c.coupling > 0) c.firmer = firmerFor(model, partner, device, mapping, link);
  Press pressing(*model.shapes[partner.own].shape, mapping, c.coupling / (mapping.scale * mapping.force_scale), press);
  c.stiffness = pressing.stiffness(c.foundation);
  c.most = device.max_force;
  c.carries = c.coupling > 0 ? c.most : std::min(c.most, pressing.carried(c.foundation, c.held));
  c.bearable = pressing.foundationFor(c.held, kSoughtFoundations * c.foundation);
  return c;
}

double bearableFoundation(const WorldDef& def, int pointer, const HandMapping& mapping, double bound, double press) {
  const PointerDef& hand = def.pointers.at(static_cast<std::size_t>(pointer));
  const LinkDef& link = def.articulations[hand.articulation].links[hand.link];
  const double coupling = couplingStiffness(hand, mapping, bound) / (mapping.scale * mapping.force_scale);
  double least = kStiffestFoundation;
  for (const CollisionDef& collision : link.collisions) {
    Press pressing(*collision.shape, mapping, coupling, press);
    least = std::min(least, pressing.foundationFor(bound, least));
  }
  return least;
}

std::string HandCertificate::text() const {
  std::ostringstream text;
  text.precision(3);
  text << "hand on " << pointer << ": ";
  if (against.empty()) {
    text << "touches nothing\n";
    return text.str();
  }
  text << (holds() ? "PASS" : "WEAKENED") << ", " << 1e-3 * stiffness << " N/mm when pressed with " << press << " N on " << against
       << "; at " << std::lround(rate) << " Hz the device bears " << 1e-3 * alone << ", held by a relaxed hand " << 1e-3 * held;
  if (delay > 0) text << " (" << 1e-3 * held_without << " without the " << 1e3 * delay << " ms of added delay)";
  if (!holds() && coupling > 0) {
    text << ": the loop softens its coupling of " << 1e-3 * coupling << " N/mm to " << 1e-3 * coupling_borne;
  } else if (!holds() && bearable > 0) {
    text << ": the loop weakens it to that; felt as it is with stiffness " << bearable << " N/m³ or less, or at a higher rate";
  } else if (!holds()) {
    text << ": the loop weakens it to that; give the pointer a virtual coupling or a higher rate";
  }
  if (firmer > 1) {
    text << "; '" << against << "' is " << firmer << " times as stiff for it as in the scene, to carry " << most
         << " N beside the tool's weight";
  }
  if (carries < most) text << "; carries " << carries << " N of the device's " << most << ", then the tool stays behind the hand";
  text << "\n";
  return text.str();
}

}  // namespace haptic
