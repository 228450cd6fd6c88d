#include "haptic_core/stepping/asleep.h"

#include <algorithm>

#include "haptic_core/base/fields.h"
#include "haptic_core/stepping/own_rate.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {
namespace {

/// Where the middles of the model's moving shapes are at the start.
std::vector<Vector3> placesOf(const Model& model) {
  std::vector<LinkWork> link(model.links.size());
  for (const ModelTree& tree : model.trees) {
    forwardKinematics(*tree.model, model.q_start.data() + tree.q, model.v_start.data() + tree.v, link.data() + tree.link);
  }
  std::vector<Vector3> places;
  for (const int s : model.moving_shapes) {
    const ModelShape& shape = model.shapes[static_cast<std::size_t>(s)];
    places.push_back(link[static_cast<std::size_t>(shape.link)].X_WL * (shape.X_LS * shape.shape->centre()));
  }
  return places;
}

/// By tree, with the end of the last: where in an ascending list of things on links its own begin.
template <class LinkOf>
std::vector<int> firstByTree(const Model& model, std::size_t count, LinkOf&& linkOf) {
  std::vector<int> first;
  std::size_t i = 0;
  for (const ModelTree& tree : model.trees) {
    while (i < count && linkOf(i) < tree.link) ++i;
    first.push_back(static_cast<int>(i));
  }
  first.push_back(static_cast<int>(count));
  return first;
}

/// Adds what ascends to what ascends.
void merge(const std::vector<int>& added, std::vector<int>& list) noexcept {
  std::size_t from = list.size(), next = added.size();
  list.resize(from + next);  // it has room for all
  for (std::size_t to = list.size(); next > 0;) {
    list[--to] = from > 0 && list[from - 1] > added[next - 1] ? list[--from] : added[--next];
  }
}

/// The tree that sleeps or moves by itself of a pair; a pair of such an island has no other that does not sleep with it.
int moverOf(const Model& model, const HandWork& hands, const ActivePair& pair) noexcept {
  const int a = model.treeOf(pair.shapeA());
  return hands.movesByItself(model.trees[a]) ? a : model.treeOf(pair.shapeB());
}

}  // namespace

Asleep::Asleep(const Model& model) : sleeper_(model.trees.size()), island_(model.trees.size()) {
  on = model.settings.leave_out && model.has_contacts && model.listed_pairs.empty();
  if (!on) return;
  const auto first = [&](std::size_t count, auto&& linkOf) { return firstByTree(model, count, linkOf); };
  first_shape_ = first(model.shapes.size(), [&](std::size_t i) { return model.shapes[i].link; });
  first_slot_ = first(model.moving_shapes.size(), [&](std::size_t i) { return model.shapes[model.moving_shapes[i]].link; });
  islands_.reserve(model.trees.size());
  tired_.reserve(2 * model.trees.size());
  woken_.reserve(model.trees.size());
  merged_.reserve(std::max(model.shapes.size(), static_cast<std::size_t>(model.pair_capacity)));
  boxes_ = BoxSlots(placesOf(model));
  pair_.resize(static_cast<std::size_t>(model.pair_capacity));
  order_.reserve(pair_.size());
  for (int i = 0; i < model.pair_capacity; ++i) next_pair_.push_back(i + 1 < model.pair_capacity ? i + 1 : -1);
  free_pair_ = model.pair_capacity > 0 ? 0 : -1;
  contacts_.reserve(model.pair_capacity);
}

std::uint64_t Asleep::hash(const State& state) noexcept {
  if (islands_.empty()) return state.hash();
  const auto key = [this](int slot) { return pair_[slot].key; };
  if (order_changes_ != changes_) {
    order_changes_ = changes_;
    order_.clear();
    for (const int island : islands_) {
      for (int slot = island_[island].first_pair; slot >= 0; slot = next_pair_[slot]) order_.push_back(slot);
    }
    std::sort(order_.begin(), order_.end(), [&](int i, int j) { return key(i) < key(j); });
  }
  std::uint64_t hash = hashFields(kHashStart, state);
  std::size_t next = 0;
  for (int i = 0; i <= state.pair_count; ++i) {
    const bool end = i == state.pair_count;
    for (; next < order_.size() && (end || key(order_[next]) < state.pairs[i].key); ++next) hash = hashFields(hash, pair_[order_[next]]);
    if (!end) hash = hashFields(hash, state.pairs[i]);
  }
  for (int i = 0; i < state.wrench_count; ++i) hash = hashFields(hash, state.wrenches[i]);
  return hash;
}

void Asleep::note(const Island& island) noexcept {
  if (!on) return;
  tired_.push_back(island.tree_count);
  tired_.insert(tired_.end(), island.trees, island.trees + island.tree_count);
}

/// It still stands.
bool mayFall(const int* trees, int count, const StandingIslands& standing) noexcept {
  return std::all_of(trees, trees + count, [&](int t) { return standing.holds(t); });
}

