/// A tree of rigid bodies on joints: the constant model. A free body is one link on a floating joint.
///
/// State lives with the caller, as plain doubles: positions q[nq()] and velocities v[nv()], both in link
/// order.
///
/// | joint     | q                                        | v                                             |
/// |-----------|------------------------------------------|-----------------------------------------------|
/// | slides    | displacements [m]                        | their rates                                   |
/// | one turn  | angle [rad]                              | its rate                                      |
/// | 3 turns   | quaternion w, x, y, z of R_JL            | angular velocity of L in the parent, in J     |
/// | floating  | p_WC [m], quaternion w, x, y, z of R_WL  | angular velocity of L, velocity of C, in W    |
///
/// A joint's slides come before its turns, in q and v (joint_type.h says which type has which); a floating one's turns
/// come first in v.
///
/// C is the link's centre of mass. With this choice a free body's inertia is block diagonal, its momentum is
/// (I ω, m v), and integrating p_WC under no force is exact. A floating joint carries no force: a floating
/// link is a root whatever its parent in the definition (which then only places it).
#pragma once
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/articulation_def.h"

namespace haptic {

/// Constant data of one link and its joint. O is the link's reference point: the centre of mass of a floating
/// link, the link frame's origin otherwise.
struct LinkModel {
  int parent = -1;                     ///< -1: the world
  bool floating = false;               ///< it hangs on nothing: six degrees of freedom
  int slides = 0, turns = 0, dof = 0;  ///< axes of the joint: dof = slides + turns
  int q = 0, v = 0;                    ///< first index in the state
  int v_slide = 0, v_turn = 0;         ///< first index of the slides, of the turns
  Vector3 p_PJ = Vector3::Zero();      ///< joint's origin from the parent's reference point, parent axes [m]
  Matrix3 R_PJ = Matrix3::Identity();  ///< joint frame
  Matrix3 axes_P = Matrix3::Zero();    ///< axes in parent axes, by column; none of a floating joint
  /// One turn: R_PL = turn[0] + turn[1] cos q + turn[2] sin q.
  Matrix3 turn[3] = {Matrix3::Identity(), Matrix3::Zero(), Matrix3::Zero()};
  double mass = 0;                        ///< [kg]
  Vector3 p_LO = Vector3::Zero();         ///< reference point in the link frame [m]
  Vector3 p_OC = Vector3::Zero();         ///< centre of mass from O, link axes [m]
  Matrix3 I_O = Matrix3::Zero();          ///< inertia about O, link axes [kg·m²]
  Matrix3 I_O_inverse = Matrix3::Zero();  ///< floating links only
  Matrix3 I_C = Matrix3::Zero();          ///< inertia about C, link axes [kg·m²]
  // Upper bounds of the link's mobility. A mass or a moment of zero counts as the smallest that numbers bear.
  double mobility = 0;                    ///< ∂v/∂f at C as if it were free [1/kg]
  Matrix3 turn_mobility = Matrix3::Zero();  ///< ∂ω/∂τ as if it were free, link axes [1/(kg·m²)]
  bool rooted = false;                    ///< its joint hangs on the world: it moves by that joint and not otherwise
  Eigen::Matrix<double, 6, 3> S_C = Eigen::Matrix<double, 6, 3>::Zero();  ///< of a rooted one: axes as twists of C, link axes
  Matrix3 joint_mobility = Matrix3::Zero();  ///< of a rooted one: (Sᵀ M S)⁻¹ of it alone, slides first
};

/// A tree of rigid bodies on joints: the constant model.
/// Immutable once constructed; shared by any number of states.
class Articulation {
 public:
  /// Compiles and checks the tree. Throws SetupError that names tree, link and joint: a parent that does not
  /// come before its child, an axis that is not a unit vector, a moment of inertia that is negative, a
  /// floating link without mass or inertia, limits upside down, a mimic of a
  /// missing joint, numbers that are not finite.
  explicit Articulation(const TreeDef& def);

  /// Links, in the order of the definition.
  int linkCount() const { return static_cast<int>(links_.size()); }
  int nq() const { return nq_; }                            ///< numbers in q
  int nv() const { return nv_; }                            ///< numbers in v
  const LinkModel& link(int i) const { return links_[i]; }  ///< constant data of link i
  const TreeDef& def() const { return def_; }               ///< the definition that it was compiled from
  /// One link on a floating joint: the routines take their short way.
  bool isFreeBody() const { return free_body_; }
  /// No degree of freedom: nothing ever moves.
  bool isStatic() const { return nv_ == 0; }
  /// The link without parent that link i hangs on.
  int root(int i) const { return root_[i]; }

  /// State of the definition: initial joint positions, initial pose and twist of floating roots.
  void initialState(double* q, double* v) const;

 private:
  void compileLink(int i);
  void boundMobility(int i, double tree_mass);
  TreeDef def_;
  std::vector<LinkModel> links_;
  std::vector<int> dof_link_, root_;
  int nq_ = 0, nv_ = 0;
  bool free_body_ = false;
};

}  // namespace haptic
