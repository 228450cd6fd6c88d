// Same input, same bits, wherever the heap puts a world's storage. Oracle: a second world at other addresses.
// The heap aligns to 16 bytes; packets of x86-64-v3 want 32, those of x86-64-v4 64, and only there can
// addresses matter. So this file replaces the whole program's operator new: it puts blocks where a test wants
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "../../scenes/blocks.h"
#include "../dynamics/chain.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/cone.h"
#include "haptic_core/geometry/shapes/ellipsoid.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/world/world.h"

namespace {

constexpr std::size_t kLargestPacket = 64;  // [bytes]
thread_local std::size_t heap_offset = 0;   // of this thread's blocks behind a multiple of that [bytes]
thread_local long blocks_taken = 0;         // by this thread

void* offsetBlock(std::size_t size) noexcept {
  ++blocks_taken;
  void* whole = std::malloc(size + 3 * kLargestPacket);
  if (!whole) return nullptr;
  const std::uintptr_t start = reinterpret_cast<std::uintptr_t>(whole) / kLargestPacket * kLargestPacket;
  char* block = reinterpret_cast<char*>(start + 2 * kLargestPacket + heap_offset);
  std::memcpy(block - sizeof whole, &whole, sizeof whole);
  return block;
}

void freeBlock(void* block) noexcept {
  if (!block) return;
  void* whole;
  std::memcpy(&whole, static_cast<char*>(block) - sizeof whole, sizeof whole);
  std::free(whole);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* block = offsetBlock(size)) return block;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return offsetBlock(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return offsetBlock(size);
}
void operator delete(void* block) noexcept {
  freeBlock(block);
}
void operator delete[](void* block) noexcept {
  freeBlock(block);
}
void operator delete(void* block, std::size_t) noexcept {
  freeBlock(block);
}
void operator delete[](void* block, std::size_t) noexcept {
  freeBlock(block);
}
void operator delete(void* block, const std::nothrow_t&) noexcept {
  freeBlock(block);
}
void operator delete[](void* block, const std::nothrow_t&) noexcept {
  freeBlock(block);
}

namespace haptic {
namespace storage_test {

/// A chain with shapes, hung up at `X_WA`.
ArticulationDef arm(int links, const Pose& X_WA) {
  const TreeDef tree = test::chain(links);
  ArticulationDef def;
  def.name = tree.name;
  def.X_WA = X_WA;
  for (const BodyDef& body : tree.links) {
    LinkDef link;
    static_cast<BodyDef&>(link) = body;
    link.joint.damping = 1e-3;
    CollisionDef collision;
    collision.name = body.name;
    collision.shape = scenes::box(Vector3(0.9 * test::kChainLength, test::kChainWidth, test::kChainWidth));
    collision.X_LS = Pose(body.inertia.p_LC);
    link.collisions.push_back(collision);
    def.links.push_back(link);
  }
  return def;
}

/// Two arms of odd numbers of joints, which fall across one another and on the floor, and a cube on top.
WorldDef fallingArms(Attempts attempts) {
  scenes::CubeParameters c;
  c.size = 0.06;
  c.stiffness = 1e7;
  WorldDef def;
  def.name = "arms";
  def.settings.attempts = attempts;
  def.settings.default_material = c.material();
  def.articulations.push_back(scenes::floorBox());
  def.articulations.push_back(arm(5, Pose(Vector3(0, 0, 0.03))));
  const Matrix3 quarter = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()).toRotationMatrix();
  def.articulations.push_back(arm(7, Pose(quarter, Vector3(0.25, -0.25, 0.06))));
  def.articulations.push_back(scenes::cube("cube", c, Pose(Vector3(0.25, 0.02, 0.12))));
  ForceDef spring(ForceType::kSpring), oil(ForceType::kViscous);
  spring.articulation_a = 1, spring.link_a = 3, spring.articulation_b = 3, spring.link_b = 0;
  spring.set("stiffness", 3), spring.set("damping", 0.01), spring.set("rest_length", 0.2);
  oil.set("viscosity", 0.01);
  def.forces = {spring, oil};
  return def;
}

class Storage : public testing::TestWithParam<Attempts> {
 protected:
  void TearDown() override { heap_offset = 0; }
};
INSTANTIATE_TEST_SUITE_P(All, Storage,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2,
                                         Attempts::kAll));

TEST_P(Storage, AWorldsBitsDoNotDependOnItsAddresses) {
  const WorldDef def = fallingArms(GetParam());
  std::vector<std::unique_ptr<World>> worlds;
  for (heap_offset = 0; heap_offset < kLargestPacket; heap_offset += 16) {
    const std::vector<double> block(7);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(block.data()) % kLargestPacket, heap_offset);
    worlds.push_back(std::make_unique<World>(def));
  }
  int touching = 0;
  for (int i = 0; i < 400; ++i) {
    for (auto& world : worlds) {
      world->step();
      ASSERT_EQ(world->hash(), worlds[0]->hash()) << "step " << i;
    }
    touching = std::max(touching, worlds[0]->contactCount());
  }
  EXPECT_GE(touching, 6);  // arms with arms, with the floor and with the cube
}

