#include "haptic_core/geometry/shapes/mass_properties.h"

#include <algorithm>

namespace haptic {

MassProperties massProperties(const TriangleMesh& mesh, double density) {
  MassProperties result;
  if (mesh.triangles.empty()) return result;
  // A tetrahedron (o, a, b, c) with v = det(a, b, c)/6 about o has ∫x = v s/4 and ∫x xᵀ = v (s sᵀ + a aᵀ + b
  // bᵀ
  // + c cᵀ)/20, where s = a + b + c. Taking o on the surface keeps the terms of the size of the solid.
  const Vector3 o = mesh.vertices[mesh.triangles[0][0]];
  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vector3 a = mesh.vertices[t[0]] - o, b = mesh.vertices[t[1]] - o, c = mesh.vertices[t[2]] - o;
    const Vector3 s = a + b + c;
    const double v = a.dot(b.cross(c)) / 6;
    volume += v;
    first += v / 4 * s;
    second += v / 20 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  result.volume = volume;
  result.mass = density * volume;
  if (volume == 0) return result;
  const Vector3 mean = first / volume;
  const Matrix3 covariance = density * (second - volume * mean * mean.transpose());
  result.com = o + mean;
  result.I_com = covariance.trace() * Matrix3::Identity() - covariance;
  return result;
}

std::array<int, 2> firstOpenEdge(const TriangleMesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) edges.push_back({t[i], t[(i + 1) % 3]});
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool twice = i + 1 < edges.size() && edges[i] == edges[i + 1];
    const bool matched =
        std::binary_search(edges.begin(), edges.end(), std::array<int, 2>{edges[i][1], edges[i][0]});
    if (twice || !matched) return edges[i];
  }
  return {-1, -1};
}

}  // namespace haptic
