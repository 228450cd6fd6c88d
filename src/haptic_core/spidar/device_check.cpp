#include "haptic_core/spidar/device_check.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/tension_distribution.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {
namespace {

constexpr double kUnlimited = 1e-6;    // λ that costs nothing: the tensions' bounds alone count
constexpr double kLostShare = 0.02;    // of a wrench, beyond which it counts as not presentable
constexpr double kProbeForce = 1.0;    // [N] all round: the least a user would call force feedback
constexpr double kProbeShare = 0.1;    // of the greatest tension, where that is less
constexpr double kPoorSingular = 0.1;  // below, the pose is ten times less certain than the lengths: not of the workspace
constexpr double kRubbing = 3e-3;      // strings nearer than this touch when the grip turns [m]
constexpr double kPromisedShare = 0.97;
constexpr double kHandSpeed = 1;  // of a grip that already moves with the wrong force when it comes [m/s]

double probeForce(const DeviceDef& def) {
  return std::min(kProbeForce, kProbeShare * def.strings[0].max_tension);
}

/// Asks for the wrenches that the device can present without λ.
class Probe {
 public:
  explicit Probe(const DeviceDef& def)
      : force_(probeForce(def)), kinematics_(def), distribution_(unlimited(def), kinematics_) {}

  const StringKinematics& kinematics() const { return kinematics_; }

  void moveTo(const GripPose& pose) {
    distribution_.setStructure(kinematics_.scaledStructure(pose));
    const Eigen::VectorXd values = kinematics_.singularValues(pose);
    least_singular_ = values[values.size() - 1];
  }

  /// Of the scaled structure matrix at the pose [1].
  double leastSingular() const { return least_singular_; }
  bool determinesPose() const { return least_singular_ >= kPoorSingular; }

  bool presents(const Wrench& F) {
    const double size = elementary::hypot(F.force.norm(), F.torque.norm() / kinematics_.knotRadius());
    return distribution_.solve(F).error <= kLostShare * size;
  }

  bool presentsAllRound() {
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) {
        Wrench F;
        F.force[axis] = sign * force_;
        if (!presents(F)) return false;
      }
    return true;
  }

  /// Largest force (or torque) presentable in the worst of the 26 directions of a cube's faces, edges and
  /// corners.
  double largest(bool torque, double limit) {
    double worst = limit;
    for (int code = 0; code < 27; ++code) {
      const Vector3 direction(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
      if (code == 13) continue;
      double low = 0, high = worst;
      for (int i = 0; i < 20; ++i) {
        const double middle = i == 0 ? high : 0.5 * (low + high);
        Wrench F;
        (torque ? F.torque : F.force) = middle * direction.normalized();
        (presents(F) ? low : high) = middle;
        if (low == high) break;
      }
      worst = low;
    }
    return worst;
  }

 private:
  static DeviceDef unlimited(DeviceDef def) {
    def.lambda = kUnlimited;
    def.border_lambda = 0;
    return def;
  }
  double force_;
  StringKinematics kinematics_;
  TensionDistribution distribution_;
  double least_singular_ = 0;
};

/// How far along `direction` (a shift in metres or a turn in radians) 1 N stays presentable all round and the lengths determine the pose.
double reach(Probe& probe, const Vector3& direction, bool turn, double limit) {
  constexpr int kSteps = 60;
  double last = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double distance = limit * i / kSteps;
    GripPose x;
    if (turn)
      x.X_BG.R = rotationFromVector(distance * direction).toRotationMatrix();
    else
      x.X_BG.p = distance * direction;
    probe.moveTo(x);
    if (!probe.determinesPose() || !probe.presentsAllRound()) break;
    last = distance;
  }
  return last;
}

void examineRegion(const DeviceDef& def, Probe& probe, DeviceReport& report) {
  Vector3 low = def.strings[0].p_BE, high = low;
  for (const StringDef& s : def.strings) {
    low = low.cwiseMin(s.p_BE);
    high = high.cwiseMax(s.p_BE);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const double span = std::max({high[axis], -low[axis], 0.0});
    report.reach_max[axis] = reach(probe, Vector3::Unit(axis), false, span);
    report.reach_min[axis] = -reach(probe, -Vector3::Unit(axis), false, span);
    if (def.dof == 3) continue;
    report.turn_max[axis] = reach(probe, Vector3::Unit(axis), true, 0.5 * M_PI);
    report.turn_min[axis] = -reach(probe, -Vector3::Unit(axis), true, 0.5 * M_PI);
  }
  constexpr int kGrid = 9;
  int feasible = 0, uncertain = 0;
  for (int code = 0; code < kGrid * kGrid * kGrid; ++code) {
    const Vector3 share((code % kGrid + 0.5) / kGrid, (code / kGrid % kGrid + 0.5) / kGrid,
                        (code / (kGrid * kGrid) + 0.5) / kGrid);
    GripPose x;
    x.X_BG.p = low + share.cwiseProduct(high - low);
    probe.moveTo(x);
    if (!probe.presentsAllRound()) continue;
    ++(probe.determinesPose() ? feasible : uncertain);
    report.worst_singular_value = std::min(report.worst_singular_value, probe.leastSingular());
  }
  report.feasible_share = static_cast<double>(feasible) / (kGrid * kGrid * kGrid);
  report.uncertain_share = static_cast<double>(uncertain) / (kGrid * kGrid * kGrid);
}

