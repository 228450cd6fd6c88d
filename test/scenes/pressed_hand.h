/// A hand that presses a wall with 9 N, and everything that may change beside the contact: for tests and benchmarks of the law of change
/// (spidar/force_slew.h).
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/base/elementary.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "touch.h"

namespace haptic::scenes {

constexpr double kPressPeriod = 1e-3, kPressed = 9;           // [s], [N]
constexpr double kWall = 2000, kHome = 0.012;            // [N/m]; the tool's height over the wall at home [m]
constexpr double kTremor = 5e-5, kTremorRate = 10;       // of a jig [m], [Hz], as hand_trial.cpp has it
constexpr int kTouch = 1500; // ticks until it presses

inline DeviceDef g6x3r() { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml"); }

/// A cube as tool over a wall, and a loose cube beside it on the wall.
inline WorldDef pressedWall(bool virtual_coupling) {
  const double edge = 0.02;
  WorldDef world = pointerOverWall(makeBox(Vector3::Constant(edge)), kHome + edge / 2, kWall / (edge * edge), kPressPeriod);
  ArticulationDef cube = springyBody("cube", makeBox(Vector3::Constant(edge)), JointType::kFloating,
                                             Vector3(0.05, 0, edge / 2 - 1e-5), kWall / (edge * edge));
  world.articulations.push_back(cube);
  if (virtual_coupling) world.pointers.back().coupling.mode = PointerCoupling::Mode::kVirtual;
  return world;
}

/// A device on its twin, whose grip is pressed by a jig that trembles or by a relaxed hand.
struct PressedHand {
  PressedHand(bool virtual_coupling, bool jig_holds) : def_(pressedWall(virtual_coupling)), jig(jig_holds) {
    begin();
    device.calibrateAtHome();
    device.setForceEnabled(true);
    for (int i = 0; i < 700; ++i) tick();
    depth = kHome + kPressed / kWall + (jig ? 0 : kPressed / 500.0);  // a relaxed hand: 500 N/m
    for (int i = 0; i < kTouch; ++i) tick();
  }
  static TwinSettings settings() {
    TwinSettings s;
    s.period = kPressPeriod;
    return s;
  }
  /// Another loop on a fresh world, as after another scene was loaded.
  void begin() {
    loop.reset();
    world = std::make_unique<World>(def_);
    loop = std::make_unique<HapticLoop>(*world);
    HandSettings hand;
    hand.workspace.X_WB.p = Vector3(0, 0, kHome + 0.01);
    device.handOver();
    loop->attach(device, 0, hand);
  }
  void tick(const std::function<void(DeviceSample&)>& wire = {}) {
    const double time = static_cast<double>(ticks_++) * kPressPeriod;
    at = at + std::clamp(depth - at, -4e-5, 4e-5);  // 40 mm/s
    GripPose grip;
    grip.X_BG.p = Vector3(0, 0, -at);
    if (jig) {
      grip.X_BG.p += kTremor * elementary::sin(2 * M_PI * kTremorRate * time) * Vector3(1, 1, 1) / std::sqrt(3.0);
      twin.place(grip);
    } else {
      twin.setHandTarget({grip, true});
    }
    input.hands = 1;
    input.sample[0] = twin.exchange(device.driveAfter(input.lost(kPressPeriod)));
    if (wire) wire(input.sample[0]);
    loop->tick(input, kPressPeriod);
    input.lost_periods = 0;
    const Vector3 F = (device.kinematics().structure(GripPose{device.pose(), 0}).leftCols(3).transpose() * device.toldTension());
    const Vector3 x = device.pose().p, asked = device.askedWrench().force;
    const double by_way = device.stableStiffness() * (x - last_x_).norm();
    if (ticks_ > 1) jump = std::max(jump, (F - last_F_).norm() - by_way);
    if (ticks_ > 1) asked_jump = std::max(asked_jump, (asked - last_asked_).norm() - by_way);
    last_F_ = F, last_x_ = x, last_asked_ = asked;
  }
  void run(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  void change(const std::function<void(HandSettings&)>& set) {
    HandSettings settings = loop->hand(0).settings();
    set(settings);
    loop->take({ChangeHand{settings}});
  }
  double force() const { return device.achievedWrench().force.norm(); }

  WorldDef def_;
  bool jig;
  double depth = 0, at = 0;          ///< where the grip shall be, and is told to be, below home [m]
  double jump = 0, asked_jump = 0;   ///< greatest change in a tick beyond K |Δx|, of the tensions told and of the wrench asked [N]
  DeviceDef device_def = g6x3r();
  DeviceTwin twin{device_def, settings()};
  Spidar device{device_def};
  std::unique_ptr<World> world;
  std::unique_ptr<HapticLoop> loop;
  TickInput input;

 private:
  long ticks_ = 0;
  Vector3 last_F_ = Vector3::Zero(), last_asked_ = Vector3::Zero(), last_x_ = Vector3::Zero();
};

/// The runner lets go as the bridge does: the world stands, and the force goes by the law.
inline void letGo(PressedHand& rig) {
  rig.loop->take({PauseWorld{true}});
  for (int i = 0; i < 300 && rig.loop->presses(); ++i) rig.tick();
}

inline void spawn(PressedHand& rig) {
  WorldDef more = rig.def_;
  ArticulationDef box = springyBody("spawned", makeBox(Vector3::Constant(0.02)), JointType::kFixed, Vector3::Zero(),
                                            kWall / (0.02 * 0.02));
  box.X_WA.p = rig.world->linkPose(1).p + Vector3(0, 0.012, 0.004);
  more.articulations.push_back(box);
  std::vector<int> kept = {0, 1, 2, -1};
  ChangeBodies change;
  *change.packed = packBodies(more, kept);
  rig.loop->take({change});
}

/// Something that happens while the hand presses.
struct HandEvent {
  const char* name;
  bool at_once;  ///< may end a force in a tick: counted apart
  std::function<void(PressedHand&)> happen;
};

inline std::vector<HandEvent> handEvents() {
  const auto frozen = [](PressedHand& rig) {
    for (int i = 1; i <= 12; ++i) rig.tick([i](DeviceSample& s) { if (i % 5) s.status = LinkStatus::kStale, s.lost = 1; });
  };
  return {
      {"pause", false, [](PressedHand& r) { r.loop->take({PauseWorld{true}}); }},
      {"resume", false, [](PressedHand& r) { r.loop->take({PauseWorld{true}}), r.run(500), r.loop->take({PauseWorld{false}}); }},
      {"restore", false, [](PressedHand& r) {
         const std::vector<double> saved = r.world->save();
         r.run(100), r.loop->take({RestoreWorld{saved}});
       }},
      {"grab", false, [](PressedHand& r) { r.loop->take({GrabLink{0, 2}}); }},
      {"release", false, [](PressedHand& r) { r.loop->take({GrabLink{0, 2}}), r.run(700), r.loop->take({GrabLink{0, 1}}); }},
      {"spawn", false, spawn},
      {"clutch", false, [](PressedHand& r) { r.loop->take({HoldClutch{true}}), r.run(200), r.loop->take({HoldClutch{false}}); }},
      {"scene", false, [](PressedHand& r) { letGo(r), r.begin(); }},
      {"coupling", false, [](PressedHand& r) {
         WorldTuning tuning = r.world->tuning();
         using Mode = PointerCoupling::Mode;
         Mode& mode = tuning.coupling[0].mode;
         mode = mode == Mode::kVirtual ? Mode::kDirect : Mode::kVirtual;
         r.loop->take({TuneWorld{tuning}});
       }},
      {"stiffness", false, [](PressedHand& r) {
         WorldTuning tuning = r.world->tuning();
         tuning.stiffness_scale = 0.2;
         r.loop->take({TuneWorld{tuning}});
       }},
      {"force_scale", false, [](PressedHand& r) { r.change([](HandSettings& s) { s.force_scale = 0.3; }); }},
      {"limits", false, [](PressedHand& r) {
         Spidar::Tuning tuning = r.device.tuning();
         r.loop->take({TuneDevice{tuning.lambda, 0.2 * tuning.max_force, 0.2 * tuning.max_torque}});
       }},
      {"silent", false, [](PressedHand& r) { r.change([](HandSettings& s) { s.silent = true; }); }},
      {"let_in", false, [](PressedHand& r) {
         r.change([](HandSettings& s) { s.silent = true; }), r.run(1200), r.change([](HandSettings& s) { s.silent = false; });
       }},
      {"switched_off", false, [](PressedHand& r) { r.device.setForceEnabled(false); }},
      {"switched_on", false, [](PressedHand& r) { r.device.setForceEnabled(false), r.run(300), r.device.setForceEnabled(true); }},
      {"calibration", false, [](PressedHand& r) { r.device.calibrateAt(r.twin.pose()); }},
      {"late_1_2", false, [](PressedHand& r) { r.input.lost_periods = 1; }},
      {"late_3", false, [](PressedHand& r) { r.input.lost_periods = 3; }},
      {"late_12", false, [](PressedHand& r) { r.input.lost_periods = 12; }},
      {"reduced", false, frozen},
      {"stop", true, [](PressedHand& r) { r.loop->take({StopDevice{}}); }},
      {"fault", true, [](PressedHand& r) { r.tick([](DeviceSample& s) { s.status = LinkStatus::kRestarted; }); }},
      {"guard", true, [](PressedHand& r) { r.tick([](DeviceSample& s) { s.status = LinkStatus::kUnguarded; }); }},
      {"interruption", true, [](PressedHand& r) { r.input.lost_periods = 100; }},
      {"suspend", true, [](PressedHand& r) { r.input.lost_periods = 5000; }},
      {"dead_man", true, [](PressedHand& r) { r.loop->take({HoldSwitch{false}}); }},
  };
}

}  // namespace haptic::scenes
