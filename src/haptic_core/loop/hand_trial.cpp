#include "haptic_core/loop/hand_trial.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr double kStart = 0.6, kAfter = 0.1;             ///< before the way and after it [s]; the start fades in
constexpr double kTouched = 0.05;                        ///< from the way's first contact to the first interval of energy [s]
constexpr double kLeastJerkPeak = 1.875;                 ///< peak over mean speed of a motion of least jerk [1]
constexpr double kImpactSpeed = 0.1, kImpactTime = 0.02; ///< [m/s], [s]
constexpr double kTurnWindow = 0.05;                     ///< [s]
constexpr int kMostTurns = 5;
/// Of a jig [m], [Hz]: a grip that does not move by a count while the force changes is taken for a board that repeats its counts.
constexpr double kTremor = 5e-5, kTremorRate = 10;

/// Counts the turns of a signal that are larger than kQuietJump.
class Turns {
 public:
  /// True: more than kMostTurns within kTurnWindow.
  bool add(double time, double value) {
    if (rising_ ? value > extreme_ : value < extreme_) extreme_ = value;
    if (std::fabs(value - extreme_) > kQuietJump) {
      rising_ = !rising_;
      extreme_ = value;
      turned_.push_back(time);
    }
    while (!turned_.empty() && turned_.front() < time - kTurnWindow) turned_.pop_front();
    return static_cast<int>(turned_.size()) > kMostTurns;
  }
  void restart(double value) {
    turned_.clear();
    extreme_ = value;
  }

 private:
  std::deque<double> turned_;
  double extreme_ = 0;
  bool rising_ = true;
};

GripPose trembling(GripPose pose, double time) {
  pose.X_BG.p += kTremor * elementary::sin(2 * M_PI * kTremorRate * time) * Vector3(1, 1, 1) / std::sqrt(3.0);
  return pose;
}

/// Reach of the pointer's shapes from the link's origin, as the grip has it [m].
double reachOf(const WorldDef& def, int pointer, double scale) {
  const PointerDef& hand = def.pointers.at(static_cast<std::size_t>(pointer));
  double reach = 0;
  for (const CollisionDef& c : def.articulations[hand.articulation].links[hand.link].collisions) {
    reach = std::max(reach, (c.X_LS * c.shape->centre()).norm() + c.shape->boundingRadius());
  }
  return reach / scale;
}

class Trial {
 public:
  Trial(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device, const TrialWay& way)
      : period_(def.settings.step), pointer_(pointer), way_(way), world_(def), spidar_(device), twin_(device, twinSettings(period_, way)),
        reach_(reachOf(def, pointer, settings.workspace.scale)) {
    to_grip_ = settings.force_scale / settings.workspace.scale;
    loop_.attach(spidar_, pointer, settings);
    spidar_.calibrateAtHome();
    spidar_.setForceEnabled(true);
  }

  TrialResult run() {
    const HandPath path = pathOf(way_);
    const int ticks = static_cast<int>((path.keys.back().time + kAfter) / period_);
    for (int i = 0; i < ticks; ++i) {
      const double time = i * period_;
      if (way_.jig) twin_.place(trembling(path.at(time), time));
      const DeviceSample sample = twin_.exchange(loop_.drive(0));
      const Pose tool = toolPose();
      loop_.tick(&sample, period_);
      judge(time, rests(path, time));
      account(tool, time);
    }
    result_.finite = world_.report().finite;
    return result_;
  }

 private:
  /// Two keys a rest: its begin and its end.
  static HandPath pathOf(const TrialWay& way) {
    HandPath path;
    double time = kStart, at = 0;
    const auto go = [&](double to) {
      time += std::max(0.02, kLeastJerkPeak * std::fabs(to - at) * way.depth / way.speed);
      at = to;
      path.keys.push_back({time, at * way.depth * way.direction, at * way.turn, 0});
    };
    path.keys = {{kStart, Vector3::Zero(), Vector3::Zero(), 0}};
    for (const double rest : way.rests) {
      go(rest);
      time += way.rest;
      path.keys.push_back({time, at * way.depth * way.direction, at * way.turn, 0});
    }
    go(0);
    return path;
  }
  /// Whether the target rests, and an impact at its arrival is over.
  static bool rests(const HandPath& path, double time) {
    for (std::size_t i = 1; i + 1 < path.keys.size(); i += 2) {
      if (time > path.keys[i].time + kImpactTime && time < path.keys[i + 1].time) return true;
    }
    return false;
  }
  static TwinSettings twinSettings(double period, const TrialWay& way) {
    TwinSettings settings;
    settings.period = period;
    settings.path = pathOf(way);
    return settings;
  }

  /// Contacts of the tool: one more is a first touch, of whatever was hit.
  int touches() const {
    int count = 0;
    const int tool = world_.pointerLink(pointer_);
    for (int i = 0; i < world_.contactCount(); ++i) count += world_.contact(i).link_a == tool || world_.contact(i).link_b == tool;
    return count;
  }

