#include "scene/stiffness_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>

#include "haptic_core/analysis/chosen_stiffness.h"
#include "haptic_core/analysis/resting_depths.h"
#include "scene/weight_above.h"

namespace haptic {
namespace {

constexpr double kStiffest = 1e12;  // [N/m³], steel 0.2 m thick: beyond it a double's rounding of a metre carries 100 N on 1 m²
// Likewise of rigid pairs: on 0.01 m² it carries 2e-4 N then, of 0.1 kg's 1 N. With 1e18, which a heavy body asks for that may lie on the
// side of a thin cylinder, solves do not converge and stacks are launched.
constexpr double kStiffestRigid = 1e14;
// k above what the weight asks for, and share of the bound above which a settled depth is too deep: friction, which remembers how the
// bodies came to rest, moves shares of loads by 2 % between the long steps here and those of the scene.
constexpr double kMargin = 1.03, kAllowed = 0.972;
constexpr double kPressed = 2;      // [N] of a hand: a firm touch, as in hand_certificate.h; what it presses on carries that as well
constexpr double kBeyond = 1.1;     // k is raised so much more than the depth asks for: patches and shares change with it
constexpr double kLadder = 1.778279410038923;  // 10^(1/4): steps of one k for all, from the default to kStiffest
constexpr int kMostLevelled = 10;   // moving links of a scene where that is tried: 4 s of its steps for each k take seconds beyond
constexpr int kRounds = 6;          // of settling and raising; what stands on flat sides needs one, what falls over some
constexpr double kFallSeconds = 4;  // until what falls over lies
// Steps of 10 ms. 2 s settle what leans and falls over; a heap gets less, for its steps cost more than in proportion to its bodies:
// 100 bodies about 2 s of computing, 1000 half a minute.
constexpr int kMostSteps = 200, kFewestSteps = 20, kLinkSteps = 4000, kFewLinks = 30;

/// Sets a value, and where it comes from, of every collision of the link that gives no number. False: none is in a file.
bool give(LoadContext& context, int articulation, int link, double ContactMaterial::*field, double value,
          const std::string& reason) {
  SceneDef& scene = context.scene;
  for (CollisionDef& collision : scene.world.articulations[articulation].links[link].collisions) {
    if (!collision.material.saysNumber()) collision.material.*field = value;
  }
  bool listed = false;
  for (const SilentCollision& silent : context.silent) {
    if (silent.articulation != articulation || silent.link != link) continue;
    listed = true;
    CollisionReport& report = scene.collisions[silent.report];
    report.material.*field = value;
    report.material_source += "; stiffness chosen: " + reason;
  }
  return listed;
}

void makeOf(const GivenSolid& solid, LoadContext& context) {
  for (const SilentCollision& silent : context.silent) {
    CollisionReport& report = context.scene.collisions[silent.report];
    if (report.material.rigid()) continue;
    std::string reason;
    report.material.stiffness = stiffnessOf(solid, silent.extent, reason);
    report.material_source += "; the scene's material: " + reason;
    std::vector<CollisionDef>& all = context.scene.world.articulations[silent.articulation].links[silent.link].collisions;
    for (std::size_t i = 0; i < silent.count; ++i) all[silent.first + i].material.stiffness = report.material.stiffness;
  }
}

void chooseTouch(const HandDef& hand, LoadContext& context) {
  const WorldDef& world = context.scene.world;
  const PointerDef& pointer = world.pointers[hand.pointer];
  const double k = touchStiffness(world, hand.pointer, {hand.workspace.scale, hand.force_scale});
  if (!(k > 0)) return;
  std::ostringstream reason;
  reason.precision(4);
  reason << k << " N/m³ with what gives none, as stiff as a relaxed hand bears that presses with 2 N at "
         << 1 / world.settings.step << " Hz";
  if (give(context, pointer.articulation, pointer.link, &ContactMaterial::touch_stiffness, k, reason.str())) return;
  context.scene.notes.push_back("contact of the added pointer: stiffness " + reason.str());  // it is in no listing
}

/// k that the bodies' own weights ask for, of whatever stands below and above at the start: where the settling begins.
void chooseRest(const LinkDef& link, const LinkLoad& load, int articulation, int index, LoadContext& context) {
  const RestingStiffness rest = restingStiffness(link, load.weight, load.thinnest);
  if (!(rest.stiffness > 0)) return;
  const double k = std::fmin(kStiffest, std::fmax(kMargin * rest.stiffness, DefaultMaterial::kStiffness));
  std::ostringstream reason;
  reason.precision(3);
  reason << "rests at most " << 100 * kSink << " % of its least extent deep, " << 1e3 * kSink * rest.extent << " mm, with "
         << kMargin * rest.stiffness << " N/m³ under " << load.weight << " N";
  if (k > kMargin * rest.stiffness) reason << "; the default is stiffer";
  give(context, articulation, index, &ContactMaterial::rest_stiffness, k, reason.str());
}

/// Some pair of surfaces is rigid.
bool saysRigid(const WorldDef& world) {
  if (world.settings.default_material.rigid()) return true;
  for (const ArticulationDef& tree : world.articulations) {
    for (const LinkDef& link : tree.links) {
      for (const CollisionDef& collision : link.collisions) {
        if (collision.material.rigid()) return true;
      }
    }
  }
  return false;
}

/// Least k of a link's rigid pairs [N/m³]; 0: it cannot lie.
double rigidOf(const LinkDef& link, const LinkLoad& load) {
  return std::fmin(kStiffestRigid, kMargin * restingStiffness(link, load.weight, load.thinnest, kRigidSink).stiffness);
}

/// k of every body's rigid pairs, whether the body says rigid or what it meets does.
void chooseRigid(const std::vector<std::vector<LinkLoad>>& loads, double pressed, const std::map<std::pair<int, int>, bool>& held,
                 LoadContext& context) {
  const WorldDef& world = context.scene.world;
  const bool all = world.settings.default_material.rigid();
  for (int a = 0; a < static_cast<int>(world.articulations.size()); ++a) {
    for (int l = 0; l < static_cast<int>(world.articulations[a].links.size()); ++l) {
      LinkLoad load = loads[a][l];
      if (load.weight > 0) load.weight += pressed;
      const double k = rigidOf(world.articulations[a].links[l], load);
      if (!(k > 0) || held.count({a, l})) continue;
      const std::vector<CollisionDef>& collisions = world.articulations[a].links[l].collisions;
      const bool says = all || std::any_of(collisions.begin(), collisions.end(),
                                           [](const CollisionDef& each) { return each.material.rigid(); });
      std::ostringstream reason;
      reason.precision(3);
      reason << (says ? "" : "on what is rigid ") << k << " N/m³ or as a step resolves, for " << kRigidSink
             << " of its least extent at rest under " << load.weight << " N";
      give(context, a, l, &ContactMaterial::rigid_stiffness, k, reason.str());
    }
  }
}

/// What the scene says of each collision of the world, in the world's order.
struct PlacedCollision {
  int articulation, link;
  CollisionDef* def;
  const SilentCollision* silent;  ///< null: it gives a stiffness, or it is no surface of a file
  double first;                   ///< its k of rigid pairs before the scene settles; NaN: there are none
};

std::vector<PlacedCollision> placedCollisions(LoadContext& context) {
  std::vector<PlacedCollision> placed;
  std::map<const CollisionDef*, const SilentCollision*> silent;
  auto& trees = context.scene.world.articulations;
  for (const SilentCollision& each : context.silent) {
    std::vector<CollisionDef>& all = trees[each.articulation].links[each.link].collisions;
    for (std::size_t i = 0; i < each.count; ++i) silent[&all[each.first + i]] = &each;
  }
  for (std::size_t a = 0; a < trees.size(); ++a) {
    for (std::size_t l = 0; l < trees[a].links.size(); ++l) {
      for (CollisionDef& collision : trees[a].links[l].collisions) {
        const auto found = silent.find(&collision);
        placed.push_back({static_cast<int>(a), static_cast<int>(l), &collision, found == silent.end() ? nullptr : found->second, 0});
      }
    }
  }
  return placed;
}

std::vector<std::vector<std::vector<double>>> extentsOf(const WorldDef& world, const std::vector<PlacedCollision>& placed) {
  std::vector<std::vector<std::vector<double>>> extents(world.articulations.size());
  for (std::size_t a = 0; a < extents.size(); ++a) extents[a].resize(world.articulations[a].links.size());
  for (const PlacedCollision& each : placed) {
    extents[each.articulation][each.link].push_back(each.silent ? each.silent->extent : INFINITY);
  }
  return extents;
}

/// A pair that rests on a stiffness of which nobody gave the number, and the depth that it should not pass.
struct ChosenRest {
  const PlacedCollision *a, *b;
  double depth, bound, force;
  bool rigid;

