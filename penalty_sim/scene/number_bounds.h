/// Bounds of the numbers of a URDF, one row for each kind of number. All readers of robots ask these rows, through sound_numbers.h and
/// probable_numbers.h. urdf/scenes/README.md has the same table for users; a test compares the two.
#pragma once

namespace haptic {

/// In a file: no limit. Beyond any drive and any way [N, N·m, m/s, rad/s, m, rad].
inline constexpr double kUnlimited = 1e9;

inline constexpr double kAnyNumber = 1.7976931348623157e308;  ///< the largest that is finite: from kUnlimited on it is no limit

/// What a number of a URDF can be. An impossible number (not finite, beyond `largest`, negative where `negative` is false) is replaced;
/// one that is possible, not 0, and whose size lies outside [least, most] is improbable.
struct NumberBounds {
  const char* name;     ///< for people
  const char* unit;     ///< SI
  bool negative;        ///< whether it can be < 0
  double largest;       ///< size beyond which doubles no longer resolve the rest of a robot beside it
  const char* otherwise;  ///< in place of an impossible number, as a file writes it; empty: the row of the table says what happens
  double least, most;   ///< size beyond which no robot has it
  const char* expected; ///< words of a remedy
};

/// Coordinates of origins and centres of mass.
inline constexpr NumberBounds kPlaceBounds{"position", "m", true, 1e6, "0", 0, 30, "write metres"};
/// Of rpy: published files turn by at most 3π/2.
inline constexpr NumberBounds kAngleBounds{"angle", "rad", true, 1e6, "0", 0, 6.2832, "write radians"};
/// Of a link.
inline constexpr NumberBounds kMassBounds{"mass", "kg", false, 1e7, "", 1e-7, 1e4, "write kilograms"};
/// Entries of the inertia matrix.
inline constexpr NumberBounds kMomentBounds{"moment of inertia", "kg m²", true, 1e12, "", 0, 1e6, "write kg m²"};
/// Sides, radii and lengths of shapes.
inline constexpr NumberBounds kSizeBounds{"size", "m", false, 1e6, "", 1e-3, 1e3, "write metres"};
/// Factors of meshes; a negative one mirrors.
inline constexpr NumberBounds kScaleBounds{"scale", "1", true, 1e6, "", 1e-4, 100, "meshes in millimetres want 0.001"};
/// Exporters write −1 and inf for no limit. A drive needs a finite number, and no robot's joint has as much.
inline constexpr NumberBounds kEffortBounds{"effort", "N m or N", false, kAnyNumber, "1e6", 2e-2, 1e5, "write N m, or N for a slide"};
/// Of drives that turn: from a turn in ten minutes.
inline constexpr NumberBounds kTurnSpeedBounds{"velocity", "rad/s", false, kAnyNumber, "1e9", 1e-2, 1e5, "write rad/s"};
/// Of drives that slide.
inline constexpr NumberBounds kSlideSpeedBounds{"velocity", "m/s", false, kAnyNumber, "1e9", 1e-2, 1e3, "write m/s"};
/// Two turns: joints of quadrupeds and of welding robots go beyond one, none beyond two; 180 is degrees.
inline constexpr NumberBounds kTurnLimitBounds{"limit", "rad", true, kAnyNumber, "1e9", 0, 12.57, "write radians"};
/// Of joints that slide.
inline constexpr NumberBounds kSlideLimitBounds{"limit", "m", true, kAnyNumber, "1e9", 0, 30, "write metres"};
/// Of joints.
inline constexpr NumberBounds kDampingBounds{"damping", "N m s or N s/m", false, 1e9, "0", 0, 1e6, "write SI units"};
/// Of joints.
inline constexpr NumberBounds kFrictionBounds{"friction", "N m or N", false, 1e9, "0", 0, 1e5, "write SI units"};
/// A follower's inertia comes back with the square: beyond 1e6 the leader's own is lost in rounding.
inline constexpr NumberBounds kMultiplierBounds{"multiplier", "1", true, 1e6, "", 0, 1e4, "write its turns per turn of the other joint"};
/// Of followers.
inline constexpr NumberBounds kOffsetBounds{"offset", "rad or m", true, 1e6, "0", 0, 30, "write radians or metres"};

inline constexpr double kLeastTurn = 1e-2;   ///< between two limits of a joint that moves [rad]
inline constexpr double kLeastSlide = 1e-4;  ///< likewise [m]
inline constexpr double kRobotSize = 30;     ///< of any part that moves, or is joined to one that does [m]
/// Beyond what matter can do, for shapes that do not show all of a link [1].
inline constexpr double kMatterMargin = 3;
inline constexpr double kLeastDensity = 10;    ///< of the lightest foam; a kMatterMargin-th of it is improbable [kg/m³]
inline constexpr double kMostDensity = 23000;  ///< of osmium; kMatterMargin times it is improbable [kg/m³]
inline constexpr double kWireDensity = 9000;   ///< of copper, the densest that robots have much of [kg/m³]
/// Moment of a link's mass spread over its shapes, over the largest that the file gives [1]: published links with less reach 50, or 300
/// where the file's number is a mere placeholder; a side in millimetres makes a thousand and more.
inline constexpr double kMostSpread = 300;
inline constexpr double kMostOutgrown = 10;  ///< size of a link over that of the rest of its tree; of published robots 2.4 at most [1]
/// Of a joint by its drive, a turn in three seconds: of published robots 1.4 at least [rad/s²], [m/s²].
inline constexpr double kLeastAcceleration = 1;

}  // namespace haptic
