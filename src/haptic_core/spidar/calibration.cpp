#include "haptic_core/spidar/calibration.h"

#include <cmath>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Unknowns in the order [E_0 o_0 E_1 o_1 …]: four per string.
constexpr int kPerString = 4;

struct WaveProblem {
  const DeviceDef& nominal;
  const StringVector& nominal_zero;
  const CalibrationSettings& settings;
  std::vector<CalibrationSample> samples;  ///< `guess` follows the solution
  int strings;

  DeviceDef def;
  StringVector zero_length;
  VectorXd weight;  ///< 1 / σ_i² of a length [1/m²]

  WaveProblem(const DeviceDef& d, const StringVector& zero, const std::vector<CalibrationSample>& s,
              const CalibrationSettings& set)
      : nominal(d),
        nominal_zero(zero),
        settings(set),
        samples(s),
        strings(static_cast<int>(d.strings.size())),
        def(d),
        zero_length(zero),
        weight(strings) {
    for (int i = 0; i < strings; ++i) weight[i] = 12 / (d.strings[i].length_per_count * d.strings[i].length_per_count);
  }

  StringVector measured(const CalibrationSample& sample) const {
    StringVector length(strings);
    for (int i = 0; i < strings; ++i)
      length[i] = zero_length[i] + static_cast<double>(sample.counts[i]) * def.strings[i].length_per_count;
    return length;
  }

  VectorXd parameters() const {
    VectorXd theta(kPerString * strings);
    for (int i = 0; i < strings; ++i) theta.segment<4>(kPerString * i) << def.strings[i].p_BE, zero_length[i];
    return theta;
  }

  void setParameters(const VectorXd& theta) {
    for (int i = 0; i < strings; ++i) {
      def.strings[i].p_BE = theta.segment<3>(kPerString * i);
      zero_length[i] = theta[kPerString * i + 3];
    }
  }

  VectorXd priorPrecision() const {
    VectorXd precision(kPerString * strings);
    const double exit = 1 / (settings.exit_sigma * settings.exit_sigma), length = 1 / (settings.length_sigma * settings.length_sigma);
    for (int i = 0; i < strings; ++i) precision.segment<4>(kPerString * i) << exit, exit, exit, length;
    return precision;
  }

  VectorXd priorError() const {
    VectorXd error = parameters();
    for (int i = 0; i < strings; ++i) {
      error.segment<3>(kPerString * i) -= nominal.strings[i].p_BE;
      error[kPerString * i + 3] -= nominal_zero[i];
    }
    return error;
  }

  /// Zero lengths as the first known pose says, and all other poses from it, neighbour by neighbour: guesses
  /// made with lengths that are 10 mm off may be in another basin.
  void startFromKnownPose() {
    std::size_t first = 0;
    while (first < samples.size() && !samples[first].known) ++first;
    if (first == samples.size()) return;
    const StringKinematics kinematics(def);
    const StringVector length = kinematics.lengths(samples[first].guess);
    for (int i = 0; i < strings; ++i)
      zero_length[i] =
          length[i] - static_cast<double>(samples[first].counts[i]) * def.strings[i].length_per_count;
    const auto follow = [&](CalibrationSample& sample, const CalibrationSample& neighbour) {
      if (!sample.known) sample.guess = kinematics.solvePose(measured(sample), neighbour.guess).pose;
    };
    for (std::size_t k = first + 1; k < samples.size(); ++k) follow(samples[k], samples[k - 1]);
    for (std::size_t k = first; k-- > 0;) follow(samples[k], samples[k + 1]);
  }

  /// Solves every pose, then sums normal matrix, gradient and squared length errors; returns the cost.
  double linearise(MatrixXd& normal, VectorXd& gradient, double& squares);
};

double WaveProblem::linearise(MatrixXd& normal, VectorXd& gradient, double& squares) {
  const int size = kPerString * strings;
  const StringKinematics kinematics(def);
  normal.setZero(size, size);
  gradient.setZero(size);
  squares = 0;
  double cost = 0;
  const VectorXd root = weight.cwiseSqrt();
  MatrixXd J(strings, size);
  for (CalibrationSample& sample : samples) {
    const StringVector lengths = measured(sample);
    if (!sample.known) sample.guess = kinematics.solvePose(lengths, sample.guess).pose;
    const StringVector error = kinematics.lengths(sample.guess) - lengths;
    const StructureMatrix A = kinematics.scaledStructure(sample.guess);
    J.setZero();
    for (int i = 0; i < strings; ++i) {
      // dl_i = d_i · dE_i, and the measured length moves with o_i.
      J.block<1, 3>(i, kPerString * i) = root[i] * A.block<1, 3>(i, 0);
      J(i, kPerString * i + 3) = -root[i];
    }
    VectorXd e = root.cwiseProduct(error);
    cost += e.squaredNorm();
    squares += error.squaredNorm();
    if (!sample.known) {
      const MatrixXd moved = projectorOnto(root.asDiagonal() * A);
      J -= moved.lazyProduct(J).eval();
      e -= moved.lazyProduct(e).eval();
    }
    normal.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
    gradient += J.transpose().lazyProduct(e);
  }
  const VectorXd precision = priorPrecision(), prior = priorError();
  normal = normal.selfadjointView<Eigen::Lower>();
  normal.diagonal() += precision;
  gradient += precision.cwiseProduct(prior);
  return cost + prior.dot(precision.cwiseProduct(prior));
}

