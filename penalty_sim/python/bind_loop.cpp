#include "haptic_core/loop/hand.h"
#include "python/bindings.h"

namespace haptic::python {
namespace {

constexpr int kTicksPerLook = 1000;  // between two looks for Ctrl-C: 10 ms and more

/// One hand of a loop, for reading.
struct SeenHand {
  std::shared_ptr<TwinLoop> loop;
  int index;
  const HandReport& report() const { return loop->loop.report().hand[static_cast<std::size_t>(index)]; }
  Spidar& device() const { return *loop->devices[static_cast<std::size_t>(index)]; }
  DeviceTwin& twin() const { return *loop->twins[static_cast<std::size_t>(index)]; }
};

template <class Field>
auto field(Field HandReport::*member) {
  return [member](const SeenHand& hand) { return hand.report().*member; };
}
auto pose(Pose HandReport::*member) {
  return [member](const SeenHand& hand) { return matrixOf(hand.report().*member); };
}
auto sixNumbers(Wrench HandReport::*member) {
  return [member](const SeenHand& hand) { return (hand.report().*member).vector(); };
}
auto strings(StringVector HandReport::*member) {
  return
      [member](const py::object& self) { return vectorView(self.cast<SeenHand&>().report().*member, self); };
}

void defineHand(py::module_& m) {
  py::class_<SeenHand>(m, "Hand",
                       "One hand in the last tick of its loop, and the simulated device that it holds.")
      .def_property_readonly("X_BG", pose(&HandReport::X_BG), "measured grip in the device's base, 4 x 4")
      .def_property_readonly(
          "V_BG", [](const SeenHand& h) { return h.report().V_BG.vector(); },
          "twist of the grip, filtered, in the base: angular, linear")
      .def_property_readonly("X_WP", pose(&HandReport::X_WP), "where the hand wants the pointer, 4 x 4")
      .def_property_readonly("asked", sixNumbers(&HandReport::F_asked_B),
                             "wrench on the hand asked for, in the base: torque [N m], force [N]")
      .def_property_readonly("achieved", sixNumbers(&HandReport::F_achieved_B),
                             "what the tensions give, likewise")
      .def_property_readonly("tension", strings(&HandReport::tension), "per string [N], a view")
      .def_property_readonly("length", strings(&HandReport::length), "per string [m], a view")
      .def_property_readonly("pose_residual", field(&HandReport::pose_residual),
                             "rms of the length errors [m]")
      .def_property_readonly("port_energy", field(&HandReport::port_energy),
                             "absorbed at the port since the start [J]")
      .def_property_readonly("stiffness", field(&HandReport::stiffness),
                             "of what the pointer touches, at the grip, as the scene says [N/m]")
      .def_property_readonly("stiffness_share", field(&HandReport::stiffness_share),
                             "of it that the hand is given; below 1 where it could not bear all")
      .def_property_readonly("in_contact", field(&HandReport::in_contact), "the world pushes the pointer")
      .def_property_readonly("valid", field(&HandReport::valid), "calibrated, and the pose solved")
      .def_property_readonly("flags", field(&HandReport::device_flags),
                             "DeviceFlag of spidar/spidar.h; 0: nothing acted")
      .def_property_readonly(
          "state", [](const SeenHand& h) { return std::string(toString(h.device().state())); },
          "of the device")
      .def_property_readonly(
          "truth", [](const SeenHand& h) { return matrixOf(h.twin().latchedPose().X_BG); },
          "where the simulated grip was, 4 x 4")
      .def(
          "calibrate", [](const SeenHand& h) { h.device().calibrateAtHome(); }, "The grip is at home now.")
      .def(
          "enable_force", [](const SeenHand& h, bool on) { h.device().setForceEnabled(on); },
          py::arg("on") = true, "Tensions follow the wrench that is asked for, or rest at their minimum.")
      .def(
          "move_to",
          [](const SeenHand& h, const Matrix4& X_BG) {
            h.twin().setHandTarget({{poseOf(X_BG), 0}, true});
          },
          py::arg("X_BG"), "The simulated hand pulls the grip there from now on.")
      .def(
          "follow_path", [](const SeenHand& h) { h.twin().setHandTarget({}); },
          "The simulated hand follows the scene's script again.");
}

}  // namespace

TwinLoop::TwinLoop(const SceneDef& scene_def, const std::string& device, double rate, bool at_home)
    : scene(scene_def),
      period(1 / rate),
      world((scene.world.settings.step = 1 / rate, scene.world)),
      loop(world) {
  const DeviceDef def = loadDevice(findDevice(device));
  for (const HandDef& hand : scene.hands) {
    devices.push_back(std::make_unique<Spidar>(def));
    TwinSettings twin;
    twin.period = period;
    twin.path = hand.path;
    twins.push_back(std::make_unique<DeviceTwin>(def, twin));
    HandSettings settings;
    settings.workspace = hand.workspace;
    settings.force_scale = hand.force_scale;
    settings.delay = hand.delay;
    loop.attach(*devices.back(), hand.pointer, settings);
    if (!at_home) continue;
    devices.back()->calibrateAtHome();
    devices.back()->setForceEnabled(true);
  }
}

void TwinLoop::tick(int count) {
  checked("count", count, 0);
  for (int i = 0; i < count; ++i) {
    for (std::size_t h = 0; h < twins.size(); ++h)
      samples[h] = twins[h]->exchange(loop.drive(static_cast<int>(h)));
    loop.tick(samples.data(), period);
    if (i % kTicksPerLook == kTicksPerLook - 1) heedSignals();
  }
}

void bindLoop(py::module_& m) {
  defineHand(m);
  py::class_<TwinLoop, std::shared_ptr<TwinLoop>>(
      m, "Loop", "The haptic loop of a scene with a simulated device in each of its hands.")
      .def(py::init([](const py::object& scene, const std::string& device, double rate, bool at_home) {
             if (!(rate >= 10 && rate <= 1e5))
               throw SetupError("rate " + std::to_string(rate), "is no rate of ticks",
                                "give 10 to 100000 Hz");
             return std::make_shared<TwinLoop>(sceneFrom(scene, true), device, rate, at_home);
           }),
           py::arg("scene") = "touch_cube", py::arg("device") = "spidar_g6x3r", py::arg("rate") = 1000.0,
           py::arg("at_home") = true, "`at_home`: calibrate and switch the force on in the first tick.")
      .def("tick", &TwinLoop::tick, py::arg("count") = 1,
           "Counts in, tensions out, the world in between, `count` times.")
      .def_readonly("period", &TwinLoop::period, "[s]")
      .def_property_readonly(
          "time", [](const TwinLoop& l) { return l.world.time(); }, "simulated [s]")
      .def_property_readonly(
          "world",
          [](const std::shared_ptr<TwinLoop>& l) { return std::make_unique<SeenWorld>(l->world, l); },
          "the world between the hands, for reading and tuning")
      .def_property_readonly(
          "hands",
          [](const std::shared_ptr<TwinLoop>& l) {
            std::vector<SeenHand> hands;
            for (int i = 0; i < l->loop.handCount(); ++i) hands.push_back({l, i});
            return hands;
          },
          "one for each device of the scene")
      .def(
          "pause",
          [](TwinLoop& l, bool on) {
            l.loop.take({PauseWorld{on}, 0});
          },
          py::arg("on") = true, "The world stands, tensions rest at their minimum.")
      .def("__repr__", [](const TwinLoop& l) {
        return "<haptic.Loop of " + l.scene.world.name + " at " + std::to_string(l.world.time()) + " s>";
      });
}

}  // namespace haptic::python
