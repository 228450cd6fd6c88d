#include "haptic_core/stepping/flow.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/dynamics/runge_kutta.h"
#include "haptic_core/world/applied_wrench.h"

namespace haptic::stepping {

SteppedTree inPlace(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept {
  SteppedTree stepped;
  stepped.model = tree.model.get();
  stepped.motion = work.joints[model.indexOf(tree)].get();
  stepped.commands = state.commands.data() + tree.command;
  stepped.q = state.q.data() + tree.q;
  stepped.v = state.v.data() + tree.v;
  stepped.pull = work.motion.pull.data() + tree.v;
  stepped.half = work.motion.v_half.data() + tree.v;
  stepped.work = work.placement.link.data() + tree.link;
  return stepped;
}

void book(const JointReport* joints, State& state, StepReport& report) noexcept {
  if (!joints) return;
  state.energy.damping += joints->damping;
  state.energy.friction += joints->friction;
  state.energy.external += joints->drives;
  report.addGap(joints->closure);
  if (!joints->converged) report.flags |= kJointsNotConverged;
}

namespace {

/// Of a tree that has flowed: of the drift by its stages, of what pulls as velocity Verlet's, of laws that are not smooth as symplectic
/// Euler's, h/2 |v₁ - v₀| [m].
double flowError(const Model& model, const ModelTree& tree, double h, bool pulled, const State& state, const Work& work) noexcept {
  const double size = model.links[tree.link].size;
  const TreeMotion* laws = work.joints[model.indexOf(tree)].get();
  const bool euler = laws && laws->report().passes > 0;
  double stages = 0;
  if (laws && !euler) stages = laws->smoothError(h, size);
  if (!laws && !tree.model->isFreeBody()) stages = rungeKuttaError(*tree.model, h, size, work.motion.scratch.stages.data());
  if (!euler && !pulled) return stages;
  double turn2 = 0, way2 = 0;
  for (int l = 0; l < tree.model->linkCount(); ++l) {
    const LinkModel& link = tree.model->link(l);
    for (int d = 0; d < link.dof; ++d) {
      const int i = link.v + d, k = tree.v + i;
      const double v0 = work.motion.v_start[k], v1 = state.v[k];
      const double bent = euler ? 0.5 * (v1 - v0) : 5.0 / 6 * (v1 - 2 * work.motion.v_half[k] + v0);
      (i >= link.v_slide && i < link.v_slide + link.slides ? way2 : turn2) += bent * bent;
    }
  }
  return stages + h * std::sqrt(way2 + size * size * turn2);
}

}  // namespace

void flow(const Model& model, int t, double h, State& state, Work& work, StepReport& report) noexcept {
  const ModelTree& tree = model.trees[t];
  const Vector3& gravity = model.settings.gravity;
  const bool pulled = anyWrench(model, state, t);
  work.counted.done += units::kLink * tree.model->linkCount();
  if (!pulled && model.isFree(tree)) return stepFreeBody(tree.model->link(0), gravity, h, state.q.data() + tree.q, state.v.data() + tree.v);
  const SteppedTree stepped = inPlace(model, tree, state, work);
  LinkWork* links = work.placement.link.data();
  placeTree(tree, state, work.placement);
  if (pulled) addWrenches(model, state, t, links);
  readPull(stepped, gravity, work.motion.scratch);
  book(startVerlet(stepped, gravity, h, work.motion.scratch), state, report);
  if (pulled && !stepped.motion) {
    addWrenches(model, state, t, links);
    finishVerlet(stepped, gravity, h, work.motion.scratch);
  }
  work.position_error = std::max(work.position_error, flowError(model, tree, h, pulled, state, work));
}

void keepFlow(const Model& model, int t, double h, const std::vector<double>& v_start, State& state) noexcept {
  const ModelTree& tree = model.trees[t];
  for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) state.a_end[i] = (state.v[i] - v_start[i]) / h;
  state.last_step[t] = 0;
  state.mode[t] = TreeMode::kFlowed;
}

void flowAll(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept {
  moveHeld(model, state, work.hands, work.placement);
  for (const int t : work.visits.trees) {
    const ModelTree& tree = model.trees[t];
    if (work.hands.movesByItself(tree)) {
      std::copy_n(state.v.begin() + tree.v, tree.model->nv(), work.motion.v_start.begin() + tree.v);
      flow(model, t, h, state, work, report);
      keepFlow(model, t, h, work.motion.v_start, state);
    }
    placeTree(tree, state, work.placement);
  }
}

}  // namespace haptic::stepping
