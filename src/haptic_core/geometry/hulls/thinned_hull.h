/// A hull with fewer corners, nowhere farther inside than asked.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// Corners that a hull may have whatever the tolerance: thinning saves nothing below.
inline constexpr int kFewCorners = 64;

/// Share of the distance that is asked of a mesh that thinning may take: what is felt is round where the mesh is [1].
inline constexpr double kThinnedShare = 0.25;

/// The hull of some of the corners of `hull`, so many that none of the others lies more than `tolerance` [m] outside of it: the corners
/// farthest out come in first, face by face. It lies within the given hull. Corners that `kept` names are all in; empty: none. `distance`
/// gets the largest that a corner lies outside [m]. A hull of up to kFewCorners corners is itself. Deterministic; a world's memory grows
/// with the corners of its largest shape, and so does the time of a contact. Cost: corners times faces of the result, a few times.
std::shared_ptr<const ConvexPolyhedron> thinnedHull(std::shared_ptr<const ConvexPolyhedron> hull, double tolerance, const std::string& name,
                                                    double& distance, const std::function<bool(const Vector3&)>& kept = {});

}  // namespace haptic
