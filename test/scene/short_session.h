/// Half a second of a simulated hand on touch_cube, recorded as sessions are, without ROS.
#pragma once
#include <gtest/gtest.h>

#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/session.h"
#include "haptic_core/spidar/device_twin.h"
#include "scene/packed_scene.h"

namespace haptic::short_session {

inline const DeviceDef& device() {
  static const DeviceDef def = loadDevice(HAPTIC_SCENES "/../devices/spidar_g6x3r.yaml");
  return def;
}

/// With commands between ticks.
inline PackedSession session() {
  constexpr int kTicks = 500;
  PackedSession packed;
  packed.scene = {0, loadScene("touch_cube"), device(), ""};
  const HandDef& hand = packed.scene.scene.hands.at(0);
  World world(packed.scene.scene.world);
  HapticLoop loop(world);
  Spidar spidar(device());
  TwinSettings twin_settings;
  twin_settings.path = {{{0, Vector3::Zero(), Vector3::Zero(), 0}, {0.3, Vector3(0, 0, -0.0096), Vector3(0.1, 0, 0), 0}}};
  DeviceTwin twin(device(), twin_settings);
  HandSettings settings;
  settings.workspace = hand.workspace;
  settings.soft_start_s = 0.05;
  loop.attach(spidar, hand.pointer, settings);
  spidar.calibrateAtHome();
  spidar.setForceEnabled(true);
  packed.start.step = world.settings().step;
  packed.start.world_state = world.save();
  packed.start.world_tuning = world.tuning().numbers();
  packed.start.hands.push_back({hand.device, device(), hand.pointer, settings, spidar.save(), {}});
  loop.hand(0).save(packed.start.hands[0].loop_memory);
  // Requests to a device are not in its memory: a recording tells them as commands.
  DeviceRequests requests;
  requests.calibrate = true, requests.enable = 1;
  packed.events.push_back({0, {AskDevice{requests}, 0}});
  WorldTuning softer = world.tuning();
  softer.stiffness_scale = 0.5;
  packed.events.push_back({200, {TuneWorld{softer}, 0}});
  packed.events.push_back({400, {HoldClutch{true}, 0}});
  std::size_t event = 0;
  for (int i = 0; i < kTicks; ++i) {
    TickInput input;
    input.tick = static_cast<std::uint64_t>(i);
    input.hands = 1;
    input.sample[0] = twin.exchange(loop.drive(0));
    while (event < packed.events.size() && packed.events[event].tick <= input.tick) loop.take(packed.events[event++].command);
    loop.tick(input, packed.start.step);
    packed.ticks.push_back(input);
    packed.hashes.emplace_back();
    hashTick(loop, packed.hashes.back());
  }
  EXPECT_TRUE(loop.report().hand[0].in_contact || world.contactCount() > 1) << "the hand presses";
  return packed;
}

}  // namespace haptic::short_session
