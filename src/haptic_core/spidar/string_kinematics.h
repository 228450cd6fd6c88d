/// String lengths from a grip's pose, and the pose from the lengths, for any number of strings.
///
/// String i runs from its exit E_i on the base B to its knot K_i on the grip G:
///   v_i = p_BE - (p_BG + R_BG (p_GK + dp_GK g)),  l_i = |v_i|,  d_i = v_i / l_i,  m_i = (R p_GK(g)) × d_i.
/// The structure matrix A has the rows [d_i, m_i, d_i · R dp_GK]. It serves twice:
///   wrench on the grip = Aᵀ t (t tensions),   dl = -A [dp_BG; dθ; dg]  (θ in B's axes, g the opening).
/// Columns: 3 for a point grip, 6 for a rigid one, 7 for one that opens. One code, templated on that number.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {

inline constexpr int kMaxDof = 7;  ///< columns of a structure matrix at most
/// Rows: strings. Columns: force x y z [1], torque x y z [m], opening [1].
using StructureMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxStrings, kMaxDof>;

/// Configuration of the grip relative to the base.
struct GripPose {
  Pose X_BG;           ///< pose of the grip in the device's base
  double opening = 0;  ///< [m]; 0 for grips that do not open

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.X_BG), visit(s.opening);
  }
};

/// When the search for a pose ends.
struct PoseSettings {
  int max_iterations = 40;  ///< bound of one call; warm calls need 2 or 3
  /// Converged when a step is below this share of the curvature length (knot radius): the error left is its
  /// square times that length, 1e-12 · 22.5 mm = 2e-14 m. A smaller value costs an iteration for nothing.
  double step_tolerance = 1e-6;
};

/// How a search for a pose ended.
enum class PoseStatus : unsigned char { kConverged, kIterationLimit, kNotFinite };

/// A grip's pose, and how well the string lengths agree with it.
struct PoseSolution {
  GripPose pose;              ///< best so far, whatever the status
  StringVector length_error;  ///< l_i(pose) - measured [m]; the redundancy's verdict on each string
  double residual = 0;        ///< rms of length_error [m]
  int iterations = 0;         ///< linearisations
  PoseStatus status = PoseStatus::kNotFinite;  ///< kNotFinite: nothing was solved, or a length was not finite

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.pose), visit(s.length_error), visit(s.residual), visit(s.iterations), visit(s.status);
  }
};

/// String lengths from a grip's pose, and the pose from the lengths.
class StringKinematics {
 public:
  explicit StringKinematics(const DeviceDef& def);  ///< copies exits, knots and dof

  int strings() const { return strings_; }  ///< up to kMaxStrings
  int dof() const { return dof_; }          ///< 3, 6 or 7
  /// r of W: rms distance of the knots from G's origin [m]; 1 for a point grip, whose torque columns are
  /// absent.
  double knotRadius() const { return radius_; }

  StringVector lengths(const GripPose& pose) const noexcept;       ///< (in realtime) [m]
  StructureMatrix structure(const GripPose& pose) const noexcept;  ///< (in realtime) A
  StructureMatrix scaledStructure(
      const GripPose& pose) const noexcept;  ///< (in realtime) A W: torque columns over r
  Eigen::VectorXd singularValues(const GripPose& pose) const;  ///< of the scaled structure, largest first

  /// (in realtime) The pose whose lengths fit `measured` [m] best, least squares.
  ///
  /// Gauss-Newton on u = [dp; r dθ; dg] (all metres), so that damping treats both kinds alike; a step that
  /// does not lower the residual is taken back and repeated with Levenberg damping. Converged means: the next
  /// step would be rounding. Cost: about 0.3 µs per iteration with 8 strings.
  PoseSolution solvePose(const StringVector& measured, const GripPose& guess,
                         const PoseSettings& settings = {}) const noexcept;
  /// (in realtime) The same, and `pose_nearby` at the lengths `nearby` [m], by one step of the last linearisation: with lengths that
  /// differ by e it errs by e² over the knot radius, 6e-9 m for half a count of 0.02 mm. Not converged: the same pose.
  PoseSolution solvePose(const StringVector& measured, const GripPose& guess, const StringVector& nearby, GripPose& pose_nearby,
                         const PoseSettings& settings = {}) const noexcept;

 private:
  template <int kDof>
  friend struct StringLinearisation;
  template <int kDof>
  PoseSolution solve(const StringVector& measured, const GripPose& guess, const PoseSettings& settings, const StringVector& nearby,
                     GripPose& pose_nearby) const noexcept;

  using Lane = std::array<double, kMaxStrings>;
  int strings_ = 0, padded_ = 0, dof_ = 6;
  double radius_ = 1, curvature_length_ = 1;
  // One lane per coordinate, padded to a multiple of four with strings that never enter a sum.
  alignas(64) std::array<Lane, 3> exit_{}, knot_{}, knot_per_opening_{};
};

}  // namespace haptic