/// Share of a wrench on each axis that the file's own λ lets through, worst of both signs.
double presentedShare(const DeviceDef& def, bool torque, double size) {
  const StringKinematics kinematics(def);
  TensionDistribution distribution(def, kinematics);
  double worst = 1;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      Wrench F;
      (torque ? F.torque : F.force)[axis] = sign * size;
      const Wrench& given = distribution.present(F).F_G_B;
      worst = std::min(worst, (torque ? given.torque : given.force)[axis] * sign / size);
    }
  return worst;
}

void examineHome(const DeviceDef& def, Probe& probe, DeviceReport& report) {
  const StringKinematics& kinematics = probe.kinematics();
  const GripPose home;
  const int n = kinematics.strings();
  report.knot_radius = kinematics.knotRadius();
  report.singular_values = kinematics.singularValues(home);
  report.worst_singular_value = report.singular_values[report.singular_values.size() - 1];
  probe.moveTo(home);
  report.presentable_force = probe.largest(false, 2 * def.strings[0].max_tension);
  if (def.dof >= 6)
    report.presentable_torque = probe.largest(true, 2 * def.strings[0].max_tension * report.knot_radius);
  report.force_share = presentedShare(def, false, std::min(5.0, def.max_force));
  report.torque_share = def.dof >= 6 ? presentedShare(def, true, std::min(0.1, def.max_torque)) : 1;

  const StructureMatrix A = kinematics.scaledStructure(home);
  const StringVector length = kinematics.lengths(home);
  Eigen::MatrixXd rounded = A;  // rows over the rms of each string's rounding
  for (int i = 0; i < n; ++i) {
    const StringDef& s = def.strings[i];
    const Vector3 d = A.row(i).head<3>();
    report.stiffness += s.min_tension / length[i] * (Vector3::Ones() - d.cwiseAbs2());
    rounded.row(i) *= std::sqrt(12.0) / std::fabs(s.length_per_count);
  }
  const Eigen::MatrixXd covariance = inverse(rounded.transpose().lazyProduct(rounded));
  report.resolution = covariance.diagonal().head<3>().cwiseSqrt();
  if (def.dof >= 6)
    report.turn_resolution = covariance.diagonal().segment<3>(3).cwiseSqrt() / report.knot_radius;

  report.closest_strings = 1e9;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      const StringDef &a = def.strings[i], &b = def.strings[j];
      if ((a.p_GK - b.p_GK).norm() < 1e-4) continue;
      report.closest_strings =
          std::min(report.closest_strings, segmentDistance(a.p_BE, a.p_GK, b.p_BE, b.p_GK));
    }
}

