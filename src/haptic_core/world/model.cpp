#include "haptic_core/world/model.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/symmetric_matrix.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/pairs/internal_faces.h"

namespace haptic {
namespace {

std::uint64_t pairKey(int a, int b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

/// Shapes that move whose boxes may overlap that of another at once, in the mean. A heap of 300 cubes has 8; rods of ten widths that
/// lie densely any way have some 40 by estimate, for a box about a slanted rod is mostly empty. Fewer: their heaps lose pairs, which is
/// flagged; more: memory and time at load, 3.5 kB a pair.
constexpr int kNeighboursPerShape = 64;
/// Of shapes that never move, a shape has so many neighbours as may overlap it at once, but at most these: one that lies on more pieces
/// of ground is computed with the first of them, and flagged.
constexpr int kMostFixedNeighbours = 1024;

/// Up to this many possible pairs per shape, testing each of them costs fewer instructions than sorting the boxes and
/// ordering the pairs of the sweep (10 a pair against about 100 a box). Beyond, the list would grow like N²; and beyond kMostListed a
/// tree of the shapes that never move costs less.
constexpr int kListedPairsPerShape = 8, kMostListed = 2048;

/// A pair that starts deeper than this share of the thinner shape's width is not at rest under its weight.
constexpr double kBuried = 0.01;
/// Weights of all that moves that a depth has to carry before it counts as buried. It is pushed out with no more than that: with one,
/// a body alone in the world would rest at any depth, and one that starts at rest would sink [1].
constexpr double kCarries = 2;
/// Swing of a rigid contact in a step, at least [rad]. Ten times as much: friction that begins to slide is not solved, and a wedge of 5°
/// that is pulled from under a load chatters by 3 % of its pull; a tenth: what falls from its own height goes a thousandth of it deep.
constexpr double kRigidSwing = 100;

/// Largest side of the box around all shapes of a link [m²]; infinite where one has no end.
double sectionOf(const LinkDef& link) {
  Vector3 lower = Vector3::Constant(std::numeric_limits<double>::infinity()), upper = -lower;
  for (const CollisionDef& collision : link.collisions) {
    if (!collision.shape || !collision.shape->bounded()) return std::numeric_limits<double>::infinity();
    const ConvexShape::Box box = collision.shape->aabb(collision.X_LS);
    lower = lower.cwiseMin(box.lower);
    upper = upper.cwiseMax(box.upper);
  }
  const Vector3 size = upper - lower;
  return size.prod() / size.minCoeff();
}
/// Speeds of recovery are those of falls; without gravity, of falls in a thousandth of the earth's [m/s²].
constexpr double kLeastGravity = 0.01;

bool sameMaterial(const ContactMaterial& a, const ContactMaterial& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

std::string number(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

Model::Model(const WorldDef& def) : name(def.name), settings(def.settings), pointers(def.pointers) {
  checkSettings();
  addTrees(def);
  addLoops(def);
  addMaterials(def);
  addFilters(def);
  addForces(def);
  checkPointers(def);
  drive_paths = drivePaths(def, *this);
  addMotions(def);
  tuning.gravity = settings.gravity;
  for (const PointerDef& pointer : pointers) tuning.coupling.push_back(pointer.coupling);
  sortShapes();
  findInternalFaces();
  has_seams = std::any_of(shapes.begin(), shapes.end(), [](const ModelShape& shape) { return !shape.surface.empty(); });
  countPairs();
  chooseVisits();
  const bool may_wait = settings.leave_out && implicit_steps && listed_pairs.empty() && !pointers.empty() && def.sensors.empty();
  if (may_wait && has_contacts) {
    turn_steps = std::max(1, static_cast<int>(std::lround(settings.far_step / settings.step)));
  }
  measureWidths();
}

void Model::checkPointers(const WorldDef& def) const {
  for (const PointerDef& p : def.pointers) {
    if (p.articulation < 0 || p.articulation >= static_cast<int>(def.articulations.size()) || p.link < 0 ||
        p.link >= static_cast<int>(def.articulations[p.articulation].links.size())) {
      throw SetupError(def.name, "pointer of device " + p.device + " names a link that does not exist",
                       "name one of the scene's links");
    }
  }
}

void Model::addMotions(const WorldDef& def) {
  motions = compileMotions(def, *this);
  for (const ModelMotion& motion : motions) links[motion.link].led = true;
}

void Model::checkSettings() const {
  const WorldSettings& s = settings;
  if (!(s.step > 0 && s.step <= 0.1)) {
    throw SetupError(name, "step is " + number(s.step) + " s", "give a step > 0 and <= 0.1 s");
  }
  if (s.history_steps < 0 || s.history_steps > 100000) {
    throw SetupError(name, "history_steps is " + std::to_string(s.history_steps), "give 0 to 100000");
  }
  if (!(s.far_step >= 0 && s.far_step <= kMostTurnSteps * s.step * (1 + 1e-9))) {
    throw SetupError(name, "far_step is " + number(s.far_step) + " s",
                     "give at most " + std::to_string(kMostTurnSteps) + " steps, " + number(kMostTurnSteps * s.step) + " s, or 0");
  }
  if (!(s.accuracy > 0 && s.accuracy <= 1)) {
    throw SetupError(name, "accuracy is " + number(s.accuracy), "give a share > 0 and <= 1 of the way that forces move a body in a step");
  }
  if (!s.gravity.allFinite()) throw SetupError(name, "gravity is not finite", "give three numbers in m/s^2");
  check(s.default_material, name + ", default material");
}

void Model::addLink(const LinkDef& link, int local, const WorldDef& world) {
  const ModelTree& tree = trees.back();
  const LinkModel& model = tree.model->link(local);
  ModelLink entry;
  entry.name = link.name;
  entry.articulation = static_cast<int>(trees.size()) - 1;
  entry.local = local;
  entry.mass = link.inertia.mass;
  entry.least_inertia = principalAxes(link.inertia.I_C).value[0];
  for (const CollisionDef& collision : link.collisions) {
    if (!collision.shape || !collision.shape->bounded()) continue;  // which turns about no centre
    const Vector3 centre = collision.X_LS * collision.shape->centre() - link.inertia.p_LC;
    entry.size = std::max(entry.size, centre.norm() + collision.shape->boundingRadius());
  }
  if (entry.size == 0) entry.size = 1;
  entry.section = sectionOf(link);
  entry.moves = model.dof > 0 || (model.parent >= 0 && links[tree.link + model.parent].moves);
  has_joints |= model.dof > 0 && !model.floating;
  for (const CollisionDef& collision : link.collisions) {
    const std::string where = world.name + ", link " + link.name;
    if (!collision.shape) throw SetupError(where, "a collision has no shape", "give it a polyhedron, a ball, a rod or a half-space");
    if (!collision.shape->bounded() && entry.moves) {
      throw SetupError(where, "it moves and has a half-space, which has no end",
                       "put the half-space on a link that is fixed to the world, or give the link a box");
    }
    check(collision.material, where);
    ModelShape shape;
    shape.owner = collision.shape;
    shape.shape = collision.shape.get();
    shape.link = static_cast<int>(links.size());
    shape.X_LS = collision.X_LS;
    shape.width = collision.shape->leastWidth();
    shape.look = 0.5 * units::kLook + (collision.shape->flat() || collision.shape->sides().size() == 1 ? 0 : units::kCurved);
    shape.belt = collision.belt;
    if (shape.belt.moves()) {
      const Twist& V = shape.belt.V_L;
      if (!V.angular.allFinite() || !V.linear.allFinite()) {
        throw SetupError(where, "its surface velocity is not finite", "write m/s and rad/s");
      }
      const bool turns = !V.angular.isZero(0);
      if (turns && !collision.shape->bounded()) {
        throw SetupError(where, "its surface turns and has no end, so it is as fast as you like somewhere", "let a cylinder turn");
      }
      const double reach = turns ? (collision.X_LS * collision.shape->centre()).norm() + collision.shape->boundingRadius() : 0;
      has_belts = true;
      belt_speed = std::max(belt_speed, V.linear.norm() + reach * V.angular.norm());
    }
    shape.name = collision.name.empty() ? link.name : collision.name;
    const auto found = std::find_if(materials_.begin(), materials_.end(),
                                    [&](const ContactMaterial& m) { return sameMaterial(m, collision.material); });
    shape.material = static_cast<int>(found - materials_.begin());
    if (found == materials_.end()) materials_.push_back(collision.material);
    shapes.push_back(std::move(shape));
  }
  links.push_back(std::move(entry));
}

void Model::addMaterials(const WorldDef& def) {
  const int n = static_cast<int>(materials_.size());
  laws_.resize(static_cast<std::size_t>(n) * n);
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) {
      PairLaw& law = laws_[static_cast<std::size_t>(a) * n + b];
      law.material = combine(materials_[a], materials_[b], def.settings.default_material);
      law.pressure = def.settings.pressure_law;
      law.torsion = def.settings.torsional_friction;
      const ContactMaterial& otherwise = def.settings.default_material;
      law.rigid = isRigid(materials_[a], materials_[b], otherwise);
      law.shear_follows = std::isnan(materials_[a].tangential_stiffness) && std::isnan(materials_[b].tangential_stiffness) &&
                          std::isnan(otherwise.tangential_stiffness);
      has_friction |= law.material.mu_static > 0;
    }
  }
  defined_laws_ = laws_;
}

void Model::tune(const WorldTuning& wanted) {
  tuning = wanted;
  settings.gravity = tuning.gravity;
  const double stiffness = tuning.stiffness_scale, friction = tuning.friction_scale;
  for (std::size_t i = 0; i < laws_.size(); ++i) {
    const ContactMaterial& defined = defined_laws_[i].material;
    ContactMaterial& material = laws_[i].material;
    material.stiffness = stiffness * defined.stiffness;
    material.tangential_stiffness = stiffness * defined.tangential_stiffness;
    material.mu_static = friction * defined.mu_static;
    material.mu_dynamic = friction * defined.mu_dynamic;
  }
}

void Model::addFilters(const WorldDef& def) {
  for (const CollisionFilter& f : def.filters) {
    excluded_.push_back(pairKey(link(f.articulation_a, f.link_a), link(f.articulation_b, f.link_b)));
  }
  for (const ModelTree& tree : trees) {
    for (int i = 0; i < tree.model->linkCount(); ++i) {
      const int parent = tree.model->link(i).parent;
      if (parent >= 0) excluded_.push_back(pairKey(tree.link + parent, tree.link + i));
    }
  }
  std::sort(excluded_.begin(), excluded_.end());
  excluded_.erase(std::unique(excluded_.begin(), excluded_.end()), excluded_.end());
}

bool Model::hasLink(int articulation, int local) const {
  const int count = static_cast<int>(first_link_.size());
  if (articulation < 0 || articulation >= count || local < 0) return false;
  const ModelTree& tree = trees[links[first_link_[articulation]].articulation];
  int end = tree.link + tree.model->linkCount();  // or where the next articulation of a joined tree begins
  for (const int first : first_link_) {
    if (first > first_link_[articulation]) end = std::min(end, first);
  }
  return first_link_[articulation] + local < end;
}

bool Model::mayCollide(int a, int b) const {
  const int la = shapes[a].link, lb = shapes[b].link;
  const auto pushed = [this](int link) { return links[link].moves && !links[link].led; };
  if (la == lb || !(pushed(la) || pushed(lb))) return false;
  return !std::binary_search(excluded_.begin(), excluded_.end(), pairKey(la, lb));
}

void Model::sortShapes() {
  std::vector<LinkWork> work(links.size());
  for (const ModelTree& tree : trees) {
    forwardKinematics(*tree.model, q_start.data() + tree.q, v_start.data() + tree.v, work.data() + tree.link);
  }
  int next = 0;
  for (ModelTree& tree : trees) {
    tree.shape = next;
    while (next < static_cast<int>(shapes.size()) && shapes[next].link < tree.link + tree.model->linkCount()) ++next;
    tree.shape_end = next;
  }
  std::vector<ConvexShape::Box> boxes;
  for (int s = 0; s < static_cast<int>(shapes.size()); ++s) {
    const ModelShape& shape = shapes[s];
    if (links[shape.link].moves) {
      moving_shapes.push_back(s);
      continue;
    }
    fixed_shapes.push_back(s);
    X_WF_.push_back(work[shape.link].X_WL * shape.X_LS);
    boxes.push_back(shape.shape->aabb(X_WF_.back()));
  }
  fixed_boxes = BoxTree(boxes);
}

/// Pieces of one link touch one another, and so do bodies that never move: a floor of several boxes is one body.
void Model::findInternalFaces() {
  std::vector<std::vector<int>> groups(links.size());
  for (const int s : moving_shapes) groups[shapes[s].link].push_back(s);
  groups.push_back(fixed_shapes);
  for (const std::vector<int>& group : groups) {
    if (group.size() < 2) continue;
    const bool fixed = &group == &groups.back();
    std::vector<PlacedPiece> pieces;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const ModelShape& shape = shapes[group[i]];
      pieces.push_back({shape.shape, fixed ? X_WF_[i] : shape.X_LS});
    }
    InternalFaces internal = internalFaces(pieces);
    for (std::size_t i = 0; i < group.size(); ++i) {
      shapes[group[i]].inner = std::move(internal.inner[i]);
      shapes[group[i]].surface = std::move(internal.surface[i]);
    }
    for (const auto& pair : internal.neighbours) neighbours_.push_back(pairKey(group[pair.first], group[pair.second]));
  }
  std::sort(neighbours_.begin(), neighbours_.end());
}

bool Model::areNeighbours(int a, int b) const {
  return std::binary_search(neighbours_.begin(), neighbours_.end(), pairKey(a, b));
}

void Model::countPairs() {
  const int n = static_cast<int>(shapes.size());
  for (const int a : moving_shapes) {
    for (int b = 0; b < n; ++b) {
      const bool counted = links[shapes[b].link].moves && b <= a;
      if (!counted && mayCollide(std::min(a, b), std::max(a, b))) ++possible_pairs;
    }
  }
  has_contacts = possible_pairs > 0;
  const long between = kNeighboursPerShape * static_cast<long>(moving_shapes.size()) / 2;  // a pair is a neighbour of both its shapes
  pair_capacity = static_cast<int>(std::min<long>(possible_pairs, 64L + between + fixedNeighbours()));
}

/// Most shapes that never move whose boxes a box of that width can overlap at once: as many as there are with so many near them. Two that
/// it overlaps are no farther apart along any axis than it is wide; so of k at once each has k near it, itself among them.
int Model::fixedWithin(double width) const {
  std::vector<int> with(kMostFixedNeighbours + 1, 0);  // by number near: shapes
  for (std::size_t f = 0; f < fixed_shapes.size(); ++f) {
    const ConvexShape::Box box = shapes[fixed_shapes[f]].shape->aabb(X_WF_[f]);
    int near = 0;
    fixed_boxes.eachOverlap({box.lower.array() - width, box.upper.array() + width}, [&near](int) { ++near; });
    ++with[std::min(near, kMostFixedNeighbours)];
  }
  int most = kMostFixedNeighbours;
  for (int found = with[most]; found < most; found += with[most]) --most;
  return most;
}

/// Most pairs of boxes that all shapes that move can have with what never moves.
int Model::fixedNeighbours() const {
  long sum = 0;
  std::vector<std::pair<double, int>> known;  // by width: a heap's bodies are alike
  for (const int s : moving_shapes) {
    const ConvexShape::Box own = shapes[s].shape->aabb(Pose());
    const double width = (own.upper - own.lower).norm();  // of its box however it is turned, at most
    auto found = std::find_if(known.begin(), known.end(), [&](const auto& entry) { return entry.first == width; });
    if (found == known.end()) found = known.emplace(known.end(), width, fixedWithin(width));
    sum += found->second;
  }
  return static_cast<int>(std::min<long>(sum, std::numeric_limits<int>::max() / 2));
}

void Model::chooseVisits() {
  const bool all = !settings.leave_out;
  for (int t = 0; t < static_cast<int>(trees.size()); ++t) {
    if (all || !trees[t].model->isStatic()) updated_trees.push_back(t);
  }
  const int n = static_cast<int>(shapes.size());
  searches_pairs = all || has_contacts;
  for (int s = 0; s < n; ++s) {
    if (all || (has_contacts && links[shapes[s].link].moves)) updated_shapes.push_back(s);
  }
  // Links that nothing touches and neither hands nor springs pull are never too stiff: they flow.
  const bool may_be_stiff = all || has_contacts || !pointers.empty() || !forces.empty();
  implicit_steps = !settings.comparator && (settings.attempts != Attempts::kAll || may_be_stiff);
  if (all || possible_pairs > std::min<long>(static_cast<long>(kListedPairsPerShape) * n, kMostListed)) return;
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      if (mayCollide(a, b)) listed_pairs.emplace_back(a, b);
    }
  }
}

