#include "haptic_core/analysis/certificate.h"
#include "python/bindings.h"
#include "scene/scene_extension.h"

namespace haptic::python {
namespace {

/// A scene's method is no setting any more; programs that name one go on, warned.
void setIntegrator(SceneDef&, const std::string& name) {
  if (name == "automatic") return;
  const std::string line = "integrator '" + name + "' is ignored: each island takes the cheapest step that errs by no more than accuracy";
  if (PyErr_WarnEx(PyExc_DeprecationWarning, line.c_str(), 1) != 0) throw py::error_already_set();
}

SceneDef load(const std::string& file_or_name, SceneOptions options, const std::string& missing, bool add_pointer) {
  options.missing = missingMeshesNamed(missing);
  options.add_pointer = add_pointer;
  options.words = {"default_density=1000", "missing_meshes='box' or 'skip'", "xacro=['name:=value']"};
  return loadScene(file_or_name, options);
}

void defineCertificate(py::module_& m) {
  py::class_<Certificate>(m, "Certificate", "Where a scene is stable, and with which steps velocity Verlet would be.")
      .def_readonly("step", &Certificate::step, "of the scene [s]")
      .def_readonly("settled", &Certificate::settled, "the scene came to rest before it was judged")
      .def_property_readonly(
          "verdict", [](const Certificate& c) { return std::string(toString(c.verdict)); },
          "worst of the islands")
      .def_property_readonly(
          "limits",
          [](const Certificate& c) {
            std::vector<double> limits;
            for (const IslandCertificate& island : c.islands) limits.push_back(island.limit);
            return limits;
          },
          "largest stable step of velocity Verlet of each island [s]")
      .def_property_readonly(
          "islands",
          [](const Certificate& c) {
            std::vector<std::vector<std::string>> links;
            for (const IslandCertificate& island : c.islands) links.push_back(island.links);
            return links;
          },
          "links of each island")
      .def("text", &Certificate::text, "for people: pairs, islands, verdicts");
  m.def(
      "certify",
      [](const py::object& scene, double settle) { return certify(sceneFrom(scene).world, checked("settle", settle, 0)); },
      py::arg("scene"), py::arg("settle") = 1.0,
      "Lets a copy of the world settle for `settle` [s] and says what is stable there.");
}

}  // namespace

void setNumbers(const char* name, const std::vector<double>& numbers, SceneDef& scene) {
  std::string text;
  for (const double number : numbers) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%s%.17g", text.empty() ? "" : " ", number);
    text += digits;
  }
  std::vector<std::string> warnings;
  setWorldSetting("scene " + scene.world.name, name, text, scene.world.settings, warnings);
}

SceneDef sceneFrom(const py::object& scene_or_name, bool add_pointer) {
  if (py::isinstance<SceneDef>(scene_or_name)) return scene_or_name.cast<SceneDef>();
  return load(py::str(scene_or_name), {}, "stop", add_pointer);  // a path of pathlib as well
}

void bindScene(py::module_& m) {
  py::class_<SceneDef>(
      m, "Scene",
      "A scene or robot as its file gives it. What is set here holds for worlds made of it afterwards.")
      .def(py::init([](const py::object& file, double density, const std::string& missing, const std::vector<std::string>& xacro,
                       bool add_pointer) {
             SceneOptions options;
             options.default_density = checked("default_density", density, 0);
             options.xacro = xacro;
             return load(py::str(file), options, missing, add_pointer);
           }),
           py::arg("file_or_name"), py::arg("default_density") = 0.0, py::arg("missing_meshes") = "stop",
           py::arg("xacro") = std::vector<std::string>(), py::arg("add_pointer") = false,
           "Loads a URDF, an xacro file, a YAML list, or a scene by its name. `default_density` [kg/m³]: of moving links "
           "without inertia. `missing_meshes`: of collisions, \"stop\", \"box\" or \"skip\". `xacro`: arguments, \"name:=value\". "
           "`add_pointer`: a ball of 10 mm for the hand of a Loop, where the scene names none.")
      .def_readonly("file", &SceneDef::file, "absolute path")
      .def_property_readonly(
          "name", [](const SceneDef& s) { return s.world.name; }, "of the robot or list")
      .def_readonly("notes", &SceneDef::notes, "what a user should know, one line each")
      .def_readonly("warnings", &SceneDef::warnings, "what a user should mend, one line each")
      .def_readonly("replaced", &SceneDef::replaced, "parts that could not be as the files have them, and what stands in their place")
      .def_property_readonly(
          "devices",
          [](const SceneDef& s) {
            std::vector<std::string> names;
            for (const HandDef& hand : s.hands) names.push_back(hand.device);
            return names;
          },
          "names of the devices that move its pointers")
      .def_property(
          "step", [](const SceneDef& s) { return s.world.settings.step; },
          [](SceneDef& s, double h) { setNumbers("step", {h}, s); }, "h [s]")
      .def_property(
          "far_step", [](const SceneDef& s) { return s.world.settings.far_step; },
          [](SceneDef& s, double h) { setNumbers("far_step", {h}, s); },
          "step of islands that no hand touches or can reach before their next one [s]; 0: all are stepped by `step`")
      .def_property(
          "gravity", [](const SceneDef& s) { return s.world.settings.gravity; },
          [](SceneDef& s, const Vector3& g) { setNumbers("gravity", {g.x(), g.y(), g.z()}, s); }, "in W [m/s²]")
      .def_property(
          "accuracy", [](const SceneDef& s) { return s.world.settings.accuracy; },
          [](SceneDef& s, double share) { setNumbers("accuracy", {share}, s); },
          "error of position that a step may add, over the way that gravity and its change of speed move a body in it")
      .def_property(
          "integrator", [](const SceneDef&) { return "automatic"; }, &setIntegrator, "no setting any more: see accuracy")
      .def("text", &sceneText, "models, links, joints, collisions with their contact values and sources")
      .def("__repr__",
           [](const SceneDef& s) { return "<haptic.Scene " + s.world.name + " from " + s.file + ">"; });
  defineCertificate(m);
}

}  // namespace haptic::python
