#include "scene/probable_numbers.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/symmetric_matrix.h"
#include "scene/joint_reading.h"
#include "scene/link_inertia.h"
#include "scene/number_bounds.h"

namespace haptic {
namespace {

/// Files give links that only name a frame so little, in a body that weighs more: nothing feels it [kg], share of the body's mass [1].
constexpr double kDummyMass = 1e-5, kDummyShare = 1e-3;

/// Corners and joints of a link, and the box around them.
struct Extent {
  std::vector<Vector3> points;
  Vector3 lower = Vector3::Constant(INFINITY), upper = Vector3::Constant(-INFINITY);

  void add(const Vector3& p) {
    points.push_back(p);
    lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  }
  double size() const { return points.empty() ? 0 : (upper - lower).norm(); }
  double distance(const Vector3& p) const { return (p - p.cwiseMax(lower).cwiseMin(upper)).norm(); }
};

Extent extentOf(const JudgedLink& link) {
  Extent extent;
  for (const Vector3& p : link.joints) extent.add(p);
  for (const CollisionDef& collision : link.collisions) {
    if (!collision.shape->bounded()) continue;
    const ConvexShape::Box box = collision.shape->aabb();
    for (int i = 0; i < 8; ++i) {
      Vector3 corner;
      for (int k = 0; k < 3; ++k) corner[k] = i >> k & 1 ? box.upper[k] : box.lower[k];
      extent.add(collision.X_LS * corner);
    }
  }
  return extent;
}

/// Of a tree at its initial pose.
class TreeExtent {
 public:
  TreeExtent(const ArticulationDef& tree, const std::vector<const JudgedLink*>& links) : links_(links) {
    const std::vector<Pose> X_WL = initialPoses(tree);
    for (const JudgedLink* link : links) {
      extents_.emplace_back();
      for (const Vector3& p : extentOf(*link).points) extents_.back().add(X_WL[link->link] * p);
    }
  }
  double size() const { return without(nullptr, false); }
  /// Size of the rest of the robot; 0 where no other link has a shape.
  double besides(const JudgedLink& link) const { return without(&link, true); }

 private:
  double without(const JudgedLink* left_out, bool shaped) const {
    Extent rest;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (links_[i] == left_out || extents_[i].points.empty()) continue;
      rest.add(extents_[i].lower), rest.add(extents_[i].upper);
      shaped &= links_[i]->collisions.empty();
    }
    return shaped ? 0 : rest.size();
  }
  const std::vector<const JudgedLink*>& links_;
  std::vector<Extent> extents_;
};

class LinkJudge {
 public:
  LinkJudge(const JudgedLink& link, const TreeExtent& tree, std::vector<std::string>& warnings)
      : link_(link), extent_(extentOf(link)), tree_size_(tree.size()), rest_(tree.besides(link)),
        solid_(inertiaOfShapes(link.collisions, 1)), warnings_(warnings) {}

  void judge(bool joined) {
    const double size = extent_.size();
    if (joined && size > kRobotSize) {
      warn("is ", size, " m large, a robot's parts are less than ", kRobotSize,
           " m; write sizes and places in metres, for meshes in millimetres scale=\"0.001 0.001 0.001\"");
      return;  // the rest follows from it
    }
    if (rest_ > 0 && size > kMostOutgrown * std::max(rest_, kLeastReach)) {
      warn("is ", size, " m large, all the rest of its body ", rest_, " m; write sizes and places in metres");
      return;
    }
    if (!(link_.inertia.mass > 0)) return;
    if (centre()) return;
    if (moments()) spread();
    density();
  }

 private:
  template <class... Parts>
  void warn(const Parts&... parts) const {
    std::ostringstream text;
    text.precision(4);
    text << link_.where << ": ";
    (text << ... << parts);
    warnings_.push_back(text.str());
  }

  bool centre() const {
    const double away = extent_.distance(link_.inertia.p_LC), size = link_.collisions.empty() ? std::max(tree_size_, extent_.size())
        : extent_.size();
    if (!(away > std::max(size, kLeastReach))) return false;
    warn("<inertial> <origin> puts the centre of mass ", link_.inertia.p_LC.transpose(), " ", away, " m away from the link, which is ",
        size,
         " m large; expected within it, in metres");
    return true;
  }

