#include "haptic_core/world/carry_over.h"

#include <algorithm>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/world/initial_overlap.h"
#include "haptic_core/world/led_motion.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

void mapLinks(const Model& from, const Model& to, const std::vector<int>& kept, CarryOver& map) {
  int last = -1;
  for (int a = 0; a < to.articulationCount(); ++a) {
    const int old = a < static_cast<int>(kept.size()) ? kept[a] : -1;
    if (old < 0) continue;
    const bool known = old > last && old < from.articulationCount() && from.linkCount(old) == to.linkCount(a);
    last = old;
    for (int l = 0; known && l < to.linkCount(a); ++l) {
      map.link[from.link(old, l)] = from.links[from.link(old, l)].name == to.links[to.link(a, l)].name ? to.link(a, l) : -1;
    }
    if (known && to.linkCount(a) > 0 && map.link[from.link(old, 0)] >= 0) continue;
    throw SetupError(to.name, "keeps an articulation " + std::to_string(old) + " that is out of order or has other links",
                     "keep the order of what stays");
  }
}

/// Of the links before the one that became this one; -1: it is new.
int linkBefore(const CarryOver& map, int link) noexcept {
  const auto found = std::find(map.link.begin(), map.link.end(), link);
  return found == map.link.end() ? -1 : static_cast<int>(found - map.link.begin());
}

int shapesOn(const Model& model, int link) {
  return static_cast<int>(std::count_if(model.shapes.begin(), model.shapes.end(), [=](const ModelShape& s) { return s.link == link; }));
}

void mapTrees(const Model& from, const Model& to, CarryOver& map) {
  map.tree.assign(to.trees.size(), -1);
  for (std::size_t l = 0; l < map.link.size(); ++l) {
    if (map.link[l] < 0) continue;
    const int t = to.links[map.link[l]].articulation, old = from.links[l].articulation;
    const bool same = (map.tree[t] < 0 || map.tree[t] == old) && to.trees[t].model->linkCount() == from.trees[old].model->linkCount() &&
                      to.trees[t].model->nq() == from.trees[old].model->nq() && to.trees[t].has_laws == from.trees[old].has_laws;
    if (!same) throw SetupError(to.name, "joins or parts what loops hold together", "change whole mechanisms");
    map.tree[t] = old;
  }
  map.tree_now.assign(from.trees.size(), -1);
  for (std::size_t t = 0; t < to.trees.size(); ++t) {
    if (map.tree[t] < 0) map.coming.push_back(static_cast<int>(t));
    if (map.tree[t] >= 0) map.tree_now[map.tree[t]] = static_cast<int>(t);
  }
}

void mapShapes(const Model& from, const Model& to, CarryOver& map) {
  for (std::size_t l = 0; l < map.link.size(); ++l) {
    if (map.link[l] < 0 || shapesOn(from, static_cast<int>(l)) == shapesOn(to, map.link[l])) continue;
    throw SetupError(to.name, "link '" + from.links[l].name + "' has other collisions than before", "keep what stays as it is");
  }
  std::vector<int> next(to.links.size(), 0), first(to.links.size(), -1);
  for (int s = static_cast<int>(to.shapes.size()) - 1; s >= 0; --s) first[to.shapes[s].link] = s;
  for (std::size_t s = 0; s < from.shapes.size(); ++s) {
    const int link = map.link[from.shapes[s].link];
    map.shape.push_back(link < 0 || first[link] < 0 ? -1 : first[link] + next[link]++);
  }
}

/// The element of one world is that of the other.
bool isSame(const CarryOver& map, const ModelForce& old, const ModelForce& force) {
  const auto now = [&](int link) { return link < 0 ? -1 : map.link[link]; };
  return old.type == force.type && now(old.link_a) == force.link_a && (old.link_a < 0 || force.link_a >= 0) &&
         now(old.link_b) == force.link_b && old.p_A == force.p_A && old.p_B == force.p_B &&
         std::equal(std::begin(old.parameter), std::end(old.parameter), std::begin(force.parameter));
}

/// Trees of the elements of `some` that are not among those of `others`.
template <class Same, class TreeOf>
void addUnlike(const std::vector<ModelForce>& some, const std::vector<ModelForce>& others, Same&& same, TreeOf&& treeOf,
               std::vector<int>& trees) {
  for (const ModelForce& force : some) {
    if (std::any_of(others.begin(), others.end(), [&](const ModelForce& other) { return same(force, other); })) continue;
    for (const int link : {force.link_a, force.link_b}) {
      const int tree = link < 0 ? -1 : treeOf(link);
      if (tree >= 0) trees.push_back(tree);
    }
  }
}

void mapForces(const Model& from, const Model& to, CarryOver& map) {
  addUnlike(to.forces, from.forces, [&](const ModelForce& is, const ModelForce& was) { return isSame(map, was, is); },
            [&](int link) { return to.links[link].articulation; }, map.pulled);
  addUnlike(from.forces, to.forces, [&](const ModelForce& was, const ModelForce& is) { return isSame(map, was, is); },
            [&](int link) { return map.link[link] < 0 ? -1 : to.links[map.link[link]].articulation; }, map.pulled);
  std::sort(map.pulled.begin(), map.pulled.end());
  map.pulled.erase(std::unique(map.pulled.begin(), map.pulled.end()), map.pulled.end());
}

