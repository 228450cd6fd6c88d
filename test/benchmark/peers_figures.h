/// Figures of `bench peers`: rigid surfaces, and the scenes that makers of simulators publish, beside other simulators.
#pragma once
#include <string>

namespace haptic::bench {

void measureRigidSinks();    ///< stiff_rigid.sink_share_max and what belongs to it: 200 random stacks
void measureRigidTimes();    ///< stiff_rigid.step_over_soft: shipped scenes with their scripted hands
void measureGrasp();         ///< grasp.*, beside all settings of all peers
void measureCradle();        ///< cradle.*, likewise
void measureGyroscope();     ///< gyro.*, likewise
void measureContactbench();  ///< contactbench.*, likewise: residuals of the rigid law
void measureCenic();         ///< cenic.*: error over CPU time by accuracy, beside the peers by step
void measurePyramid(int rows);  ///< pyramid5050.* with 100 rows, beside Bullet and ODE
void measureHaptic();        ///< god.*, god_point.*, ours.*, ours_direct.*: the god object beside our hand
void measureTwoHands();      ///< the same renderers: a cube held by two hands
/// Runs one renderer through one trial of measureHaptic where callgrind counts.
void countHapticTicks(const std::string& renderer, const std::string& trial);

}  // namespace haptic::bench