void Asleep::close(const Model& model, State& state, Work& work, Report& report) noexcept {
  report.step.implicit_islands += islands();
  report.step.standing += trees() - waiting();
  report.step.waiting += waiting();
  report.step.flags |= flags();
  if (report.step.finite) fall(model, state, work, report);
  tired_.clear();
  report.step.pairs = state.pair_count + pairs();
  report.step.contacts = report.contacts.size() + contacts_.size();
}

/// Boxes as wide as the tree may come until its turn, from where it is now.
void Asleep::placeWaiting(const Model& model, int tree, const State& state, Work& work) noexcept {
  merged_.clear();
  for (int s = first_shape_[tree]; s < first_shape_[tree + 1]; ++s) merged_.push_back(s);
  placeShapes(model, model.settings.step, merged_, state, work.hands, work.placement);
}

void Asleep::fall(const Model& model, State& state, Work& work, Report& report) noexcept {
  bool any = false;
  for (std::size_t at = 0; at < tired_.size(); at += 1 + static_cast<std::size_t>(tired_[at])) {
    const int* trees = &tired_[at + 1];
    const int count = tired_[at];
    if (!mayFall(trees, count, work.standing)) continue;
    any = true;
    const StandingIslands::Standing& stood = work.standing.of(trees[0]);
    const bool waits = state.turn[trees[0]] != 0;
    island_[trees[0]] = {count, 0, -1, contacts_.size(), stood.contacts, false, waits};
    if (waits) waiting_ += count;
    for (int i = 0; i < stood.contacts; ++i) {
      ContactReport& contact = report.contacts[stood.first_contact + i];
      contacts_.push_back(contact);
      flags_ |= flagsOf(contact);
      contact.link_a = -1;  // it leaves the report below
    }
    islands_.push_back(trees[0]);
    trees_ += count;
    for (int n = 0; n < count; ++n) {
      const int t = trees[n];
      sleeper_[t] = {trees[0], n + 1 < count ? trees[n + 1] : -1};
      if (waits) placeWaiting(model, t, state, work);
      for (int i = first_slot_[t]; i < first_slot_[t + 1]; ++i) boxes_.put(i, work.placement.box[model.moving_shapes[i]]);
    }
  }
  if (!any) return;
  leaveReport(work, report.contacts);
  int kept = 0;
  for (int i = 0; i < state.pair_count; ++i) {
    const ActivePair& pair = state.pairs[i];
    const int island = sleeper_[moverOf(model, work.hands, pair)].island;
    if (island < 0) {
      if (kept != i) state.pairs[kept] = pair;
      ++kept;
      continue;
    }
    const int slot = free_pair_;
    free_pair_ = next_pair_[slot];
    pair_[slot] = pair;
    next_pair_[slot] = island_[island].first_pair;
    island_[island].first_pair = slot;
    ++island_[island].pairs;
    ++pair_count_;
  }
  state.pair_count = kept;
  visit(model, work);
}

/// The contacts of what fell asleep leave the report; those of what stands beside it are found where they are then.
void Asleep::leaveReport(Work& work, LoadedVector<ContactReport>& contacts) noexcept {
  merged_.clear();  // by contact: where it goes
  int kept = 0;
  for (int i = 0; i < contacts.size(); ++i) {
    merged_.push_back(kept);
    if (contacts[i].link_a >= 0) contacts[kept++] = contacts[i];
  }
  contacts.resize(kept);
  for (const int t : work.visits.trees) {
    if (sleeper_[t].island >= 0 || !work.standing.holds(t)) continue;
    StandingIslands::Standing standing = work.standing.of(t);
    if (standing.contacts > 0) standing.first_contact = merged_[standing.first_contact];
    work.standing.put(t, standing, false);
  }
}

/// The lists that a step visits, without the sleeping islands.
void Asleep::visit(const Model& model, Work& work) noexcept {
  ++changes_;
  const auto sleeps = [this](int tree) { return sleeper_[tree].island >= 0; };
  const auto drop = [](std::vector<int>& list, auto&& is) { list.erase(std::remove_if(list.begin(), list.end(), is), list.end()); };
  Visits& visits = work.visits;
  drop(visits.trees, sleeps);
  drop(visits.shapes, [&](int s) { return sleeps(model.treeOf(s)); });
  drop(visits.moving, [&](int i) { return sleeps(model.treeOf(model.moving_shapes[i])); });
  work.search.boxes.select(visits.moving);
  work.hands.movers.clear();
  for (const int t : visits.trees) {
    if (work.hands.movesByItself(model.trees[t])) work.hands.movers.push_back(&model.trees[t]);
  }
}

void Asleep::mark(int tree) noexcept {
  const int island = sleeper_[tree].island;
  if (island < 0 || island_[island].wakes) return;
  island_[island].wakes = true;
  ++marked_;
}

void Asleep::wakeNear(const Model& model, double h, State& state, Work& work) noexcept {
  if (islands_.empty()) return;
  for (const int s : work.visits.shapes) {
    eachOverlap(model, work.placement.box[s], [&](int other) {
      if (model.mayCollide(std::min(s, other), std::max(s, other))) mark(model.treeOf(other));
    });
  }
  if (marked_ == 0) return;
  wakeMarked(model, state, work, work.standing.contacts(), true);
  placeShapes(model, h, work.visits.shapes, state, work.hands, work.placement);
}

