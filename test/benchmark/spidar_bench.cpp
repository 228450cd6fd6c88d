// Figures of string kinematics, tension distribution, device files and calibration. Definitions: see each
// function.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "figure.h"
#include "haptic_core/spidar/calibration.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace {

using namespace haptic;
using bench::figure;

const std::string kDevices = std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/";

struct Random {
  std::mt19937_64 generator;
  explicit Random(unsigned seed) : generator(seed) {}
  double uniform(double size) { return std::uniform_real_distribution<double>(-size, size)(generator); }
  Vector3 box(double size) { return {uniform(size), uniform(size), uniform(size)}; }
  Vector3 direction() {
    Vector3 v;
    do v = box(1);
    while (v.squaredNorm() > 1 || v.squaredNorm() < 1e-4);
    return v.normalized();
  }
  Vector3 ball(double size) { return size * std::cbrt(0.5 + 0.5 * uniform(1)) * direction(); }
};

/// |x| ≤ shift, angle ≤ turn.
GripPose randomPose(Random& random, int dof, double shift, double turn, double opening = 0) {
  GripPose x;
  x.X_BG.p = random.ball(shift);
  if (dof >= 6) x.X_BG.R = rotationFromVector(random.ball(turn)).toRotationMatrix();
  if (dof == 7) x.opening = random.uniform(opening);
  return x;
}

double angleBetween(const Matrix3& A, const Matrix3& B) {
  return vectorFromRotation(Quaternion(A * B.transpose())).norm();
}

double poseError(const StringKinematics& k, const GripPose& a, const GripPose& b) {
  const double turn = k.dof() >= 6 ? k.knotRadius() * angleBetween(a.X_BG.R, b.X_BG.R) : 0;
  return std::max({(a.X_BG.p - b.X_BG.p).norm(), turn, std::fabs(a.opening - b.opening)});
}

/// Share of the frame in which a device is exercised: 30 mm for the default one.
double reachOf(const DeviceDef& def) {
  double shortest = 1e9;
  const StringKinematics k(def);
  for (int i = 0; i < k.strings(); ++i) shortest = std::min(shortest, k.lengths(GripPose{})[i]);
  return 0.3 * shortest;
}

std::vector<DeviceDef> allDevices() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(kDevices))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<DeviceDef> devices;
  for (const std::string& file : files) devices.push_back(loadDevice(file));
  return devices;
}

/// Noise-free round trip: largest of position error, r · angle and opening error.
double roundTripError(const DeviceDef& def, double turn, int poses, int& failures) {
  const StringKinematics k(def);
  Random random(1);
  const double reach = reachOf(def);
  double worst = 0;
  for (int i = 0; i < poses; ++i) {
    const GripPose truth = randomPose(random, def.dof, reach, turn, 0.01);
    GripPose guess = truth;
    guess.X_BG.p += random.ball(0.01 * reach);
    if (def.dof >= 6) guess.X_BG.R = rotationFromVector(random.ball(0.01)).toRotationMatrix() * truth.X_BG.R;
    const PoseSolution found = k.solvePose(k.lengths(truth), guess);
    failures += found.status != PoseStatus::kConverged;
    worst = std::max(worst, poseError(k, found.pose, truth));
  }
  return worst;
}

/// Largest start error, of position or of angle, from which at least 99.9 % of `poses` random poses are
/// found.
double basin(const DeviceDef& def, bool rotation, int poses) {
  const StringKinematics k(def);
  const double unit = rotation ? 0.1 : 0.005;
  for (int level = 1; level <= 30; ++level) {
    Random random(100 + level);
    int missed = 0;
    for (int i = 0; i < poses; ++i) {
      const GripPose truth = randomPose(random, def.dof, 0.03, 0.5);
      GripPose guess = truth;
      if (rotation)
        guess.X_BG.R =
            rotationFromVector(level * unit * random.direction()).toRotationMatrix() * truth.X_BG.R;
      else
        guess.X_BG.p += level * unit * random.direction();
      const PoseSolution found = k.solvePose(k.lengths(truth), guess);
      missed += !(poseError(k, found.pose, truth) < 1e-9);
    }
    if (missed > 0.001 * poses) return (level - 1) * unit;
  }
  return 30 * unit;
}

