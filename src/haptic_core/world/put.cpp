#include "haptic_core/world/put.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/world/initial_overlap.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

/// Longest time that a wrench acts [s]: a day. Whoever wants it for longer asks again.
constexpr double kLongestWrench = 86400;
/// Largest number of a wrench, pose or twist that is given [N, m, …]: beyond it products overflow, and the world stops.
constexpr double kMostGiven = 1e9;

void requireLink(const Model& model, const char* what, int link) {
  if (link >= 0 && link < static_cast<int>(model.links.size())) return;
  throw SetupError(what, "there is no link " + std::to_string(link), "the scene has " + std::to_string(model.links.size()));
}

/// What wrenches on a link do in one step, were it free: in shares of its size and of a radian.
struct StepShares {
  double way = 0, turn = 0;
};

/// A link without inertia of its own moves with others of its tree: it counts as a thousandth of that.
StepShares sharesOf(const Model& model, int link, const LinkWrench& wrench, const Matrix3& R_WL) {
  constexpr double kOfTree = 1e-3;
  const ModelLink& named = model.links[link];
  const Articulation& tree = *model.trees[named.articulation].model;
  const LinkModel& its = tree.link(named.local);
  double mass = 0;
  for (int i = 0; i < tree.linkCount(); ++i) mass += tree.link(i).mass;
  const double least = kOfTree * mass, h = model.settings.step;
  const auto inLink = [&](const Vector3& f) { return wrench.in_link ? f : Vector3(R_WL.transpose() * f); };
  const Vector3 force = inLink(wrench.F.force), lever = wrench.p_L - its.p_LO - its.p_OC;
  const Vector3 torque = inLink(wrench.F.torque) + lever.cross(force);
  const double accelerates = std::fmin(its.mobility, 1 / least) * force.norm();
  const double turns = std::fmin((its.turn_mobility * torque).norm(), torque.norm() / (least * named.size * named.size));
  return {accelerates * h * h / named.size, turns * h * h};
}

/// Refuses a wrench that, with the others on its link, moves it by its size in a step, or turns it by a radian: no step resolves that.
void requireResolved(const Model& model, int link, const LinkWrench& wrench, const State& state, const Matrix3& R_WL) {
  const StepShares own = sharesOf(model, link, wrench, R_WL);
  StepShares all = own;
  for (int i = 0; i < state.wrench_count; ++i) {
    if (state.wrenches[i].link != link) continue;
    const StepShares other = sharesOf(model, link, state.wrenches[i].wrench, R_WL);
    all.way += other.way, all.turn += other.turn;
  }
  const double most = std::fmax(all.way, all.turn);
  if (most <= 1) return;
  const double rest = 1 - (most - std::fmax(own.way, own.turn));
  std::ostringstream text, remedy;
  text.precision(3), remedy.precision(3);
  text << "would move link " << model.links[link].name << " by " << all.way << " of its size, " << model.links[link].size
      << " m, and turn it by "
       << all.turn << " rad in one step";
  remedy << "give at most " << std::fmax(0, rest) / std::fmax(own.way, own.turn) << " of it";
  throw SetupError("wrench", text.str(), remedy.str());
}

/// Nothing but forces moves any link of the tree.
void requireLoose(const Model& model, const char* what, int tree, const State& state, const HandWork& hands) {
  const ModelTree& its = model.trees[tree];
  const std::string& name = model.links[its.link].name;
  if (its.model->isStatic()) throw SetupError(what, "link " + name + " is fixed to the world", "name one that moves");
  if (hands.held_by[its.link] >= static_cast<int>(model.pointers.size())) {
    throw SetupError(what, "link " + name + " is led along a motion", "name one that nothing leads");
  }
  for (const PointerState& pointer : state.pointers) {
    if (pointer.link < 0 || model.links[pointer.link].articulation != tree) continue;
    throw SetupError(what, "link " + model.links[pointer.link].name + " is in a hand", "let the hand go of it first");
  }
}

/// The tree is elsewhere: contacts begin anew, and what acts on it now is not what did.
void settleAnew(const Model& model, int tree, State& state, Work& work) {
  for (const int i : state.pairs.awake()) {
    ActivePair& pair = state.pairs[i];
    if (model.treeOf(pair.shapeA()) != tree && model.treeOf(pair.shapeB()) != tree) continue;
    const std::uint64_t key = pair.key;
    pair = ActivePair{};
    pair.key = key;
  }
  placeTree(model.trees[tree], state, work.placement);
  findBuried(model, tree, state, work);
  state.mode[tree] = TreeMode::kPut;  // as at the start
  state.beginAnew(tree);
  state.calm[tree] = 0;
  eachForce(model, TreeRange{&tree, 1}, [tree](int t) { return t == tree; }, [&](int, const ModelForce& force) {
    for (const int other : {force.tree_a, force.tree_b}) {  // its end is elsewhere
      if (other >= 0) state.beginAnew(other);
    }
  });
  renewSupply(model, work, state);
}

/// Joints that follow others go where these were put: closing would move leaders and followers towards each other.
void putFollowers(const Articulation& tree, double* q) {
  const std::vector<BodyDef>& links = tree.def().links;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const JointDef& joint = links[i].joint;
    if (joint.mimic_joint < 0) continue;
    q[tree.link(static_cast<int>(i)).q] = joint.mimic_multiplier * q[tree.link(joint.mimic_joint).q] + joint.mimic_offset;
  }
}

}  // namespace