void Model::measureWidths() {
  least_width.assign(links.size(), std::numeric_limits<double>::infinity());
  own_width = least_width;
  const int n = static_cast<int>(shapes.size());
  for (const ModelShape& shape : shapes) {
    double& width = links[shape.link].moves ? own_width[shape.link] : fixed_width;
    width = std::min(width, shape.width);
  }
  for (const int a : moving_shapes) {
    for (int b = 0; b < n; ++b) {
      if (!mayCollide(std::min(a, b), std::max(a, b))) continue;
      const double width = std::min(shapes[a].width, shapes[b].width);
      for (int s : {a, b}) least_width[shapes[s].link] = std::min(least_width[shapes[s].link], width);
    }
  }
}

void Model::reserve(ContactWorkspace& workspace) const {
  std::vector<const ConvexShape*> all;
  for (const ModelShape& shape : shapes) all.push_back(shape.shape);
  workspace.reserve(all);
}

PairLaw Model::law(int a, int b, bool a_held, bool b_held) const {
  PairLaw law = laws_[static_cast<std::size_t>(shapes[a].material) * materials_.size() + shapes[b].material];
  const auto mass = [this](int shape, bool held) {
    const ModelLink& link = links[shapes[shape].link];
    return held || !link.moves ? std::numeric_limits<double>::infinity() : link.mass;
  };
  const double ma = mass(a, a_held), mb = mass(b, b_held);
  // Two bodies that nothing moves (a hand's pointer on a fixed wall) have no mass of their own: one kilogram
  // makes their tangential damper finite.
  law.reduced_mass = std::isinf(ma) && std::isinf(mb) ? 1.0 : 1 / (1 / ma + 1 / mb);
  if (law.rigid) stiffenRigid(a, b, law);
  return law;
}