/// Shapes of every kind in one bowl: no step takes a block from the heap, whichever pairs meet.
TEST(HeapOfSteps, IsLeftAloneWhicheverKindsOfShapesMeet) {
  WorldDef def;
  def.settings.step = 1e-3;
  def.settings.gravity = Vector3(0, 0, -scenes::kGravity);
  def.settings.default_material.stiffness = 1e7;
  def.articulations.push_back(scenes::floorBox());
  for (const double side : {-0.17, 0.17}) {
    const std::string end = side < 0 ? "0" : "1";
    def.articulations.push_back(scenes::staticBox("x" + end, Vector3(0.1, 0.44, 0.3), Pose(Vector3(side, 0, 0.15))));
    def.articulations.push_back(scenes::staticBox("y" + end, Vector3(0.24, 0.1, 0.3), Pose(Vector3(0, side, 0.15))));
  }
  const std::shared_ptr<const ConvexShape> shapes[] = {std::make_shared<Ellipsoid>(Vector3(0.05, 0.04, 0.03)),
                                                       std::make_shared<Cone>(0.04, 0.02, 0.06),
                                                       std::make_shared<Ball>(0.04),
                                                       std::make_shared<Rod>(0.03, 0.06, Rod::Ends::kRound),
                                                       scenes::box(Vector3(0.06, 0.05, 0.04))};
  for (int i = 0; i < 15; ++i) {
    const auto& shape = shapes[i % 5];
    const MassProperties solid = shape->massProperties(500);
    ArticulationDef body = scenes::freeBody("body" + std::to_string(i), shape, solid.mass, solid.I_com,
                                            Pose(Vector3(0.05 * (i % 2), 0.04 * (i % 3 - 1), 0.06 + 0.09 * i)));
    body.links[0].inertia.p_LC = solid.com;
    def.articulations.push_back(body);
    ForceDef spring(ForceType::kSpring);
    spring.articulation_b = static_cast<int>(def.articulations.size()) - 1, spring.link_b = 0;
    if (i % 3 == 1) spring.articulation_a = spring.articulation_b - 1, spring.link_a = 0;
    spring.set("stiffness", 20), spring.set("most", 0.5);
    def.forces.push_back(spring);
  }
  def.forces.emplace_back(ForceType::kViscous).set("viscosity", 0.01);
  World world(def);
  int contacts = 0;
  world.step();
  const long before = blocks_taken;
  for (int i = 0; i < 700; ++i) {
    world.step();
    contacts = std::max(contacts, world.report().contacts);
  }
  EXPECT_EQ(blocks_taken, before);
  EXPECT_GT(contacts, 20);
  const auto counted = std::make_unique<int>(1);
  EXPECT_EQ(blocks_taken, before + 1) << *counted;  // it counts
}

}  // namespace storage_test
}  // namespace haptic
