#include "god_object.h"

#include <algorithm>
#include <cmath>

namespace haptic::bench {
namespace {

/// The proxy stays this far off what stops it [m]: rounding must not carry it through. An error of K times
/// that.
constexpr double kSkin = 1e-9;

}  // namespace

int GodObject::addMesh(const TriangleMesh& mesh, const Pose& X_WM) {
  meshes_.push_back({TriangleTree(mesh), X_WM, X_WM});
  return static_cast<int>(meshes_.size()) - 1;
}

/// Moves the proxy towards the goal, as far as the first obstacle, whose plane is added while there is room.
/// False: it is there.
bool GodObject::meet(const Vector3& goal, bool carried) noexcept {
  TriangleTree::Touch first;
  int touched = -1;
  Vector3 place;
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const Mesh& mesh = meshes_[i];
    const Vector3 from = (carried ? mesh.before : mesh.now).inverse() * proxy_,
                  to = mesh.now.inverse() * goal;
    TriangleTree::Touch touch;
    if (!mesh.tree.firstTouch(from, to, settings_.radius, touch) ||
        (touched >= 0 && touch.share >= first.share))
      continue;
    const double fall = -touch.normal.dot(to - from);  // of the whole way towards the surface [m]
    place = mesh.now * (from + std::max(0.0, touch.share - kSkin / fall) * (to - from));
    touch.normal = mesh.now.R * touch.normal;
    first = touch, touched = static_cast<int>(i);
  }
  if (touched < 0) {
    proxy_ = goal;
    return false;
  }
  proxy_ = place;
  if (count_ < kMost) plane_[count_++] = {first.normal, first.normal.dot(proxy_), 0, touched};
  return true;
}

/// x = h + Σ λ_i n_i on the planes of the bits of `active`. False: a plane would pull, or they are not
/// independent, or it lies behind another.
bool GodObject::solve(const Vector3& h, unsigned active, Vector3& x) noexcept {
  Matrix3 gram = Matrix3::Identity();
  Vector3 depth = Vector3::Zero();
  for (int i = 0; i < count_; ++i) {
    if (!(active >> i & 1)) continue;
    depth[i] = plane_[i].offset - plane_[i].normal.dot(h);
    for (int j = 0; j < count_; ++j) {
      if (active >> j & 1) gram(i, j) = plane_[i].normal.dot(plane_[j].normal);
    }
  }
  const double independent = gram.determinant();
  if (!(std::abs(independent) > 1e-9)) return false;
  const Vector3 multiplier = gram.inverse() * depth;
  x = h;
  for (int i = 0; i < count_; ++i) {
    if (!(active >> i & 1)) continue;
    if (!(multiplier[i] >= 0)) return false;
    x += multiplier[i] * plane_[i].normal;
  }
  for (int i = 0; i < count_; ++i) {
    if (plane_[i].normal.dot(x) < plane_[i].offset - 0.5 * kSkin) return false;
  }
  for (int i = 0; i < count_; ++i) plane_[i].multiplier = active >> i & 1 ? multiplier[i] : 0;
  return true;
}

/// The point nearest to h on the outer side of all planes; where rounding finds none, the proxy stays.
Vector3 GodObject::nearestAllowed(const Vector3& h) noexcept {
  Vector3 x;
  for (unsigned active = 0; active < 1u << count_; ++active) {
    if (solve(h, active, x)) return x;
  }
  return proxy_;
}

/// The goal that friction leaves of one on the planes.
Vector3 GodObject::held(const Vector3& goal) noexcept {
  double depth = 0;
  for (int i = 0; i < count_; ++i) depth += plane_[i].multiplier;
  const Vector3 way = goal - proxy_;
  const double length = way.norm(), most = (sliding_ ? settings_.mu_dynamic : settings_.mu_static) * depth;
  sliding_ = length > most;
  if (!sliding_) return proxy_;
  return goal - settings_.mu_dynamic * depth / length * way;
}

Vector3 GodObject::tick(const Vector3& h) noexcept {
  count_ = 0;
  Vector3 goal = h;
  bool stopped = meet(goal, true);
  for (Mesh& mesh : meshes_) mesh.before = mesh.now;
  if (!stopped) sliding_ = false;
  while (stopped) {
    goal = nearestAllowed(h);
    if (settings_.mu_static > 0) goal = held(goal);
    const bool last = count_ == kMost;
    stopped = meet(goal, false) && !last;
  }
  force_ = settings_.stiffness * (proxy_ - h);
  return force_;
}

Vector3 GodObject::forceOn(int mesh) const noexcept {
  Vector3 sum = Vector3::Zero(), normal = Vector3::Zero();
  for (int i = 0; i < count_; ++i) {
    const Vector3 F = -settings_.stiffness * plane_[i].multiplier * plane_[i].normal;
    normal += F;
    if (plane_[i].mesh == mesh) sum += F;
  }
  if (count_ > 0 && plane_[0].mesh == mesh) sum += -force_ - normal;
  return sum;
}

}  // namespace haptic::bench
