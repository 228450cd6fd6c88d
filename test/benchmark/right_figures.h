/// Parts of `./run bench right`; each prints figures of its own.
#pragma once
#include <string>

#include "haptic_core/world/world.h"

namespace haptic::bench {

struct NamedIntegrator {
  Integrator integrator;
  const char* name;
};
inline constexpr NamedIntegrator kIntegrators[] = {{Integrator::kSymplecticEuler, "euler"},
                                                   {Integrator::kVelocityVerlet, "verlet"},
                                                   {Integrator::kImplicitEuler, "implicit"},
                                                   {Integrator::kSdirk2, "sdirk2"},
                                                   {Integrator::kAutomatic, "automatic"}};
inline bool isExplicit(Integrator integrator) {
  return integrator == Integrator::kSymplecticEuler || integrator == Integrator::kVelocityVerlet;
}

void runCarriers();   ///< carrier.*
void runBalances();   ///< wrench.*, momentum.*
void runEnergy();     ///< energy.*
void runImpacts();    ///< impact.*, runaway.*

}  // namespace haptic::bench