  void judge(double time, bool rests) {
    const HandReport& now = loop_.report().hand[0];
    TrialResult& r = result_;
    r.stiffness = loop_.hand(0).stableStiffness();
    ++r.ticks;
    r.touching += now.in_contact;
    r.led += now.slewed;
    r.doubted += spidar_.state() == DeviceState::kReduced || spidar_.state() == DeviceState::kFault;
    r.weakened += now.in_contact && now.stiffness_share < 1;
    r.strongest = std::max(r.strongest, now.F_asked_B.force.norm());
    r.over_limit += now.F_asked_B.force.norm() > (1 + 1e-9) * spidar_.def().max_force;
    const int touched = touches();
    if (touched > last_touched_ && now.V_BG.linear.norm() > kImpactSpeed) impact_until_ = time + kImpactTime;
    last_touched_ = touched;
    const bool impact = time < impact_until_;
    r.impacts += impact;
    if (r.ticks > 1 && !impact && last_.valid) {
      const double way = (now.X_BG.p - last_.X_BG.p).norm();
      const double turn = vectorFromRotation(Quaternion(Matrix3(now.X_BG.R * last_.X_BG.R.transpose()))).norm();
      const double allowed = r.stiffness * way;
      r.jump = std::max(r.jump, (now.F_asked_B.force - last_.F_asked_B.force).norm() - allowed);
      r.tension_jump = std::max(r.tension_jump, (now.F_achieved_B.force - last_.F_achieved_B.force).norm() - allowed);
      r.torque_jump = std::max(r.torque_jump, (now.F_asked_B.torque - last_.F_asked_B.torque).norm() -
                                                  r.stiffness * reach_ * (way + reach_ * turn));
    }
    for (int i = 0; i < 3; ++i) {
      const double F = now.F_asked_B.force[i];
      if (!rests || impact) {
        turns_[i].restart(F);
      } else if (turns_[i].add(time, F)) {
        r.rings = true;
      }
    }
    last_ = now;
  }

  Pose toolPose() const { return world_.pointerPose(pointer_); }

  /// Work of the wrench F on its way from one pose to the next [J].
  static double work(const Wrench& F, const Pose& from, const Pose& to) {
    return F.force.dot(to.p - from.p) + F.torque.dot(vectorFromRotation(Quaternion(Matrix3(to.R * from.R.transpose()))));
  }

  /// Of the springs of a virtual coupling between the tool and its target: K e, and from the hand's limit F on F itself [J].
  double couplingEnergy() const {
    if (world_.model().holds(pointer_)) return 0;
    const auto p = static_cast<std::size_t>(pointer_);
    const double asked = world_.tuning().coupling[p].rotational_stiffness, own = world_.work().hands.own_coupling[p].rotational_stiffness;
    const PointerBound& bound = world_.pointerBound(pointer_);
    const auto energy = [](double K, double e, double F) { return K * e > F ? F * (e - 0.5 * F / K) : 0.5 * K * e * e; };
    const Pose goal = loop_.report().hand[0].X_WP, tool = toolPose();
    const double turn = vectorFromRotation(Quaternion(Matrix3(goal.R * tool.R.transpose()))).norm();
    const double K = std::min(world_.pointerStiffness(pointer_), bound.stiffness);
    const double most = bound.turn_of_way * bound.stiffness;
    const double K_turn = asked == PointerCoupling::kDerived && std::isfinite(most) ? most : std::min(own, most);
    return energy(K, (goal.p - tool.p).norm(), bound.force) + energy(K_turn, turn, bound.torque);
  }

  /// A held tool stays behind its hand under a force that is as large on the hand's way back: F times the way along it [J].
  double heldBackEnergy() const {
    if (!world_.model().holds(pointer_)) return 0;
    const Pose goal = loop_.report().hand[0].X_WP, tool = toolPose();
    const Wrench F = world_.pointerWrench(pointer_);
    const Vector3 turn = vectorFromRotation(Quaternion(Matrix3(tool.R * goal.R.transpose())));
    return std::max(0.0, F.force.dot(tool.p - goal.p)) + std::max(0.0, F.torque.dot(turn));
  }