void poseFigures(const DeviceDef& def) {
  int failures = 0;
  figure("spidar.pose_error_m", roundTripError(def, 0.5, 100000, failures), "m");
  figure("spidar.pose_unsolved", failures, "poses");
  figure("spidar.pose_basin_rad", basin(def, true, 2000), "rad");
  figure("spidar.pose_basin_m", basin(def, false, 2000), "m");

  // Warm: the guess is the pose one tick ago, 0.1 m/s and 1 rad/s at 1 kHz.
  const StringKinematics k(def);
  Random random(2);
  constexpr int kPoses = 256;
  std::vector<StringVector> lengths;
  std::vector<GripPose> guesses;
  for (int i = 0; i < kPoses; ++i) {
    const GripPose truth = randomPose(random, def.dof, 0.03, 0.5);
    GripPose guess = truth;
    guess.X_BG.p += 1e-4 * random.direction();
    guess.X_BG.R = rotationFromVector(1e-3 * random.direction()).toRotationMatrix() * truth.X_BG.R;
    lengths.push_back(k.lengths(truth));
    guesses.push_back(guess);
  }
  double sink = 0;
  const double seconds = bench::secondsPerCall(
      [&](int i) { sink += k.solvePose(lengths[i % kPoses], guesses[i % kPoses]).residual; }, kPoses, 201);
  figure("spidar.pose_ns", seconds * 1e9, sink > 1 ? "ns?" : "ns");
}

Wrench randomWrench(Random& random, double force, double torque) {
  Wrench F;
  F.force = random.ball(force);
  F.torque = random.ball(torque);
  return F;
}

void tensionTimes(const DeviceDef& def) {
  const StringKinematics k(def);
  TensionDistribution distribution(def, k);
  Random random(3);
  constexpr int kCases = 256;
  std::vector<StructureMatrix> structures;
  std::vector<Wrench> wrenches, near;
  const Wrench around = randomWrench(random, 3, 0.05);
  for (int i = 0; i < kCases; ++i) {
    structures.push_back(k.scaledStructure(randomPose(random, def.dof, 0.03, 0.5)));
    wrenches.push_back(randomWrench(random, 10, 0.3));
    near.push_back(around + randomWrench(random, 0.01, 1e-4));
  }
  double sink = 0;
  // Cold: another pose, another wrench, no guess of the active set.
  const double cold = bench::secondsPerCall(
      [&](int i) {
        distribution.setStructure(structures[i % kCases]);
        distribution.forgetActiveSet();
        sink += distribution.solve(wrenches[i % kCases]).error;
      },
      kCases, 201);
  figure("spidar.qp_cold_ns", cold * 1e9, "ns");
  // Warm: the wrench of the next tick at the same pose; and with a pose that moved by an encoder count.
  StructureMatrix moved[2] = {structures[0], structures[0]};
  moved[1].array() += 1e-5;
  distribution.setStructure(moved[0]);
  const double warm =
      bench::secondsPerCall([&](int i) { sink += distribution.solve(near[i % kCases]).error; }, kCases, 201);
  figure("spidar.qp_warm_ns", warm * 1e9, "ns");
  const double warm_moved = bench::secondsPerCall(
      [&](int i) {
        distribution.setStructure(moved[i & 1]);
        sink += distribution.solve(near[i % kCases]).error;
      },
      kCases, 201);
  figure("spidar.qp_warm_moved_ns", warm_moved * 1e9, sink < 0 ? "ns?" : "ns");
}

/// 10⁵ wrenches from 0.1 N to 1000 N (and r times that in N·m), in and out of what can be presented.
void tensionExactness(const DeviceDef& def) {
  const StringKinematics k(def);
  TensionDistribution distribution(def, k);
  Random random(4);
  double worst = 0;
  int unsolved = 0, most = 0;
  for (int i = 0; i < 100000; ++i) {
    distribution.setStructure(k.scaledStructure(randomPose(random, def.dof, 0.03, 0.5)));
    const double size = std::pow(10, 1 + random.uniform(2));
    const TensionReport& report = distribution.solve(randomWrench(random, size, 0.03 * size));
    worst = std::max(worst, report.kkt_residual);
    unsolved += report.status != TensionStatus::kSolved;
    most = std::max(most, report.iterations);
  }
  figure("spidar.qp_kkt_max", worst, "1");
  figure("spidar.qp_unsolved", unsolved, "wrenches");
  figure("spidar.qp_iterations_max", most, "sets");
}

