/// How a world advances in time, and what files call it.
#pragma once

namespace haptic {

enum class Integrator : unsigned char { kSymplecticEuler, kVelocityVerlet, kImplicitEuler, kSdirk2, kAutomatic };

struct IntegratorKind {
  Integrator integrator;
  const char* name;  ///< in files
};

inline constexpr IntegratorKind kIntegratorKinds[] = {
    {Integrator::kSymplecticEuler, "symplectic_euler"}, {Integrator::kVelocityVerlet, "velocity_verlet"},
    {Integrator::kImplicitEuler, "implicit_euler"},     {Integrator::kSdirk2, "sdirk2"},
    {Integrator::kAutomatic, "automatic"},
};

}  // namespace haptic
