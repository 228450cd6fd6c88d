/// The field's own benchmarks; each file says whose they are.
#pragma once
#include "report_scene.h"

namespace haptic::report {

std::vector<Scene> ballScenes();       ///< SimBenchmark: rolling, bouncing, 666, elastic 666
std::vector<Scene> publishedScenes();  ///< MotrixSim's grasp, a cradle

}  // namespace haptic::report