void putFree(const Vector3& p_LO, const Vector3& p_WL, const Quaternion& q_WL, const Twist& V_WL, double* q, double* v) noexcept {
  const Vector3 p_LO_W = q_WL * p_LO, p_WO = p_WL + p_LO_W, v_WO = V_WL.linear + V_WL.angular.cross(p_LO_W);
  const double pose[7] = {p_WO.x(), p_WO.y(), p_WO.z(), q_WL.w(), q_WL.x(), q_WL.y(), q_WL.z()};
  std::copy_n(pose, 7, q);
  std::copy_n(V_WL.angular.data(), 3, v);
  std::copy_n(v_WO.data(), 3, v + 3);
}

void applyWrench(const Model& model, int link, const LinkWrench& wrench, double seconds, State& state, Work& work) {
  constexpr char kWhat[] = "wrench";
  requireLink(model, kWhat, link);
  if (!(seconds >= 0 && seconds <= kLongestWrench)) {
    throw SetupError(kWhat, "its time is " + std::to_string(seconds) + " s", "give 0 to 86400 s; 0 ends what acts on the link");
  }
  if (!(wrench.F.force.norm() <= kMostGiven && wrench.F.torque.norm() <= kMostGiven && wrench.p_L.norm() <= kMostGiven)) {
    throw SetupError(kWhat, "has a number beyond 1e9, or one that is not finite", "write newtons, newton metres and metres");
  }
  const int tree = model.links[link].articulation;
  if (seconds > 0) {
    const std::string& name = model.links[link].name;
    if (!model.links[link].moves) throw SetupError(kWhat, "link " + name + " is fixed to the world", "name one that moves");
    if (work.hands.held_by[link] >= 0) {
      throw SetupError(kWhat, "link " + name + " goes where it is led", "name one that no hand holds and no motion leads");
    }
    if (state.wrench_count == kMostWrenches) {
      throw SetupError(kWhat, std::to_string(kMostWrenches) + " act already", "wait for one to end, or end those of a link by 0 s");
    }
    requireResolved(model, link, wrench, state, work.placement.link[link].X_WL.R);
    const auto steps = static_cast<std::uint64_t>(std::max(1LL, std::llround(seconds / model.settings.step)));
    state.wrenches[state.wrench_count++] = {link, state.step + steps, wrench};
  } else {
    const auto of_link = [link](const AppliedWrench& applied) { return applied.link == link; };
    const auto first = state.wrenches.begin();
    state.wrench_count = static_cast<int>(std::remove_if(first, first + state.wrench_count, of_link) - first);
  }
  state.beginAnew(tree);
}

void putBody(const Model& model, int link, const Pose& X_WL, const Twist& V_WL, State& state, Work& work) {
  constexpr char kWhat[] = "body pose";
  requireLink(model, kWhat, link);
  const int t = model.links[link].articulation;
  const ModelTree& tree = model.trees[t];
  requireLoose(model, kWhat, t, state, work.hands);
  const LinkModel& body = tree.model->link(model.links[link].local);
  if (!body.floating || !tree.rings.empty()) {
    throw SetupError(kWhat, "link " + model.links[link].name + " hangs on joints", "set the positions of its joints");
  }
  if (!(X_WL.p.norm() <= kMostGiven && X_WL.R.allFinite() && V_WL.angular.norm() <= kMostGiven && V_WL.linear.norm() <= kMostGiven)) {
    throw SetupError(kWhat, "has a number beyond 1e9, or one that is not finite", "write metres, a unit quaternion, m/s and rad/s");
  }
  putFree(body.p_LO, X_WL.p, Quaternion(X_WL.R).normalized(), V_WL, state.q.data() + tree.q + body.q, state.v.data() + tree.v + body.v);
  settleAnew(model, t, state, work);
}

void putJoints(const Model& model, const std::vector<std::pair<int, double>>& positions, State& state, Work& work) {
  constexpr char kWhat[] = "joint positions";
  std::vector<int> trees;
  for (const auto& [index, position] : positions) {
    if (index < 0 || index >= static_cast<int>(model.joints.size())) {
      throw SetupError(kWhat, "there is no joint " + std::to_string(index), "the scene has " + std::to_string(model.joints.size()));
    }
    const ModelJoint& joint = model.joints[index];
    const ModelLink& link = model.links[joint.link];
    const JointDef& def = model.trees[link.articulation].model->def().links[link.local].joint;
    requireLoose(model, kWhat, link.articulation, state, work.hands);
    if (def.mimic_joint >= 0) throw SetupError(kWhat, "joint " + joint.name + " follows another", "set the one that it follows");
    if (!(position >= def.lower && position <= def.upper) || !std::isfinite(position)) {
      throw SetupError(kWhat, "joint " + joint.name + " at " + std::to_string(position) + " is not within its limits",
                       "give " + std::to_string(def.lower) + " to " + std::to_string(def.upper));
    }
    trees.push_back(link.articulation);
  }
  std::sort(trees.begin(), trees.end());
  trees.erase(std::unique(trees.begin(), trees.end()), trees.end());
  const std::vector<double> q = state.q, v = state.v;
  for (const auto& [index, position] : positions) {
    state.q[model.joints[index].q] = position;
    state.v[model.joints[index].v] = 0;
  }
  for (const int t : trees) {
    const ModelTree& tree = model.trees[t];
    if (!tree.has_laws) continue;
    std::fill_n(state.v.begin() + tree.v, tree.model->nv(), 0.0);  // those that close loops stand as well
    putFollowers(*tree.model, state.q.data() + tree.q);
    if (work.joints[t]->close(state.q.data() + tree.q, state.v.data() + tree.v, work.placement.link.data() + tree.link)) continue;
    state.q = q;
    state.v = v;
    for (const int moved : trees) placeTree(model.trees[moved], state, work.placement);
    throw SetupError(kWhat, "the loops and followers of " + tree.model->def().name + " do not close from there",
                     "give positions nearer to closing, of all joints of the loop");
  }
  for (const int t : trees) settleAnew(model, t, state, work);
}

}  // namespace haptic
