// A packed scene runs as the one that it was made of, bit for bit, and a file that was cut or altered is refused.
#include "scene/packed_scene.h"

#include <gtest/gtest.h>

#include "../scenes/shipped_scenes.h"
#include "short_session.h"

namespace haptic {
namespace packed_scene_test {

using short_session::device;
using short_session::session;

constexpr int kSteps = 1000;

std::uint64_t hashAfter(const SceneDef& scene) {
  World world(scene.world);
  for (int i = 0; i < kSteps; ++i) {
    followPaths(scene, world);
    world.step();
  }
  return world.hash();
}

TEST(PackedScene, EveryShippedSceneRunsAsItWas) {
  int tried = 0;
  for (const scenes::ShippedScene& scene : scenes::shippedScenes(HAPTIC_SCENES)) {
    const SceneDef again = unpackScene(packScene({0, scene.def, device(), ""}), scene.name).scene;
    EXPECT_EQ(fingerprint(again.world), fingerprint(scene.def.world)) << scene.name;
    EXPECT_EQ(hashAfter(again), hashAfter(scene.def)) << scene.name;
    EXPECT_EQ(again.hands.size(), scene.def.hands.size()) << scene.name;
    ++tried;
  }
  EXPECT_GE(tried, 25);
}

TEST(PackedScene, ItsDeviceBehavesAsItDid) {
  const DeviceDef again = unpackScene(packScene({0, loadScene("touch_cube"), device(), "said"}), "a file").device;
  TwinSettings settings;
  settings.path = handPath("wave");
  DeviceTwin one(device(), settings), two(again, settings);
  DriveCommand drive;
  for (int i = 0; i < 3000; ++i) {
    for (int s = 0; s < 8; ++s) drive.voltage[static_cast<std::size_t>(s)] = 0.1 + 0.05 * ((i + s) % 7);
    ASSERT_EQ(two.exchange(drive).counts, one.exchange(drive).counts) << i;
  }
  EXPECT_EQ(again.max_force, device().max_force);
  EXPECT_EQ(again.border_lambda, device().border_lambda);
}

TEST(PackedScene, ASessionReplaysFromItsFile) {
  const PackedSession one = session(), two = unpackSession(packSession(one), "a file");
  SessionReplay replay(two.scene.scene.world, two.start);
  std::size_t event = 0;
  ASSERT_EQ(two.ticks.size(), one.ticks.size());
  for (std::size_t i = 0; i < two.ticks.size(); ++i) {
    while (event < two.events.size() && two.events[event].tick <= two.ticks[i].tick) replay.apply(two.events[event++].command);
    ASSERT_TRUE(replay.tick(two.ticks[i]) == one.hashes[i]) << i;
    ASSERT_TRUE(two.hashes[i] == one.hashes[i]) << i;
  }
  EXPECT_EQ(event, 3u);
}

TEST(PackedScene, DrawnMeshesBecomeTriangles) {
  SceneDef scene = loadScene("c_bin");
  VisualDef visual = scene.visuals.at(0);
  visual.shape = VisualShape::kMesh;
  visual.mesh_uri = "file:///no/such/file.stl";
  scene.visuals.push_back(visual);
  drawWithoutFiles(scene, 1e-4, 1000);
  for (const VisualDef& each : scene.visuals) EXPECT_NE(each.shape, VisualShape::kMesh);
  EXPECT_GT(scene.visuals.back().corners.size(), 2u) << "the shapes that collide stand in";
}

TEST(PackedScene, WhatWasCutOrAlteredIsRefused) {
  const std::string bytes = packScene({0, loadScene("touch_cube"), device(), ""});
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    EXPECT_THROW(unpackScene(bytes.substr(0, size), "a file"), SetupError) << size;
  }
  for (std::size_t at = 0; at < bytes.size(); at += 89) {
    std::string altered = bytes;
    altered[at] = static_cast<char>(altered[at] ^ 0x10);
    EXPECT_THROW(unpackScene(altered, "a file"), SetupError) << at;
  }
  EXPECT_THROW(unpackScene(bytes + "x", "a file"), SetupError);
}

}  // namespace packed_scene_test
}  // namespace haptic
