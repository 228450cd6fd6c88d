/// Groups of `./run bench shapes`.
#pragma once

namespace haptic::bench {

void measureRodAccuracy(int pairs);  ///< rod_rod.*_err_c and false_empty; `pairs` of each kind
void measureRodJumps(int moves);     ///< rod_rod.wrench_jump
void measureRodCost();               ///< instructions of rods' contacts over those of two boxes
/// The work that measureRodCost counts, in this program started again.
void countRodPass(const char* name, int passes);
void measureLogs();      ///< logs.*, roll_over.*
void measureOverhang();  ///< overhang.depth_err_rel
void measureTerrain();   ///< terrain.*
void measureEllipsoid();  ///< ellipsoid.energy_err_rel

}  // namespace haptic::bench
