#include "haptic_core/geometry/search/gjk.h"

#include <algorithm>
#include <limits>

namespace haptic {
namespace {

/// A point b − a of the difference B − A with where it comes from.
struct SupportPoint {
  Vector3 difference = Vector3::Zero(), on_a = Vector3::Zero(), on_b = Vector3::Zero();
};

struct Simplex {
  SupportPoint point[4];
  double weight[4] = {0, 0, 0, 0};
  int count = 0;
};

/// Keeps the points listed in `keep` with their weights.
void reduce(Simplex& simplex, const int* keep, const double* weight, int count) {
  for (int i = 0; i < count; ++i) {  // keep[i] ≥ i: no point is overwritten before it is moved
    simplex.point[i] = simplex.point[keep[i]];
    simplex.weight[i] = weight[i];
  }
  simplex.count = count;
}

struct Candidate {
  double distance2 = std::numeric_limits<double>::infinity();
  int keep[3] = {0, 0, 0};
  double weight[3] = {1, 0, 0};
  int count = 0;
};

void offer(Candidate& best, const Vector3& closest, int count, const int* keep, const double* weight) {
  const double d2 = closest.squaredNorm();
  if (!(d2 < best.distance2)) return;
  best.distance2 = d2;
  best.count = count;
  for (int i = 0; i < count; ++i) {
    best.keep[i] = keep[i];
    best.weight[i] = weight[i];
  }
}

void tryPoint(Candidate& best, const Simplex& s, int i) {
  const int keep[] = {i};
  const double weight[] = {1};
  offer(best, s.point[i].difference, 1, keep, weight);
}

void tryEdge(Candidate& best, const Simplex& s, int i, int j) {
  const Vector3 &a = s.point[i].difference, &b = s.point[j].difference;
  const Vector3 e = b - a;
  const double length2 = e.squaredNorm(), t = -a.dot(e);
  if (!(t > 0) || !(t < length2)) return;
  const int keep[] = {i, j};
  const double weight[] = {1 - t / length2, t / length2};
  offer(best, a + weight[1] * e, 2, keep, weight);
}

void tryTriangle(Candidate& best, const Simplex& s, int i, int j, int k) {
  const Vector3 &a = s.point[i].difference, &b = s.point[j].difference, &c = s.point[k].difference;
  const Vector3 n = (b - a).cross(c - a);
  const double n2 = n.squaredNorm();
  if (!(n2 > 0)) return;
  const double wa = n.dot(b.cross(c)), wb = n.dot(c.cross(a)), wc = n.dot(a.cross(b));
  if (!(wa > 0) || !(wb > 0) || !(wc > 0)) return;
  const double sum = wa + wb + wc;
  const int keep[] = {i, j, k};
  const double weight[] = {wa / sum, wb / sum, wc / sum};
  offer(best, (a.dot(n) / n2) * n, 3, keep, weight);
}

/// True when the origin lies inside the tetrahedron.
bool enclosesOrigin(const Simplex& s) {
  const Vector3 &a = s.point[0].difference, &b = s.point[1].difference, &c = s.point[2].difference,
                &d = s.point[3].difference;
  const double volume = (b - a).dot((c - a).cross(d - a));
  const double side = volume > 0 ? 1 : -1;
  return volume != 0 && side * a.dot((b - a).cross(c - a)) < 0 && side * a.dot((c - a).cross(d - a)) < 0 &&
         side * a.dot((d - a).cross(b - a)) < 0 && -side * b.dot((c - b).cross(d - b)) < 0;
}

/// Reduces the simplex to the face nearest to the origin and returns that point; every face is tried, which
/// is slower than a Voronoi walk and cannot lose the right one by rounding.
Vector3 nearest(Simplex& s) {
  Candidate best{};
  for (int i = 0; i < s.count; ++i) {
    tryPoint(best, s, i);
    for (int j = i + 1; j < s.count; ++j) {
      tryEdge(best, s, i, j);
      for (int k = j + 1; k < s.count; ++k) tryTriangle(best, s, i, j, k);
    }
  }
  reduce(s, best.keep, best.weight, std::min(best.count, 3));  // a corner, an edge or a face
  Vector3 v = Vector3::Zero();
  for (int i = 0; i < s.count; ++i) v += s.weight[i] * s.point[i].difference;
  return v;
}

/// Iterations until a search is given up, unproven; 10–20 are usual, and the caller then decides by cutting.
constexpr int kIterations = 64;

/// Relative progress below which rounding has won.
constexpr double kProgress = 1e-14;

/// `support(n, point)` finds A's highest and B's lowest point along n and returns their gap.
template <class Support>
void search(Support&& support, const Vector3& direction, ClosestPoints& result) {
  Vector3 v = direction.squaredNorm() > 0 ? direction.normalized() : Vector3::UnitZ();
  double best_gap = -std::numeric_limits<double>::infinity();
  Simplex simplex;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double length = v.norm();
    if (!(length > 0)) break;
    const Vector3 n = v / length;
    SupportPoint& added = simplex.point[simplex.count];
    const double gap = support(n, added);
    if (gap > best_gap) {
      best_gap = gap;
      result.direction = n;
    }
    added.difference = added.on_b - added.on_a;
    const bool progress = simplex.count == 0 || gap < length * (1 - kProgress);
    if (!progress) break;
    bool repeated = false;
    for (int i = 0; i < simplex.count; ++i)
      repeated = repeated || simplex.point[i].difference == added.difference;
    if (repeated) break;
    ++simplex.count;
    if (simplex.count == 4 && enclosesOrigin(simplex)) break;
    v = nearest(simplex);
  }
  result.separated = best_gap > 0;
  result.p_A = result.p_B = Vector3::Zero();
  const int used = simplex.count < 4 ? simplex.count : 3;
  double sum = 0;
  for (int i = 0; i < used; ++i) {
    sum += simplex.weight[i];
    result.p_A += simplex.weight[i] * simplex.point[i].on_a;
    result.p_B += simplex.weight[i] * simplex.point[i].on_b;
  }
  result.p_A /= sum;
  result.p_B /= sum;
  result.distance = result.separated ? (result.p_B - result.p_A).norm() : 0.0;
}

}  // namespace

double gapAlong(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                const Vector3& direction, int& vertex_a, int& vertex_b) noexcept {
  const Vector3 direction_B = X_AB.R.transpose() * direction;
  vertex_a = A.support(direction, vertex_a);
  vertex_b = B.support(-direction_B, vertex_b);
  return direction.dot(X_AB * B.vertices()[vertex_b] - A.vertices()[vertex_a]);
}

void closestPoints(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                   const Vector3& direction, ClosestPoints& result) noexcept {
  search(
      [&](const Vector3& n, SupportPoint& point) {
        const double gap = gapAlong(A, B, X_AB, n, result.vertex_a, result.vertex_b);
        point.on_a = A.vertices()[result.vertex_a];
        point.on_b = X_AB * B.vertices()[result.vertex_b];
        return gap;
      },
      direction, result);
}

void closestCores(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const Vector3& direction,
                  ClosestPoints& result) noexcept {
  const auto support = [&](const Vector3& n, SupportPoint& point) {
    point.on_a = A.core(n);
    point.on_b = X_AB * B.core(-(X_AB.R.transpose() * n));
    return n.dot(point.on_b - point.on_a);
  };
  search(support, direction, result);
  // The distance that the direction proves: between curved cores the points found may be farther.
  SupportPoint along;
  if (result.separated) result.distance = support(result.direction, along);
}

}  // namespace haptic
