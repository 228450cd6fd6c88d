#include "haptic_core/world/applied_wrench.h"

namespace haptic {

Wrench wrenchInWorld(const LinkWrench& wrench, const LinkWork& link) noexcept {
  return wrench.in_link ? wrench.F.rotated(link.X_WL.R) : wrench.F;
}

void addWrenches(const Model& model, const State& state, int tree, LinkWork* link) noexcept {
  for (int i = 0; i < state.wrench_count; ++i) {
    const AppliedWrench& applied = state.wrenches[i];
    if (model.links[applied.link].articulation != tree) continue;
    LinkWork& pushed = link[applied.link];
    pushed.addWrench(wrenchInWorld(applied.wrench, pushed), pushed.X_WL * applied.wrench.p_L);
  }
}

bool anyWrench(const Model& model, const State& state, int tree) noexcept {
  for (int i = 0; i < state.wrench_count; ++i) {
    if (model.links[state.wrenches[i].link].articulation == tree) return true;
  }
  return false;
}

void noteWrenches(const State& state, const Placement& placement, WrenchWork& work) noexcept {
  for (int i = 0; i < state.wrench_count; ++i) {
    const LinkWork& link = placement.link[state.wrenches[i].link];
    work.before[i] = {link.X_WL * state.wrenches[i].wrench.p_L, wrenchInWorld(state.wrenches[i].wrench, link), link.omega};
  }
}

void bookWrenches(const HandWork& hands, double h, const WrenchWork& work, const Placement& placement, State& state) noexcept {
  for (int i = 0; i < state.wrench_count; ++i) {
    const AppliedWrench& applied = state.wrenches[i];
    if (hands.held_by[applied.link] >= 0) continue;
    const LinkWork& link = placement.link[applied.link];
    const WrenchWork::Place& before = work.before[i];
    const Wrench mean = (before.F_W + wrenchInWorld(applied.wrench, link)) * 0.5;
    state.energy.external += mean.force.dot(link.X_WL * applied.wrench.p_L - before.p_W) +
                             mean.torque.dot(0.5 * h * (before.omega + link.omega));
  }
}

}  // namespace haptic