/// Worst of six axes and both signs at the centre: 5 N and 0.1 N·m.
void presentedShares(const DeviceDef& def) {
  const StringKinematics k(def);
  TensionDistribution distribution(def, k);
  double force = 1e9, torque = 1e9, lambda = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      Wrench F, M;
      F.force[axis] = 5 * sign;
      M.torque[axis] = 0.1 * sign;
      const TensionReport of_force = distribution.present(F), of_torque = distribution.present(M);
      force = std::min(force, of_force.F_G_B.force[axis] / (5 * sign));
      torque = std::min(torque, of_torque.F_G_B.torque[axis] / (0.1 * sign));
      lambda = std::max({lambda, of_force.lambda, of_torque.lambda});
    }
  }
  figure("spidar.force_presented_pct", 100 * force, "%");
  figure("spidar.torque_presented_pct", 100 * torque, "%");
  figure("spidar.presented_lambda", lambda, "1");  // the largest that these solves used
}

/// Largest change of a tension per 10 µm of straight paths through the frame, presenting a constant wrench of
/// 5 N or of 0.1 N·m: each path crosses the border of the full-presentation area.
double tensionJump(const DeviceDef& def, int paths, double& largest_lambda) {
  const StringKinematics k(def);
  TensionDistribution distribution(def, k);
  Random random(5);
  double worst = 0;
  for (int path = 0; path < paths; ++path) {
    const Vector3 along = random.direction(), through = random.ball(0.01);
    const Matrix3 R = rotationFromVector(random.ball(0.3)).toRotationMatrix();
    Wrench F;
    (path % 2 ? F.torque : F.force) = (path % 2 ? 0.1 : 5.0) * random.direction();
    StringVector before;
    for (int step = -5000; step <= 5000; ++step) {
      GripPose x;
      x.X_BG = Pose(R, through + 1e-5 * step * along);
      distribution.setStructure(k.scaledStructure(x));
      const TensionReport report = distribution.present(F);
      const StringVector& tension = report.tension;
      largest_lambda = std::max(largest_lambda, report.lambda);
      if (before.size()) worst = std::max(worst, (tension - before).cwiseAbs().maxCoeff());
      before = tension;
    }
  }
  return worst;
}

/// rms(achieved - asked) / rms(asked) in the norm with W, over random poses (30 mm, 0.4 rad) and wrenches (5
/// N, 0.1 N·m) of the full-presentation area.
double insideError(const DeviceDef& def) {
  const StringKinematics k(def);
  DeviceDef exact_def = def;
  exact_def.lambda = 1e-6;
  TensionDistribution distribution(def, k), exact(exact_def, k);
  Random random(7);
  double missing = 0, asked = 0;
  for (int i = 0; i < 20000; ++i) {
    const StructureMatrix A = k.scaledStructure(randomPose(random, def.dof, 0.03, 0.4));
    const Wrench F = randomWrench(random, 5, 0.1);
    exact.setStructure(A);
    if (exact.solve(F).error > 1e-3) continue;
    distribution.setStructure(A);
    const double error = distribution.present(F).error;
    missing += error * error;
    asked += F.force.squaredNorm() + F.torque.squaredNorm() / (k.knotRadius() * k.knotRadius());
  }
  return std::sqrt(missing / asked);
}

/// λ from the distance to the border against one constant λ, at the λ that gives the constant one no smaller
/// tension steps.
void automaticLambdaFigures(const DeviceDef& def) {
  DeviceDef constant = def;
  constant.border_lambda = 0;
  constant.lambda = 0.01;
  double lambda = 0, constant_lambda = 0;  // the largest that a solve used
  figure("spidar.tension_jump_n", tensionJump(def, 200, lambda), "N");
  figure("spidar.tension_jump_lambda", lambda, "1");
  figure("spidar.inside_error_pct", 100 * insideError(def), "%");
  figure("spidar.constant_lambda", constant.lambda, "1");
  figure("spidar.constant_jump_n", tensionJump(constant, 200, constant_lambda), "N");
  figure("spidar.constant_inside_error_pct", 100 * insideError(constant), "%");
}

