/// Trees whose joints do something by themselves, in explicit steps: limits, damping, friction, drives,
/// mimic, loops.
#include <algorithm>
#include <cmath>
#include <functional>

#include "haptic_core/base/error.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {

void Pipeline::makeMotions() {
  motions_.resize(plan_.trees.size());
  state_.commands.resize(plan_.commands);
  for (const PlanTree& tree : plan_.trees) {
    if (!tree.has_laws) continue;
    motions_[&tree - plan_.trees.data()] = std::make_unique<TreeMotion>(*tree.model, tree.rings);
    for (int i = 0; i < tree.model->linkCount(); ++i) {
      state_.commands[tree.command + i] = initialCommand(tree.model->def().links[i].joint);
    }
    if (motionOf(tree)->close(state_.q.data() + tree.q, state_.v.data() + tree.v, work_.data() + tree.link))
      continue;
    throw SetupError(tree.model->def().name,
                     "its loops and mimic joints do not close from the initial joint positions",
                     "give initial positions nearer to closing, or check the frames of the loops");
  }
}

void Pipeline::addJointPaths(const WorldDef& def) {
  for (const JointPathDef& path : def.joint_paths) {
    JointPath added;
    added.time = path.time;
    added.position = path.position;
    for (const auto& [articulation, local] : path.joints) {
      const int link = plan_.link(articulation, local);
      const auto joint = std::find_if(plan_.joints.begin(), plan_.joints.end(),
                                      [&](const PlanJoint& j) { return j.link == link && j.driven; });
      if (joint == plan_.joints.end()) {
        throw SetupError(
            path.name, "the joint of link " + plan_.links[link].name + " has no drive",
            "give it an effort limit, or <haptic:joint drive=\"position\" drive_stiffness=\"...\"/>");
      }
      added.commands.push_back(plan_.trees[plan_.links[link].articulation].command + plan_.links[link].local);
    }
    const bool rising = std::is_sorted(path.time.begin(), path.time.end(), std::less_equal<double>());
    if (path.time.empty() || !rising || path.position.size() != path.time.size() * path.joints.size()) {
      throw SetupError(path.name, "its times do not rise, or a row lacks a position",
                       "give one row per time, in order");
    }
    joint_paths_.push_back(added);
  }
}

/// Drives are asked for where the path is at the end of the step, and for its rate as the velocity.
void Pipeline::followJointPaths() noexcept {
  const double t = state_.time + settings_.step;
  for (const JointPath& path : joint_paths_) {
    const int rows = static_cast<int>(path.time.size()), columns = static_cast<int>(path.commands.size());
    if (t > path.time.back() + settings_.step) continue;  // told its last row; others may command now
    const int next =
        static_cast<int>(std::upper_bound(path.time.begin(), path.time.end(), t) - path.time.begin());
    const int a = std::max(next - 1, 0), b = std::min(next, rows - 1);
    const double width = path.time[b] - path.time[a];
    for (int c = 0; c < columns; ++c) {
      const double from = path.position[a * columns + c], to = path.position[b * columns + c];
      const double rate = width > 0 ? (to - from) / width : 0;
      state_.commands[path.commands[c]] = {JointDef::Drive::kPosition,
                                           from + rate * (t - path.time[a]) * (width > 0), rate, 0};
    }
  }
}

/// One step of symplectic Euler with the joints' forces implicit. `tau`: generalised forces instead of the
/// wrenches in `work_`.
void Pipeline::moveJointed(const PlanTree& tree, double h, const double* tau) noexcept {
  const JointReport& report =
      motionOf(tree)->step(settings_.gravity, h, commandsOf(tree), state_.q.data() + tree.q,
                           state_.v.data() + tree.v, work_.data() + tree.link, tau);
  state_.energy[0] += report.damping;
  state_.energy[1] += report.friction;
  state_.energy[2] += report.drives;
  report_.closure = std::max(report_.closure, report.closure);
  if (!report.converged) report_.flags |= kJointsNotConverged;
}

/// Velocity Verlet: what contacts and hands do to the tree at the end of the step is kept for the next one,
/// kicks of contacts that parted included.
void Pipeline::gatherPull(const PlanTree& tree, double h) noexcept {
  double* pull = state_.pull.data() + tree.v;
  std::fill(pull, pull + tree.model->nv(), 0.0);
  for (int i = 0; i < tree.model->linkCount(); ++i) {
    LinkWork& link = work_[tree.link + i];
    Wrench F = link.F_ext;
    if (has_kick_) F += kick_[tree.link + i] * (1 / h);
    link.F_ext = Wrench{};
    addGeneralisedForce(*tree.model, work_.data() + tree.link, i, F, link.p_WO, pull);
  }
}

bool Pipeline::setJointCommand(int joint, const JointCommand& command) noexcept {
  if (joint < 0 || joint >= static_cast<int>(plan_.joints.size()) || !plan_.joints[joint].driven)
    return false;
  if (!isFinite(command)) return false;
  const PlanLink& link = plan_.links[plan_.joints[joint].link];
  state_.commands[plan_.trees[link.articulation].command + link.local] = command;
  return true;
}

JointReading Pipeline::joint(int i) const noexcept {
  const PlanJoint& joint = plan_.joints[i];
  const PlanLink& link = plan_.links[joint.link];
  const TreeMotion* motion = motions_[link.articulation].get();
  const double drive = implicit_ && isImplicit(link.articulation) ? implicit_->joints().driveForce(joint.link)
                       : motion  ? motion->driveForceOf(link.local)
                                 : 0;
  return {state_.q[joint.q], state_.v[joint.v], drive};
}

std::string Pipeline::text() const {
  std::string text = plan_.text();
  for (const auto& motion : motions_) {
    if (!motion) continue;
    for (const std::string& line : motion->unsupported()) text += "  not simulated: " + line + "\n";
  }
  return text;
}

}  // namespace haptic
