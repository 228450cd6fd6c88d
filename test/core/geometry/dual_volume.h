/// The seeds' own method, on Qhull: the oracle of tests and the peer of the benchmark.
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace haptic::oracle {

/// Dual points of all half spaces about `interior`, a point inside both bodies; their hull; and from its
/// facets the vertices and volume of A ∩ B (Muller & Preparata 1978). All coordinates in A's frame. Errors
/// grow as the interior point nears a face: some 1e-15 m / distance, relative.
inline double qhullDualVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                              const Vector3& interior) {
  std::vector<double> dual;
  std::vector<Vector3> normals;
  const auto add = [&](const Vector3& n, double offset) {
    const double distance = offset - n.dot(interior);
    normals.push_back(n);
    for (int i = 0; i < 3; ++i) dual.push_back(n[i] / distance);
  };
  for (const auto& f : A.faces()) add(f.normal, f.offset);
  for (const auto& f : B.faces()) {
    const Vector3 n = X_AB.R * f.normal;
    add(n, f.offset + n.dot(X_AB.p));
  }
  qhT context;
  qhT* qh = &context;
  qh_zero(qh, nullptr);
  char options[] = "qhull Qt";
  double volume = 0;
  if (qh_new_qhull(qh, 3, static_cast<int>(normals.size()), dual.data(), 0, options, nullptr, nullptr) == 0) {
    // A dual facet is a vertex of V, a dual vertex a face: sum the faces as fans over their neighbouring
    // facets.
    qh_vertexneighbors(qh);
    vertexT* vertex;
    FORALLvertices {
      std::vector<Vector3> corners;
      facetT *neighbor, **neighborp;
      FOREACHneighbor_(vertex) {
        if (neighbor->offset < 0)
          corners.push_back(Vector3(neighbor->normal[0], neighbor->normal[1], neighbor->normal[2]) /
                            -neighbor->offset);
      }
      const Vector3& n = normals[qh_pointid(qh, vertex->point)];
      if (corners.size() < 3) continue;
      Vector3 middle = Vector3::Zero();
      for (const Vector3& c : corners) middle += c / static_cast<double>(corners.size());
      const Vector3 x = (corners[0] - middle).normalized(), y = n.cross(x);
      std::vector<std::pair<double, int>> order;
      for (std::size_t i = 0; i < corners.size(); ++i)
        order.push_back(
            {std::atan2(y.dot(corners[i] - middle), x.dot(corners[i] - middle)), static_cast<int>(i)});
      std::sort(order.begin(), order.end());
      for (std::size_t i = 0; i < order.size(); ++i)
        volume +=
            middle.dot(corners[order[i].second].cross(corners[order[(i + 1) % order.size()].second])) / 6;
    }
  }
  qh->NOerrexit = True;
  qh_freeqhull(qh, !qh_ALL);
  int remaining = 0, blocks = 0;
  qh_memfreeshort(qh, &remaining, &blocks);
  return volume;
}

}  // namespace haptic::oracle
