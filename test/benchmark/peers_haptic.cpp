// Our hand beside the god object of the literature (god_object.h), on the same meshes with the same spring:
// force against closed forms, time of a tick, and where each lets its tool through what is solid.
//
// What favours whom by construction. Theirs: one point or ball without mass, turn or torque; its force is a
// formula, so it is exact where the search is; nothing but the tool is computed. Ours: a body of 50 g on a
// spring and a damper, in a world that may hold others; it feels torques, may have any shape, and pays for
// that. All tools here are balls, all obstacles convex, fixed or led, so that both can run; a god object
// could take any mesh of triangles, ours takes convex pieces.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "../scenes/touch.h"
#include "figure.h"
#include "god_object.h"
#include "haptic_core/base/cpu_time.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/world/led_motion.h"
#include "instruction_count.h"
#include "peers_figures.h"

namespace haptic::bench {
namespace {

constexpr double kStep = 1e-3, kK = 1000, kRadius = 0.005;  // [s], [N/m], [m]
constexpr double kDamper = 2,
                 kMass = 0.05;  // of our coupling [N·s/m] and tool [kg]; the god object has neither
constexpr double kInertia =
    1e-4;  // [kg·m²]: a tool with a handle, so that its coupling keeps it from rolling
constexpr double kFoundation = 1e13;  // of our surfaces [N/m³]: 5 N sink a ball of 5 mm by 6 um
constexpr double kMostForce = 20;     // that our hand bears in direct coupling [N]

struct Obstacle {
  std::shared_ptr<const ConvexPolyhedron> shape;
  std::function<Pose(double)> place;  ///< at a time [s]
  bool moves = false;
};

/// What a hand does, and the force that it should feel of a rigid world: by a spring `K` and a damper `b`,
/// [N].
struct Trial {
  std::string name;
  std::vector<Obstacle> obstacles;
  double seconds = 1, mu = 0;
  std::function<Vector3(double)> hand = {};
  std::function<Vector3(double t, double b)> force = {};
  /// All of the tool is inside of something, or its centre on the other side of a plate: ours sinks in, by
  /// its radius at most.
  std::function<bool(const Vector3& tool, double t)> lost = {};
};

Obstacle fixedBox(const Vector3& size, const Pose& X) {
  return {scenes::box(size), [X](double) { return X; }};
}

double smooth(double x) {
  return 0.5 - 0.5 * std::cos(M_PI * std::clamp(x, 0.0, 1.0));
}

/// One renderer under its name.
class Renderer {
 public:
  virtual ~Renderer() = default;
  virtual Vector3 tick(double t) = 0;  ///< force on the hand at the end of the tick that ends at t [N]
  virtual Vector3 tool() const = 0;    ///< its centre [m]
};

class God : public Renderer {
 public:
  God(const Trial& trial, double radius)
      : trial_(trial), god_({kK, radius, trial.mu, trial.mu}, trial.hand(0)) {
    for (const Obstacle& o : trial.obstacles) god_.addMesh(o.shape->triangles(), o.place(0));
  }
  Vector3 tick(double t) override {
    for (std::size_t i = 0; i < trial_.obstacles.size(); ++i) {
      if (trial_.obstacles[i].moves) god_.moveMesh(static_cast<int>(i), trial_.obstacles[i].place(t));
    }
    return god_.tick(trial_.hand(t));
  }
  Vector3 tool() const override { return god_.proxy(); }

 private:
  const Trial& trial_;
  GodObject god_;
};

class Ours : public Renderer {
 public:
  Ours(const Trial& trial, PointerCoupling::Mode mode) : trial_(trial), world_(definition(trial, mode)) {
    if (mode != PointerCoupling::Mode::kDirect) return;
    bound_.stiffness = kK, bound_.force = kMostForce;
  }
  Vector3 tick(double t) override {
    int motion = 0;
    for (const Obstacle& o : trial_.obstacles) {
      if (!o.moves) continue;
      const Pose X = o.place(t);
      world_.leadBody(motion++, {X.p, Quaternion(X.R), rateOf(o, t)}, kStep);
    }
    const Vector3 now = trial_.hand(t);
    world_.setPointerBound(0, bound_);
    world_.setPointerTarget(0, Pose(now), {Vector3::Zero(), (now - trial_.hand(t - kStep)) / kStep});
    world_.step();
    return world_.pointerWrench(0).force;
  }
  Vector3 tool() const override { return world_.linkPose(world_.pointerLink(0)).p; }