/// Projector onto the six rigid motions of all exits, in the parameters' order.
MatrixXd rigidMotions(const DeviceDef& def) {
  const int strings = static_cast<int>(def.strings.size());
  MatrixXd rigid = MatrixXd::Zero(kPerString * strings, 6);
  for (int i = 0; i < strings; ++i) {
    rigid.block<3, 3>(kPerString * i, 0) = Matrix3::Identity();
    rigid.block<3, 3>(kPerString * i, 3) = -crossMatrix(def.strings[i].p_BE);
  }
  return projectorOnto(rigid);
}

/// Largest standard deviation of an exit's coordinate once the six rigid motions of all exits are taken out.
double sigmaWithoutRigidMotion(const DeviceDef& def, const MatrixXd& covariance) {
  const MatrixXd rigid = rigidMotions(def), rest = MatrixXd::Identity(rigid.rows(), rigid.rows()) - rigid;
  const VectorXd variance = rest.cwiseProduct(rest.lazyProduct(covariance)).rowwise().sum();  // diagonal of rest · covariance · restᵀ
  double largest = 0;
  for (std::size_t i = 0; i < def.strings.size(); ++i)
    largest = std::max(largest, variance.segment<3>(kPerString * i).maxCoeff());
  return std::sqrt(std::max(0.0, largest));
}

/// Damped Gauss-Newton step. Without a known pose the six rigid motions are held: the data say nothing about
/// them, and rounding would.
VectorXd dampedStep(const WaveProblem& problem, const MatrixXd& normal, const VectorXd& gradient,
                    double damping) {
  MatrixXd damped = normal;
  VectorXd downhill = -gradient;
  damped.diagonal() *= 1 + damping;
  bool known = false;
  for (const CalibrationSample& sample : problem.samples) known = known || sample.known;
  if (!known) {
    const MatrixXd rigid = rigidMotions(problem.def);
    downhill -= rigid.lazyProduct(downhill).eval();
    damped += normal.diagonal().mean() * rigid;
  }
  return solveSymmetric(damped, downhill);
}

void requireEnough(const DeviceDef& def, const std::vector<CalibrationSample>& samples) {
  const int n = static_cast<int>(def.strings.size());
  if (n <= def.dof)
    throw SetupError("calibration of " + def.name, "needs more strings than degrees of freedom",
                     "calibrate by the home pose or a jig instead");
  int equations = 0;
  for (const CalibrationSample& sample : samples) equations += sample.known ? n : n - def.dof;
  if (equations < kPerString * n)
    throw SetupError("calibration of " + def.name, "has only " + std::to_string(samples.size()) + " samples",
                     "wave the grip through its whole workspace for 20 s");
}

}  // namespace

DeviceDef Calibration::applied(DeviceDef def) const {
  for (std::size_t i = 0; i < p_BE.size() && i < def.strings.size(); ++i) def.strings[i].p_BE = p_BE[i];
  return def;
}

Calibration calibrateFromWave(const DeviceDef& def, const StringVector& zero_length,
                              const std::vector<CalibrationSample>& samples,
                              const CalibrationSettings& settings) {
  requireEnough(def, samples);
  WaveProblem problem(def, zero_length, samples, settings);
  MatrixXd normal, next_normal;
  VectorXd gradient, next_gradient;
  double squares = 0;
  problem.startFromKnownPose();
  double cost = problem.linearise(normal, gradient, squares);
  // Marquardt damping: the first steps are long against the curvature of the lengths.
  double damping = 1e-3;
  Calibration out;
  while (!out.converged && out.iterations < settings.max_iterations) {
    ++out.iterations;
    const VectorXd step = dampedStep(problem, normal, gradient, damping);
    const VectorXd before = problem.parameters();
    const std::vector<CalibrationSample> poses = problem.samples;
    problem.setParameters(before + step);
    double next_squares = 0;
    const double next = problem.linearise(next_normal, next_gradient, next_squares);
    const bool smallest = step.cwiseAbs().maxCoeff() < settings.tolerance;
    if (next <= cost || smallest) {
      cost = next;
      squares = next_squares;
      normal.swap(next_normal);
      gradient.swap(next_gradient);
      damping = std::max(1e-12, damping * 0.1);
      out.converged = smallest && damping < 1e-3;
    } else {
      problem.setParameters(before);
      problem.samples = poses;
      damping *= 10;
    }
  }
  out.device = def.name;
  for (const StringDef& s : problem.def.strings) out.p_BE.push_back(s.p_BE);
  out.zero_length = problem.zero_length;
  out.samples = static_cast<int>(samples.size());
  out.residual = std::sqrt(squares / (samples.size() * def.strings.size()));
  out.covariance = solveSymmetric(normal, MatrixXd::Identity(normal.rows(), normal.cols()));
  out.exit_sigma = sigmaWithoutRigidMotion(problem.def, out.covariance);
  return out;
}

}  // namespace haptic
