/// Nuts of M4, M8 and M20 on joints with their threads, as files say them, beside closed forms; and the time of a tick of nut_on_bolt.
///
/// Pitch and pitch diameter are those of ISO 724, flanks of 60°. With r the pitch radius, tan α = lead/(2π r) and μ' = μ/cos β_n, a load F
/// takes the torque F r (tan α ± μ')/(1 ∓ μ' tan α) to climb, or holds it back coming down. A nut of moment I and mass m that falls has
/// θ'' = −K m g/(I + K m l), K = r (tan α − μ')/(1 + μ' tan α), l the lead over 2π.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "figure.h"
#include "haptic_core/base/cpu_time.h"
#include "loop_rig.h"

namespace haptic::bench {
namespace {

constexpr double kGravity = 9.8, kFlank = M_PI / 6;

struct Thread {
  const char* name;
  double diameter, pitch, mass, moment;  ///< of the nut: ISO 4032's
  double radius() const { return 0.5 * (diameter - 0.6495190528 * pitch); }
  double lead() const { return pitch / (2 * M_PI); }
  double tangent() const { return lead() / radius(); }
  double rubbed(double mu) const { return mu * std::hypot(1, std::tan(kFlank) / std::hypot(1, tangent())); }
  double lever(double mu, int sign) const {
    return radius() * (tangent() + sign * rubbed(mu)) / (1 - sign * rubbed(mu) * tangent());
  }
};
constexpr Thread kThreads[] = {
    {"m4", 4e-3, 0.7e-3, 0.8e-3, 7e-9}, {"m8", 8e-3, 1.25e-3, 5e-3, 1.5e-7}, {"m20", 20e-3, 2.5e-3, 64e-3, 1.1e-5}};

/// A nut under gravity, above a plate that it does not touch yet unless `gap` is 0.
SceneDef nutScene(const Thread& thread, double mu, double mass, double gravity, double gap) {
  std::ostringstream text;
  text.precision(17);
  text << "<robot name='screw' xmlns:haptic='https://haptic/urdf'><haptic:scene step='0.001' gravity='0 0 " << -gravity
       << "'><haptic:contact stiffness='1e10' mu_static='0' mu_dynamic='0'/></haptic:scene><link name='world'/>"
       << "<link name='plate'><collision><geometry><box size='0.1 0.1 0.02'/></geometry></collision></link>"
       << "<joint name='p' type='fixed'><parent link='world'/><child link='plate'/><origin xyz='0 0 -0.01'/></joint>"
       << "<link name='nut'><inertial><mass value='" << mass << "'/><inertia ixx='" << thread.moment << "' iyy='" << thread.moment
       << "' izz='" << thread.moment << "'/></inertial><collision><geometry><cylinder radius='" << thread.diameter
       << "' length='0.01'/></geometry></collision></link><joint name='turn' type='continuous'><parent link='world'/><child link='nut'/>"
       << "<origin xyz='0 0 " << 0.005 + gap << "'/><axis xyz='0 0 1'/><limit effort='100' velocity='1e3'/><haptic:joint lead='"
       << thread.pitch << "' thread_diameter='" << 2 * thread.radius() << "' thread_friction='" << mu
       << "' drive='effort'/></joint></robot>";
  SceneOptions options;
  options.add_pointer = false;
  options.text = text.str();
  return loadScene("screw.urdf", options);
}

/// The nut, its turn and its slide.
struct Nut {
  explicit Nut(const SceneDef& scene) : world(scene.world), turn(world.jointIndex("turn")), slide(world.jointIndex("turn_slide")) {}
  void run(double seconds) {
    for (int i = 0; i < std::lround(1e3 * seconds); ++i) world.step();
  }
  void drive(double torque) {
    JointCommand command;
    command.drive = JointDef::Drive::kEffort;
    command.effort = torque;
    world.setJointCommand(turn, command);
  }
  double angle() const { return world.joint(turn).position; }
  double way() const { return world.joint(slide).position; }
  World world;
  int turn, slide;
};

/// Whether 100 N turn the nut by less than 1e-6 rad from 0.5 s to 1.5 s.
bool locks(const Thread& thread, double mu) {
  Nut nut(nutScene(thread, mu, 100 / kGravity, kGravity, 100));
  nut.run(0.5);
  const double before = nut.angle();
  nut.run(1);
  return std::abs(nut.angle() - before) < 1e-6;
}

void measureLocking() {
  double worst = 1;
  for (const Thread& thread : kThreads) {
    const double expected = thread.tangent() * std::cos(kFlank);
    double low = 0.5, high = 1.5;
    while (high - low > 1e-5) (locks(thread, 0.5 * (low + high) * expected) ? high : low) = 0.5 * (low + high);
    std::printf("%s: locks from a friction of %.5f on, tan α cos 30° is %.5f\n", thread.name, high * expected, expected);
    if (std::abs(high - 1) > std::abs(worst - 1)) worst = high;
  }
  figure("screw.locks_at_mu", worst, "1");
}

void measureFall() {
  double worst = 0, lead = 0;
  for (const Thread& thread : kThreads) {
    for (const double mu : {0., 0.01, 0.02}) {
      Nut nut(nutScene(thread, mu, thread.mass, kGravity, 100));
      const double K = thread.lever(mu, -1), rate = -K * thread.mass * kGravity / (thread.moment + K * thread.mass * thread.lead());
      nut.run(0.5);
      worst = std::max(worst, std::abs(nut.world.joint(nut.turn).velocity / (0.5 * rate) - 1));
      lead = std::max(lead, std::abs(nut.way() / (thread.lead() * nut.angle()) - 1));
    }
  }
  figure("screw.speed_err_rel", worst, "1");
  figure("screw.lead_err_rel", lead, "1");
}

/// A drive tightens the nut ever more; no gravity, and the plate is smooth.
void measureTorque() {
  double worst = 0, lead = 0;
  for (const Thread& thread : kThreads) {
    for (const double mu : {0.05, 0.15, 0.3}) {
      Nut nut(nutScene(thread, mu, thread.mass, 0, 0));
      const double K = thread.lever(mu, 1), most = 3e6 * thread.diameter * thread.diameter * K;  // of 48 N to 1200 N
      for (int i = 1; i <= 1000; ++i) {
        nut.drive(-most * i / 1000);
        nut.world.step();
        if (i % 250 != 0) continue;
        double force = 0;
        for (int c = 0; c < nut.world.contactCount(); ++c) force += std::abs(nut.world.contact(c).F_BP_W.force.z());
        worst = std::max(worst, std::abs(most * i / 1000 / force / K - 1));
      }
      lead = std::max(lead, std::abs(nut.way() / (thread.lead() * nut.angle()) - 1));
    }
  }
  figure("screw.torque_err_rel", worst, "1");
  figure("screw.pressed_lead_err_rel", lead, "1");
}

void measureTicks() {
  constexpr int kTicks = 20000;
  Rig rig(loadScene(repositoryFile("test/scenes/nut_on_bolt.urdf")), {});
  std::vector<double> us;
  double touched = 0, least = 0, most = 0;
  const int turn = rig.world.jointIndex("nut_turn");
  for (int i = 0; i < kTicks; ++i) {
    rig.exchange();
    const double before = cpuSeconds();
    rig.tick();
    us.push_back(1e6 * (cpuSeconds() - before));
    touched = std::max(touched, rig.world.pointerWrench(0).force.norm());
    least = std::min(least, rig.world.joint(turn).position), most = std::max(most, rig.world.joint(turn).position);
  }
  std::sort(us.begin(), us.end());
  figure("screw.tick_us_p50", us[kTicks / 2], "us");
  figure("screw.tick_us_p999", us[kTicks - kTicks / 1000], "us");
  figure("screw.hand_force_n_max", touched, "N");
  figure("screw.hand_turned_rad", most - least, "rad");
}

}  // namespace
}  // namespace haptic::bench

int main() {
  using namespace haptic::bench;
  measureLocking();
  measureFall();
  measureTorque();
  measureTicks();
}
