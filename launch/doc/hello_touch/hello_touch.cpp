// Touches a wall with a simulated SPIDAR, without ROS: counts in, tensions out, a thousand times a second.
//     hello_touch urdf/devices/spidar_g6x3r.yaml
#include <cstdio>

#include "haptic_core/geometry/shapes/shapes.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/world.h"

using namespace haptic;

ArticulationDef body(const char* name, JointType joint, const Vector3& size, const Vector3& p_W) {
  CollisionDef collision;
  collision.shape = std::make_shared<ConvexPolyhedron>(makeBox(size));
  collision.material.stiffness = 5e6;  // pressure per depth [N/m³]: 2000 N/m under the pointer
  LinkDef link;
  link.name = link.joint.name = name;
  link.joint.type = joint;
  link.inertia.mass = 0.1, link.inertia.I_C = 1e-5 * Matrix3::Identity();  // [kg], [kg·m²]
  link.collisions = {collision};
  return {name, {link}, Pose(p_W), {}};
}

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("usage: hello_touch DEVICE.yaml\n", stderr), 2;
  WorldDef scene;
  scene.articulations = {body("wall", JointType::kFixed, {1, 1, 0.1}, {0, 0, -0.05}),
                         body("pointer", JointType::kFloating, {0.02, 0.02, 0.02}, {0, 0, 0.02})};
  scene.pointers.resize(1);
  scene.pointers[0].articulation = 1, scene.pointers[0].link = 0;
  World world(scene);
  const DeviceDef def = loadDevice(argv[1]);
  DeviceTwin twin(def);  // a hand and strings; a real device is another Transport
  Spidar device(def);
  HapticLoop loop(world);
  HandSettings hand;
  hand.workspace.X_WB.p = {0, 0, 0.02};  // the grip's home in the world [m]
  loop.attach(device, 0, hand);
  device.calibrateAtHome();
  device.setForceEnabled(true);
  HandTarget target;
  target.active = true;
  for (int tick = 0; tick < 3000; ++tick) {
    target.pose.X_BG.p.z() = -4e-6 * tick;  // the hand sinks by 12 mm in 3 s; the wall begins at 10 mm
    twin.setHandTarget(target);
    const DeviceSample sample = twin.exchange(loop.drive(0));
    loop.tick(&sample, 1e-3);
    if (tick % 250 == 249) std::printf("%4d ms: %5.2f mm, %5.2f N\n", tick + 1, 1e3 * loop.report().hand[0].X_WP.p.z(),
                                       loop.report().hand[0].F_achieved_B.force.z());
  }
}
