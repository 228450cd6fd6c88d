/// Groups of `./run bench shapes`.
#pragma once

namespace haptic::bench {

/// rod_rod.*_err_c and false_empty; `filter`: accuracy_cylinder, accuracy_capsule or accuracy_mixed alone; null: all. `pairs` of each
/// kind; 0: as many as the definition says.
void measureRodAccuracy(const char* filter, int pairs);
void measureRodJumps(int moves);     ///< rod_rod.wrench_jump
void measureRodCost();               ///< instructions of rods' contacts over those of two boxes
/// The work that measureRodCost counts, in this program started again.
void countRodPass(const char* name, int passes);
void measureLogs();      ///< logs.*, roll_over.*
void measureOverhang();  ///< overhang.depth_err_rel
void measureTerrain();   ///< terrain.*
void measureEllipsoid();  ///< ellipsoid.energy_err_rel

}  // namespace haptic::bench
