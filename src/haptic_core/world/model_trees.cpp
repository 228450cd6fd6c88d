/// Which articulations share a tree, where the trees lie in the world's state, which joints they have.
#include <algorithm>
#include <numeric>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/joint_law.h"
#include "haptic_core/world/model.h"

namespace haptic {
namespace {

bool isStatic(const ArticulationDef& def) {
  return std::all_of(def.links.begin(), def.links.end(),
                     [](const LinkDef& link) { return link.joint.type == JointType::kFixed; });
}

/// Articulations by group: those that loops hold together; a static one is alone, since a loop to it is one
/// to the world.
std::vector<std::vector<int>> groups(const WorldDef& def) {
  const int n = static_cast<int>(def.articulations.size());
  std::vector<int> group(n);
  std::iota(group.begin(), group.end(), 0);
  for (const LoopDef& loop : def.loops) {
    const int a = loop.articulation_a, b = loop.articulation_b;
    if (a < 0 || b < 0 || isStatic(def.articulations[a]) || isStatic(def.articulations[b])) continue;
    const int kept = std::min(group[a], group[b]), gone = std::max(group[a], group[b]);
    for (int& g : group) g = g == gone ? kept : g;
  }
  std::vector<std::vector<int>> members(n);
  for (int i = 0; i < n; ++i) members[group[i]].push_back(i);
  members.erase(std::remove_if(members.begin(), members.end(), [](const auto& m) { return m.empty(); }),
                members.end());
  return members;
}

/// Several articulations as one definition, its roots given in W.
TreeDef join(const WorldDef& world, const std::vector<int>& articulations) {
  if (articulations.size() == 1) return haptic::treeOf(world.articulations[articulations[0]]);
  TreeDef joined;
  for (int i : articulations) {
    const ArticulationDef& def = world.articulations[i];
    const int first = static_cast<int>(joined.links.size());
    joined.name += (joined.name.empty() ? "" : "+") + def.name;
    for (BodyDef body : def.links) {
      if (body.parent < 0) body.joint.X_PJ = def.X_WA * body.joint.X_PJ;
      if (body.parent >= 0) body.parent += first;
      if (body.joint.mimic_joint >= 0) body.joint.mimic_joint += first;
      joined.links.push_back(body);
    }
  }
  return joined;
}

bool hasLaws(const Articulation& model) {
  for (int i = 0; i < model.linkCount(); ++i) {
    const JointDef& joint = model.def().links[i].joint;
    const int dof = model.link(i).dof;
    if (dof > 0 && dof < 6 && (joint.damping > 0 || joint.mimic_joint >= 0 || (dof == 1 && hasLaw(joint))))
      return true;
  }
  return false;
}

}  // namespace

void Model::addTrees(const WorldDef& def) {
  for (const LoopDef& loop : def.loops) {
    for (const auto& [articulation, link] :
         {std::pair{loop.articulation_a, loop.link_a}, std::pair{loop.articulation_b, loop.link_b}}) {
      const bool world = articulation < 0;
      if (world || (articulation < static_cast<int>(def.articulations.size()) && link >= 0 &&
                    link < static_cast<int>(def.articulations[articulation].links.size())))
        continue;
      throw SetupError(def.name + ", loop " + loop.name, "joins a link that does not exist",
                       "name the scene's links");
    }
  }
  first_link_.resize(def.articulations.size());
  for (const ArticulationDef& articulation : def.articulations) link_count_.push_back(static_cast<int>(articulation.links.size()));
  for (const std::vector<int>& group : groups(def)) addTree(def, group);
}

void Model::addTree(const WorldDef& world, const std::vector<int>& articulations) {
  trees.emplace_back();
  ModelTree& tree = trees.back();
  tree.model = std::make_shared<const Articulation>(join(world, articulations));
  tree.q = nq;
  tree.v = nv;
  tree.link = static_cast<int>(links.size());
  tree.has_laws = hasLaws(*tree.model);
  nq += tree.model->nq();
  nv += tree.model->nv();
  q_start.resize(nq);
  v_start.resize(nv);
  int local = 0;
  for (int i : articulations) {
    const ArticulationDef& def = world.articulations[i];
    first_link_[i] = tree.link + local;
    if (!def.links.empty()) {  // each in its own frame A, which a joined tree does not have
      const LinkModel& first = tree.model->link(local);
      Articulation(haptic::treeOf(def)).initialState(q_start.data() + tree.q + first.q, v_start.data() + tree.v + first.v);
    }
    for (const LinkDef& link : def.links) addLink(link, local++, world);
  }
  addJoints(tree);
}

void Model::addJoints(const ModelTree& tree) {
  for (int i = 0; i < tree.model->linkCount(); ++i) {
    const LinkModel& model = tree.model->link(i);
    if (model.dof != 1) continue;
    const JointDef& def = tree.model->def().links[i].joint;
    joints.push_back({def.name, tree.link + i, tree.q + model.q, tree.v + model.v, isDriven(ownLaw(def))});
  }
}

void Model::addLoops(const WorldDef& def) {
  for (const LoopDef& loop : def.loops) {
    RingDef ring;
    ring.name = loop.name;
    ring.type = loop.type;
    ring.axis = loop.axis;
    ring.X_AF = loop.X_AF;
    ring.X_BF = loop.X_BF;
    int owner = -1;
    const auto place = [&](int articulation, int link, int& ring_link, Pose& X_LF) {
      if (articulation < 0) return;
      if (isStatic(def.articulations[articulation])) {
        Pose X_WL = def.articulations[articulation].X_WA;
        std::vector<Pose> X_AL;
        for (const LinkDef& l : def.articulations[articulation].links) {
          X_AL.push_back((l.parent < 0 ? X_WL : X_AL[l.parent]) * l.joint.X_PJ);
        }
        X_LF = X_AL[link] * X_LF;
        return;
      }
      const ModelLink& place = links[this->link(articulation, link)];
      owner = place.articulation;
      ring_link = place.local;
    };
    place(loop.articulation_a, loop.link_a, ring.link_a, ring.X_AF);
    place(loop.articulation_b, loop.link_b, ring.link_b, ring.X_BF);
    if (owner < 0) {
      throw SetupError(def.name + ", loop " + loop.name, "joins two bodies that never move", "take it out");
    }
    trees[owner].rings.push_back(ring);
    trees[owner].has_laws = true;
  }
  for (ModelTree& tree : trees) {
    if (!tree.has_laws) continue;
    tree.command = commands;
    commands += tree.model->linkCount();
  }
}

}  // namespace haptic