void Asleep::wakeActed(const Model& model, State& state, Work& work) noexcept {
  for (const PointerState& pointer : state.pointers) {
    if (pointer.targeted && pointer.link >= 0) mark(model.links[pointer.link].articulation);
  }
  if (marked_ > 0) wakeMarked(model, state, work, work.standing.contacts(), true);
}

void Asleep::wakeDue(const Model& model, State& state, Work& work) noexcept {
  if (waiting_ == 0) return;
  for (const int island : islands_) {
    if (island_[island].waits && isDue(state, island)) mark(island);
  }
  if (marked_ > 0) wakeMarked(model, state, work, work.standing.contacts(), true);
}

void Asleep::wakeAll(const Model& model, State& state, Work& work, Report* report) noexcept {
  for (const int island : islands_) mark(island);
  if (marked_ > 0) wakeMarked(model, state, work, report ? report->contacts : work.standing.contacts(), !report);
}

void Asleep::wakeMarked(const Model& model, State& state, Work& work, LoadedVector<ContactReport>& contacts, bool within) noexcept {
  marked_ = 0;
  ++changes_;
  woken_.clear();
  for (const int island : islands_) {
    for (int t = island; island_[island].wakes && t >= 0; t = sleeper_[t].next) woken_.push_back(t);
  }
  std::sort(woken_.begin(), woken_.end());
  takePairs(state);
  takeContacts(work, contacts, within);
  const auto ofTrees = [this](const std::vector<int>& first, auto&& of, std::vector<int>& list) {
    merged_.clear();
    for (const int t : woken_) {
      for (int i = first[t]; i < first[t + 1]; ++i) {
        if (of(i)) merged_.push_back(i);
      }
    }
    merge(merged_, list);
  };
  Visits& visits = work.visits;
  merge(woken_, visits.trees);
  const auto all = [](int) { return true; };
  ofTrees(first_shape_, [&](int s) { return model.links[model.shapes[s].link].moves; }, visits.shapes);
  ofTrees(first_slot_, all, visits.moving);
  for (const int t : woken_) {
    sleeper_[t] = Sleeper{};
    for (int i = first_slot_[t]; i < first_slot_[t + 1]; ++i) boxes_.clear(i);
  }
  trees_ -= static_cast<int>(woken_.size());
  visit(model, work);
}

void lookForPairs(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  placeShapes(model, h, work.visits.shapes, state, work.hands, work.placement);
  work.asleep.wakeNear(model, h, state, work);
  findPairs(model, work.visits, work.placement, work.asleep.pairs(), state, work.search, report);
}

/// Pairs of the islands that wake, among those of the awake ones, in the order of their keys.
void Asleep::takePairs(State& state) noexcept {
  merged_.clear();
  for (const int island : islands_) {
    if (!island_[island].wakes) continue;
    for (int slot = island_[island].first_pair; slot >= 0; slot = next_pair_[slot]) merged_.push_back(slot);
  }
  std::sort(merged_.begin(), merged_.end(), [this](int i, int j) { return pair_[i].key < pair_[j].key; });
  int from = state.pair_count, next = static_cast<int>(merged_.size());  // there is room: findPairs has left it
  state.pair_count += next;
  for (int to = state.pair_count; next > 0;) {
    const ActivePair& added = pair_[merged_[next - 1]];
    const bool before = from > 0 && state.pairs[from - 1].key > added.key;
    --to;
    state.pairs[to] = before ? state.pairs[from - 1] : added;
    --(before ? from : next);
  }
  for (const int slot : merged_) {
    next_pair_[slot] = free_pair_;
    free_pair_ = slot;
  }
  pair_count_ -= static_cast<int>(merged_.size());
}

/// Contacts of the islands that wake become the last of `contacts`, those of the others move up.
void Asleep::takeContacts(Work& work, LoadedVector<ContactReport>& contacts, bool within) noexcept {
  int kept = 0;
  std::size_t asleep = 0;
  for (const int first : islands_) {
    SleepingIsland& island = island_[first];
    if (!island.wakes) {
      for (int i = 0; i < island.contacts; ++i) contacts_[kept + i] = contacts_[island.first_contact + i];
      island.first_contact = kept;
      kept += island.contacts;
      islands_[asleep++] = first;
      continue;
    }
    StandingIslands::Standing standing;
    standing.trees = island.trees;
    standing.pairs = island.pairs;
    standing.first_contact = contacts.size();
    standing.contacts = island.contacts;
    for (int i = 0; i < island.contacts; ++i) contacts.push_back(contacts_[island.first_contact + i]);
    for (int t = first; t >= 0; t = sleeper_[t].next) work.standing.put(t, standing, within);
    if (island.waits) waiting_ -= island.trees;
    island.wakes = false;
  }
  contacts_.resize(kept);
  islands_.resize(asleep);
  flags_ = 0;
  for (const ContactReport& contact : contacts_) flags_ |= flagsOf(contact);
}

}  // namespace haptic::stepping