 private:
  static Twist rateOf(const Obstacle& o, double t) {
    const Pose before = o.place(t - 0.5 * kStep), after = o.place(t + 0.5 * kStep);
    return {vectorFromRotation(Quaternion(Matrix3(after.R * before.R.transpose()))) / kStep,
            (after.p - before.p) / kStep};
  }
  static WorldDef definition(const Trial& trial, PointerCoupling::Mode mode) {
    WorldDef def;
    def.name = trial.name;
    def.settings.step = kStep;
    def.settings.gravity = Vector3::Zero();
    def.settings.history_steps = 0;
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = kFoundation;
    m.mu_static = m.mu_dynamic = trial.mu;
    for (std::size_t i = 0; i < trial.obstacles.size(); ++i) {
      const Obstacle& o = trial.obstacles[i];
      ArticulationDef body = scenes::freeBody("obstacle" + std::to_string(i), o.shape, 1,
                                              1e-3 * Matrix3::Identity(), o.place(0));
      if (!o.moves) body.links[0].joint.type = JointType::kFixed;
      if (o.moves) {
        MotionDef motion;
        motion.name = body.name;
        motion.articulation = static_cast<int>(i), motion.link = 0;
        def.motions.push_back(motion);
      }
      def.articulations.push_back(body);
    }
    def.articulations.push_back(scenes::freeBody("tool", std::make_shared<Ball>(kRadius), kMass,
                                                 kInertia * Matrix3::Identity(), Pose(trial.hand(0))));
    scenes::addPointer(def, static_cast<int>(def.articulations.size()) - 1);
    PointerCoupling& coupling = def.pointers[0].coupling;
    coupling.mode = mode;
    coupling.stiffness = kK, coupling.damping = kDamper;
    return def;
  }

