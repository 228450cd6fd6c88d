/// The kinds of force elements: a row each, which names the kind's parameters and the function that gives its force at one instant
/// (link_force.h). A file of its own has that function; nothing else in the core knows a kind.
#pragma once
#include <limits>
#include <string>

#include "haptic_core/dynamics/link_force.h"

namespace haptic {

/// Which kind a force element is.
enum class ForceType : unsigned char { kSpring, kViscous };

/// Most parameters of a kind; an element keeps so many numbers [1].
inline constexpr int kMostForceParameters = 8;

/// A parameter of a kind.
struct ForceParameter {
  const char *name = nullptr, *unit = "";  ///< in files and messages; null: no such parameter
  double usual = 0;                        ///< where nothing is given
  double least = 0, most = std::numeric_limits<double>::infinity();  ///< bounds
};

/// Parameters of springs, by index: see spring_force.cpp.
enum SpringParameter : int { kSpringStiffness, kSpringDamping, kSpringRestLength, kSpringMost };
/// (in realtime) Between a point of A and a point of B.
void actAsSpring(const double* parameter, const ForceEnds& ends, LinkForce& force) noexcept;

/// Parameters of viscous fields, by index: see viscous_force.cpp.
enum ViscousParameter : int {
  kViscosity, kViscousLowerX, kViscousLowerY, kViscousLowerZ, kViscousUpperX, kViscousUpperY, kViscousUpperZ
};
/// (in realtime) On B where it is within a box of A.
void actAsViscousField(const double* parameter, const ForceEnds& ends, LinkForce& force) noexcept;

/// A row of `kForceKinds`.
struct ForceKind {
  ForceType type;                                                  ///< the kind it describes
  const char* name;                                                ///< in files
  ForceParameter parameters[kMostForceParameters];                 ///< by index; those without a name are none
  /// (in realtime) The force of an element with these parameters, into a `force` that holds zeros.
  void (*act)(const double* parameter, const ForceEnds& ends, LinkForce& force) noexcept;
};

inline constexpr double kNoBound = std::numeric_limits<double>::infinity();  ///< of a parameter

/// All kinds, in the order of `ForceType`.
inline constexpr ForceKind kForceKinds[] = {
    {ForceType::kSpring, "spring",
     {{"stiffness", "N/m"}, {"damping", "N·s/m"}, {"rest_length", "m"}, {"most", "N", kNoBound}}, actAsSpring},
    {ForceType::kViscous, "viscous",
     {{"viscosity", "Pa·s"},
      {"lower_x", "m", -kNoBound, -kNoBound}, {"lower_y", "m", -kNoBound, -kNoBound}, {"lower_z", "m", -kNoBound, -kNoBound},
      {"upper_x", "m", kNoBound, -kNoBound}, {"upper_y", "m", kNoBound, -kNoBound}, {"upper_z", "m", kNoBound, -kNoBound}},
     actAsViscousField},
};

/// Row of a kind.
constexpr const ForceKind& kindOf(ForceType type) { return kForceKinds[static_cast<int>(type)]; }

/// A force element as a user defines it.
struct ForceDef {
  std::string name;                           ///< for messages
  ForceType type = ForceType::kSpring;        ///< its kind
  /// Links by articulation and their index in it. A: articulation −1 is W. B: articulation −1 is each link that moves, one element each.
  int articulation_a = -1, link_a = -1, articulation_b = -1, link_b = -1;
  Vector3 p_A = Vector3::Zero(), p_B = Vector3::Zero();  ///< points, in A's frame and in B's [m]
  double parameter[kMostForceParameters] = {};           ///< by index, in the kind's units

  ForceDef() : ForceDef(ForceType::kSpring) {}  ///< a spring without stiffness
  explicit ForceDef(ForceType kind) : type(kind) {
    for (int i = 0; i < kMostForceParameters; ++i) parameter[i] = kindOf(kind).parameters[i].usual;
  }  ///< with the usual parameters
  /// By the parameter's name. Throws SetupError: the kind has none of that name.
  void set(const std::string& parameter_name, double value);

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.type), visit(s.articulation_a), visit(s.link_a), visit(s.articulation_b), visit(s.link_b);
    visit(s.p_A), visit(s.p_B), visit(s.parameter);
  }
};

/// Throws SetupError where a parameter is out of its bounds or a point not finite; `where`: for the message.
void check(const ForceDef& def, const std::string& where);

}  // namespace haptic
