/// The poses at which a device presents all required wrenches and its lengths determine the pose: a region of certified cells.
///
/// A box of poses is bisected along its widest coordinate until each part is certified inside or outside of the region, or small.
/// Inside: presentable_set.h, and the least singular value of the scaled structure matrix A is at least σ throughout. Outside: one of
/// the two fails throughout.
///
/// The singular value over a cell, A(u) = A + L(u) + E with L linear and |E|_F ≤ |bend|:
///   σ_min(A(u)) ≥ √λ_min(G(u)) - |bend| with G(u) = AᵀA + AᵀL + LᵀA, for LᵀL ≥ 0 was left out. λ_min is concave and G affine, so
///     the corners have the least: σ_min ≥ σ throughout where G - (σ + |bend|)² has a Cholesky factor at every corner (before that, where
///     AᵀA - (σ + |spread|)² has one);
///   σ_min(A(u)) ≤ |(A + L(u)) x| + |bend| for any unit x, and the corners have the most of a convex function.
#pragma once
#include <vector>

#include "haptic_core/design/presentable_set.h"

namespace haptic {

/// When a pose belongs to the workspace, and how far cells are divided.
struct WorkspaceSettings {
  RequiredWrench required;                ///< to be presented all at once
  double least_singular = 0.1;            ///< σ: below, the pose is ten times less certain than the lengths [1]
  double cell_m = 2e-3;                   ///< undecided cells are divided until no wider than this [m]
  double cell_rad = 2 * M_PI / 180;       ///< likewise [rad]
  double undecided = 0.015;               ///< and until they are at most this share of the searched box [1]
  long work = 12000000;                   ///< bound: two for each cell and one for each of its faces; then the rest stays undecided
};

/// A region of certified cells.
struct Workspace {
  PoseCell searched;                               ///< box in which it was searched
  std::vector<PoseCell> inside, outside, undecided;  ///< a partition of it
  double inside_share = 0, undecided_share = 0;    ///< of the box's volume [1]
  bool exhausted = false;                          ///< the bound of the work ended it
  PoseCell ball;                                   ///< largest ball found in the certified cells; half: its radius [m or rad]
  PoseCell box;                                    ///< largest box found about home or about that ball's centre
  PoseCell home_ball, home_box;                    ///< likewise, about home
};

/// The exits' box at identity orientation, and turns of ±90° about each axis at home.
PoseCell translations(const DeviceDef& def);
PoseCell rotations();  ///< see above

/// Set-up: seconds.
Workspace certifyWorkspace(const DeviceDef& def, const PoseCell& searched, const WorkspaceSettings& settings);

/// Judges one cell of poses.
class CellJudge {
 public:
  CellJudge(const DeviceDef& def, const PoseCell& searched, const WorkspaceSettings& settings);  ///< poses of `searched` alone

  /// Whether the pose belongs to the workspace, exactly.
  bool contains(const Vector6& at) const;
  /// The verdict on a cell, of whose faces those `open` and, if `singular_open`, the singular value are to be judged.
  CellVerdict judge(const PoseCell& cell, const PresentableSet::Faces& open, bool singular_open, PresentableSet::Faces& still_open,
                    bool& still_singular) const;
  const PresentableSet& set() const { return set_; }  ///< of wrenches
  const CellRows& rows() const { return rows_; }      ///< of the device

 private:
  CellVerdict judgeSingular(const RowBounds& rows) const;

  CellRows rows_;
  PresentableSet set_;
  double least_singular_;
};

}  // namespace haptic
