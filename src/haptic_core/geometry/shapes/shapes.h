/// The shapes that scenes name: box, cylinder, sphere. A compound is a list of polyhedra.
#pragma once
#include <memory>
#include <string>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic {

/// Throws a SetupError that names the shape and `what`, unless `value` is a positive length [m].
void checkLength(double value, const char* what, const std::string& name);

/// How a round shape becomes a polyhedron.
enum class RoundFit : unsigned char {
  kInscribed,   ///< vertices on the true surface; the volume is too small by `volume_error`
  kEqualVolume  ///< scaled about the centre (a cylinder: about its axis) to the true volume
};

/// Errors of a tessellation, to be printed.
struct TessellationReport {
  double volume_error = 0;   ///< relative: (true − made)/true; 0 to rounding for kEqualVolume
  double surface_error = 0;  ///< largest distance between true and made surface [m]
};

/// Box of the given full size [m] centred on the origin. Throws SetupError unless each size is positive and
/// finite.
ConvexPolyhedron makeBox(const Vector3& size, const std::string& name = "box");

/// Prism over a regular polygon of `segments` (≥ 3) sides, axis z, centred on the origin. The inscribed
/// prism's volume is sin(2π/n)/(2π/n) of the cylinder's: 2π²/(3n²) too small (0.6 % at 32, 0.16 % at 64).
ConvexPolyhedron makeCylinder(double radius, double length, int segments = 32,
                              RoundFit fit = RoundFit::kInscribed, const std::string& name = "cylinder",
                              TessellationReport* report = nullptr);

/// Icosahedron subdivided `subdivision` (0…6) times, vertices on the sphere, centred on the origin: 10·4ˢ + 2
/// vertices. Inscribed volume error: 39 %, 13 %, 3.4 %, 0.87 %, 0.22 % for s = 0…4 (≤ 0.56·4⁻ˢ).
ConvexPolyhedron makeSphere(double radius, int subdivision = 2, RoundFit fit = RoundFit::kInscribed,
                            const std::string& name = "sphere", TessellationReport* report = nullptr);

/// Largest distance between a shape's surface and that of `hull`, which stands in for it [m]: of their supports along 2562 directions
/// spread over the sphere and along the hull's normals, where a hull whose corners lie on the surface is farthest from it.
double tessellationError(const ConvexShape& shape, const ConvexPolyhedron& hull);

}  // namespace haptic
