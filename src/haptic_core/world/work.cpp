#include "haptic_core/world/work.h"

#include <algorithm>

#include "haptic_core/base/error.h"
#include "haptic_core/world/initial_overlap.h"
#include "haptic_core/world/put.h"
#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

/// Joints of trees with laws start with their own commands, on their loops.
void startJoints(const Model& model, State& state, Work& work) {
  state.commands.resize(model.commands);
  for (const ModelTree& tree : model.trees) {
    if (!tree.has_laws) continue;
    TreeMotion& motion = *work.joints[model.indexOf(tree)];
    for (int i = 0; i < tree.model->linkCount(); ++i) {
      state.commands[tree.command + i] = initialCommand(tree.model->def().links[i].joint);
    }
    if (motion.close(state.q.data() + tree.q, state.v.data() + tree.v, work.placement.link.data() + tree.link)) continue;
    throw SetupError(tree.model->def().name, "its loops and mimic joints do not close from the initial joint positions",
                     "give initial positions nearer to closing, or check the frames of the loops");
  }
}

/// Bodies on motions start where these are at time 0.
void startMotions(const Model& model, State& state) {
  state.motions.resize(model.motions.size());
  for (std::size_t m = 0; m < model.motions.size(); ++m) {
    const ModelMotion& motion = model.motions[m];
    const ModelTree& tree = model.trees[model.links[motion.link].articulation];
    const Vector3 p_LC = tree.model->link(0).p_LO;
    double *q = state.q.data() + tree.q, *v = state.v.data() + tree.v;
    const Quaternion q_WL(q[3], q[4], q[5], q[6]);
    state.motions[m] = standingAt(Pose(q_WL, Vector3(q[0], q[1], q[2]) - q_WL * p_LC));
    const MotionPoint start = motionAt(motion, state.motions[m], 0);
    putFree(p_LC, start.p_WL, start.q_WL, start.V_WL, q, v);
  }
}

}  // namespace

ContactWork::ContactWork(const Model& model)
    : seams(model) {
  model.reserve(workspace);
}

FlowWork::FlowWork(const Model& model) : q_start(model.nq), v_start(model.nv), pull(model.nv), v_half(model.nv) {
  for (const ModelTree& tree : model.trees) scratch.fit(*tree.model);
}

Work::Work(const Model& model)
    : visits(model), placement(model), search(model), hands(model), contacts(model), motion(model), reported(model.pair_capacity),
      islands(model), activity(model), rates(model), sums(model) {
  if (model.settings.comparator) comparator = model.settings.comparator(model);
  if (model.implicit_steps) implicit = std::make_unique<stepping::ImplicitWork>(model);
  joints.resize(model.trees.size());
  for (const ModelTree& tree : model.trees) {
    if (tree.has_laws) joints[model.indexOf(tree)] = std::make_unique<TreeMotion>(*tree.model, tree.rings);
  }
}

Work::~Work() = default;

State initialState(const Model& model, Work& work) {
  State state;
  state.q = model.q_start;
  state.v = model.v_start;
  state.pairs.fit(model.pair_capacity);
  state.mode.assign(model.trees.size(), TreeMode::kPut);
  for (auto* history : {&state.a_end, &state.a_mean, &state.v_mean}) history->assign(model.nv, 0);
  state.last_step.assign(model.trees.size(), 0);
  state.calm.assign(model.trees.size(), 0);
  for (auto* steps : {&state.turn, &state.as_of}) steps->assign(model.trees.size(), 0);
  startJoints(model, state, work);
  startMotions(model, state);
  state.wrenches.resize(kMostWrenches);
  placeAll(model, state, work.placement);
  state.pointers.resize(model.pointers.size());
  refreshHands(model, state, work.hands);
  for (int i = 0; i < static_cast<int>(model.pointers.size()); ++i) {
    checkGrab(model, work.hands, i, model.pointerHome(i));
    grab(model, work.placement, i, model.pointerHome(i), state, work.hands);
  }
  refreshHands(model, state, work.hands);
  refuseStaticOverlaps(model, work);
  findBuried(model, -1, state, work);
  startSupply(model, work, state);
  return state;
}

}  // namespace haptic
