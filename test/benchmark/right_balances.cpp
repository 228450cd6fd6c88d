/// What is reported is what was done: linear and angular momentum against reported wrenches, and of an isolated pair.
#include <algorithm>
#include <cmath>

#include "../scenes/moving.h"
#include "figure.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "right_figures.h"

namespace haptic::bench {
namespace {

using namespace scenes;

struct Momentum {
  Vector3 linear = Vector3::Zero(), angular = Vector3::Zero();  ///< about W's origin
};

/// Of a free body; link frames at the centres of mass.
Momentum momentumOf(const World& world, int link, double mass, const Matrix3& I_C) {
  const Pose X = world.linkPose(link);
  const Twist V = world.linkTwist(link);
  return {mass * V.linear, X.p.cross(mass * V.linear) + X.R * I_C * X.R.transpose() * V.angular};
}

}  // namespace

namespace {

/// Change of the angular momentum of the pair at one step size, relative.
double angularDrift(Attempts attempts, double h) {
  WorldSettings settings;
  settings.attempts = attempts;
  settings.step = h;
  const WorldDef def = crosses(settings);
  const double mass = def.articulations[0].links[0].inertia.mass;
  const Matrix3 I = def.articulations[0].links[0].inertia.I_C;
  World world(def);
  const auto total = [&] { return Vector3(momentumOf(world, 0, mass, I).angular + momentumOf(world, 1, mass, I).angular); };
  const Vector3 first = total();
  double most = 0;
  for (double t = 0; t < 0.6; t += h) {
    world.step();
    most = std::max(most, (total() - first).norm());
  }
  return most / first.norm();
}

}  // namespace

void runBalances() {
  for (const NamedAttempts& i : kNamedAttempts) {  // order with which it vanishes
    if (i.comparator) continue;
    figure(std::string("momentum.L_order_") + i.name,
           std::log(angularDrift(i.attempts, 1e-4) / angularDrift(i.attempts, 2.5e-5)) / std::log(4.0), "1");
  }
  double worst_impulse = 0, worst_P = 0, worst_L = 0;
  for (const NamedAttempts& i : kNamedAttempts) {
    WorldSettings settings;
    i.into(settings);
    const WorldDef def = crosses(settings);
    const double mass = def.articulations[0].links[0].inertia.mass, h = settings.step;
    const Matrix3 I = def.articulations[0].links[0].inertia.I_C;
    World world(def);
    Momentum start[2] = {momentumOf(world, 0, mass, I), momentumOf(world, 1, mass, I)};
    const Momentum first{start[0].linear + start[1].linear, start[0].angular + start[1].angular};
    Vector3 impulse = Vector3::Zero();
    double scale = 0, error = 0, P = 0, L = 0;
    for (int step = 0; step < 600; ++step) {
      const Vector3 before = momentumOf(world, 1, mass, I).linear;
      world.step();
      for (int c = 0; c < world.contactCount(); ++c) impulse += h * world.contact(c).F_BP_W.force;
      const Momentum a = momentumOf(world, 0, mass, I), b = momentumOf(world, 1, mass, I);
      scale = std::max(scale, (b.linear - before).norm());
      error = std::max(error, (b.linear - start[1].linear - impulse).norm());
      P = std::max(P, (a.linear + b.linear - first.linear).norm());
      L = std::max(L, (a.angular + b.angular - first.angular).norm());
    }
    worst_impulse = std::max(worst_impulse, error / scale);
    figure(std::string("wrench.impulse_err_rel_") + i.name, error / scale, "1");
    figure(std::string("momentum.P_rel_") + i.name, P / (mass * 0.5), "1");
    figure(std::string("momentum.L_rel_") + i.name, L / first.angular.norm(), "1");
    worst_P = std::max(worst_P, P / (mass * 0.5));
    worst_L = std::max(worst_L, L / first.angular.norm());
  }
  figure("wrench.impulse_err_rel", worst_impulse, "1");
  figure("momentum.P_rel", worst_P, "1");
  figure("momentum.L_rel", worst_L, "1");
}

}  // namespace haptic::bench