std::string number(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string lambdaText(const DeviceDef& def) {
  return def.border_lambda > 0 ? "border_lambda " + number(def.border_lambda, 4) : "lambda " + number(def.lambda, 4);
}

void findProblems(const DeviceDef& def, DeviceReport& report) {
  const auto add = [&](const std::string& line) { report.problems.push_back(line); };
  const double probe = probeForce(def);
  const bool surrounded = report.presentable_force >= probe;
  if (!surrounded)
    add("not even " + number(probe, 1) +
        " N can be presented in every direction at home: the strings do not surround the grip; move exits");
  else if (report.presentable_force < def.max_force)
    add("max_force " + number(def.max_force, 1) + " N is more than the " +
        number(report.presentable_force, 1) + " N that every direction allows at home; lower it");
  if (surrounded && def.dof >= 6 && report.presentable_torque < def.max_torque)
    add("max_torque " + number(def.max_torque, 3) + " N·m is more than the " +
        number(report.presentable_torque, 3) + " N·m that every direction allows at home; lower it");
  if (const double least = report.singular_values[report.singular_values.size() - 1]; least < kPoorSingular)
    add("the lengths hardly determine the pose at home (smallest singular value " + number(least, 3) +
        "); move knots apart or exits");
  if (surrounded && std::min(report.force_share, report.torque_share) < kPromisedShare)
    add(lambdaText(def) + " presents only " + number(100 * report.force_share, 1) +
        " % of a force and " + number(100 * report.torque_share, 1) + " % of a torque; lower it");
  if (report.closest_strings < kRubbing)
    add("two strings pass at " + number(1e3 * report.closest_strings, 1) +
        " mm at home and will rub; swap exits or knots");
  if (static_cast<int>(def.strings.size()) == def.dof)
    add("no more strings than degrees of freedom: they can only hold a grip that gravity or a spring pulls, "
        "and no slip can be noticed");
  if (def.handedness == Handedness::kGuessedLeft || def.handedness == Handedness::kGuessedRight)
    report.to_do.push_back("handedness is guessed: do the first-motion test, then write left or right");
}

std::string vectorText(const Vector3& v, double scale, int digits) {
  return number(scale * v.x(), digits) + " " + number(scale * v.y(), digits) + " " +
         number(scale * v.z(), digits);
}

std::string rangeText(const Vector3& low, const Vector3& high, double scale, int digits) {
  std::string text;
  const char* axes[] = {"x ", ", y ", ", z "};
  for (int axis = 0; axis < 3; ++axis)
    text += axes[axis] + number(scale * low[axis], digits) + " to " + number(scale * high[axis], digits);
  return text;
}

/// Largest stable contact stiffness per rate, by the device's own damping and with a relaxed hand's on top.
std::string wallText(const DeviceDef& def) {
  std::string text = "stable contact stiffness [N/mm], grip free / in a relaxed hand:";
  double count = 0;
  for (const StringDef& string : def.strings) count = std::max(count, std::fabs(string.length_per_count));
  for (const double rate : {1000.0, 2000.0, 5000.0, 10000.0}) {
    if (rate > def.max_rate_hz * (1 + 1e-9)) continue;
    const double period = 1 / rate, delay = loopDelay(period, def.delay_s);
    const auto borne = [&](double damping, int digits) {
      return number(1e-3 * stiffestWall(largestWallStiffness(damping, 0, period, delay), count), digits);
    };
    text += " " + number(rate, 0) + " Hz " + borne(def.grip_damping, 2) + " / " + borne(def.grip_damping + kRelaxedHandDamping, 1) + ";";
  }
  text.back() = '\n';
  return text + "  (Colgate & Schenkel: damping over half a period plus delay, and " + number(kCountForce, 2) +
         " N a count at most; the passivity controller adds damping up to its own)\n";
}

/// How far the wire tells whether the motors obey their currents, and the faults that stay unseen.
std::string obedienceText(const DeviceDef& def) {
  if (def.transport == "usb_sh4" || def.transport == "usb_simple")
    return "obedience: not seen on this hardware: the amplifier echoes its drive and reports no currents; a motor that does not pull is "
           "seen only when its string hangs loose\n";
  if (def.transport != "uart") return "";
  bool senses = !def.boards.empty();
  for (const std::string& model : def.boards) senses = senses && model.substr(0, 2) == "B3";
  std::string text =
      "obedience: each board is examined every 30 ms for commands that it cuts short (28 bytes of the wire, one string off by at most "
      "128 digits for 0.3 ms) and asked for its mode (up to 90 bytes, 450 us, at rates that have room for it)";
  if (senses) return text + " and its measured currents: one that ignores them is seen within 0.2 s\n";
  return text + "\n  not seen on this hardware: a board that answers, is in its mode and ignores its currents, for it does not report them "
                "(until the strings' lengths or a counter that stands still under a changing force tell)\n";
}

/// When a fault of all counters at once is seen: lengths that freeze together agree for ever.
std::string frozenText(const DeviceDef& def) {
  using Still = StillCounters;
  return "counts that freeze on every string: seen within " + number(1e3 * Still::kRest, 0) + " ms after a string was faster than " +
         number(1e3 * Still(def).tellingSpeed(), 0) + " mm/s, else " + number(1e3 * Still::kTime, 0) + " ms after the force changed by " +
         number(Still::kForceChange, 0) + " N; not seen on this hardware: those of a slower hand in no contact\n";
}

/// Which counters must rise and fall when the grip is moved a centimetre along each axis.
std::string firstMotionTest(const DeviceDef& def) {
  const StringKinematics kinematics(def);
  const char* moves[] = {"forward (+x)", "left (+y)", "up (+z)"};
  std::string text = "first-motion test: move the grip 1 cm from home; the counters must\n";
  for (int axis = 0; axis < 3; ++axis) {
    GripPose moved;
    moved.X_BG.p[axis] = 0.01;
    const StringVector change = kinematics.lengths(moved) - kinematics.lengths(GripPose{});
    std::string rise, fall;
    for (int i = 0; i < kinematics.strings(); ++i) {
      const double counts = change[i] / def.strings[i].length_per_count;
      if (std::fabs(change[i]) > 1e-3) (counts > 0 ? rise : fall) += " " + std::to_string(i);
    }
    text += std::string("  ") + moves[axis] + ": rise" + (rise.empty() ? " -" : rise) + ", fall" +
            (fall.empty() ? " -" : fall) + "\n";
  }
  return text +
         "  if forward alone is reversed, the other handedness is right; if one string alone is, its "
         "invert_count is wrong\n";
}

}  // namespace

