#include "triangle_tree.h"

#include <algorithm>
#include <cmath>

namespace haptic::bench {
namespace {

constexpr double kInside = 1e-9;  // of a triangle's size: neighbours overlap by that, so that no way leads
                                  // between them (Zilles, 1995)
constexpr int kMostDepth = 64;    // halves: more triangles than any machine holds

/// A way of the centre: from + s d, s in [0, 1].
struct Way {
  Vector3 from, d;
  double radius;
};

/// Takes a touch at share s where it is the first so far and the ball approaches.
void take(const Way& way, double s, const Vector3& normal, TriangleTree::Touch& touch, bool& found) {
  if (s > touch.share || (found && s == touch.share) || way.d.dot(normal) >= -1e-12 * way.d.norm()) return;
  touch.share = s;
  touch.normal = normal;
  found = true;
}

/// The centre meets the sphere of the way's radius about `p`; `d2` is the part of d that counts (across an
/// edge's axis), `m` likewise. False: it does not.
bool meetsCircle(const Vector3& m, const Vector3& d2, double radius, double& s) {
  const double a = d2.squaredNorm(), b = m.dot(d2), c = m.squaredNorm() - radius * radius;
  if (c <= 0) {
    s = 0;
    return true;
  }
  const double root = b * b - a * c;
  if (!(b < 0) || root < 0) return false;
  s = c / (-b + std::sqrt(root));
  return s <= 1;
}

Vector3 nearestOnSegment(const Vector3& a, const Vector3& b, const Vector3& p) {
  const Vector3 e = b - a;
  return a + std::clamp((p - a).dot(e) / e.squaredNorm(), 0.0, 1.0) * e;
}

/// Whether q, in the triangle's plane, lies in it.
template <class Triangle>
bool holds(const Triangle& t, const Vector3& q) {
  for (int i = 0; i < 3; ++i) {
    const Vector3 e = t.corner[(i + 1) % 3] - t.corner[i];
    if (t.normal.cross(e).dot(q - t.corner[i]) < -kInside * e.squaredNorm()) return false;
  }
  return true;
}

template <class Triangle>
void touchTriangle(const Triangle& t, const Way& way, TriangleTree::Touch& touch, bool& found) {
  const double height = t.normal.dot(way.from - t.corner[0]), fall = -t.normal.dot(way.d);
  if (fall > 0 && height >= 0) {
    const double s = std::max(0.0, (height - way.radius) / fall);
    const Vector3 centre = way.from + s * way.d;
    if (s <= 1 && holds(t, centre - t.normal.dot(centre - t.corner[0]) * t.normal))
      take(way, s, t.normal, touch, found);
  }
  if (way.radius == 0) return;
  for (int i = 0; i < 3; ++i) {
    const Vector3& a = t.corner[i];
    const Vector3 e = t.corner[(i + 1) % 3] - a, axis = e.normalized(), m = way.from - a;
    double s = 0;
    if (meetsCircle(m - axis.dot(m) * axis, way.d - axis.dot(way.d) * axis, way.radius, s)) {
      const Vector3 centre = way.from + s * way.d, foot = nearestOnSegment(a, a + e, centre),
                    n = centre - foot;
      const double along = axis.dot(centre - a);
      // A normal on the back of this triangle is another's, or of a ball that comes from inside.
      if (along >= 0 && along <= e.norm() && n.dot(t.normal) > 0) take(way, s, n.normalized(), touch, found);
    }
    if (meetsCircle(m, way.d, way.radius, s)) {
      const Vector3 n = way.from + s * way.d - a;
      if (n.dot(t.normal) > 0) take(way, s, n.normalized(), touch, found);
    }
  }
}

/// Whether the way, widened by its radius, meets the box before `share`.
bool meetsBox(const Vector3& lower, const Vector3& upper, const Way& way, double share) {
  double first = 0, last = share;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = lower[axis] - way.radius - way.from[axis],
                 high = upper[axis] + way.radius - way.from[axis], d = way.d[axis];
    if (d == 0) {
      if (low > 0 || high < 0) return false;
      continue;
    }
    const double a = low / d, b = high / d;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

template <class Triangle>
Vector3 nearestOfTriangle(const Triangle& t, const Vector3& p) {
  const Vector3 q = p - t.normal.dot(p - t.corner[0]) * t.normal;
  if (holds(t, q)) return q;
  Vector3 best = t.corner[0];
  for (int i = 0; i < 3; ++i) {
    const Vector3 on = nearestOnSegment(t.corner[i], t.corner[(i + 1) % 3], p);
    if ((on - p).squaredNorm() < (best - p).squaredNorm()) best = on;
  }
  return best;
}

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  for (const auto& indices : mesh.triangles) {
    Triangle t;
    for (int i = 0; i < 3; ++i) t.corner[i] = mesh.vertices[indices[i]];
    const Vector3 area = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]);
    if (!(area.norm() > 0)) continue;
    t.normal = area.normalized();
    triangles_.push_back(t);
  }
  nodes_.reserve(2 * triangles_.size());
  if (!triangles_.empty()) root_ = build(0, static_cast<int>(triangles_.size()));
}

/// Halves along the longest extent, down to single triangles.
int TriangleTree::build(int first, int count) {
  Node node;
  node.lower = node.upper = triangles_[first].corner[0];
  for (int t = first; t < first + count; ++t) {
    for (const Vector3& corner : triangles_[t].corner) {
      node.lower = node.lower.cwiseMin(corner), node.upper = node.upper.cwiseMax(corner);
    }
  }
  if (count == 1) {
    node.triangle = first;
  } else {
    int axis = 0;
    (node.upper - node.lower).maxCoeff(&axis);
    const auto middle = triangles_.begin() + first + count / 2;
    std::nth_element(triangles_.begin() + first, middle, triangles_.begin() + first + count,
                     [axis](const Triangle& a, const Triangle& b) {
                       return a.corner[0][axis] + a.corner[1][axis] + a.corner[2][axis] <
                              b.corner[0][axis] + b.corner[1][axis] + b.corner[2][axis];
                     });
    node.left = build(first, count / 2);
    node.right = build(first + count / 2, count - count / 2);
  }
  nodes_.push_back(node);
  return static_cast<int>(nodes_.size()) - 1;
}

bool TriangleTree::firstTouch(const Vector3& from, const Vector3& to, double radius,
                              Touch& touch) const noexcept {
  touch = Touch();
  bool found = false;
  const Way way{from, to - from, radius};
  if (root_ < 0 || way.d.squaredNorm() == 0) return false;
  int waiting[2 * kMostDepth], count = 0;
  waiting[count++] = root_;
  while (count > 0) {
    const Node& node = nodes_[waiting[--count]];
    if (!meetsBox(node.lower, node.upper, way, touch.share)) continue;
    if (node.triangle >= 0) {
      touchTriangle(triangles_[node.triangle], way, touch, found);
    } else {
      waiting[count++] = node.left, waiting[count++] = node.right;
    }
  }
  return found;
}

Vector3 TriangleTree::nearestPoint(const Vector3& p) const noexcept {
  Vector3 best = Vector3::Constant(INFINITY);
  for (const Triangle& t : triangles_) {
    const Vector3 q = nearestOfTriangle(t, p);
    if (!((q - p).squaredNorm() >= (best - p).squaredNorm())) best = q;
  }
  return best;
}

}  // namespace haptic::bench
