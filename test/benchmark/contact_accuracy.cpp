// Error of the contact volume and its normal against arithmetic beyond double, and the hard cases.
#include <algorithm>
#include <cstdio>
#include <thread>
#include <vector>

#include "allocation_count.h"
#include "contact_figures.h"
#include "contact_fuzz.h"
#include "figure.h"
#include "hard_cases.h"

namespace haptic::bench {
namespace {

/// Largest errors over a sample, each with how many pairs overlapped.
struct Errors {
  double volume = 0;  ///< relative error × depth [m]
  double normal = 0;  ///< [rad]
  long overlapping = 0;
  long false_empty = 0, false_overlap = 0;  ///< pairs that the oracle decides otherwise

  void take(const Errors& other) {
    volume = std::max(volume, other.volume);
    normal = std::max(normal, other.normal);
    overlapping += other.overlapping;
    false_empty += other.false_empty;
    false_overlap += other.false_overlap;
  }
};
Errors random_pairs;  ///< of all samples, for the counts that hold over random pairs and hard cases together

/// Two boxes or two hulls in any orientation, or two boxes face on face, nearly parallel; 1 µm to 1 cm deep.
Pair anyPair(Scenes& scenes, int i) {
  const double depth = 1e-6 * std::pow(10.0, scenes.uniform(0, 4));
  if (i % 16 == 0) return scenes.interlocked(scenes.hull(i / 16), scenes.hull(i / 256 + 1), depth);
  if (i % 4 == 1) {
    const double tilt = std::pow(10.0, scenes.uniform(-12, -2));
    const Matrix3 R = (Eigen::AngleAxisd(tilt, scenes.direction()) *
                       Eigen::AngleAxisd(scenes.uniform(-3.2, 3.2), Vector3::UnitZ()))
                          .toRotationMatrix();
    const Vector3 p(scenes.uniform(-0.08, 0.08), scenes.uniform(-0.08, 0.08), 0.1 - depth);
    return {&scenes.box(), &scenes.box(), Pose(R, p), {}, {}};
  }
  return scenes.interlocked(scenes.box(), scenes.box(), depth);
}

/// Over `count` pairs that overlap.
template <class T>
Errors measure(unsigned seed, int count, double distance) {
  Scenes scenes(seed);
  ContactWorkspace workspace;
  workspace.reserve(scenes.box(), scenes.box());
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 16; ++j) workspace.reserve(scenes.hull(i), scenes.hull(j));
  Errors errors;
  for (int i = 0; errors.overlapping < count; ++i) {
    Pair pair = anyPair(scenes, i);
    const Pose X_WA(scenes.rotation(), (distance > 0 ? distance : 0.1) * scenes.direction());
    const Pose X_WB = X_WA * pair.X_AB;
    ContactVolume v;
    contactVolume(*pair.a, *pair.b, relativePose(X_WA, X_WB), pair.cache, workspace, v);
    const bool overlap = v.status == ContactVolume::Status::kOverlap;
    const auto exact = oracle::PolygonVolume<T>::evaluate(*pair.a, *pair.b, X_WA, X_WB);
    errors.false_empty += !overlap && exact.volume > T(0);
    errors.false_overlap += overlap && exact.volume <= T(0);
    if (!overlap || exact.volume <= T(0)) continue;
    ++errors.overlapping;
    const double relative = static_cast<double>((T(v.volume) - exact.volume) / exact.volume);
    errors.volume = std::max(errors.volume, std::abs(relative) * v.depth);
    if (v.flags & ContactVolume::kNormalFromHistory) continue;
    Vector3 S;
    for (int k = 0; k < 3; ++k) S[k] = static_cast<double>(exact.area_vector_A[k]);
    errors.normal = std::max(errors.normal, (X_WA.R * v.normal()).cross(S.normalized()).norm());
  }
  return errors;
}

/// The same number of overlapping pairs on every core.
template <class T>
Errors measureOnAllCores(int count, double distance) {
  const int workers = std::max(1u, std::thread::hardware_concurrency());
  std::vector<Errors> results(workers);
  std::vector<std::thread> threads;
  for (int w = 0; w < workers; ++w)
    threads.emplace_back(
        [&, w] { results[w] = measure<T>(100 + w, (count + workers - 1) / workers, distance); });
  for (std::thread& t : threads) t.join();
  for (int w = 1; w < workers; ++w) results[0].take(results[w]);
  return results[0];
}

}  // namespace

void measureAccuracy() {
  for (const double distance : {0.0, 10.0}) {
    const std::string suffix = distance > 0 ? "_far" : "";
    const Errors exact = measureOnAllCores<__float128>(10000, distance);
    std::printf("113 bits, bodies %g m away: %ld overlapping pairs, c %.3g m, normal %.3g rad\n", distance,
                exact.overlapping, exact.volume, exact.normal);
    Errors all = measureOnAllCores<long double>(1000000, distance);
    std::printf("64 bits, bodies %g m away: %ld overlapping pairs, c %.3g m, normal %.3g rad\n", distance,
                all.overlapping, all.volume, all.normal);
    all.take(exact);
    random_pairs.take(all);
    figure("contact.volume_err_c" + suffix, all.volume, "m");
    if (distance == 0) figure("contact.normal_err_rad_max", all.normal, "rad");
  }
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
      const long before = allocationCount();
      contactVolume(*c.a, *c.b, c.X_AB, cache, workspace, v);
      allocated += allocationCount() - before;
      const oracle::Verdict verdict = oracle::judge(c, v);
      ++count;
      false_empty += verdict.false_empty;
      wrong += verdict.wrong;
      failed += verdict.failed;
      worst = std::max(worst, std::abs(verdict.error) / verdict.allowed);
    });
  }
  figure("contact.hard_cases", count, "1");
  figure("contact.false_empty", static_cast<double>(false_empty + random_pairs.false_empty), "1");
  figure("contact.false_empty_random", static_cast<double>(random_pairs.false_empty), "1");
  figure("contact.wrong_volume", static_cast<double>(wrong + random_pairs.false_overlap), "1");
  figure("contact.hard_worst_error", worst, "of allowed");
  figure("contact.failures", failed, "1");
  figure("contact.allocations", static_cast<double>(allocated), "1");
}

void runFuzz() {
  constexpr int kExecutions = 500000;  // per core; the coverage-guided run is the test `contact_fuzz`
  const int workers = std::max(1u, std::thread::hardware_concurrency());
  std::vector<long> violations(workers, 0);
  std::vector<std::thread> threads;
  for (int w = 0; w < workers; ++w)
    threads.emplace_back([&, w] {
      std::mt19937 random(w + 1);
      std::uint8_t bytes[40];
      for (int i = 0; i < kExecutions; ++i) {
        for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 24);
        violations[w] += fuzz::contactViolation(bytes, sizeof bytes) != nullptr;
      }
    });
  for (std::thread& t : threads) t.join();
  long found = 0;
  for (long v : violations) found += v;
  figure("contact.fuzz_execs", static_cast<double>(kExecutions) * workers, "1");
  figure("contact.fuzz_violations", static_cast<double>(found), "1");
}

}  // namespace haptic::bench
