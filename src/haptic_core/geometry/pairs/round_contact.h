/// The contact volume of pairs with a round shape: what balls (ball_contact.h), ellipsoids and rods (rod_contact.h) have in common.
#pragma once
#include <cmath>

#include "haptic_core/geometry/search/nearest_point.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/geometry/volume/solid_moments.h"

namespace haptic {

/// Fills the contact, and the workspace's copy of V.
class RoundContact {
 public:
  /// Fills `out` and the volume in `workspace`.
  RoundContact(const ContactRequest& request, PairCache& cache, ContactWorkspace& workspace, ContactVolume& out);

 protected:
  /// The normal of the last contact, in A; where there was none, `otherwise`.
  Vector3 lastOr(const Vector3& otherwise) const;
  /// No common points: `gap` [m] between them, along `direction_A`.
  void setSeparated(const Vector3& direction_A, double gap);
  /// Common points, but no volume that rounding resolves.
  void setTouching(const Vector3& normal_A, const Vector3& point_A);
  /// Round about `axis`, along which the patch of radius √r2 faces.
  void setAxial(const Vector3& normal_A, const Vector3& axis_A, const Vector3& centroid_A, double volume, double across,
                double r2, double depth);
  /// Shapes that the workspace was not made for: a cube as deep as they are along `n` stands for V, so that the pair still
  /// pushes apart.
  void setCube(const Vector3& normal_A, const Vector3& middle_A, double depth);
  /// From V's moments and the parts of the faces, both about o in Q; `covered`: area vector of their parts that are no surface. Leaves
  /// the depth to the caller. False: no volume.
  bool setMoments(const SolidMoments& sums, const Vector3& o_Q, const Vector3& covered_Q, const Vector3& way_out_A);
  /// The normal, in Q, of the face of the other shape that supports V, or of this cylinder's end: the one with the largest share of
  /// the patch. Zero if n is that normal, or if the cylinder's side has the largest share. After `setMoments`.
  Vector3 supportNormal() const;
  /// The part of a cover's outline between two heights in Q; valid until the next call.
  const LoadedVector<Vector3>& outlineBetween(const std::vector<Vector3>& outline_S, const Pose& X_QS, double low, double high);
  /// Area vector, in Q, of the covered part of faces of V; `areaWithin(face, outline)` is that of one face within a cover's outline.
  template <class Face, class AreaWithin>
  Vector3 coveredArea(const LoadedVector<Face>& faces, const InnerFaces* covers, AreaWithin areaWithin) {
    Vector3 sum = Vector3::Zero();
    if (!covers) return sum;
    for (int f = 0; f < faces.size(); ++f) {
      const Face face = faces[f];
      if (face.index < 0 || !covers->has(face.index)) continue;
      for (const InnerFaces::Cover& cover : covers->covers) {
        const double area = cover.face == face.index ? areaWithin(face, cover.outline) : 0;
        if (!(area > 0)) continue;
        sum += area * cover.share(deep_) * face.normal;
        out_.flags |= ContactVolume::kOnSeam;
      }
    }
    return sum;
  }
  /// Room in the workspace for the other shape in other coordinates, and for an outline.
  CutSolid& scratchSolid() { return w_.solid_; }
  LoadedVector<Vector3>& scratchOutline() { return w_.outline_; }  ///< see above
  /// Keeps the faces for those who draw V or look for its points.
  void keep();

  const ContactRequest& request_;
  double deep_ = INFINITY;  ///< about the depth, where gaps between pieces are judged [m]
  Vector3 given_;  ///< n in A, prescribed or remembered; zero: the area vector's direction
  PairCache& cache_;
  ContactWorkspace& w_;
  RoundVolume& v_;
  ContactVolume& out_;

 private:
  Vector3 normalOf(const Vector3& surface_A, double scale, const Vector3& otherwise);
  void keepAbove(double side, double height);
};

}  // namespace haptic
