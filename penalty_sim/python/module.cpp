#include "haptic_core/base/build_info.h"
#include "python/bindings.h"

PYBIND11_MODULE(_haptic, m) {
  namespace py = pybind11;
  m.doc() = "The compiled part of the package haptic.";
  py::register_exception<haptic::SetupError>(m, "SetupError", PyExc_ValueError).doc() =
      "What cannot be done: one line that says what, where, and what to do.";
  const std::string version = haptic::programVersion();
  m.attr("__version__") = version.substr(version.find(' ') + 1);
  haptic::python::bindScene(m);
  haptic::python::bindWorld(m);
  haptic::python::bindDevice(m);
  haptic::python::bindLoop(m);
}
