/// Details of a reported contact: centre of pressure, slip, outline of its patch. Computed where it is asked for.
#pragma once
#include <vector>

#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"

namespace haptic {

/// (in realtime) Z in W [m]: the point of the patch's plane about which the wrench turns about the normal n only,
///     p_WZ = p_WP + n × τ_P/N.
/// Friction acts in the plane and moves it nowhere. Without a normal force: the patch's origin.
Vector3 centreOfPressure(const ContactReport& contact) noexcept;

/// (in realtime) Velocity along the patch of B's surface on A's at the centre of pressure, belts included, in W [m/s]. Of a patch that
/// sticks, what its springs still give way. `link`: by world index, as they are placed.
Vector3 slipOf(const Model& model, const ContactReport& contact, const LinkWork* link) noexcept;

/// Outlines of patches: the curve in which two surfaces cross, seen along the normal. It encloses the area that the report has.
class PatchOutline {
 public:
  /// Set-up: room for all pairs of the model, which must outlive it.
  explicit PatchOutline(const Model& model);
  /// Corners in W in the plane of the patch [m], counter-clockwise seen from the normal's tip, for links at X_WA, X_WB. Of polyhedra
  /// exact at these poses (of several curves, where a body passes through another, the largest); where a round shape takes part,
  /// `kRoundCorners` of the ellipse with the patch's area, centre and second moments. Empty: the shapes do not overlap there, or one
  /// lies within the other. Costs a contact; allocates.
  const std::vector<Vector3>& of(const ContactReport& contact, const Pose& X_WA, const Pose& X_WB);

  static constexpr int kRoundCorners = 32;  ///< [1]: 0.6 % of the radius off; twice as many are four times nearer

 private:
  const Model& model_;
  ContactWorkspace workspace_;
  std::vector<int> next_;
  std::vector<Vector2> points_;
  std::vector<Vector3> corners_;
};

}  // namespace haptic
