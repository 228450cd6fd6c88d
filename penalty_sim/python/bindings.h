/// What the parts of the Python module share: views of the simulator's memory, and the objects that own it.
#pragma once
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/contact_detail.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"
#include "scene/scene_file.h"

namespace haptic::python {

namespace py = pybind11;
using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

inline Matrix4 matrixOf(const Pose& X) {
  Matrix4 m = Matrix4::Identity();
  m.topLeftCorner<3, 3>() = X.R;
  m.topRightCorner<3, 1>() = X.p;
  return m;
}
Pose poseOf(const Matrix4& m);  ///< throws SetupError when it is no rotation and position

/// Throws SetupError that names `what` where a number of Python is not finite or below `least`.
void checkNumbers(const std::string& what, const double* numbers, py::ssize_t count,
                  double least = -std::numeric_limits<double>::infinity());
/// The number itself, checked.
inline double checked(const char* what, double number, double least = -std::numeric_limits<double>::infinity()) {
  checkNumbers(what, &number, 1, least);
  return number;
}
/// The vector itself, checked.
template <class Vector>
const Vector& checked(const char* what, const Eigen::PlainObjectBase<Vector>& numbers) {
  checkNumbers(what, numbers.data(), numbers.size());
  return numbers.derived();
}
/// The twist of six numbers, angular first.
inline Twist twistOf(const char* what, const Vector6& V) { return {checked(what, V).head<3>(), V.tail<3>()}; }
/// A setting of a scene by its name in files, within the same bounds.
void setNumbers(const char* name, const std::vector<double>& numbers, SceneDef& scene);

/// View of memory that `owner` keeps alive. Strides in bytes.
inline py::array view(py::dtype type, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
                      const void* data, py::handle owner, bool writable = false) {
  py::array array(std::move(type), std::move(shape), std::move(strides), data, owner);
  if (!writable) array.attr("setflags")(py::arg("write") = false);
  return array;
}
inline py::array vectorView(const double* data, py::ssize_t size, py::handle owner, bool writable = false) {
  return view(py::dtype::of<double>(), {size}, {sizeof(double)}, data, owner, writable);
}
template <class Vector>
py::array vectorView(const Vector& v, py::handle owner) {
  return vectorView(v.data(), v.size(), owner);
}

/// Throws KeyboardInterrupt's exception when the user has pressed Ctrl-C.
inline void heedSignals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

/// A world that Python sees. Its q and v are written in place; whoever reads or steps calls `takeWritten`
/// first.
class SeenWorld {
 public:
  explicit SeenWorld(const SceneDef& scene);
  SeenWorld(World& world, std::shared_ptr<void> owner);

  World& world() { return *world_; }
  int link(const std::string& name) const;   ///< throws SetupError that lists the names
  int joint(const std::string& name) const;  ///< likewise
  double* q() { return const_cast<double*>(world_->state().q.data()); }  // the state itself is not const
  double* v() { return const_cast<double*>(world_->state().v.data()); }

  /// Poses, boxes and memories follow what Python wrote into q and v since the last step. Costs a comparison.
  void takeWritten();
  void step(int count);
  void remember();  ///< q and v as they are now
  PatchOutline& outline();  ///< made when it is first asked for

 private:
  std::unique_ptr<World> own_;
  std::shared_ptr<void> owner_;
  World* world_;
  std::vector<double> seen_q_, seen_v_;
  std::unique_ptr<PatchOutline> outline_;
};

/// Sensors, and what contacts and joints say beside their numbers.
void defineSensors(py::class_<SeenWorld>& world);

/// A scene's hands on simulated devices, and the loop between them.
struct TwinLoop {
  TwinLoop(const SceneDef& scene, const std::string& device, double rate, bool at_home);
  void tick(int count);

  SceneDef scene;
  double period;
  World world;
  std::vector<std::unique_ptr<Spidar>> devices;
  std::vector<std::unique_ptr<DeviceTwin>> twins;
  HapticLoop loop;
  std::array<DeviceSample, kMaxHands> samples;
};

/// Path of a device file: a path, or a name below haptic_description/devices. Throws SetupError.
std::string findDevice(const std::string& file_or_name);
/// A Scene, or what `loadScene` takes.
SceneDef sceneFrom(const py::object& scene_or_name, bool add_pointer = false);

void bindScene(py::module_& m);
void bindWorld(py::module_& m);
void bindDevice(py::module_& m);
void bindLoop(py::module_& m);

}  // namespace haptic::python