  const Trial& trial_;
  World world_;
  PointerBound bound_;
};

struct Rival {
  std::string name;
  double damper;  ///< of its coupling [N·s/m]
  std::function<std::unique_ptr<Renderer>(const Trial&)> make;
};

std::vector<Rival> rivals() {
  using Mode = PointerCoupling::Mode;
  return {{"god", 0, [](const Trial& t) { return std::make_unique<God>(t, kRadius); }},
          {"god_point", 0, [](const Trial& t) { return std::make_unique<God>(t, 0); }},
          {"ours", kDamper, [](const Trial& t) { return std::make_unique<Ours>(t, Mode::kVirtual); }},
          {"ours_direct", 0, [](const Trial& t) { return std::make_unique<Ours>(t, Mode::kDirect); }}};
}

/// Of a frictionless tool on a convex obstacle at rest: the point nearest to the hand of those a radius away,
/// and the damper along the normal.
std::function<Vector3(double, double)> nearestForce(const Obstacle& o,
                                                    const std::function<Vector3(double)>& hand) {
  const auto tree = std::make_shared<TriangleTree>(o.shape->triangles());
  const Pose X = o.place(0);
  return [tree, X, hand](double t, double b) -> Vector3 {
    const auto way = [&](double at) -> Vector3 {
      const Vector3 h = X.inverse() * hand(at), away = h - tree->nearestPoint(h);
      return X.R * (std::max(0.0, kRadius - away.norm()) * away.normalized());
    };
    const Vector3 now = way(t);
    if (now.norm() == 0) return now;
    return (kK + b * (now.norm() - way(t - kStep).norm()) / kStep / now.norm()) * now;
  };
}

/// Quasi-static ways, by at most 10 mm/s, each with the exact force.
std::vector<Trial> forceTrials() {
  std::vector<Trial> trials;
  const Obstacle slab =
      fixedBox({0.2, 0.2, 0.1}, Pose(Vector3(-0.1, 0, -0.05)));  // its edge is the line x = z = 0
  const auto add = [&](const std::string& name, const Obstacle& o, double seconds,
                       const std::function<Vector3(double)>& hand) {
    trials.push_back({name, {o}, seconds, 0, hand, nearestForce(o, hand)});
  };
  add("plane", slab, 4, [](double t) {
    return Vector3(-0.05, 0, kRadius + 1e-3 - 5e-3 * smooth(t / 2) * (t < 2 ? 1 : smooth((4 - t) / 2)));
  });
  add("edge", slab, 10, [](double t) {
    return Vector3(-0.015 + 0.03 * smooth((t - 3) / 7), 0, kRadius + 1e-3 - 4e-3 * smooth(t / 3));
  });
  const Obstacle ball{std::make_shared<ConvexPolyhedron>(makeSphere(0.05, 3)), [](double) { return Pose(); }};
  add("sphere", ball, 13, [](double t) {
    const double a = 0.3 + smooth((t - 3) / 10), out = 0.05 + kRadius + 1e-3 - 4e-3 * smooth(t / 3);
    return Vector3(out * Vector3(std::sin(a), 0.3 * std::sin(2 * a), std::cos(a)).normalized());
  });
  // Down on a slope that falls along +x: it stays at 0.9 of the limit, and slides at 1.5 times it.
  for (const bool slides : {false, true}) {
    const double mu = 0.5, angle = std::atan(slides ? 0.75 : 0.45), deep = 8e-3, seconds = 3;
    const Matrix3 R = rotationAbout(Vector3::UnitY(), angle);
    const double height = kRadius / std::cos(angle) + 1e-3;
    Trial t{slides ? "slope_slide" : "slope_stick",
            {fixedBox({0.4, 0.4, 0.1}, Pose(R, -0.05 * R.col(2)))},
            seconds,
            mu};
    t.hand = [=](double at) { return Vector3(0, 0, height - (deep + 1e-3) * smooth(at / seconds)); };
    t.force = [=](double at, double b) -> Vector3 {
      const auto depth = [=](double when) {
        return std::max(0.0, (deep + 1e-3) * smooth(when / seconds) - 1e-3);
      };
      if (depth(at) == 0) return Vector3::Zero();
      const double pressed = kK * depth(at) + b * (depth(at) - depth(at - kStep)) / kStep;
      if (!slides) return pressed * Vector3::UnitZ();
      return pressed * std::cos(angle) * (R.col(2) - mu * R.col(0));
    };
    trials.push_back(t);
  }
  // Into grooves of two walls, from the middle: at right angles, and 60 degrees apart.
  for (const double half : {M_PI / 4, M_PI / 6}) {
    Trial t{half > 0.7 ? "corner" : "groove", {}, 3};
    for (const int side : {-1, 1}) {
      const Matrix3 R = rotationAbout(Vector3::UnitY(), side * half);
      t.obstacles.push_back(fixedBox({0.2, 0.2, 0.2}, Pose(R, R * Vector3(side * 0.1, 0, 0.1))));
    }
    const double bottom = kRadius / std::sin(half);
    t.hand = [=](double at) { return Vector3(0, 0, bottom + 1e-3 - 7e-3 * smooth(at / 3)); };
    t.force = [=](double at, double b) -> Vector3 {
      const auto depth = [=](double when) { return std::max(0.0, 7e-3 * smooth(when / 3) - 1e-3); };
      return (depth(at) > 0) * (kK * depth(at) + b * (depth(at) - depth(at - kStep)) / kStep) *
             Vector3::UnitZ();
    };
    trials.push_back(t);
  }
  return trials;
}

/// Deep, fast, thin, and moving: everything has a place outside of all that is solid in every tick.
std::vector<Trial> holdingTrials() {
  std::vector<Trial> trials;
  const auto down = [](double from, double to, double speed) {
    return [=](double t) { return Vector3(0, 0, std::max(to, from - speed * t)); };
  };
  const auto below = [](double z) { return [=](const Vector3& tool, double) { return tool.z() < z; }; };
  trials.push_back({"plate of 1 mm, 30 mm deep",
                    {fixedBox({0.2, 0.2, 1e-3}, Pose(Vector3(0, 0, -5e-4)))},
                    2,
                    0,
                    down(0.02, -0.03, 0.05),
                    {},
                    below(-5e-4)});
  trials.push_back({"plate of 0.1 mm at 5 m/s",
                    {fixedBox({0.2, 0.2, 1e-4}, Pose(Vector3(0, 0, -5e-5)))},
                    0.5,
                    0,
                    down(0.2, -0.03, 5),
                    {},
                    below(-5e-5)});
  // Along a floor into a wall, 10 mm behind both.
  trials.push_back(
      {"concave edge at 0.5 m/s",
       {fixedBox({0.4, 0.2, 0.05}, Pose(Vector3(0, 0, -0.025))),
        fixedBox({0.05, 0.2, 0.2}, Pose(Vector3(0.125, 0, 0.1)))},
       1,
       0,
       [](double t) { return Vector3(std::min(0.11, 0.5 * t - 0.1), 0, std::max(-0.01, 0.02 - 0.2 * t)); },
       {},
       [](const Vector3& tool, double) { return tool.z() < -kRadius || tool.x() > 0.1 + kRadius; }});
  // Round a ball of triangles at half of its radius, twice, over all its edges.
  trials.push_back(
      {"round a ball, 20 mm deep, 0.5 m/s",
       {{std::make_shared<ConvexPolyhedron>(makeSphere(0.05, 3)), [](double) { return Pose(); }}},
       2,
       0,
       [](double t) {
         const double a = 6.28 * std::max(0.0, t - 0.2), out = std::max(0.03, 0.07 - 0.2 * t);
         return Vector3(out * Vector3(std::sin(a), 0.3 * std::sin(2.3 * a), std::cos(a)).normalized());
       },
       {},
       [](const Vector3& tool, double) { return tool.norm() < 0.0495 - kRadius; }});
  // A plate sweeps over a hand at rest.
  for (const double speed : {0.2, 5.0}) {
    Trial t{speed > 1 ? "plate sweeps at 5 m/s" : "plate sweeps at 0.2 m/s", {}, 0.06 / speed + 0.02};
    const Matrix3 R = rotationAbout(Vector3::UnitY(), M_PI / 2);
    t.obstacles = {{scenes::box({0.2, 0.2, 1e-3}),
                    [=](double at) { return Pose(R, Vector3(std::min(0.03, speed * at - 0.03), 0, 0)); },
                    true}};
    t.hand = [](double) { return Vector3::Zero(); };
    t.lost = [=](const Vector3& tool, double at) { return tool.x() < std::min(0.03, speed * at - 0.03); };
    trials.push_back(t);
  }
  // A lid on a hinge closes over a tool that is pressed on a floor, from 60 to 20 degrees: it is driven out
  // along the floor.
  Trial lid{"lid closes on a floor", {fixedBox({0.6, 0.2, 0.05}, Pose(Vector3(0, 0, -0.025)))}, 1.2};
  const auto angle = [](double t) { return (60 - 40 * std::clamp(t - 0.2, 0.0, 1.0)) * M_PI / 180; };
  lid.obstacles.push_back(
      {scenes::box({0.2, 0.2, 0.01}),
       [=](double t) {
         const Matrix3 R = rotationAbout(Vector3::UnitY(), -angle(t));
         return Pose(R, R * Vector3(0.1, 0, 0.005));  // its lower face passes the hinge at the origin
       },
       true});
  lid.hand = [](double t) { return Vector3(0.012, 0, std::max(-0.012, 6e-3 - 0.1 * t)); };
  lid.lost = [=](const Vector3& tool, double t) {
    return tool.z() < -kRadius || Vector3(-std::sin(angle(t)), 0, std::cos(angle(t))).dot(tool) > kRadius;
  };
  trials.push_back(lid);
  // A wall that leans over the tool drives it along the floor.
  Trial plough{
      "leaning wall drives it along a floor", {fixedBox({1, 0.2, 0.05}, Pose(Vector3(0, 0, -0.025)))}, 1};
  const Matrix3 R = rotationAbout(Vector3::UnitY(), -M_PI / 3);
  const auto foot = [](double t) { return -0.03 + 0.1 * t; };
  plough.obstacles.push_back(
      {scenes::box({0.2, 0.2, 0.01}),
       [=](double t) { return Pose(R, R * Vector3(0.1, 0, 0.005) + foot(t) * Vector3::UnitX()); }, true});
  plough.hand = [](double t) { return Vector3(0, 0, std::max(-0.012, 6e-3 - 0.1 * t)); };
  plough.lost = [=](const Vector3& tool, double t) {
    return tool.z() < -kRadius ||
           Vector3(-std::sin(M_PI / 3), 0, std::cos(M_PI / 3)).dot(tool - foot(t) * Vector3::UnitX()) >
               kRadius;
  };
  trials.push_back(plough);
  return trials;
}

int ticksOf(const Trial& trial) {
  return static_cast<int>(std::lround(trial.seconds / kStep));
}

/// Largest error of the force, over the largest force of the trial [1]. A point has no radius: its force is
/// not that of the references.
double worstForceError(const Trial& trial, const Rival& rival) {
  const auto renderer = rival.make(trial);
  double worst = 0, most = 0;
  for (int i = 1; i <= ticksOf(trial); ++i) {
    const double t = i * kStep;
    const Vector3 F = renderer->tick(t), exact = trial.force(t, rival.damper);
    worst = std::max(worst, (F - exact).norm()), most = std::max(most, exact.norm());
  }
  return worst / most;
}

/// Median and worst CPU time of a tick [s]: of five runs by turns, the median over runs.
void timeTicks(const Trial& trial, const std::vector<Rival>& all) {
  constexpr int kRuns = 5;
  std::vector<std::vector<double>> middle(all.size()), worst(all.size());
  for (int run = 0; run < kRuns; ++run) {
    for (std::size_t r = 0; r < all.size(); ++r) {
      const auto renderer = all[r].make(trial);
      std::vector<double> us;
      for (int i = 1; i <= ticksOf(trial); ++i) {
        const double before = cpuSeconds();
        renderer->tick(i * kStep);
        us.push_back(1e6 * (cpuSeconds() - before));
      }
      us.erase(us.begin());  // fills caches
      middle[r].push_back(median(us)), worst[r].push_back(*std::max_element(us.begin(), us.end()));
    }
  }
  for (std::size_t r = 0; r < all.size(); ++r) {
    figure(all[r].name + "." + trial.name + ".tick_us", median(middle[r]), "us");
    figure(all[r].name + "." + trial.name + ".tick_us_worst", median(worst[r]), "us");
    if (trial.name != "edge") continue;  // minutes each under callgrind
    const double count = instructionsOf("count " + all[r].name + " " + trial.name);
    instructionFigure(all[r].name + "." + trial.name + ".tick_instructions", count / ticksOf(trial));
  }
}

}  // namespace

void countHapticTicks(const std::string& name, const std::string& trial_name) {
  for (const Trial& trial : forceTrials()) {
    for (const Rival& rival : rivals()) {
      if (trial.name != trial_name || rival.name != name) continue;
      const auto renderer = rival.make(trial);
      countedPass([&] {
        for (int i = 1; i <= ticksOf(trial); ++i) renderer->tick(i * kStep);
      });
    }
  }
}

void measureHaptic() {
  const std::vector<Rival> all = rivals();
  for (const Rival& rival : all) {
    if (rival.name == "god_point") continue;
    double worst = 0;
    for (const Trial& trial : forceTrials()) {
      const double error = worstForceError(trial, rival);
      std::printf("peers haptic %-12s %-12s force errs by %.3g %% of its largest\n", rival.name.c_str(),
                  trial.name.c_str(), 100 * error);
      worst = std::max(worst, error);
    }
    figure(rival.name + ".force_err_pct_max", 100 * worst, "%");
  }
  // No way of these reaches the surface itself: a point would be timed in the air.
  std::vector<Rival> touching = all;
  touching.erase(
      std::remove_if(touching.begin(), touching.end(), [](const Rival& r) { return r.name == "god_point"; }),
      touching.end());
  for (const Trial& trial : forceTrials()) {
    if (trial.name == "edge" || trial.name == "sphere" || trial.name == "corner") timeTicks(trial, touching);
  }
  const std::vector<Trial> holding = holdingTrials();
  for (const Rival& rival : all) {
    int lost = 0;
    for (const Trial& trial : holding) {
      const auto renderer = rival.make(trial);
      int through = 0;
      for (int i = 1; i <= ticksOf(trial); ++i) {
        renderer->tick(i * kStep);
        if (through == 0 && trial.lost(renderer->tool(), i * kStep)) through = i;
      }
      if (through > 0)
        std::printf("peers haptic %-12s %s: lets go after %.3f s\n", rival.name.c_str(), trial.name.c_str(),
                    through * kStep);
      lost += through > 0;
    }
    figure(rival.name + ".lets_go", lost, "trials");
  }
  figure("haptic.trials", static_cast<double>(holding.size()), "trials");
}

}  // namespace haptic::bench
