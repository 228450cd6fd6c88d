/// Where the exits really are and how long the strings are at count zero, from a wave of the grip.
///
/// n strings measure dof < n numbers per pose: the surplus calibrates the device. Unknown are the zero
/// lengths o_i, the exits E_i and the pose of every sample; known are the knots and the encoder steps.
/// Minimised is
///   Σ_k Σ_i (|E_i - (p_k + R_k K_i)| - (o_i + count_ik · step_i))² / σ_i²  +  prior,   σ_i = step_i / √12,
/// by Gauss-Newton over (E, o) with the poses eliminated: each sample's pose is solved to convergence, and
/// only the part of its residual that no pose can explain enters (projection onto the complement of the
/// structure matrix). Moving exits and poses rigidly together changes nothing: six directions are
/// unobservable. Samples whose pose is known (a jig, or the grip held at home) fix them; without one they are
/// held where the file has them. The rest is observable only in a varied wave; the covariance tells.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// One reading of a calibration wave: counts, and about where the grip was.
struct CalibrationSample {
  std::array<std::int64_t, kMaxStrings> counts{};  ///< of the encoders, by string
  GripPose
      guess;  ///< where the grip was: exactly when `known`, else roughly (not used when another is known)
  bool known = false;  ///< held by a jig
};

/// Priors of a calibration, and when it stops.
struct CalibrationSettings {
  double exit_sigma = 0.01;    ///< prior of the exits about the file's [m]; wide enough for a tape measure
  double length_sigma = 0.02;  ///< prior of the zero lengths about their guess [m]
  int max_iterations = 50;     ///< Gauss-Newton steps
  double tolerance = 1e-9;  ///< converged when no parameter moves further [m]
};

/// Exits and string lengths as a wave of the grip told them, with their uncertainty.
struct Calibration {
  std::string device;          ///< name in the file
  std::string time;            ///< when it was made, ISO 8601, as the caller says
  std::vector<Vector3> p_BE;   ///< refined exits [m]
  StringVector zero_length;    ///< length at count 0 [m]; valid until the counters are reset
  Eigen::MatrixXd covariance;  ///< of [E_0 o_0 E_1 o_1 …] [m²], prior included
  double exit_sigma = 0;  ///< largest standard deviation of an exit's coordinate, rigid motions removed [m]
  double residual = 0;    ///< rms of the length errors [m]; about step / √12 when the model fits
  int samples = 0, iterations = 0;  ///< poses used, and Gauss-Newton steps done
  bool converged = false;           ///< false: `max_iterations` were not enough

  DeviceDef applied(DeviceDef def) const;  ///< `def` with the refined exits
};

/// Set-up; seconds for thousands of samples. `zero_length` is the guess (home lengths minus counts). Throws
/// SetupError when there are too few samples or strings without redundancy.
Calibration calibrateFromWave(const DeviceDef& def, const StringVector& zero_length,
                              const std::vector<CalibrationSample>& samples,
                              const CalibrationSettings& settings = {});

/// YAML with device, time, residual, exits, zero lengths, standard deviations. Throws SetupError.
void saveCalibration(const Calibration& calibration, const std::string& path);
/// Reads it back (without covariance). Throws SetupError when the file is not one for `def`.
Calibration loadCalibration(const DeviceDef& def, const std::string& path);

}  // namespace haptic
