/// The twelve extreme cases: stiff, heavy on light, deep, fast, thin, tiny, huge. One code, no tuned constants.
///
/// Materials. k is the stiffest that a case needs (k_eff = k·area: 1e6 N/m under 1:1e3, 1e8 under 1:1e5, 1e8 for the
/// impact; elsewhere the rest depth is 1e-4 of the size). Hunt–Crossley c = 1/sqrt(g·size): what was pressed in
/// leaves at the speed of a fall from its own height at most. Critical means c such that the damper at rest is
/// critical.
#pragma once
#include "blocks.h"

namespace haptic::scenes {

struct ExtremeCase {
  std::string name;
  WorldDef def;
  std::vector<int> links;      ///< the bodies that are judged (world link indices)
  std::vector<double> rest_z;  ///< where each lies in the end [m]
  double size = 0.1;           ///< of the bodies [m]: rise and rest are judged by it
  double seconds = 3;          ///< simulated
};

namespace extreme {

inline CubeParameters cubeOf(double size, double mass, double k_eff) {
  CubeParameters c;
  c.size = size;
  c.mass = mass;
  c.stiffness = k_eff / (size * size);
  return c;
}

inline ExtremeCase one(const std::string& name, const CubeParameters& c, const WorldSettings& settings,
                       double above) {
  ExtremeCase e;
  e.name = name;
  e.def = cubeOnFloor(c, settings, 0);
  const double reach = std::max(4.0, 4 * c.size);
  e.def.articulations[0] = floorBox(reach, reach);
  e.def.articulations[1].X_WA.p.z() = c.size / 2 + above;
  e.def.settings.default_material.dissipation = 1 / std::sqrt(kGravity * c.size);
  e.links = {1};
  e.rest_z = {c.size / 2 - c.restDepth()};
  e.size = c.size;
  e.seconds = std::max(1.0, 3 * std::sqrt(c.size / 0.1));
  return e;
}

/// A heavy cube on a light one of the same size.
inline ExtremeCase heavyOnLight(double ratio, double k_eff, const WorldSettings& settings) {
  CubeParameters light = cubeOf(0.1, 0.1, k_eff);
  ExtremeCase e = one("mass ratio 1:" + std::to_string(static_cast<long>(ratio)), light, settings, 0);
  CubeParameters heavy = light;
  heavy.mass = ratio * light.mass;
  const double lower = (light.mass + heavy.mass) * kGravity / k_eff, upper = heavy.mass * kGravity / k_eff;
  e.def.articulations.push_back(cube("heavy", heavy, Pose(Vector3(0, 0, 1.5 * light.size + 0.001))));
  e.links = {1, 2};
  e.rest_z = {light.size / 2 - lower, 1.5 * light.size - lower - upper};
  return e;
}

inline ExtremeCase sizeOf(double size, const char* name, const WorldSettings& settings) {
  const double mass = 1000 * size * size * size;         // water
  const double k_eff = mass * kGravity / (1e-4 * size);  // sinks 1e-4 of its size
  return one(name, cubeOf(size, mass, k_eff), settings, 0.1 * size);
}

}  // namespace extreme

inline std::vector<ExtremeCase> extremeCases(const WorldSettings& settings) {
  using namespace extreme;
  std::vector<ExtremeCase> cases;
  cases.push_back(heavyOnLight(1e3, 1e6, settings));
  cases.push_back(heavyOnLight(1e5, 1e8, settings));

  ExtremeCase stiff = one("stiff and critically damped", cubeOf(0.1, 0.1, 1e6), settings, 0.05);
  stiff.def.settings.default_material.dissipation = cubeOf(0.1, 0.1, 1e6).material().dissipation;
  cases.push_back(stiff);

  cases.push_back(one("half inside the floor", cubeOf(0.1, 0.1, 1e6), settings, -0.05));

  ExtremeCase impact = one("impact at 100 m/s", cubeOf(0.1, 0.1, 1e8), settings, 0.5);
  impact.def.articulations[1].V_WA.linear = Vector3(0, 0, -100);
  cases.push_back(impact);

  ExtremeCase plate = one("plate 0.5 mm x 100 mm", cubeOf(0.1, 0.1, 1e5), settings, 0);
  const Vector3 plate_size(0.1, 0.1, 0.5e-3);
  plate.def.articulations[1] = freeBox("plate", plate_size, 0.04, Pose(Vector3(0, 0, 0.02)));
  plate.rest_z = {0.25e-3 - 0.04 * kGravity / 1e5};
  cases.push_back(plate);

  cases.push_back(sizeOf(1e-6, "cube of 1 um", settings));
  cases.push_back(sizeOf(1e-3, "cube of 1 mm", settings));
  cases.push_back(sizeOf(100, "cube of 100 m", settings));

  // Balanced to rounding it would stand for seconds: a milliradian decides which way it falls.
  ExtremeCase corner = one("cube on its corner", cubeOf(0.1, 0.1, 1e5), settings, 0);
  corner.def.articulations[1].X_WA.R =
      rotationAbout(Vector3(1, 0.3, 0).normalized(), 1e-3) *
      shortestTurn(Vector3(1, 1, 1).normalized(), Vector3::UnitZ()).toRotationMatrix();
  corner.def.articulations[1].X_WA.p.z() = std::sqrt(3.0) / 2 * 0.1;
  cases.push_back(corner);

  ExtremeCase faces = one("two cubes exactly face to face", cubeOf(0.1, 0.1, 1e5), settings, 0);
  faces.def.articulations.push_back(cube("upper", cubeOf(0.1, 0.1, 1e5), Pose(Vector3(0, 0, 0.15))));
  const double weight_depth = 0.1 * kGravity / 1e5;
  faces.links = {1, 2};
  faces.rest_z = {0.05 - 2 * weight_depth, 0.15 - 3 * weight_depth};
  cases.push_back(faces);

  ExtremeCase drop = one("8 cubes dropped on one another", cubeOf(0.1, 0.1, 1e6), settings, 0.01);
  for (int i = 1; i < 8; ++i) {
    drop.def.articulations.push_back(
        cube("cube" + std::to_string(i), cubeOf(0.1, 0.1, 1e6), Pose(Vector3(0, 0, 0.05 + 0.11 * i + 0.01))));
  }
  drop.links.clear();
  drop.rest_z.clear();
  double top = 0;
  for (int i = 0; i < 8; ++i) {
    top += 0.1 - (8 - i) * 0.1 * kGravity / 1e6;
    drop.links.push_back(1 + i);
    drop.rest_z.push_back(top - 0.05);
  }
  cases.push_back(drop);
  return cases;
}

}  // namespace haptic::scenes
