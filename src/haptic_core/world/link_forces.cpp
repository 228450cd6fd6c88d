#include "haptic_core/world/link_forces.h"

#include <algorithm>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

auto movesOf(const Model& model, const HandWork& hands) {
  return [&model, &hands](int tree) { return hands.movesByItself(model.trees[tree]); };
}

}  // namespace

LinkForce forceNow(const Model& model, const ModelForce& force, const LinkWork* link) noexcept {
  ForceEnds ends;
  ends.a = force.link_a >= 0 ? link + force.link_a : nullptr;
  ends.b = link + force.link_b;
  ends.p_A = force.p_A;
  ends.p_B = force.p_B;
  ends.size_b = model.links[force.link_b].size;
  LinkForce now;
  kindOf(force.type).act(force.parameter, ends, now);
  return now;
}

bool forcesStayWithin(const Model& model, const TreeRange& trees) noexcept {
  const auto has = [&trees](int tree) { return std::binary_search(trees.begin(), trees.end(), tree); };
  bool within = true;
  eachForce(model, trees, has, [&](int, const ModelForce& force) {
    for (const int tree : {force.tree_a, force.tree_b}) within &= tree < 0 || has(tree);
  });
  return within;
}

double springsOf(const Model& model, int tree, const HandWork& hands, const Placement& placement) noexcept {
  double sum = 0;
  eachForce(model, TreeRange{&tree, 1}, movesOf(model, hands),
            [&](int, const ModelForce& force) { sum += forceNow(model, force, placement.link.data()).stored; });
  return sum;
}

/// Elements on each link that moves where B is not named; and by tree.
void Model::addForces(const WorldDef& def) {
  for (const ForceDef& f : def.forces) {
    const std::string where = def.name + ", force " + f.name;
    check(f, where);
    const bool has_a = f.articulation_a < 0 || hasLink(f.articulation_a, f.link_a);
    if (!has_a || (f.articulation_b >= 0 && !hasLink(f.articulation_b, f.link_b))) {
      throw SetupError(where, "joins a link that does not exist", "name the scene's links");
    }
    ModelForce force;
    force.name = f.name;
    force.type = f.type;
    force.p_A = f.p_A;
    force.p_B = f.p_B;
    std::copy(std::begin(f.parameter), std::end(f.parameter), force.parameter);
    const auto moverOf = [this](int link) { return link >= 0 && links[link].moves ? links[link].articulation : -1; };
    force.link_a = f.articulation_a >= 0 ? link(f.articulation_a, f.link_a) : -1;
    force.tree_a = moverOf(force.link_a);
    const std::size_t before = forces.size();
    for (int b = 0; b < static_cast<int>(links.size()); ++b) {
      const bool named = f.articulation_b >= 0;
      if (b == force.link_a || (named ? b != link(f.articulation_b, f.link_b) : !links[b].moves)) continue;
      force.link_b = b;
      force.tree_b = moverOf(b);
      if (force.tree_a >= 0 || force.tree_b >= 0) forces.push_back(force);
    }
    if (forces.size() == before) throw SetupError(where, "joins no two links of which one moves", "take it out, or name others");
  }
  if (forces.empty()) return;
  for (int t = 0; t < static_cast<int>(trees.size()); ++t) {
    first_tree_force.push_back(static_cast<int>(tree_forces.size()));
    for (int i = 0; i < static_cast<int>(forces.size()); ++i) {
      if (forces[i].tree_a == t || forces[i].tree_b == t) tree_forces.push_back(i);
    }
  }
  first_tree_force.push_back(static_cast<int>(tree_forces.size()));
}

}  // namespace haptic
