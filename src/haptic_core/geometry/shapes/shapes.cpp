#include "haptic_core/geometry/shapes/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace {

constexpr double kPi = 3.14159265358979323846;

using Triangles = std::vector<std::vector<int>>;

/// One step of the subdivision: each triangle becomes four, new vertices are pushed out to the unit sphere.
void subdivide(std::vector<Vector3>& vertices, Triangles& triangles) {
  std::map<std::pair<int, int>, int> midpoint;
  const auto between = [&](int a, int b) {
    const auto key = std::minmax(a, b);
    const auto found = midpoint.find(key);
    if (found != midpoint.end()) return found->second;
    vertices.push_back((vertices[a] + vertices[b]).normalized());
    return midpoint[key] = static_cast<int>(vertices.size()) - 1;
  };
  Triangles finer;
  for (const auto& t : triangles) {
    const int ab = between(t[0], t[1]), bc = between(t[1], t[2]), ca = between(t[2], t[0]);
    finer.insert(finer.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
  }
  triangles.swap(finer);
}

}  // namespace

void checkLength(double value, const char* what, const std::string& name) {
  if (value > 0 && std::isfinite(value)) return;
  throw SetupError(name, std::string(what) + " is " + std::to_string(value), "give a positive length in metres");
}

ConvexPolyhedron makeBox(const Vector3& size, const std::string& name) {
  for (int axis = 0; axis < 3; ++axis)
    checkLength(size[axis], axis == 0 ? "size x" : axis == 1 ? "size y" : "size z", name);
  // Vertex i has the sign of bit k of i along axis k. Face 2k looks along -k, face 2k + 1 along +k.
  std::vector<Vector3> vertices;
  for (int i = 0; i < 8; ++i)
    vertices.push_back(0.5 * Vector3(i & 1 ? size.x() : -size.x(), i & 2 ? size.y() : -size.y(),
                                     i & 4 ? size.z() : -size.z()));
  return ConvexPolyhedron(
      std::move(vertices),
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}, name);
}

ConvexPolyhedron makeCylinder(double radius, double length, int segments, RoundFit fit,
                              const std::string& name, TessellationReport* report) {
  checkLength(radius, "radius", name);
  checkLength(length, "length", name);
  if (segments < 3 || segments > 10000)
    throw SetupError(name, std::to_string(segments) + " segments", "give 3 to 10000");
  const double angle = 2 * kPi / segments;
  const double share = elementary::sin(angle) / angle;  // inscribed polygon's area over the circle's
  const double r = fit == RoundFit::kEqualVolume ? radius / std::sqrt(share) : radius;
  std::vector<Vector3> vertices;
  std::vector<std::vector<int>> faces(2);
  for (int i = 0; i < segments; ++i) {
    const auto [sine, cosine] = elementary::sinCos(i * angle);
    const Vector3 rim(r * cosine, r * sine, 0.5 * length);
    vertices.push_back(Vector3(rim.x(), rim.y(), -rim.z()));
    vertices.push_back(rim);
    const int next = (i + 1) % segments;
    faces.push_back({2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
    faces[0].push_back(2 * (segments - 1 - i));
    faces[1].push_back(2 * i + 1);
  }
  if (report) {
    report->volume_error = 1 - share * (r * r) / (radius * radius);
    report->surface_error = std::max(r - radius, radius - r * elementary::cos(angle / 2));
  }
  return ConvexPolyhedron(std::move(vertices), faces, name);
}

ConvexPolyhedron makeSphere(double radius, int subdivision, RoundFit fit, const std::string& name,
                            TessellationReport* report) {
  checkLength(radius, "radius", name);
  if (subdivision < 0 || subdivision > 6)
    throw SetupError(name, "subdivision " + std::to_string(subdivision), "give 0 to 6");
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vector3> vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vector3& v : vertices) v.normalize();
  Triangles triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                         {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                         {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int i = 0; i < subdivision; ++i) subdivide(vertices, triangles);
  const ConvexPolyhedron unit(vertices, triangles, name);
  const double share = unit.volume() / (4 * kPi / 3);
  const double r = fit == RoundFit::kEqualVolume ? radius / elementary::cbrt(share) : radius;
  for (Vector3& v : vertices) v *= r;
  if (report) {
    double inner = r;
    for (const auto& face : unit.faces()) inner = std::min(inner, r * face.offset);
    report->volume_error = 1 - share * (r * r * r) / (radius * radius * radius);
    report->surface_error = std::max(r - radius, radius - inner);
  }
  return ConvexPolyhedron(std::move(vertices), triangles, name);
}

double tessellationError(const ConvexShape& shape, const ConvexPolyhedron& hull) {
  static const ConvexPolyhedron directions = makeSphere(1, 4);
  double error = 0;
  int vertex = 0;
  const auto compare = [&](const Vector3& n) {
    vertex = hull.support(n, vertex);
    error = std::max(error, std::abs(n.dot(shape.core(n) - hull.vertices()[vertex]) + shape.rounding()));
  };
  for (const Vector3& n : directions.vertices()) compare(n);
  for (const ConvexPolyhedron::Face& face : hull.faces()) compare(face.normal);
  return error;
}

}  // namespace haptic
