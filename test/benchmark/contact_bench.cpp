// Contacts: time beside the peers, error against exact arithmetic, hard cases.
//
// Times: medians over repetitions of the mean of a pass over all pairs; each pair keeps its cache, as in a
// world. Ours includes detection, volume, centroid, area vector, normal, area moments and the wrench. For
// instruction counts: `valgrind --tool=callgrind bench_contact --only box`.
#include <sys/resource.h>

#include <atomic>
#include <cstring>
#include <new>
#include <random>

#include "contact_peers.h"
#include "figure.h"
#include "haptic_core/geometry/broad_phase.h"
#include "haptic_core/geometry/gjk.h"
#include "hard_cases.h"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const std::size_t a = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  std::free(p);
}

namespace haptic::bench {
namespace {

struct Pair {
  const ConvexPolyhedron *a, *b;
  Pose X_AB;
  PairCache cache;
  Vector3 interior = Vector3::Zero();
};

class Scenes {
 public:
  Scenes() : box_(makeBox(Vector3(0.1, 0.1, 0.1))) {
    for (int h = 0; h < 16; ++h) {
      std::vector<Vector3> points;
      for (int i = 0; i < 100; ++i) points.push_back(0.05 * direction());
      hulls_.push_back(ConvexPolyhedron::hull(points));
    }
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3 direction() { return Vector3(normal_(random_), normal_(random_), normal_(random_)).normalized(); }
  Matrix3 rotation() {
    return Quaternion(normal_(random_), normal_(random_), normal_(random_), normal_(random_))
        .normalized()
        .toRotationMatrix();
  }

  std::vector<Pair> boxes(double yaw, double depth) {
    std::vector<Pair> pairs;
    const Matrix3 R = Eigen::AngleAxisd(yaw, Vector3::UnitZ()).toRotationMatrix();
    for (int i = 0; i < 8; ++i)
      pairs.push_back(
          {&box_, &box_, Pose(R, Vector3(uniform(-5e-3, 5e-3), uniform(-5e-3, 5e-3), 0.1 - depth)), {}, {}});
    return pairs;
  }

  /// B pushed along a random direction until `depth` beyond first contact with A's lowest support plane.
  Pair at(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double depth) {
    const Vector3 u = direction();
    Pose X(rotation(), Vector3::Zero());
    const double top = u.dot(a.vertices()[a.support(u)]);
    const double bottom = u.dot(X.R * b.vertices()[b.support(-(X.R.transpose() * u))]);
    X.p = (top - bottom - depth) * u;
    return {&a, &b, X, {}, {}};
  }
  std::vector<Pair> hulls(double depth) {
    std::vector<Pair> pairs;
    for (int i = 0; i < 256; ++i) pairs.push_back(at(hulls_[i % 16], hulls_[(i + 1 + i / 16) % 16], depth));
    return pairs;
  }
  std::vector<Pair> deepHulls() {
    std::vector<Pair> pairs;
    for (int i = 0; i < 256; ++i) {
      Pair pair{&hulls_[i % 16], &hulls_[(i + 1 + i / 16) % 16], Pose(rotation(), Vector3::Zero()), {}, {}};
      pair.X_AB.p = uniform(0, 0.5) * 0.1 * direction();
      pairs.push_back(pair);
    }
    return pairs;
  }
  const ConvexPolyhedron& box() const { return box_; }
  const ConvexPolyhedron& hull(int i) const { return hulls_[i % 16]; }

 private:
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  ConvexPolyhedron box_;
  std::vector<ConvexPolyhedron> hulls_;
};

Wrench linearWrench(const ContactVolume& v) {
  const Vector3 force = 1e6 * v.volume * v.normal();
  return {v.X_AP.p.cross(force), force};
}

volatile double sink;

/// Seconds per pair, cycling through all of them. Each group of 8 keeps its own samples; its median is taken,
/// then the groups' mean: an interruption spoils one sample of one group, not a pass over 256 pairs. A scene
/// of one group is repeated `passes` times per sample, against the clock's resolution.
template <class Work>
double timeEach(std::vector<Pair>& pairs, int passes, int repetitions, Work&& work) {
  constexpr std::size_t kGroup = 8;
  const std::size_t groups = (pairs.size() + kGroup - 1) / kGroup;
  const int inner = groups == 1 ? passes : 1;
  std::vector<std::vector<double>> samples(groups);
  for (int r = 0; r < repetitions; ++r)
    for (std::size_t g = 0; g < groups; ++g)
      samples[g].push_back(secondsPerCall(
          [&](int) {
            double sum = 0;
            for (std::size_t i = kGroup * g; i < std::min(kGroup * (g + 1), pairs.size()); ++i)
              sum += work(pairs[i]);
            sink = sum;
          },
          inner, 1));
  double total = 0;
  for (const auto& of_group : samples) total += median(of_group);
  return total / pairs.size();
}

double timePairs(std::vector<Pair>& pairs, int passes) {
  ContactWorkspace workspace;
  for (const Pair& p : pairs) workspace.reserve(*p.a, *p.b);
  ContactVolume out;
  for (Pair& p : pairs) {
    contactVolume(*p.a, *p.b, p.X_AB, p.cache, workspace, out);
    p.interior = out.X_AP.p;
  }
  return timeEach(pairs, passes, 25, [&](Pair& p) {
    contactVolume(*p.a, *p.b, p.X_AB, p.cache, workspace, out);
    return out.status == ContactVolume::Status::kOverlap ? linearWrench(out).force.x() : 0.0;
  });
}

template <class Peer>
double timePeer(std::vector<Pair>& pairs, int passes, Peer&& peer) {
  return timeEach(pairs, passes, 15, peer);
}

void timeBoxes(Scenes& scenes) {
  auto boxes = scenes.boxes(0.3, 1e-3), aligned = scenes.boxes(0, 1e-3), separated = scenes.boxes(0.3, -1e-3);
  const double ours = timePairs(boxes, 200);
  figure("contact.box_ns", 1e9 * ours, "ns");
  figure("contact.box_aligned_ns", 1e9 * timePairs(aligned, 200), "ns");
  figure("contact.separated_box_ns", 1e9 * timePairs(separated, 1000), "ns");
  const double qhull =
      timePeer(boxes, 5, [](const Pair& p) { return qhullDualVolume(*p.a, *p.b, p.X_AB, p.interior); });
  figure("contact.box_qhull_ns", 1e9 * qhull, "ns");
  figure("contact.box_speedup_vs_qhull", qhull / ours, "1");
  figure("contact.libccd_gjk_box_ns",
         1e9 * timePeer(boxes, 20, [](const Pair& p) { return ccdIntersects(*p.a, *p.b, p.X_AB); }), "ns");
  const auto half = [](const ConvexPolyhedron* s) { return s->halfSize(); };
  if (bulletBoxPoints(half(boxes[0].a), half(boxes[0].b), boxes[0].X_AB) >= 0)
    figure("contact.bullet_box_ns",
           1e9 * timePeer(boxes, 50,
                          [&](const Pair& p) { return bulletBoxPoints(half(p.a), half(p.b), p.X_AB); }),
           "ns");
  if (odeBoxPoints(half(boxes[0].a), half(boxes[0].b), boxes[0].X_AB) >= 0)
    figure(
        "contact.ode_box_ns",
        1e9 * timePeer(boxes, 50, [&](const Pair& p) { return odeBoxPoints(half(p.a), half(p.b), p.X_AB); }),
        "ns");
}

void timeHulls(Scenes& scenes) {
  auto shallow = scenes.hulls(3e-3), middle = scenes.hulls(10e-3), deep = scenes.deepHulls(),
       apart = scenes.hulls(-3e-3);
  const double ours = timePairs(shallow, 2);
  figure("contact.hull100_3mm_ns", 1e9 * ours, "ns");
  figure("contact.hull100_10mm_ns", 1e9 * timePairs(middle, 1), "ns");
  figure("contact.hull100_deep_ns", 1e9 * timePairs(deep, 1), "ns");
  figure("contact.separated_hull100_ns", 1e9 * timePairs(apart, 50), "ns");
  std::vector<Pair> overlapping;  // not every hull is reached at 3 mm below its support plane
  ContactWorkspace workspace;
  for (Pair& p : shallow) {
    ContactVolume v;
    workspace.reserve(*p.a, *p.b);
    contactVolume(*p.a, *p.b, p.X_AB, p.cache, workspace, v);
    if (v.status == ContactVolume::Status::kOverlap && overlapping.size() < 32) overlapping.push_back(p);
  }
  const double same = timePairs(overlapping, 10);
  const double qhull =
      timePeer(overlapping, 1, [](const Pair& p) { return qhullDualVolume(*p.a, *p.b, p.X_AB, p.interior); });
  figure("contact.hull100_3mm_overlapping", static_cast<double>(overlapping.size()), "pairs");
  figure("contact.hull100_qhull_ns", 1e9 * qhull, "ns");
  figure("contact.hull100_speedup_vs_qhull", qhull / same, "1");
}

/// Largest (relative error × depth) and normal error over random pairs; bodies `distance` from the origin.
template <class T>
void measureError(Scenes& scenes, int count, double distance, double& worst, double& worst_normal) {
  ContactWorkspace workspace;
  workspace.reserve(scenes.box(), scenes.box());
  workspace.reserve(scenes.hull(0), scenes.hull(1));
  for (int i = 0; i < 16; ++i) workspace.reserve(scenes.hull(i), scenes.box());
  for (int i = 0; i < count; ++i) {
    const double depth = 1e-6 * std::pow(10.0, scenes.uniform(0, 4));
    // Boxes mostly: their exact volumes are cheap.
    Pair pair = i % 16 ? scenes.at(scenes.box(), scenes.box(), depth)
                       : scenes.at(scenes.hull(i), scenes.hull(i / 16), depth);
    Pose X_WA(scenes.rotation(), 0.1 * scenes.direction()), X_WB;
    if (distance > 0) X_WA.p = distance * scenes.direction();
    X_WB = X_WA * pair.X_AB;
    const Pose X_AB = relativePose(X_WA, X_WB);
    ContactVolume v;
    contactVolume(*pair.a, *pair.b, X_AB, pair.cache, workspace, v);
    if (v.status != ContactVolume::Status::kOverlap) continue;
    const auto exact = oracle::PolygonVolume<T>::evaluate(*pair.a, *pair.b, X_WA, X_WB);
    if (exact.volume <= T(0)) continue;
    worst =
        std::max(worst, std::abs(static_cast<double>((T(v.volume) - exact.volume) / exact.volume)) * v.depth);
    if (v.flags) continue;
    Vector3 S;
    for (int k = 0; k < 3; ++k) S[k] = static_cast<double>(exact.area_vector_A[k]);
    worst_normal = std::max(worst_normal, (X_WA.R * v.normal()).cross(S.normalized()).norm());
  }
}

void measureAccuracy(Scenes& scenes) {
  double near = 0, far = 0, normal = 0, far_normal = 0;
  measureError<__float128>(scenes, 10000, 0, near, normal);
  measureError<long double>(scenes, 1000000, 0, near, normal);
  measureError<long double>(scenes, 100000, 10, far, far_normal);
  figure("contact.volume_err_c", near, "m");
  figure("contact.volume_err_c_far", far, "m");
  figure("contact.normal_err_rad_max", normal, "rad");
}

void runHardCases() {
  int count = 0, false_empty = 0, wrong = 0, failed = 0;
  double worst = 0;
  long allocated = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    oracle::HardCases cases(seed);
    cases.each([&](const oracle::HardCase& c) {
      ContactWorkspace workspace;
      workspace.reserve(*c.a, *c.b);
      PairCache cache;
      ContactVolume v;
      const long before = allocations;
      contactVolume(*c.a, *c.b, c.X_AB, cache, workspace, v);
      allocated += allocations - before;
      const oracle::Verdict verdict = oracle::judge(c, v);
      ++count;
      false_empty += verdict.false_empty;
      wrong += verdict.wrong;
      failed += verdict.failed;
      worst = std::max(worst, std::abs(verdict.error) / verdict.allowed);
    });
  }
  figure("contact.hard_cases", count, "1");
  figure("contact.false_empty", false_empty, "1");
  figure("contact.wrong_volume", wrong, "1");
  figure("contact.hard_worst_error", worst, "of allowed");
  figure("contact.failures", failed, "1");
  figure("contact.allocations", static_cast<double>(allocated), "1");
}

void timeBroadPhase(Scenes& scenes) {
  // 1000 cubes in a box that leaves each one or two neighbours, moving a hundredth of their size a step.
  const int count = 1000;
  BroadPhase phase(count, {});
  std::vector<ConvexPolyhedron::Box> boxes(count);
  for (auto& box : boxes) {
    box.lower = Vector3(scenes.uniform(0, 1), scenes.uniform(0, 1), scenes.uniform(0, 1));
    box.upper = box.lower + Vector3::Constant(0.1);
  }
  std::vector<Vector3> moves;
  for (int i = 0; i < count; ++i) moves.push_back(1e-3 * scenes.direction());
  const double seconds = secondsPerCall(
      [&](int step) {
        for (int i = 0; i < count; ++i) {
          const Vector3 move = step % 2 ? moves[i] : Vector3(-moves[i]);
          boxes[i].lower += move;
          boxes[i].upper += move;
        }
        phase.update(boxes.data());
      },
      20, 15);
  figure("contact.broadphase_1000_pairs", phase.pairs().size(), "1");
  figure("contact.broadphase_1000_us", 1e6 * seconds, "us");
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  const bool all = argc < 3 || std::strcmp(argv[1], "--only") != 0;
  const auto wanted = [&](const char* part) { return all || std::strcmp(argv[2], part) == 0; };
  Scenes scenes;
  if (wanted("box")) timeBoxes(scenes);
  if (wanted("hull")) timeHulls(scenes);
  if (wanted("broadphase")) timeBroadPhase(scenes);
  if (wanted("hard")) runHardCases();
  if (wanted("error")) measureAccuracy(scenes);
  return 0;
}
