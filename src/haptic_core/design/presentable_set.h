/// Whether strings present all wrenches up to a force and a torque: exactly at a pose, and certified over a cell of poses.
///
/// The presentable wrenches {Aᵀ t : t_min ≤ t ≤ t_max}, scaled by W (tension_distribution.h), are a zonotope Z; the required ones are
/// the set B = {|f| ≤ F, |τ| ≤ T} (a grip that opens: no force along the opening). With D columns, rows a_i of A W and the support
/// functions
///   h_Z(n) = Σ_i max(t_min n·a_i, t_max n·a_i),   h_B(n) = F |n_f| + (T/r) |n_τ|,
/// B lies in Z exactly when h_Z ≥ h_B in the outward normals of Z's faces (Bouchard, Gosselin, Moore, On the Ability of a Cable-Driven
/// Robot to Generate a Prescribed Set of Wrenches, 2010). Each normal is the null vector n_S of D-1 rows S, with either sign. The margin
///   μ = min over S, ± of (h_Z(n) - h_B(n)) / |n|
/// is the scaled force by which B can grow in every direction, and for μ > 0 the least of h_Z - h_B over all unit n.
///
/// Over a cell (bounds of pose_cell.h; a_i(u) = a_i + J_i u + e_i). For one S let n be the unit null vector at the centre, A_S the rows of
/// S, U⁻ᵀ in A_S⁺ = Q U⁻ᵀ with columns c_j, and n(u) = n + η, η ⊥ n, the null vector of A_S(u). The rows give A_S η = -b with
/// b_j = n·(J_j u + e_j) + Δ_j·η, |Δ_j| ≤ spread_j, so with sums over S
///   |η| ≤ H := (Σ_m w_m |Σ_j c_j n·J_jm| + Σ_j |c_j| bend_j) / (1 - Σ_j |c_j| spread_j)
/// provided that Σ |c_j| spread_j < 1: then n(u) exists and is unique. Else S is irregular.
/// Any y has y·η = -z·b for z = A_S⁺ᵀ y. Strings i outside of S: D_i(u) = n(u)·a_i(u) = n·a_i + g_i u + ρ with
///   g_i = n·J_i - Σ_j z_ij n·J_j,   |ρ| ≤ bend_i + spread_i H + Σ_j |z_ij| (bend_j + spread_j H) =: R_i.
/// Strings of S contribute nothing. h_B is convex: with y its gradient at n, h_B(n + η) ≥ h_B(n) + y·η, and since
/// |v + η| ≤ |v| + v·η/|v| + min(|η|²/(2|v|), 2|η|), the same plus second-order terms bounds it from above.
///   Inside: h_Z is convex in the D_i, so its tangents bound it from below: an affine function of u less remainders, least at a corner.
///     Where it is positive for every S and sign the cell is inside. A face that is settled over a cell is settled over its parts.
///   Outside: n(u) is some direction, so one S suffices: chords of h over the range of D_i bound it from above.
///   Irregular S: its rows depend on one another somewhere near. Leave out the weakest one, and let Q span the others, c_j
///     as above. Any unit null vector n of A_S(u) has |n·a_j| ≤ spread_j, hence |Qᵀn| ≤ Σ |c_j| spread_j =: τ, so it is a unit vector of
///     the plane across Q up to τ. With i outside of S alone, h_Z(n; u) - h_B(n) ≥ √(1-τ²) (least of Σ h_i over the plane's unit vectors)
///     - Σ_i t_max,i (τ |Qᵀa_i| + spread_i) - √(F² + (T/r)²).
/// But for irregular S the bounds are exact to first order in the cell's size: only cells near the border stay undecided.
/// Rounding: sums of some hundred products of numbers up to t_max; `kSlack` t_max is 1e4 times their rounding.
///
/// Not faces: S whose rows depend on one another at every pose (four strings at one knot). `markDegenerate` finds them at poses that the
/// caller draws: n_S is analytic in the pose, so it vanishes at generic poses only if it vanishes everywhere.
#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "haptic_core/design/pose_cell.h"

namespace haptic {

/// All wrenches that must be presentable at once.
struct RequiredWrench {
  double force = 1;   ///< every force up to this [N]
  double torque = 0;  ///< together with every torque up to this [N·m]
};

/// What is known of a cell.
enum class CellVerdict : unsigned char { kInside, kOutside, kUndecided };

/// Presentable wrenches of one device against required ones.
class PresentableSet {
 public:
  using Faces = std::vector<std::uint16_t>;  ///< sets S, by their number

  PresentableSet(const DeviceDef& def, const RequiredWrench& required);  ///< set-up: copies tensions, lists the sets S
  ~PresentableSet();

  Faces faces() const;                                  ///< all that may be faces
  void markDegenerate(const std::vector<RowBounds>& at);  ///< leaves out those that are none at any of these poses
  double margin(const RowBounds& rows) const;           ///< μ at the centre [N]; below zero outside, -∞ where Z is flat
  double largestForce(const RowBounds& rows) const;     ///< F for which μ = 0 with the required torque, at the centre [N]; 0: none
  double largestTorque(const RowBounds& rows) const;    ///< T for which μ = 0 with the required force, at the centre [N·m]; 0: none
  /// The verdict on a cell whose faces but `open` are settled; `still_open` becomes what its parts have to look at.
  CellVerdict judge(const RowBounds& rows, const Faces& open, Faces& still_open) const;

 private:
  class Part;  // one instantiation per number of columns
  template <int D>
  class Columns;
  std::unique_ptr<Part> part_;
};

}  // namespace haptic
