/// The haptic renderer that most devices run, as a peer of our hand: the god object, a point or ball that
/// surfaces stop.
///
/// Written from the papers, at its best:
///   - Zilles, Salisbury: A constraint-based god-object method for haptic display, IROS 1995. The god object
///   goes as near to the hand as
///     the facets between them allow: min |x - h|² over active planes, by Lagrange multipliers; a facet is
///     active where the way from the god object to the hand passes through it. The hand feels a spring, F = K
///     (x - h).
///   - Ruspini, Kolarov, Khatib, SIGGRAPH 1997: a proxy of finite radius among obstacles grown by that
///   radius; the planes are inequalities.
///   - The three-constraint algorithm of CHAI3D (Conti et al., 2003; Salisbury, Conti, Barbagli: Haptic
///   rendering, IEEE CG&A 2004): the way
///     to the hand, then that along the plane which it met, then that along the line of two planes; a third
///     one stops it.
///   - Friction by a cone (Harwin, Melder, Eurohaptics 2002; Salisbury, Zilles 1997): it stays while the
///   tangential way to the hand is at
///     most μ0 times the depth, and slides at μ times it once it has begun to.
///   - Objects that move carry the proxy's end of the way with them, as in CHAI3D: the way is taken in each
///   object's own frame, from where
///     the object would have carried the proxy since the last tick.
/// It has no mass, no rotation, no torque and no volume. Cost: up to four searches of each mesh's tree a
/// tick.
#pragma once
#include <vector>

#include "triangle_tree.h"

namespace haptic::bench {

struct GodObjectSettings {
  double stiffness = 1000;  ///< K [N/m]
  double radius = 0;        ///< of the proxy [m]; 0: a point
  double mu_static = 0, mu_dynamic = 0;
};

class GodObject {
 public:
  GodObject(const GodObjectSettings& settings, const Vector3& start) : settings_(settings), proxy_(start) {}

  int addMesh(const TriangleMesh& mesh, const Pose& X_WM);  ///< set-up; returns its index
  void moveMesh(int mesh, const Pose& X_WM) {
    meshes_[mesh].now = X_WM;
  }  ///< before a tick: where it is at the tick's end

  /// One tick with the hand at h [m]: the force on the hand [N], in W.
  Vector3 tick(const Vector3& h) noexcept;

  const Vector3& proxy() const { return proxy_; }  ///< the god object [m]
  int constraints() const { return count_; }       ///< planes that stopped it in the last tick, 0…3
  const Vector3& normal(int i) const { return plane_[i].normal; }  ///< of constraint i, in W
  /// Force on mesh i of the last tick [N], in W: the reaction, by the planes' multipliers; friction goes with
  /// the first one.
  Vector3 forceOn(int mesh) const noexcept;

 private:
  struct Mesh {
    TriangleTree tree;
    Pose before, now;
  };
  struct Plane {
    Vector3 normal;
    double offset = 0;      ///< n·x ≥ offset
    double multiplier = 0;  ///< n times this is its part of x - h [m]
    int mesh = -1;
  };
  bool meet(const Vector3& goal, bool carried) noexcept;
  Vector3 nearestAllowed(const Vector3& h) noexcept;
  bool solve(const Vector3& h, unsigned active, Vector3& x) noexcept;
  Vector3 held(const Vector3& goal) noexcept;

  static constexpr int kMost = 3;  // planes: a third one stops a point
  GodObjectSettings settings_;
  Vector3 proxy_;
  Vector3 force_ = Vector3::Zero();
  bool sliding_ = false;
  std::vector<Mesh> meshes_;
  Plane plane_[kMost];
  int count_ = 0;
};

}  // namespace haptic::bench