  /// Bounds of matter: all mass at the farthest point; a wire along the link, m/(πρL) = r², m r²/2; a ball.
  bool moments() const {
    const LinkInertia& inertia = link_.inertia;
    const PrincipalAxes principal = principalAxes(inertia.I_C);
    const bool shaped = !link_.collisions.empty();
    const double length = shaped ? std::max(extent_.size(), kLeastReach) : std::max(tree_size_, kLeastReach);
    const double wire = inertia.mass * inertia.mass / (2 * M_PI * kWireDensity * length);
    const double radius = elementary::cbrt(3 * inertia.mass / (4 * M_PI * kMostDensity)), ball = 0.4 * inertia.mass * radius * radius;
    if (!(principal.value[2] > 0)) return false;  // a point, which a file may mean
    for (int i = 0; i < 3; ++i) {
      double reach = shaped ? 0 : length * length;
      for (const Vector3& p : extent_.points) reach = std::max(reach, (p - inertia.p_LC).cross(principal.axes.col(i)).squaredNorm());
      const double most = kMatterMargin * inertia.mass * std::max(reach, kLeastReach * kLeastReach);
      const double least = std::max(wire, i == 2 ? ball : 0) / kMatterMargin;
      const double moment = principal.value[i];
      if (moment <= most && moment >= least) continue;
      warn("<inertia> has a moment of ", moment, " kg m², ", moment > most ? "more" : "less", " than its <mass> of ", inertia.mass,
           " kg can have in it (", moment > most ? most : least, "); expected ", expected(principal.axes.col(i), length),
           ", of a solid: for a box ixx = m (y² + z²)/12");
      return false;
    }
    return true;
  }

  /// A mass may sit in the middle of its shapes, but not in a hundredth of them.
  void spread() const {
    if (!(solid_.mass > 0)) return;
    const double given = principalAxes(link_.inertia.I_C).value[2];
    const double solid = link_.inertia.mass / solid_.mass * principalAxes(solid_.I_C).value[2];
    if (solid <= kMostSpread * given) return;
    warn("<inertia> has no moment above ", given, " kg m², and its <mass> of ", link_.inertia.mass,
         " kg spread over its shapes, which are ", extent_.size(), " m large, has ", solid,
         "; write sizes in metres and moments in kg m²");
  }


  double expected(const Vector3& axis, double length) const {
    const double mass = link_.inertia.mass;
    if (!(solid_.mass > 0)) return mass * length * length / 12;
    return mass / solid_.mass * axis.dot(solid_.I_C * axis);
  }

  void density() const {
    const double volume = solid_.mass;
    if (!(volume > 0)) return;
    const double density = link_.inertia.mass / volume;
    if (density >= kLeastDensity / kMatterMargin && density <= kMostDensity * kMatterMargin) return;
    warn("<mass> of ", link_.inertia.mass, " kg in shapes of ", volume, " m³, ", extent_.size(), " m large, is ", density,
         " kg/m³; expected ", 1000 * volume,
         " kg, or larger shapes: kilograms and metres");
  }

  static constexpr double kLeastReach = 0.05;  // of links that show nothing but a point [m]

  const JudgedLink& link_;
  Extent extent_;
  double tree_size_, rest_;  ///< of its tree, and of that without it [m]
  LinkInertia solid_;  ///< of its shapes at 1 kg/m³
  std::vector<std::string>& warnings_;
};

}  // namespace

void warnOfImprobableNumbers(LoadContext& context) {
  SceneDef& scene = context.scene;
  const auto& trees = scene.world.articulations;
  std::vector<std::vector<const JudgedLink*>> links(trees.size());
  for (const JudgedLink& link : context.judged) links[link.articulation].push_back(&link);
  for (std::size_t a = 0; a < trees.size(); ++a) {
    const TreeExtent size(trees[a], links[a]);
    for (const JudgedLink* link : links[a]) {
      const double whole = trees[a].links[link->link].inertia.mass;
      if (link->inertia.mass > 0 && link->inertia.mass <= kDummyMass && link->inertia.mass < kDummyShare * whole) continue;
      const bool joined = trees[a].links.size() > 1 || trees[a].links[0].joint.type != JointType::kFixed;
      LinkJudge(*link, size, scene.warnings).judge(joined);
    }
  }
  for (const int held : context.held) {
    for (const IdleJoint& idle : idleJoints(trees[held], scene.world.settings.gravity)) {
      const auto place = context.effort_places.find(idle.joint);
      const bool said = idle.effort > 0 && idle.effort < kEffortBounds.least;
      if (place == context.effort_places.end() || said) continue;
      std::ostringstream text;
      text.precision(4);
      text << place->second << ": <limit> effort=\"" << idle.effort << "\" ";
      if (idle.effort > 0 && std::isfinite(idle.effort)) {
        text << "moves what hangs on it (" << idle.inertia << (idle.turns ? " kg m²) by " : " kg) by ") << idle.effort / idle.inertia
             << (idle.turns ? " rad/s²" : " m/s²");
      } else {
        text << "is no drive, and the joint must carry " << idle.weight << (idle.turns ? " N m" : " N") << " at the start: it gives way";
      }
      text << "; expected " << std::max(2 * idle.weight, idle.inertia) << (idle.turns ? " N m" : " N") << " or more";
      scene.warnings.push_back(text.str());
    }
  }
}

}  // namespace haptic
