/// How a world advances in time, and what files call it.
#pragma once

namespace haptic {

/// The schemes: two explicit ones of first and second order, two implicit ones likewise, and the choice
/// between Verlet and implicit.
enum class Integrator : unsigned char { kSymplecticEuler, kVelocityVerlet, kImplicitEuler, kSdirk2, kAutomatic };

/// A row of `kIntegratorKinds`: a scheme and its name in files.
struct IntegratorKind {
  Integrator integrator;  ///< the scheme it describes
  const char* name;  ///< in files
};

/// All schemes, in the order of `Integrator`.
inline constexpr IntegratorKind kIntegratorKinds[] = {
    {Integrator::kSymplecticEuler, "symplectic_euler"}, {Integrator::kVelocityVerlet, "velocity_verlet"},
    {Integrator::kImplicitEuler, "implicit_euler"},     {Integrator::kSdirk2, "sdirk2"},
    {Integrator::kAutomatic, "automatic"},
};

}  // namespace haptic