  /// Energies of this tick. `tool`: where the tool was before it. All that the world gets beside this hand's work is of led bodies,
  /// belts and drives; what the grip feels of the world's energy is to_grip_ times it.
  void account(const Pose& tool, double time) {
    const Pose grip = twin_.latchedPose().X_BG;
    if (result_.ticks > 1) given_ += work(strings_, grip_, grip);  // held between the last two samples
    strings_ = twin_.stringWrench();
    grip_ = grip;
    const EnergyLedger& energy = world_.report().energy;
    const Wrench on_tool = -world_.pointerWrench(pointer_);
    const double others = energy.external - external_ - work(on_tool, tool, toolPose());
    external_ = energy.external;
    given_ -= to_grip_ * others;
    if (time < kStart || (touched_ == 0 && !last_.in_contact)) return;  // before it a force that fades in gives back more than it took
    touched_ += period_;
    if (touched_ < kTouched) return;
    const double at = given_ + to_grip_ * energy.potential;
    const double stored = to_grip_ * (energy.elastic + energy.tangential + couplingEnergy());
    least_ = std::min(least_, at + stored);
    least_moving_ = std::min(least_moving_, at + stored + to_grip_ * energy.kinetic);
    least_held_ = std::min(least_held_, at + stored + to_grip_ * heldBackEnergy());
    if (at - least_ > result_.energy_given) result_.energy_given = at - least_;
    result_.energy_moving = std::max(result_.energy_moving, at - least_moving_);
    result_.energy_held = std::max(result_.energy_held, at - least_held_);
  }

  double period_;
  int pointer_, last_touched_ = 0;
  TrialWay way_;
  World world_;
  Spidar spidar_;
  DeviceTwin twin_;
  HapticLoop loop_{world_};
  double reach_, impact_until_ = -1;
  HandReport last_;
  Turns turns_[3];
  double to_grip_ = 1;                       ///< energy at the grip over the world's
  double given_ = 0, external_ = 0;          ///< to the hand, less other sources; the world's work from outside, so far [J]
  double touched_ = 0;                       ///< since the first contact [s]
  double least_ = INFINITY, least_moving_ = INFINITY, least_held_ = INFINITY;  ///< of the sums [J]
  Wrench strings_;
  Pose grip_;
  TrialResult result_;
};

}  // namespace

double workspaceEnd(const DeviceDef& device, const Vector3& direction) {
  Vector3 half = Vector3::Zero();
  for (const StringDef& string : device.strings) half = half.cwiseMax(string.p_BE.cwiseAbs());
  double end = INFINITY;
  for (int i = 0; i < 3; ++i) {
    if (direction[i] != 0 && half[i] > 0) end = std::min(end, half[i] / std::fabs(direction[i]));
  }
  return 0.8 * end;
}

std::vector<TrialWay> pressingWays(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device) {
  const Model model(def);
  const World world(def);
  const int link = world.pointerLink(pointer), count = static_cast<int>(model.shapes.size());
  const auto pose = [&](int s) { return world.linkPose(model.shapes[s].link) * model.shapes[s].X_LS; };
  double least = INFINITY;
  Vector3 direction_W = Vector3::Zero();
  for (int own = 0; own < count; ++own) {
    for (int other = 0; model.shapes[own].link == link && other < count; ++other) {
      const int a = std::min(own, other), b = std::max(own, other);
      const bool is_a = a == own;
      if (model.shapes[other].link == link || !model.mayCollide(a, b)) continue;
      ClosestPoints near;
      const ModelShape &A = model.shapes[a], &B = model.shapes[b];
      const Vector3 between = pose(b).p - pose(a).p;
      const Vector3 guess_A = between.norm() > 0 ? Vector3(pose(a).R.transpose() * between.normalized()) : Vector3::UnitZ();
      closestPoints(*A.shape, *B.shape, relativePose(pose(a), pose(b)), guess_A, near);
      if (near.distance >= least) continue;
      least = near.distance;
      direction_W = pose(a).R * near.direction * (is_a ? 1 : -1);
    }
  }
  std::vector<TrialWay> ways;
  if (!(direction_W.norm() > 0)) return ways;
  for (const double speed : {0.05, 0.3}) {
    for (const bool jig : {true, false}) {
      TrialWay way;
      way.direction = settings.workspace.X_WB.R.transpose() * direction_W.normalized();
      way.depth = workspaceEnd(device, way.direction);
      way.speed = speed;
      way.rests = {0.1, 0.25, 1};
      way.jig = jig;
      ways.push_back(way);
    }
  }
  return ways;
}

TrialResult pressHand(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device) {
  TrialResult worst;
  for (const TrialWay& way : pressingWays(def, pointer, settings, device)) {
    const TrialResult r = tryHand(def, pointer, settings, device, way);
    worst.jump = std::max(worst.jump, r.jump);
    worst.torque_jump = std::max(worst.torque_jump, r.torque_jump);
    worst.tension_jump = std::max(worst.tension_jump, r.tension_jump);
    worst.strongest = std::max(worst.strongest, r.strongest);
    worst.stiffness = r.stiffness;
    worst.ticks += r.ticks, worst.touching += r.touching, worst.impacts += r.impacts, worst.over_limit += r.over_limit;
    worst.rings = worst.rings || r.rings;
    worst.finite = worst.finite && r.finite;
  }
  return worst;
}

TrialResult tryHand(const WorldDef& def, int pointer, const HandSettings& settings, const DeviceDef& device, const TrialWay& way) {
  return Trial(def, pointer, settings, device, way).run();
}

}  // namespace haptic