/// One tree's own numbers, from one state to another.
void carryTree(const ModelTree& old, const ModelTree& tree, int was, int is, const State& from, State& to) noexcept {
  const int nq = tree.model->nq(), nv = tree.model->nv();
  std::copy_n(from.q.begin() + old.q, nq, to.q.begin() + tree.q);
  const auto carry = [&](const std::vector<double>& a, std::vector<double>& b) { std::copy_n(a.begin() + old.v, nv, b.begin() + tree.v); };
  carry(from.v, to.v), carry(from.a_end, to.a_end), carry(from.a_mean, to.a_mean), carry(from.v_mean, to.v_mean);
  to.mode[is] = from.mode[was];
  to.last_step[is] = from.last_step[was];
  to.calm[is] = from.calm[was];
  if (tree.has_laws) std::copy_n(from.commands.begin() + old.command, tree.model->linkCount(), to.commands.begin() + tree.command);
}

void carryContact(const CarryOver& map, ContactReport contact, int slot, ContactReports& tells) noexcept {
  contact.link_a = map.link[contact.link_a], contact.link_b = map.link[contact.link_b];
  contact.shape_a = map.shape[contact.shape_a], contact.shape_b = map.shape[contact.shape_b];
  tells.tell(slot, contact);
}

/// Contacts of what stays, and what the last step told of them. What lost one is pulled at by other forces from now on.
void carryPairs(CarryOver& map, const State& from, const ContactReports& told, const Model& model, State& to,
                ContactReports& tells) noexcept {
  to.pairs.clear(), tells.clear();
  from.pairs.each([&](int i) {
    const ActivePair& pair = from.pairs[i];
    const int a = map.shape[pair.shapeA()], b = map.shape[pair.shapeB()];
    const int slot = a >= 0 && b >= 0 ? to.pairs.append(ActivePair::keyOf(a, b)) : -1;
    if (slot >= 0) {
      to.pairs[slot] = pair;
      to.pairs[slot].key = ActivePair::keyOf(a, b);
      if (told.touches(i)) carryContact(map, told[i], slot, tells);
      return;
    }
    for (const int shape : {a, b}) {
      if (shape < 0) continue;
      map.stirred[model.treeOf(shape)] = 1;
      to.beginAnew(model.treeOf(shape));
    }
  });
}

}  // namespace

CarryOver carryOverOf(const Model& from, const Model& to, const std::vector<int>& kept) {
  CarryOver map;
  map.from = &from;
  const WorldSettings &was = from.settings, &is = to.settings;
  if (is.step != was.step || to.pointers.size() != from.pointers.size()) {
    throw SetupError(to.name, "has another step or other pointers than the world that runs", "change bodies alone");
  }
  map.link.assign(from.links.size(), -1);
  mapLinks(from, to, kept, map);
  mapTrees(from, to, map);
  mapShapes(from, to, map);
  mapForces(from, to, map);
  for (std::size_t p = 0; p < from.pointers.size(); ++p) {
    const bool stays = map.link[from.pointerHome(static_cast<int>(p))] == to.pointerHome(static_cast<int>(p));
    if (!stays) throw SetupError(to.name, "takes the pointer of " + from.pointers[p].device + " away", "keep what hands move");
  }
  for (const ModelMotion& motion : to.motions) {
    int old = -1;
    for (std::size_t m = 0; m < from.motions.size(); ++m) {
      if (map.link[from.motions[m].link] == motion.link) old = static_cast<int>(m);
    }
    map.motion.push_back(old);
  }
  map.stirred.resize(to.trees.size());
  return map;
}

void carryOver(CarryOver& map, const State& from, const Work& old_work, Model& model, State& state, Work& work) noexcept {
  const Model& old = *map.from;
  model.tune(old.tuning);
  state.time = from.time;
  state.step = from.step;
  state.energy = from.energy;
  for (std::size_t t = 0; t < map.tree.size(); ++t) {
    if (map.tree[t] < 0) continue;
    carryTree(old.trees[map.tree[t]], model.trees[t], map.tree[t], static_cast<int>(t), from, state);
  }
  for (std::size_t m = 0; m < map.motion.size(); ++m) {
    const int was = map.motion[m];
    if (was >= 0 && old.motions[was].time.empty()) state.motions[m] = from.motions[was];
    // A body that was led along a path, or not at all, stands where it is until it is told a pose.
    const int before = was >= 0 ? old.motions[was].link : linkBefore(map, model.motions[m].link);
    if (before >= 0 && !(was >= 0 && old.motions[was].time.empty())) state.motions[m] = standingAt(old_work.placement.link[before].X_WL);
  }
  for (std::size_t p = 0; p < from.pointers.size(); ++p) {
    const int link = map.link[from.pointers[p].link];
    state.pointers[p] = from.pointers[p];
    state.pointers[p].link = link >= 0 ? link : model.pointerHome(static_cast<int>(p));  // the link that it had grabbed goes
    state.pointers[p].targeted = from.pointers[p].targeted && link >= 0;
    work.hands.bound[p] = old_work.hands.bound[p];
  }
  state.wrench_count = 0;
  for (int i = 0; i < from.wrench_count; ++i) {
    const int link = map.link[from.wrenches[i].link];
    if (link < 0) continue;
    state.wrenches[state.wrench_count] = from.wrenches[i];
    state.wrenches[state.wrench_count++].link = link;
  }
  std::fill(map.stirred.begin(), map.stirred.end(), 0);
  carryPairs(map, from, old_work.reported, model, state, work.reported);
  for (const int t : map.pulled) {
    map.stirred[t] = 1;
    state.beginAnew(t);
  }
  refreshHands(model, state, work.hands);
  placeTrees(model, work.visits.trees, state, work.placement);
  for (const int t : map.coming) findBuried(model, t, state, work);
  renewSupply(model, work, state);
  work.stopped = old_work.stopped;
  work.activity.carryOver(old_work.activity, map, old_work, model, state, work);
  work.reported.list(state.pairs.awake());
}

}  // namespace haptic
