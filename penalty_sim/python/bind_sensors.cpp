#include "haptic_core/world/contact_detail.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/work.h"
#include "python/bindings.h"

namespace haptic::python {
namespace {

/// SensorReading as NumPy sees it.
py::dtype readingType() {
  static const SensorReading sample;
  py::list names, formats, offsets;
  const auto field = [&](const char* name, const char* format, const void* place) {
    names.append(name), formats.append(format);
    offsets.append(static_cast<const char*>(place) - reinterpret_cast<const char*>(&sample));
  };
  field("step", "u8", &sample.step);
  field("torque", "(3,)f8", sample.F_S.torque.data()), field("force", "(3,)f8", sample.F_S.force.data());
  field("orientation", "(4,)f8", sample.q_WS.coeffs().data());  // x, y, z, w, as Eigen keeps it and ROS has it
  field("angular_rate", "(3,)f8", sample.omega_S.data());
  field("specific_force", "(3,)f8", sample.specific_force_S.data());
  py::dict type;
  type["names"] = names, type["formats"] = formats, type["offsets"] = offsets, type["itemsize"] = sizeof(SensorReading);
  return py::dtype::from_args(type);
}

py::array readings(const py::object& self) {
  World& world = self.cast<SeenWorld&>().world();
  static const py::dtype& type = *new py::dtype(readingType());  // never destroyed: at exit there is no interpreter to do it
  if (world.sensorCount() == 0) return py::array(type, std::vector<py::ssize_t>{0});
  return view(type, {world.sensorCount()}, {sizeof(SensorReading)}, &world.sensorReading(0), self);
}

/// An array of a vector for each of the last step's contacts.
template <class VectorOf>
py::array_t<double> perContact(const World& world, VectorOf vectorOf) {
  py::array_t<double> rows({static_cast<py::ssize_t>(world.contactCount()), static_cast<py::ssize_t>(3)});
  for (int i = 0; i < world.contactCount(); ++i) Eigen::Map<Vector3>(rows.mutable_data(i)) = vectorOf(world.contact(i));
  return rows;
}

template <class NumberOf>
py::array_t<double> perJoint(const World& world, NumberOf numberOf) {
  py::array_t<double> numbers(static_cast<py::ssize_t>(world.jointCount()));
  for (int i = 0; i < world.jointCount(); ++i) numbers.mutable_at(i) = numberOf(world.joint(i));
  return numbers;
}

/// Corners x 3.
py::array_t<double> patch(SeenWorld& seen, int i) {
  const World& world = seen.world();
  if (i < 0 || i >= world.contactCount()) {
    throw SetupError("contact " + std::to_string(i), "is not in this step", "it has " + std::to_string(world.contactCount()));
  }
  const ContactReport& contact = world.contact(i);
  const std::vector<Vector3>& corners = seen.outline().of(contact, world.linkPose(contact.link_a), world.linkPose(contact.link_b));
  py::array_t<double> rows({static_cast<py::ssize_t>(corners.size()), static_cast<py::ssize_t>(3)});
  for (std::size_t c = 0; c < corners.size(); ++c) Eigen::Map<Vector3>(rows.mutable_data(static_cast<py::ssize_t>(c))) = corners[c];
  return rows;
}

}  // namespace

PatchOutline& SeenWorld::outline() {
  if (!outline_) outline_ = std::make_unique<PatchOutline>(world_->model());
  return *outline_;
}

void defineSensors(py::class_<SeenWorld>& world) {
  world
      .def_property_readonly(
          "sensors",
          [](SeenWorld& w) {
            std::vector<std::string> names;
            for (int i = 0; i < w.world().sensorCount(); ++i) names.push_back(w.world().sensor(i).name);
            return names;
          },
          "names of the scene's <haptic:sensor>, in the order of `readings`")
      .def_property_readonly("readings", &readings,
                             "last sample of each sensor, a view with fields step (0: none yet), torque [N m] and force [N] on the "
                             "child or link about the sensor's frame, orientation (x, y, z, w), angular_rate [rad/s], specific_force "
                             "[m/s²]; in the sensor's axes. What a sensor does not measure is NaN.")
      .def_property_readonly(
          "centres_of_pressure",
          [](SeenWorld& w) { return perContact(w.world(), [](const ContactReport& c) { return centreOfPressure(c); }); },
          "of `contacts`, contacts x 3 [m], in W")
      .def_property_readonly(
          "slips",
          [](SeenWorld& w) {
            const World& world = w.world();
            const LinkWork* link = world.work().placement.link.data();
            return perContact(world, [&](const ContactReport& c) { return slipOf(world.model(), c, link); });
          },
          "velocity of b's surface on a's along the patch at the centre of pressure, contacts x 3 [m/s], in W")
      .def("patch", &patch, py::arg("contact"),
           "Outline of a contact's patch, corners x 3 [m] in W, counter-clockwise about the normal; 32 corners of an ellipse where a "
           "shape is round.")
      .def_property_readonly(
          "joint_efforts", [](SeenWorld& w) { return perJoint(w.world(), [](const JointReading& j) { return j.effort; }); },
          "of `joints`: drive, spring, damping, friction and limits together in the last step [N m or N]")
      .def_property_readonly(
          "drive_efforts", [](SeenWorld& w) { return perJoint(w.world(), [](const JointReading& j) { return j.drive; }); },
          "of `joints`: of the drives alone [N m or N]");
}

}  // namespace haptic::python