  double ContactMaterial::*field() const { return rigid ? &ContactMaterial::rigid_stiffness : &ContactMaterial::rest_stiffness; }
  double share() const { return (rigid ? kRigidSink : kSink) * depth / bound; }  ///< of the least extent
  /// k that the pair has [N/m³].
  double present() const {
    const double chosen = std::fmax(a->def->material.*field(), b->def->material.*field());
    return rigid ? chosen : std::fmax(DefaultMaterial::kStiffness, chosen);
  }
  double stiffest() const { return rigid ? kStiffestRigid : kStiffest; }
};

std::vector<ChosenRest> chosenRests(const RestingDepths& rest, const std::vector<PlacedCollision>& placed,
                                    const ContactMaterial& otherwise) {
  std::vector<ChosenRest> chosen;
  for (const RestingContact& contact : rest.contacts) {
    const PlacedCollision &a = placed[contact.shape_a], &b = placed[contact.shape_b];
    const double touch = std::fmin(a.def->material.touch_stiffness, b.def->material.touch_stiffness);
    if (!a.silent || !b.silent || touch > 0) continue;
    if (a.def->material.saysNumber() || b.def->material.saysNumber()) continue;  // by the scene's material
    const bool rigid = a.def->material.rigid() || b.def->material.rigid() || otherwise.rigid();
    const double extent = std::fmin(a.silent->extent, b.silent->extent);
    ChosenRest each{&a, &b, contact.depth, (rigid ? kRigidSink : kSink) * extent, contact.force, rigid};
    if (each.present() > 0 && (rigid || !otherwise.saysNumber())) chosen.push_back(each);
  }
  return chosen;
}

double& restOf(const PlacedCollision& collision) { return collision.def->material.rest_stiffness; }

/// The pieces of one collision are one surface: all get k, and the listing says why.
void stiffen(const PlacedCollision& collision, double k, const ChosenRest& rest, LoadContext& context) {
  double ContactMaterial::*const field = rest.field();
  const SilentCollision& silent = *collision.silent;
  std::vector<CollisionDef>& all = context.scene.world.articulations[silent.articulation].links[silent.link].collisions;
  for (std::size_t i = 0; i < silent.count; ++i) all[silent.first + i].material.*field = k;
  std::ostringstream text;
  text.precision(3);
  text << "; stiffened to " << k << " N/m³ by what the scene comes to rest with: " << rest.force << " N, " << 1e3 * rest.depth << " mm";
  CollisionReport& report = context.scene.collisions[silent.report];
  report.material.*field = k;
  const std::size_t before = report.material_source.find("; stiffened to ");
  report.material_source = report.material_source.substr(0, before) + text.str();
}

/// Raises k where the settled scene is deeper than it should be; false: nowhere. Depths on flat sides go as k⁻¹, on a corner as k^(−1/3):
/// what the first did not cure gets the cube.
bool stiffenTooDeep(const std::vector<ChosenRest>& rests, bool cubed, LoadContext& context) {
  bool changed = false;
  for (const ChosenRest& rest : rests) {
    if (!(rest.depth > kAllowed * rest.bound)) continue;
    const double present = rest.present();
    const double share = rest.depth / rest.bound, factor = cubed ? share * share * share : share;
    const double k = std::fmin(rest.stiffest(), kBeyond * present * factor);
    if (!(k > present)) continue;
    // The one that is smaller has the fewer contacts with others, which get stiffer as well.
    stiffen(rest.a->silent->extent < rest.b->silent->extent ? *rest.a : *rest.b, k, rest, context);
    changed = true;
  }
  return changed;
}

bool withinBounds(const std::vector<ChosenRest>& rests) {
  return std::all_of(rests.begin(), rests.end(), [](const ChosenRest& rest) { return rest.depth <= kAllowed * rest.bound; });
}

/// All that says nothing gets this k, and the listing says why.
void level(const std::vector<PlacedCollision>& placed, double k, LoadContext& context) {
  std::ostringstream text;
  text.precision(3);
  text << "; stiffened to " << k << " N/m³, one for all: with others the scene comes to rest on edges, too deep";
  for (const PlacedCollision& each : placed) {
    if (!each.silent) continue;
    restOf(each) = k;
    CollisionReport& report = context.scene.collisions[each.silent->report];
    report.material.rest_stiffness = k;
    report.material_source = report.material_source.substr(0, report.material_source.find("; stiffened to ")) + text.str();
  }
}

/// Raising pair by pair changes how things fall, and may end with one on its edge that no k carries. Then the least k for all with which
/// the scene, by its own steps, rests as asked; one that rolls on is the second choice. False: there is none, and nothing has changed.
bool levelWhereNothingElseDoes(const std::vector<PlacedCollision>& placed, SettleBudget& budget, LoadContext& context,
                               RestingDepths& rest) {
  const ContactMaterial& otherwise = context.scene.world.settings.default_material;
  std::vector<double> before;
  for (const PlacedCollision& each : placed) before.push_back(restOf(each));
  const std::vector<CollisionReport> reports = context.scene.collisions;
  double second = 0;
  for (double k = DefaultMaterial::kStiffness; k <= kStiffest * kMargin && !budget.spent(); k *= kLadder) {
    level(placed, k, context);
    rest = restingDepthsAsRun(context.scene.world, kFallSeconds, kAtRest, &budget);
    if (budget.spent()) break;
    if (rest.contacts.empty() || !withinBounds(chosenRests(rest, placed, otherwise))) continue;
    if (rest.settled) return true;
    if (second == 0) second = k;
  }
  if (second > 0) {
    level(placed, second, context);
    rest = restingDepthsAsRun(context.scene.world, kFallSeconds);
    return true;
  }
  for (std::size_t i = 0; i < placed.size(); ++i) restOf(placed[i]) = before[i];
  context.scene.collisions = reports;
  return false;
}

std::string depthText(const ChosenRest& rest) {
  std::ostringstream text;
  text.precision(3);
  text << "'" << rest.a->def->name << "' and '" << rest.b->def->name << "', " << 1e3 * rest.depth << " mm under " << rest.force << " N, "
       << 100 * rest.share() << " % of the least extent";
  return text.str();
}

void tellDepths(std::vector<ChosenRest> rests, bool settled, LoadContext& context) {
  if (rests.empty()) return;
  std::sort(rests.begin(), rests.end(), [](const ChosenRest& a, const ChosenRest& b) { return a.depth / a.bound > b.depth / b.bound; });
  context.scene.notes.push_back("at rest with the stiffnesses chosen: " + std::to_string(rests.size()) +
                                " contacts, the deepest for its size " + depthText(rests[0]) + (settled ? "" : " (other bodies move on)"));
  const auto deep = std::count_if(rests.begin(), rests.end(), [](const ChosenRest& rest) { return rest.depth > rest.bound; });
  if (deep == 0) return;
  const PlacedCollision& first = *rests[0].a;
  std::ostringstream text;
  text << context.places[first.articulation][first.link] << ": " << depthText(rests[0]) << " and not "
       << 100 * (rests[0].rigid ? kRigidSink : kSink) << " %, with a stiffness of " << rests[0].present() << " N/m³, "
       << rests[0].stiffest() << " at most";
  if (deep > 1) text << ", as " << deep - 1 << " other contact" << (deep > 2 ? "s" : "");
  text << ": give them stiffness, or thicker shapes";
  context.scene.warnings.push_back(text.str());
}

bool mayRest(const LoadContext& context) {
  for (const SilentCollision& silent : context.silent) {
    const ArticulationDef& tree = context.scene.world.articulations[silent.articulation];
    const ContactMaterial& material = tree.links[silent.link].collisions[silent.first].material;
    if (material.rest_stiffness > 0 || material.rigid_stiffness > 0) return true;
  }
  return false;
}

int movingLinks(const WorldDef& world) {
  int moving = 0;
  for (const ArticulationDef& tree : world.articulations) {
    for (const LinkDef& link : tree.links) moving += link.joint.type != JointType::kFixed;
  }
  return moving;
}

/// What counts as at rest: rigid bodies of the least size move by a hundredth of their bound in a step.
double restSpeed(const std::vector<PlacedCollision>& placed) {
  double extent = INFINITY;
  for (const PlacedCollision& each : placed) {
    if (each.first > 0 && each.silent) extent = std::fmin(extent, each.silent->extent);
  }
  return std::fmin(kAtRest, 0.01 * kRigidSink * extent / kSettleStep);
}

/// [units] of a scene's settling, about a nanosecond each: a few bodies settle by thousands of the scene's steps, many by 40 long ones.
double settleWork(int moving) { return moving > kFewLinks ? 2e9 : 1e10; }

/// What settles says so, a line a second.
std::function<void(double)> settlingProgress(const std::function<void(const std::string&)>& tell, int moving) {
  if (!tell) return {};
  auto told = std::make_shared<std::chrono::steady_clock::time_point>(std::chrono::steady_clock::now());
  return [=, &tell](double left) {
    const auto now = std::chrono::steady_clock::now();
    if (now - *told < std::chrono::seconds(1)) return;
    *told = now;
    tell("letting " + std::to_string(moving) + " links settle, to choose their stiffness: " +
         std::to_string(std::lround(100 * std::max(0.0, left) / settleWork(moving))) + " % of the work left");
  };
}

void tellUnsettled(int moving, LoadContext& context) {
  context.scene.notes.push_back("settling " + std::to_string(moving) +
                                " links ended before they were at rest, for it takes too much work: "
                                "where a depth was not seen, stiffness is "
                                "that which the weights ask for; give them one by <haptic:contact>");
}

void settleRest(const std::vector<PlacedCollision>& placed, const std::function<void(const std::string&)>& tell, LoadContext& context) {
  const WorldDef& world = context.scene.world;
  const ContactMaterial& otherwise = world.settings.default_material;
  const double at_rest = restSpeed(placed);
  const int moving = std::max(1, movingLinks(world)), steps = std::clamp(kLinkSteps / moving, kFewestSteps, kMostSteps);
  SettleBudget budget;
  budget.left = settleWork(moving);
  budget.progress = settlingProgress(tell, moving);
  std::vector<ChosenRest> chosen;
  bool settled = false;
  const auto raiseWhile = [&](int rounds, bool cubed, const auto& settle) {
    for (int round = 0;; ++round) {
      const RestingDepths rest = settle();
      chosen = chosenRests(rest, placed, otherwise), settled = rest.settled;
      if (round == rounds || budget.spent() || !stiffenTooDeep(chosen, cubed || round > 0, context)) return;
    }
  };
  raiseWhile(moving > kFewLinks ? 1 : kRounds, false, [&] { return restingDepths(world, steps, at_rest, &budget); });
  // What leans may fall over by the scene's own steps only, and lies as these lay it.
  if (moving <= kFewLinks) raiseWhile(kRounds, true, [&] { return restingDepthsAsRun(world, kFallSeconds, at_rest, &budget); });
  RestingDepths rest;
  const auto isDeep = [](const ChosenRest& each) { return !each.rigid && each.depth > each.bound; };
  const bool deep = std::any_of(chosen.begin(), chosen.end(), isDeep);
  if (deep && moving <= kMostLevelled && !budget.spent() && levelWhereNothingElseDoes(placed, budget, context, rest)) {
    chosen = chosenRests(rest, placed, otherwise), settled = rest.settled;
  }
  if (budget.spent()) tellUnsettled(moving, context);
  tellDepths(chosen, settled, context);
}

}  // namespace

void chooseStiffness(const std::function<void(const std::string&)>& tell, LoadContext& context) {
  SceneDef& scene = context.scene;
  if (context.solid) makeOf(context.solid, context);
  const bool rigid = saysRigid(scene.world);
  const bool silent_pairs = !context.solid && std::isnan(scene.world.settings.default_material.stiffness);
  if (!rigid && !silent_pairs) return;
  std::map<std::pair<int, int>, bool> held;
  for (const HandDef& hand : scene.hands) {
    const PointerDef& pointer = scene.world.pointers[hand.pointer];
    held[{pointer.articulation, pointer.link}] = true;
    chooseTouch(hand, context);
  }
  double pressed = 0;  // on any body, by the strongest hand
  for (const HandDef& hand : scene.hands) pressed = std::fmax(pressed, kPressed / hand.force_scale);
  std::vector<PlacedCollision> placed = placedCollisions(context);
  const auto loads = loadsOf(scene.world, extentsOf(scene.world, placed));
  for (int a = 0; a < static_cast<int>(scene.world.articulations.size()); ++a) {
    const ArticulationDef& tree = scene.world.articulations[a];
    for (int l = 0; l < static_cast<int>(tree.links.size()); ++l) {
      bool silent = false;
      for (const CollisionDef& collision : tree.links[l].collisions) silent |= std::isnan(collision.material.stiffness);
      LinkLoad load = loads[a][l];
      if (load.weight > 0) load.weight += pressed;
      if (silent && silent_pairs && !held.count({a, l})) chooseRest(tree.links[l], load, a, l, context);
    }
  }
  if (rigid) chooseRigid(loads, pressed, held, context);
  for (PlacedCollision& each : placed) each.first = each.def->material.rigid_stiffness;
  if (!mayRest(context)) return;
  try {
    settleRest(placed, tell, context);
  } catch (const SetupError&) {  // whoever makes a World of the scene is told
  }
}

void makeRigid(WorldDef& def) {
  std::vector<std::vector<std::vector<double>>> extents;
  for (ArticulationDef& tree : def.articulations) {
    extents.emplace_back();
    for (LinkDef& link : tree.links) {
      extents.back().emplace_back();
      for (CollisionDef& collision : link.collisions) {
        collision.material.stiffness = ContactMaterial::kRigid;
        collision.material.tangential_stiffness = ContactMaterial::kUnset;  // it was that of another k
        const ConvexShape::Box box = collision.shape->bounded() ? collision.shape->aabb() : ConvexShape::Box{};
        extents.back().back().push_back(collision.shape->bounded() ? (box.upper - box.lower).minCoeff() : INFINITY);
      }
    }
  }
  const auto loads = loadsOf(def, extents);
  for (std::size_t a = 0; a < loads.size(); ++a) {
    for (std::size_t l = 0; l < loads[a].size(); ++l) {
      const double k = rigidOf(def.articulations[a].links[l], loads[a][l]);
      for (CollisionDef& collision : def.articulations[a].links[l].collisions) {
        if (k > 0) collision.material.rigid_stiffness = k;
      }
    }
  }
}

}  // namespace haptic