double faultEnergy(const DeviceDef& def) {
  const SpidarSettings limits;
  const double reaction = limits.freshness.limit_s;
  const double rise = std::min(reaction, def.max_force / limits.force_slew);
  const double impulse = limits.force_slew * rise * (reaction - 0.5 * rise);
  return impulse * (kHandSpeed + impulse / (2 * def.grip_mass));
}

double segmentDistance(const Vector3& p0, const Vector3& p1, const Vector3& q0, const Vector3& q1) {
  const Vector3 u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double a = u.dot(u), b = u.dot(v), c = v.dot(v), d = u.dot(w), e = v.dot(w);
  const auto clamped = [](double s) { return std::min(1.0, std::max(0.0, s)); };
  const double denominator = a * c - b * b;
  double s = denominator > 1e-12 * a * c ? clamped((b * e - c * d) / denominator) : 0.0;
  const double t = clamped((b * s + e) / c);
  s = clamped((b * t - d) / a);
  return (w + s * u - t * v).norm();
}

DeviceReport examineDevice(const DeviceDef& def) {
  DeviceReport report;
  report.reach_min = report.reach_max = report.turn_min = report.turn_max = Vector3::Zero();
  Probe probe(def);
  examineHome(def, probe, report);
  examineRegion(def, probe, report);
  findProblems(def, report);
  return report;
}

std::string checkDevice(const DeviceDef& def) {
  const DeviceReport r = examineDevice(def);
  std::string text = def.name + ": " + std::to_string(def.strings.size()) + " strings, " +
                     std::to_string(def.dof) + " degrees of freedom (" + def.file + ")\n";
  text += "source: " + def.source + "\n";
  if (!def.note.empty()) text += "note: " + def.note + "\n";
  text += "workspace [mm], " + number(probeForce(def), 1) +
          " N presentable all round: " + rangeText(r.reach_min, r.reach_max, 1e3, 0) + "\n";
  if (def.dof >= 6) text += "turns [rad], likewise: " + rangeText(r.turn_min, r.turn_max, 1, 2) + "\n";
  text += "wrench-feasible region: " + number(100 * r.feasible_share, 0) + " % of the box of the exits";
  if (r.uncertain_share > 0)
    text += ", and " + number(100 * r.uncertain_share, 1) + " % where the pose is more than " + number(1 / kPoorSingular, 0) +
            " times less certain than the lengths";
  text += "\n";
  text += "presentable at home in every direction: " + number(r.presentable_force, 1) + " N";
  if (def.dof >= 6) text += ", " + number(r.presentable_torque, 3) + " N·m";
  text += "; with " + lambdaText(def) + ": " + number(100 * r.force_share, 1) +
          " % of a force, " + number(100 * r.torque_share, 1) + " % of a torque\n";
  text += "conditioning: singular values";
  for (int i = 0; i < r.singular_values.size(); ++i) text += " " + number(r.singular_values[i], 2);
  text += ", least in the region " + number(r.worst_singular_value, 3) + "\n";
  text += "stiffness of the strings at least tension [N/m]: " + vectorText(r.stiffness, 1, 1) + "\n";
  text += "resolution [mm]: " + vectorText(r.resolution, 1e3, 4) + "\n";
  if (def.dof >= 6) text += "resolution [mrad]: " + vectorText(r.turn_resolution, 1e3, 3) + "\n";
  text +=
      "highest rate " + number(def.max_rate_hz, 0) + " Hz, delay " + number(1e6 * def.delay_s, 0) + " us\n";
  text += wallText(def);
  const SpidarSettings limits;
  text += "a fault puts at most " + number(1e3 * faultEnergy(def), 0) + " mJ into the hand: " + number(def.max_force, 1) +
          " N, rising at " + number(limits.force_slew, 0) + " N/s, for the " + number(1e3 * limits.freshness.limit_s, 0) +
          " ms for which counts may be old\n";
  text += obedienceText(def) + frozenText(def);
  text += firstMotionTest(def);
  for (const std::string& line : r.to_do) text += "to do: " + line + "\n";
  for (const std::string& problem : r.problems) text += "problem: " + problem + "\n";
  if (r.problems.empty()) text += "no problem found\n";
  return text;
}

}  // namespace haptic