/// Two bodies that lie on each other by all of S, the section of the smaller one, swing on k S by kRigidSwing in a step at least: under its
/// own weight a body rests g (h/kRigidSwing)² deep, and what hits at a speed v stops within v h/kRigidSwing.
void Model::stiffenRigid(int a, int b, PairLaw& law) const {
  const ModelLink &A = links[shapes[a].link], &B = links[shapes[b].link];
  const auto share = [](const ModelLink& link) { return link.moves ? 1 / link.mass : 0; };
  const double swing = kRigidSwing / settings.step, inverse = share(A) + share(B);
  if (!(inverse > 0)) return;
  const double k = tuning.stiffness_scale * swing * swing / (inverse * std::min(A.section, B.section));
  if (!(k > law.material.stiffness)) return;
  if (law.shear_follows) law.material.tangential_stiffness *= k / law.material.stiffness;
  law.material.stiffness = k;
}

double Model::buriedDepth(int a, int b, double area) const {
  double weight = 0;
  for (const ModelLink& link : links) weight += link.moves && !link.led ? link.mass * settings.gravity.norm() : 0;
  const double carries = area > 0 ? kCarries * weight / (law(a, b, false, false).material.stiffness * area) : 0;
  return std::max(kBuried * std::min(shapes[a].width, shapes[b].width), carries);
}