/// Errors of wrench and grasp force of the 7-DOF grip, rms(achieved - asked) / rms(asked), where λ → 0
/// presents all.
void gripFigures(const DeviceDef& def) {
  const StringKinematics k(def);
  DeviceDef exact_def = def;
  exact_def.lambda = 1e-6;
  TensionDistribution distribution(def, k), exact(exact_def, k);
  Random random(6);
  double force = 0, force_asked = 0, torque = 0, torque_asked = 0, grasp = 0, grasp_asked = 0;
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const StructureMatrix A = k.scaledStructure(randomPose(random, def.dof, 0.02, 0.3, 0.01));
    const Wrench F = randomWrench(random, 5, 0.1);
    const double g = random.uniform(5);
    exact.setStructure(A);
    if (exact.solve(F, g).error > 1e-3) continue;
    ++inside;
    distribution.setStructure(A);
    const TensionReport& report = distribution.present(F, g);
    force += (report.F_G_B.force - F.force).squaredNorm();
    torque += (report.F_G_B.torque - F.torque).squaredNorm();
    grasp += std::pow(report.grasp_force - g, 2);
    force_asked += F.force.squaredNorm();
    torque_asked += F.torque.squaredNorm();
    grasp_asked += g * g;
  }
  figure("grip7.inside_pct", 100.0 * inside / 20000, "%");
  figure("grip7.force_error_pct", 100 * std::sqrt(force / force_asked), "%");
  figure("grip7.torque_error_pct", 100 * std::sqrt(torque / torque_asked), "%");
  figure("grip7.grasp_error_pct", 100 * std::sqrt(grasp / grasp_asked), "%");
}

std::string figureFolder() {
  const char* given = std::getenv("HAPTIC_FIGURE_DIR");
  const std::string folder = given ? given : std::string(HAPTIC_SOURCE_DIR) + "/build/figures";
  std::filesystem::create_directories(folder);
  return folder;
}

/// The slides' curves: tensions and presented force of SPIDAR-4 along the diagonal of its frame, 5 N asked
/// along x, for one constant λ each. Prints by λ the largest tension step per 10 µm: finite for λ > 0, a jump
/// for λ → 0.
void slideCurves(DeviceDef def) {
  const std::string path = figureFolder() + "/spidar_lambda.csv";
  std::ofstream csv(path);
  csv << "lambda,position_m,force_x_N,force_y_N,force_z_N,t0_N,t1_N,t2_N,t3_N\n";
  const StringKinematics k(def);
  const Vector3 diagonal = Vector3::Ones().normalized();
  for (const double lambda : {0.0, 0.1, 0.2, 0.3, 1.0}) {
    def.lambda = std::max(lambda, 1e-9);
    TensionDistribution distribution(def, k);
    StringVector before;
    double step_n = 0;
    for (int step = -45000; step <= 45000; ++step) {
      GripPose x;
      x.X_BG.p = 1e-5 * step * diagonal;
      distribution.setStructure(k.scaledStructure(x));
      Wrench F;
      F.force = -5 * diagonal;  // towards the face opposite to an exit, which the path crosses
      const TensionReport& report = distribution.solve(F);
      if (before.size()) step_n = std::max(step_n, (report.tension - before).cwiseAbs().maxCoeff());
      before = report.tension;
      if (step % 100) continue;
      csv << lambda << ',' << 1e-5 * step << ',' << report.F_G_B.force.x() << ',' << report.F_G_B.force.y()
          << ',' << report.F_G_B.force.z();
      for (int i = 0; i < k.strings(); ++i) csv << ',' << report.tension[i];
      csv << '\n';
    }
    char name[64];
    std::snprintf(name, sizeof name, "spidar.slide_jump_lambda_%g_n", lambda);
    figure(name, step_n, "N");
  }
  std::printf("# curves in %s\n", path.c_str());
}

/// Largest force, or torque, presentable along all axes and signs (λ → 0, 2 % missing at most).
double largestAllRound(TensionDistribution& distribution, bool torque, double radius, double limit) {
  double low = 0, high = limit;
  for (int i = 0; i < 12; ++i) {
    const double size = 0.5 * (low + high);
    bool presents = true;
    for (int axis = 0; axis < 6 && presents; ++axis) {
      Wrench F;
      (torque ? F.torque : F.force)[axis % 3] = axis < 3 ? size : -size;
      presents = distribution.solve(F).error <= 0.02 * (torque ? size / radius : size);
    }
    (presents ? low : high) = size;
  }
  return low;
}

/// Maps of presentable force and torque of every variant over the horizontal and the two vertical planes
/// through home.
void presentationMaps() {
  const std::string path = figureFolder() + "/spidar_presentable.csv";
  std::ofstream csv(path);
  csv << "device,x_m,y_m,z_m,force_N,torque_Nm\n";
  for (DeviceDef def : allDevices()) {
    def.lambda = 1e-6;
    const StringKinematics k(def);
    TensionDistribution distribution(def, k);
    const double reach = 2 * reachOf(def), strongest = 2 * def.strings[0].max_tension;
    for (int plane = 0; plane < 3; ++plane)
      for (int a = -5; a <= 5; ++a)
        for (int b = -5; b <= 5; ++b) {
          GripPose x;
          x.X_BG.p[plane] = 0.2 * a * reach;
          x.X_BG.p[(plane + 1) % 3] = 0.2 * b * reach;
          distribution.setStructure(k.scaledStructure(x));
          const double force = largestAllRound(distribution, false, k.knotRadius(), strongest);
          const double torque =
              def.dof == 3 ? 0
                           : largestAllRound(distribution, true, k.knotRadius(), strongest * k.knotRadius());
          csv << def.name << ',' << x.X_BG.p.x() << ',' << x.X_BG.p.y() << ',' << x.X_BG.p.z() << ',' << force
              << ',' << torque << '\n';
        }
  }
  std::printf("# maps in %s\n", path.c_str());
}

