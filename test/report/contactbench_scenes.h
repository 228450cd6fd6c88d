/// ContactBench's scenes, and the contacts in which the rigid law is judged.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "report_scene.h"

namespace haptic::report {

/// A contact whose wrench follows from the motion of all that it carries.
struct RuledContact {
  int upper = -1, lower = -1;  ///< links
  std::vector<int> carried;    ///< links over it, `upper` among them
  double face = 0;             ///< height of the lower body's upper face in its frame [m]
  double mu = 0;               ///< [1]
  double force = 0;            ///< exact normal force where it is constant [N]; 0: it is not
  std::function<Vector3(const BodyState&, const Vector3& n)> deepest;  ///< of the upper body's points, against n, in W [m]
};

struct RuledScene {
  Scene scene;
  std::vector<RuledContact> contacts;
};

std::vector<RuledScene> contactbenchScenes();  ///< slide, stick, drop, heavy_above, heavy_below, finger

}  // namespace haptic::report