/// Hunt–Crossley with c = 1/sqrt(g · width): a body that was pressed in leaves no faster than after a fall of half its width. The
/// pressure grows no more beyond the depth at which the pair counts as buried, so that a step that holds the contact at
/// rest pushes it out as well.
PairLaw Model::recoveryLaw(const PairLaw& law, int a, int b, const ContactVolume& volume) const {
  PairLaw recovery = law;
  const double width = std::min(shapes[a].width, shapes[b].width);
  const double c = 1 / std::sqrt(std::max(settings.gravity.norm(), kLeastGravity) * width);
  recovery.material.dissipation =
      !jumpsAtTouch(law.pressure) ? std::max(law.material.dissipation, c) : c;
  recovery.pressure = PressureLaw::kHuntCrossley;
  const double share = std::min(1.0, buriedDepth(a, b, volume.A0) / volume.depth);
  recovery.material.stiffness *= share;
  recovery.material.tangential_stiffness *= share;
  return recovery;
}

std::string Model::text() const {
  std::ostringstream out;
  const long all = static_cast<long>(shapes.size()) * (static_cast<long>(shapes.size()) - 1) / 2;
  out << "plan of " << name << "\n  " << links.size() << " links in " << trees.size() << " trees, " << nv
      << " degrees of freedom, " << shapes.size() << " convex shapes\n  step " << settings.step * 1e3
      << " ms\n  pairs: " << possible_pairs << " of " << all
      << " can touch; the others are fixed both, on one link, neighbours or filtered\n";
  const auto stage = [&](bool present, const std::string& name, const std::string& reason) {
    out << "  " << (present ? "runs     " : "left out ") << name << (present ? "" : ": ") << (present ? "" : reason)
        << "\n";
  };
  stage(has_contacts, "contact", "nothing can touch");
  stage(has_friction && has_contacts, "friction and its memory", "every pair is frictionless");
  const auto is_round = [](const ModelShape& shape) { return !shape.shape->flat(); };
  if (kindOf(settings.pressure_law).potential && std::any_of(shapes.begin(), shapes.end(), is_round)) {
    stage(false, "potential of round shapes", "balls on flat faces and on balls have it; else they press with k V n");
  }
  stage(has_joints, "articulated pass", "no joints: free and fixed bodies only");
  stage(commands > 0, "joint limits, damping, friction, drives, mimics, loops", "no joint has any");
  stage(!forces.empty(), "forces between links", "no spring and no field");
  stage(!pointers.empty(), "pointer coupling", "no pointer");
  stage(!allFlows(), "solves of islands", "nothing can touch or pull: all flows");
  const std::string of_turns = turn_steps > 1 ? ", of " + std::to_string(turn_steps) + " steps" : "";
  if (settings.far_step > 0) {
    stage(turn_steps > 1, "turns of islands far from the hands" + of_turns,
          "a world with a hand, many bodies, and no sensors, and a step shorter than far_step and 2 ms has them");
  }
  stage(settings.energy_ledger, "energy ledger", "switched off");
  if (!settings.leave_out) {
    out << "  the general pipeline: every stage visits everything\n";
    return out.str();
  }
  const std::size_t still = trees.size() - updated_trees.size(), placed = shapes.size() - updated_shapes.size();
  if (still > 0) stage(false, "kinematics of " + std::to_string(still) + " trees", "fixed, computed once");
  if (placed > 0) stage(false, "poses and boxes of " + std::to_string(placed) + " shapes", "fixed, computed once");
  stage(!has_contacts || listed_pairs.empty(), "sorting of boxes",
        std::to_string(listed_pairs.size()) + " possible pairs are tested one by one");
  return out.str();
}

}  // namespace haptic
