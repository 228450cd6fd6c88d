// Islands of the default: each is stepped as if it were alone, nothing is launched, and all of it is state.
#include <gtest/gtest.h>

#include "../../scenes/blocks.h"
#include "../../scenes/heap.h"
#include "../../scenes/motions.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace islands_test {

using namespace scenes;

WorldSettings settingsOf(double h = 1e-3) {
  WorldSettings s;
  s.step = h;
  return s;
}

void expectSameMotion(const World& a, const World& b, int links) {
  for (int i = 0; i < links; ++i) {
    ASSERT_EQ(a.linkPose(i).p, b.linkPose(i).p) << "link " << i;
    ASSERT_EQ(a.linkPose(i).R, b.linkPose(i).R) << "link " << i;
    ASSERT_EQ(a.linkTwist(i).vector(), b.linkTwist(i).vector()) << "link " << i;
  }
}

TEST(Islands, StiffContactsAreSteppedImplicitlyAndRest) {
  CubeParameters c;
  c.stiffness = 1e10;  // k_eff = 1e8 N/m: 30 times the step that explicit schemes can take
  World world(stack(3, c, settingsOf()));
  for (int i = 0; i < 500; ++i) {
    world.step();
    ASSERT_EQ(world.report().implicit_islands, 1);
    ASSERT_EQ(world.report().flags, 0u);
  }
  for (int i = 0; i < 3; ++i) EXPECT_LE(world.linkTwist(1 + i).linear.norm(), 1e-9);
}

/// Cubes beside one another, the second of steel.
WorldDef softAndStiff() {
  CubeParameters soft, stiff;
  soft.ratio = 0.3;
  stiff.stiffness = 1e10;
  WorldDef def = cubeOnFloor(soft, settingsOf(), 2e-5);
  def.articulations[0].links[0].collisions[0].material = {};
  def.articulations[1].links[0].collisions[0].material = soft.material();
  def.articulations.push_back(cube("stiff", stiff, Pose(Vector3(1, 0, stiff.size / 2 + 0.01))));
  def.articulations[2].links[0].collisions[0].material = stiff.material();
  return def;
}

TEST(Islands, AStiffIslandBesideChangesNothing) {
  const WorldDef def = softAndStiff();
  WorldDef alone = def;
  alone.articulations.resize(2);
  World world(def), soft(alone);
  for (int i = 0; i < 500; ++i) {
    world.step();
    soft.step();
    expectSameMotion(world, soft, 2);
  }
  EXPECT_NEAR(world.linkPose(2).p.z(), 0.05, 1e-6);
}

/// A heap that does not converge over a long step is halved by itself: a cube that slides beside its bin moves as if it were alone.
TEST(Islands, AHeapThatIsHalvedHalvesNothingElse) {
  HeapParameters p;
  p.count = 30;
  p.stiffness = 1e10;
  WorldDef def = heap(p, settingsOf(3e-3));
  ArticulationDef slides = freeBox("slides", Vector3::Constant(0.05), 0.1, Pose(Vector3(0.5, -0.4, 0.025)));
  slides.V_WA.linear = Vector3(0, 0.5, 0);
  WorldDef alone = def;
  alone.articulations.resize(kFirstOfHeap);
  for (WorldDef* d : {&def, &alone}) d->articulations.push_back(slides);
  World world(def), single(alone);
  const int a = world.linkIndex("slides"), b = single.linkIndex("slides");
  int halved = 0;
  for (int i = 0; i < 300; ++i) {
    world.step();
    single.step();
    halved += world.report().contacts > 20 && world.report().evaluations > 12;  // where so many touch one part has 10
    ASSERT_EQ(world.linkPose(a).p, single.linkPose(b).p) << i;
    ASSERT_EQ(world.linkTwist(a).vector(), single.linkTwist(b).vector()) << i;
  }
  EXPECT_GT(halved, 0);
  EXPECT_GT(single.linkPose(b).p.y(), -0.39);
}

TEST(Islands, AnImpactLaunchesNothing) {
  for (double k : {1e8, 1e10, 1e13}) {
    CubeParameters c;
    c.stiffness = k;
    World world(cubeOnFloor(c, settingsOf(), 0.05));
    bool touched = false;
    double highest = 0;
    for (int i = 0; i < 1500; ++i) {
      world.step();
      touched = touched || world.contactCount() > 0;
      if (touched) highest = std::max(highest, world.linkPose(1).p.z());
    }
    EXPECT_TRUE(touched) << k;
    EXPECT_LE(highest, 0.1) << k;  // no higher than it fell from
    EXPECT_NEAR(world.linkPose(1).p.z(), c.size / 2 - c.restDepth(), 1e-6) << k;
  }
}

TEST(Islands, WhateverItRemembersIsState) {
  const WorldDef def = softAndStiff();
  World one(def), two(def);
  for (int i = 0; i < 130; ++i) {
    one.step();
    World copy(def);
    copy.restore(one.save());
    ASSERT_EQ(copy.hash(), one.hash());
    two.restore(one.save());
    copy.step();
    two.step();
    ASSERT_EQ(copy.hash(), two.hash()) << "step " << i;
  }
  for (int i = 0; i < 300; ++i) {
    one.step();
    if (i == 0) continue;
    two.step();
    ASSERT_EQ(one.hash(), two.hash()) << "step " << i;
  }
}

// Oracle: connected components by repeated relabelling.
TEST(Islands, AreTheConnectedPartsOfTheContactGraph) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, settingsOf());
  constexpr int kBodies = 12;
  for (int i = 1; i < kBodies; ++i) {
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(Vector3(0.2 * i, 0, 0.05))));
  }
  const Model model(def);
  Islands islands(model);
  unsigned random = 1;
  for (int round = 0; round < 200; ++round) {
    State state;
    state.mode.assign(model.trees.size(), TreeMode::kPut);
    state.pairs.fit(model.pair_capacity);
    std::vector<int> label(kBodies + 1);
    for (int i = 0; i <= kBodies; ++i) label[i] = i;
    for (int i = 0; i < 8; ++i) {
      random = random * 1664525u + 1013904223u;
      const int a = (random >> 8) % (kBodies + 1), b = (random >> 20) % (kBodies + 1);
      if (a == b) continue;
      state.pairs.append(ActivePair::keyOf(std::min(a, b), std::max(a, b)));
      if (a == 0 || b == 0) continue;  // the floor joins nobody
      const int from = label[a], to = label[b];
      for (int& l : label) l = l == from ? to : l;
    }
    islands.find(state, model.updated_trees, std::vector<int>(model.links.size(), -1));
    EXPECT_EQ(islands.of(0), -1);
    int trees = 0, pairs = 0;
    for (int i = 0; i < islands.count(); ++i) {
      trees += islands[i].tree_count;
      pairs += islands[i].pair_count;
    }
    EXPECT_EQ(trees, kBodies);
    EXPECT_EQ(pairs, state.pairs.count());
    for (int a = 1; a <= kBodies; ++a) {
      for (int b = 1; b <= kBodies; ++b) EXPECT_EQ(islands.of(a) == islands.of(b), label[a] == label[b]);
    }
  }
}

}  // namespace islands_test
}  // namespace haptic
