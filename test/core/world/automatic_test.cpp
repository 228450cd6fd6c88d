// The choice between explicit and implicit steps of the rule of before: soft scenes are those of velocity Verlet to the last
// bit, stiff ones do not blow up, mixed ones are stepped island by island, and all of it is state.
#include <gtest/gtest.h>

#include "../../scenes/blocks.h"
#include "../../scenes/motions.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace automatic_test {

using namespace scenes;

WorldSettings automatic(double h = 1e-3) {
  WorldSettings s;
  s.step = h;
  s.attempts = Attempts::kVerletFirst;
  return s;
}

void expectSameMotion(const World& a, const World& b, int links) {
  for (int i = 0; i < links; ++i) {
    ASSERT_EQ(a.linkPose(i).p, b.linkPose(i).p) << "link " << i;
    ASSERT_EQ(a.linkPose(i).R, b.linkPose(i).R) << "link " << i;
    ASSERT_EQ(a.linkTwist(i).vector(), b.linkTwist(i).vector()) << "link " << i;
  }
}

TEST(Automatic, ASoftSceneIsThatOfVelocityVerletToTheLastBit) {
  CubeParameters c;
  c.ratio = 0.03;
  c.tangential_ratio = 0.1;
  WorldSettings verlet = automatic();
  verlet.attempts = Attempts::kVerlet;
  WorldDef def = stack(3, c, automatic(), 1e-3), reference = stack(3, c, verlet, 1e-3);
  for (WorldDef* d : {&def, &reference}) d->articulations[3].V_WA.linear = Vector3(0.2, 0.1, -0.1);
  World world(def), plain(reference);
  for (int i = 0; i < 1000; ++i) {
    world.step();
    plain.step();
    ASSERT_EQ(world.report().implicit_islands, 0);
    expectSameMotion(world, plain, 4);
  }
  EXPECT_GT(world.report().stability, 0);
}

TEST(Automatic, StiffContactsAreSteppedImplicitlyAndRest) {
  CubeParameters c;
  c.stiffness = 1e10;  // k_eff = 1e8 N/m: 30 times the step that explicit schemes can take
  World world(stack(3, c, automatic()));
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
  WorldDef def = cubeOnFloor(soft, automatic(), 2e-5);
  def.articulations[0].links[0].collisions[0].material = {};
  def.articulations[1].links[0].collisions[0].material = soft.material();
  def.articulations.push_back(cube("stiff", stiff, Pose(Vector3(1, 0, stiff.size / 2 + 0.01))));
  def.articulations[2].links[0].collisions[0].material = stiff.material();
  return def;
}

TEST(Automatic, EachIslandHasItsOwnMode) {
  const WorldDef def = softAndStiff();
  WorldDef alone = def;
  alone.articulations.resize(2);
  World world(def), soft(alone);
  int implicit = 0, standing = 0;
  for (int i = 0; i < 500; ++i) {
    const bool moves = soft.linkTwist(1).linear.norm() > 1e-9;  // at rest it stands, implicitly
    world.step();
    soft.step();
    int& most = moves ? implicit : standing;
    most = std::max(most, world.report().implicit_islands);
    expectSameMotion(world, soft, 2);  // the stiff one beside it changes nothing
  }
  EXPECT_EQ(implicit, 1);
  EXPECT_EQ(standing, 2);
  EXPECT_NEAR(world.linkPose(2).p.z(), 0.05, 1e-6);
}

TEST(Automatic, AnImpactIsTakenBackAndNothingIsLaunched) {
  for (double k : {1e8, 1e10, 1e13}) {
    CubeParameters c;
    c.stiffness = k;
    World world(cubeOnFloor(c, automatic(), 0.05));
    int redone = 0;
    double highest = 0;
    for (int i = 0; i < 1500; ++i) {
      world.step();
      redone += world.report().redone;
      if (redone > 0) highest = std::max(highest, world.linkPose(1).p.z());
    }
    EXPECT_GT(redone, 0) << k;
    EXPECT_LE(highest, 0.1) << k;  // no higher than it fell from
    EXPECT_NEAR(world.linkPose(1).p.z(), c.size / 2 - c.restDepth(), 1e-6) << k;
  }
}

TEST(Automatic, ABodyThatFliesOffIsExplicitAgain) {
  CubeParameters c;
  c.stiffness = 1e10;
  WorldDef def = cubeOnFloor(c, automatic());
  World world(def);
  for (int i = 0; i < 20; ++i) world.step();
  EXPECT_EQ(world.report().implicit_islands, 1);
  def.articulations[1].V_WA.linear = Vector3(0, 0, 2);
  World thrown(def);
  for (int i = 0; i < 64; ++i) thrown.step();
  EXPECT_EQ(thrown.report().implicit_islands, 0);
  EXPECT_NEAR(thrown.linkTwist(1).linear.z(), 2 - 9.8 * 0.064, 0.05);
}

TEST(Automatic, ModesAndNumbersAreState) {
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
  WorldDef def = cubeOnFloor(c, automatic());
  constexpr int kBodies = 12;
  for (int i = 1; i < kBodies; ++i) {
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(Vector3(0.2 * i, 0, 0.05))));
  }
  const Model model(def);
  Islands islands(model);
  unsigned random = 1;
  for (int round = 0; round < 200; ++round) {
    State state;
    state.mode.assign(model.trees.size(), TreeMode::kUnprimed);
    state.pairs.resize(model.pair_capacity);
    std::vector<int> label(kBodies + 1);
    for (int i = 0; i <= kBodies; ++i) label[i] = i;
    for (int i = 0; i < 8; ++i) {
      random = random * 1664525u + 1013904223u;
      const int a = (random >> 8) % (kBodies + 1), b = (random >> 20) % (kBodies + 1);
      if (a == b) continue;
      state.pairs[state.pair_count++].key = ActivePair::keyOf(std::min(a, b), std::max(a, b));
      if (a == 0 || b == 0) continue;  // the floor joins nobody
      const int from = label[a], to = label[b];
      for (int& l : label) l = l == from ? to : l;
    }
    islands.find(state, model.updated_trees, std::vector<int>(model.links.size(), -1), false);
    EXPECT_EQ(islands.of(0), -1);
    int trees = 0, pairs = 0;
    for (int i = 0; i < islands.count(); ++i) {
      trees += islands[i].tree_count;
      pairs += islands[i].pair_count;
    }
    EXPECT_EQ(trees, kBodies);
    EXPECT_EQ(pairs, state.pair_count);
    for (int a = 1; a <= kBodies; ++a) {
      for (int b = 1; b <= kBodies; ++b) EXPECT_EQ(islands.of(a) == islands.of(b), label[a] == label[b]);
    }
  }
}

}  // namespace automatic_test
}  // namespace haptic
