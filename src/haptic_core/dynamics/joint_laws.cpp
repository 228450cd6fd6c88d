#include "haptic_core/dynamics/joint_laws.h"

#include <algorithm>

namespace haptic {

void JointLaws::add(const Articulation& articulation, int link, int command, int q, int v) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& model = articulation.link(i);
    Law law;
    law.joint = ownLaw(articulation.def().links[i].joint);
    law.link = link + i;
    law.command = command + i;
    law.q = q + model.q;
    law.v = v + model.v;
    if (model.dof == 1 && hasLaw(law.joint)) laws_.push_back(law);
    if (model.dof < 2 || model.floating || law.joint.damping <= 0) continue;
    for (int k = 0; k < model.dof; ++k) damped_.push_back({law.v + k, law.joint.damping});
  }
}

void JointLaws::start(const JointCommand* commands, const double* q, double h) noexcept {
  h_ = h;
  for (Law& law : laws_) {
    law.q_start = q[law.q];
    buildForceGraph(law.joint, commands[law.command], law.q_start, h, law.graph);
  }
}

void JointLaws::standAt(const double* v) noexcept {
  for (Law& law : laws_) law.piece = law.graph.at(v[law.v]);
}

void JointLaws::putWithinLimits(double* v) const noexcept {
  for (const Law& law : laws_) {
    const ForcePiece &lowest = law.graph.pieces[0], &highest = law.graph.pieces[law.graph.count - 1];
    v[law.v] = std::min(std::max(v[law.v], lowest.from), highest.to);
  }
}

void JointLaws::settle(double* v) const noexcept {
  for (const Law& law : laws_) {
    if (law.now().vertical) v[law.v] = law.now().from;
  }
}

}  // namespace haptic