/// Self-calibration of a device whose exits are off by 5 mm and zero lengths by 10 mm, from a 20 s wave
/// sampled at 100 Hz: worst of three devices. Exits after the best rigid alignment; the rigid part, fixed by
/// one sample at home, as the shift of the farthest exit.
void calibrationFigures(const DeviceDef& nominal) {
  double exit_error = 0, rigid_error = 0, sigma = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    DeviceDef truth = nominal;
    for (StringDef& s : truth.strings) s.p_BE += 5e-3 * random.direction();
    StringVector zero = StringKinematics(truth).lengths(GripPose{});
    for (int i = 0; i < zero.size(); ++i) zero[i] += random.uniform(1) > 0 ? 0.01 : -0.01;
    TwinSettings settings;
    settings.path = handPath("wave");
    DeviceTwin twin(truth, settings);
    Spidar wound(nominal);
    const StringKinematics kinematics(nominal);
    std::vector<CalibrationSample> samples;
    GripPose pose;
    for (int tick = 0; tick < 20000; ++tick) {
      CalibrationSample sample;
      sample.counts = twin.exchange(wound.drive()).counts;
      if (tick % 10) continue;
      StringVector length = zero;
      for (int i = 0; i < length.size(); ++i)
        length[i] += sample.counts[i] * nominal.strings[i].length_per_count;
      pose = kinematics.solvePose(length, pose).pose;
      sample.known = tick == 0;
      sample.guess = sample.known ? GripPose{} : pose;
      samples.push_back(sample);
    }
    const Calibration calibration = calibrateFromWave(nominal, zero, samples);
    const int n = kinematics.strings();
    Eigen::MatrixXd found(3, n), real(3, n);
    for (int i = 0; i < n; ++i) {
      found.col(i) = calibration.p_BE[i];
      real.col(i) = truth.strings[i].p_BE;
    }
    const Eigen::Matrix4d X = Eigen::umeyama(found, real, false);
    const Eigen::MatrixXd aligned = (X.topLeftCorner<3, 3>() * found).colwise() + X.topRightCorner<3, 1>();
    exit_error = std::max(exit_error, (aligned - real).colwise().norm().maxCoeff());
    rigid_error = std::max(rigid_error, (aligned - found).colwise().norm().maxCoeff());
    sigma = std::max(sigma, calibration.exit_sigma);
  }
  figure("calibration.exit_error_mm", 1e3 * exit_error, "mm");
  figure("calibration.exit_sigma_mm", 1e3 * sigma, "mm");
  figure("calibration.rigid_error_mm", 1e3 * rigid_error, "mm");
}

}  // namespace

int main() {
  const DeviceDef def = loadDevice(kDevices + "spidar_g6x3r.yaml");
  int variants = 0;
  for (const DeviceDef& device : allDevices()) {
    int failures = 0;
    // 0.3 rad: the I7's strings are so short that it is singular at 0.5.
    const double error = roundTripError(device, 0.3, 2000, failures);
    const bool passes = failures == 0 && error <= 1e-12;
    variants += passes;
    std::printf("# %-22s dof %d strings %zu round trip %.1e m, %d unsolved%s\n", device.name.c_str(),
                device.dof, device.strings.size(), error, failures, passes ? "" : "  FAILS");
  }
  figure("spidar.variants", variants, "devices");
  figure("spidar.file_lambda", def.lambda, "1");  // the constant one; figures that use another print it as ..._lambda
  figure("spidar.border_lambda", def.border_lambda, "1");
  poseFigures(def);
  tensionTimes(def);
  tensionExactness(def);
  presentedShares(def);
  automaticLambdaFigures(def);
  gripFigures(loadDevice(kDevices + "spidar_g7.yaml"));
  slideCurves(loadDevice(kDevices + "spidar_4.yaml"));
  presentationMaps();
  calibrationFigures(def);
  return 0;
}
