/// Groups of the benchmark `islands`.
#pragma once

namespace haptic::bench {

/// Arithmetic that is always the same, about as long as a tick: time that the machine takes from a thread shows in it as well.
double fixedWork();

/// Prints `scenes_at_10k`, the shipped scenes with a hand that hold 10 kHz in CPU time of the ticking thread, and of how many.
void measureScenesAt10k();

/// Prints `city.cpu_vs_bullet`, 60 s of the scene in which little moves but the hand, beside Bullet without its robots, door and drawer,
/// which the peer cannot run; and `city.bodies_cpu_vs_*`, both without them.
void measureCityBesidePeers();

/// Prints `deadline.*`: 10⁷ ticks under a budget against the certificate.
void measureDeadline();

/// Prints what a unit of counted work takes in each shipped scene, and whether it keeps its deadline at its own step.
void measureUnits();

}  // namespace haptic::bench
