// Contacts: time beside the peers, error against exact arithmetic, hard cases.
//
// Times: medians over repetitions of the mean of a pass over all pairs; each pair keeps its cache, as in a
// world. Ours includes detection, volume, centroid, area vector, normal, area moments and the wrench.
// Callgrind's instruction counts of the same cases stand beside the times.
#include <cstring>

#include "ccd_oracle.h"
#include "contact_figures.h"
#include "contact_peers.h"
#include "dual_volume.h"
#include "figure.h"
#include "haptic_core/geometry/search/broad_phase.h"
#include "haptic_core/geometry/search/gjk.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "instruction_count.h"

namespace haptic::bench {
namespace {

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

/// What a step does with a pair: detection, contact volume with all its moments, and the wrench.
double contactAndWrench(Pair& p, ContactWorkspace& workspace) {
  static ContactVolume out;
  contactVolume(*p.a, *p.b, p.X_AB, p.cache, workspace, out);
  if (out.status != ContactVolume::Status::kOverlap) return 0;
  const Wrench F = linearWrench(out);
  return F.force.sum() + F.torque.sum();
}

double timePairs(std::vector<Pair>& pairs, int passes) {
  ContactWorkspace workspace;
  for (const Pair& p : pairs) workspace.reserve(*p.a, *p.b);
  ContactVolume out;
  for (Pair& p : pairs) {
    contactVolume(*p.a, *p.b, p.X_AB, p.cache, workspace, out);
    p.interior = out.X_AP.p;
  }
  return timeEach(pairs, passes, 25, [&](Pair& p) { return contactAndWrench(p, workspace); });
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
  const double qhull = timePeer(
      boxes, 5, [](const Pair& p) { return oracle::qhullDualVolume(*p.a, *p.b, p.X_AB, p.interior); });
  figure("contact.box_qhull_ns", 1e9 * qhull, "ns");
  figure("contact.box_speedup_vs_qhull", qhull / ours, "1");
  figure("contact.libccd_gjk_box_ns",
         1e9 * timePeer(boxes, 20, [](const Pair& p) { return oracle::ccdIntersects(*p.a, *p.b, p.X_AB); }), "ns");
  const auto half = [](const ConvexPolyhedron* s) { return s->halfSize(); };
  const BulletBoxes bullet(half(boxes[0].a), half(boxes[0].b));  // all pairs are of equal boxes
  if (bullet.points(boxes[0].X_AB) >= 0) {
    figure("contact.bullet_box_ns", 1e9 * timePeer(boxes, 50, [&](const Pair& p) { return bullet.points(p.X_AB); }), "ns");
  }
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
  const double qhull = timePeer(
      overlapping, 1, [](const Pair& p) { return oracle::qhullDualVolume(*p.a, *p.b, p.X_AB, p.interior); });
  figure("contact.hull100_3mm_overlapping", static_cast<double>(overlapping.size()), "pairs");
  figure("contact.hull100_qhull_ns", 1e9 * qhull, "ns");
  figure("contact.hull100_speedup_vs_qhull", qhull / same, "1");
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

/// Pairs of the case that `--count` names; its instructions go beside its time.
std::vector<Pair> pairsOf(Scenes& scenes, const std::string& name) {
  if (name == "box") return scenes.boxes(0.3, 1e-3);
  if (name == "box_aligned") return scenes.boxes(0, 1e-3);
  if (name == "separated_box") return scenes.boxes(0.3, -1e-3);
  if (name == "hull100_3mm") return scenes.hulls(3e-3);
  if (name == "hull100_10mm") return scenes.hulls(10e-3);
  if (name == "hull100_deep") return scenes.deepHulls();
  return scenes.hulls(-3e-3);  // separated_hull100
}

constexpr const char* kCases[] = {"box",          "box_aligned",  "separated_box",    "hull100_3mm",
                                  "hull100_10mm", "hull100_deep", "separated_hull100"};

/// One pass over the pairs of a case, with warm caches, where callgrind counts.
void countPass(const std::string& name) {
  Scenes scenes(1);
  std::vector<Pair> pairs = pairsOf(scenes, name);
  ContactWorkspace workspace;
  for (const Pair& p : pairs) workspace.reserve(*p.a, *p.b);
  const auto pass = [&] {
    for (Pair& p : pairs) sink = contactAndWrench(p, workspace);
  };
  pass();
  countedPass(pass);
}

void countInstructions() {
  for (const char* name : kCases) {
    Scenes scenes(1);
    const double count = instructionsOf(std::string("--count ") + name);
    instructionFigure(std::string("contact.") + name + "_instructions", count / pairsOf(scenes, name).size());
  }
}

}  // namespace
}  // namespace haptic::bench

int main(int argc, char** argv) {
  using namespace haptic::bench;
  if (argc == 3 && std::strcmp(argv[1], "--count") == 0) {
    countPass(argv[2]);
    return 0;
  }
  const bool all = argc < 3 || std::strcmp(argv[1], "--only") != 0;
  const auto wanted = [&](const char* part) { return all || std::strcmp(argv[2], part) == 0; };
  Scenes scenes(1);
  if (wanted("box")) timeBoxes(scenes);
  if (wanted("hull")) timeHulls(scenes);
  if (wanted("instructions")) countInstructions();
  if (wanted("broadphase")) timeBroadPhase(scenes);
  if (wanted("error")) measureAccuracy();
  if (wanted("hard")) runHardCases();  // its counts are those of both
  if (wanted("fuzz")) runFuzz();
  return 0;
}
