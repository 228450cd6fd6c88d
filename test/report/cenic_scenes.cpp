// CENIC's scenes for the bench: accuracy is a setting, the reference the same world at a tiny step.
#include "cenic_scenes.h"

#include "../scenes/cenic.h"
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "own_measures.h"

namespace haptic::report {
namespace {

using scenes::Clutter;
using scenes::SteelRods;
using scenes::TippeTop;
using scenes::TurningGripper;

/// Deepest overlap of any two bodies by our contact volume, for every simulator [m]. `def`: bodies that are all in the samples.
class DeepestOverlap {
 public:
  explicit DeepestOverlap(const WorldDef& def) {
    for (const ArticulationDef& body : def.articulations) {
      shapes_.push_back(body.links[0].collisions[0].shape);
      if (body.links[0].joint.type == JointType::kFixed) ++fixed_;
    }
    for (const auto& a : shapes_) {
      for (const auto& b : shapes_) workspace_.reserve(*a, *b);
    }
  }
  double operator()(const Sample& sample) {
    double most = 0;
    for (std::size_t b = fixed_; b < shapes_.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const Pose X_AB = sample.bodies[a].X_WL.inverse() * sample.bodies[b].X_WL;
        PairCache cache;
        ContactVolume volume;
        contactVolume(*shapes_[a], *shapes_[b], X_AB, cache, workspace_, volume);
        most = std::max(most, volume.depth);
      }
    }
    return most;
  }

 private:
  std::vector<std::shared_ptr<const ConvexShape>> shapes_;
  std::size_t fixed_ = 0;  // first, in these scenes
  ContactWorkspace workspace_;
};

template <class Make>
CenicScene scene(const std::string& name, double k, double seconds, int links, Make make) {
  CenicScene c;
  Scene& s = c.scene;
  s.name = "cenic_" + name;
  s.benchmark = "Kurtz, Castro and others, CENIC, arXiv 2511.08771: error over wall time for a range of accuracies.";
  s.seconds = seconds;
  s.stiffness = k;
  for (int i = 0; i < links; ++i) s.bodies.push_back(i);
  s.make = [make, k](const Choice& choice) { return make(settingsOf(choice), choice.stiffness > 0 ? choice.stiffness : k); };
  return c;
}

CenicScene clutter(const std::string& name, double k) {
  CenicScene c = scene("clutter_" + name, k, 1, Clutter::kWalls + Clutter::kBodies, Clutter::make);
  c.scene.chaotic = true;
  c.scene.samples = 50;
  // A peer has no such k: it is as stiff as its settings are.
  if (name == "soft") c.scene.not_for_peers = "peers are not told how soft surfaces are";
  const auto overlap = std::make_shared<DeepestOverlap>(Clutter::make({}, k));
  c.scene.measures = {worst("overlap", [overlap](const Sample& sample) { return (*overlap)(sample); }), energyGain()};
  return c;
}

CenicScene top() {
  CenicScene c = scene("top", 1e10, 1, 2, TippeTop::make);
  c.scene.bodies = {1};
  c.mark = TippeTop::kRadius * Vector3::UnitZ();
  c.scene.measures = {{"jellett", [](const std::vector<Sample>& samples) {
                         const auto of = [](const Sample& s) {
                           const Pose& X = s.bodies[0].X_WL;
                           return TippeTop::jellett(s.angular_momentum - X.p.cross(s.momentum), X.R.col(2));
                         };
                         double most = 0;
                         for (const Sample& s : samples) most = std::max(most, std::abs(of(s) / of(samples[0]) - 1));
                         return most;
                       }},
                      {"turned_over", [](const std::vector<Sample>& samples) {
                         double most = 0;
                         for (const Sample& s : samples) most = std::max(most, std::acos(s.bodies[0].X_WL.R(2, 2)));
                         return most;
                       }}};
  return c;
}

CenicScene gripper() {
  CenicScene c = scene("gripper", 1e10, TurningGripper::kSeconds, 0, TurningGripper::make);
  c.scene.bodies = {TurningGripper::kBody};
  c.mark = TurningGripper::kRadius * Vector3::UnitX();
  c.scene.measures = {{"turn_off_rigid", [](const std::vector<Sample>& samples) {
                         double most = 0;
                         for (const Sample& s : samples) {
                           const Matrix3& R = s.bodies[0].X_WL.R;
                           const double turn = std::atan2(-R(2, 0), R(0, 0)), rigid = TurningGripper::way(s.time) / TurningGripper::kRadius;
                           most = std::max(most, std::abs(std::remainder(turn - rigid, 2 * M_PI)));
                         }
                         return most;
                       }}};
  return c;
}

CenicScene rods() {
  CenicScene c = scene("rods", 1e10, 0.3, 0, SteelRods::make);
  c.scene.bodies = {1, 2, 3};
  c.mark = 0.5 * SteelRods::kLength * Vector3::UnitZ();
  c.scene.measures = {energyGain()};
  return c;
}

}  // namespace

std::vector<CenicScene> cenicScenes() { return {clutter("soft", 1e7), clutter("stiff", 1e10), top(), gripper(), rods()}; }

}  // namespace haptic::report
