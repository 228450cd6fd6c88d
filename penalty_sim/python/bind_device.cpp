#include <algorithm>
#include <filesystem>

#include "python/bindings.h"
#include "scene/resource_path.h"

namespace haptic::python {
namespace {

GripPose gripAt(const Matrix4& X_BG, double opening) { return {poseOf(X_BG), checked("opening", opening)}; }

/// Kinematics and tensions of one device, without its counts and states.
class Device {
 public:
  explicit Device(const std::string& file)
      : def(loadDevice(findDevice(file))), kinematics(def), distribution(def, kinematics) {}

  StringVector checkedLengths(const Eigen::VectorXd& lengths) const {
    if (lengths.size() != kinematics.strings()) {
      throw SetupError(
          "device " + def.name,
          "has " + std::to_string(kinematics.strings()) + " strings, not " + std::to_string(lengths.size()),
          "give one length for each");
    }
    checkNumbers("lengths", lengths.data(), lengths.size(), 0);
    return lengths;
  }
  TensionReport tensions(const Vector3& force, const Vector3& torque, const Matrix4& X_BG, double opening,
                         double grasp) {
    checked("force", force), checked("torque", torque);
    distribution.forgetActiveSet();  // the same question, the same bits, whatever was asked before
    distribution.setStructure(kinematics.scaledStructure(gripAt(X_BG, opening)));
    return distribution.present({torque, force}, checked("grasp_force", grasp));
  }

  DeviceDef def;
  StringKinematics kinematics;
  TensionDistribution distribution;
};

Eigen::MatrixXd table(const DeviceDef& def, Vector3 StringDef::*point) {
  Eigen::MatrixXd rows(def.strings.size(), 3);
  for (std::size_t i = 0; i < def.strings.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = (def.strings[i].*point).transpose();
  return rows;
}

/// Names of the shipped device files; empty: their package is not found.
std::string knownDevices() {
  namespace fs = std::filesystem;
  const std::string package = resolveResource("package://haptic_description/package.xml", "");
  const fs::path folder = fs::path(package).parent_path() / "devices";
  std::vector<std::string> names;
  if (package.empty() || !fs::is_directory(folder)) return "";
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
  return known;
}

void defineSolutions(py::module_& m) {
  py::class_<PoseSolution>(m, "PoseSolution", "The pose whose string lengths fit best.")
      .def_property_readonly(
          "X_BG", [](const PoseSolution& s) { return matrixOf(s.pose.X_BG); }, "grip in the base, 4 x 4")
      .def_property_readonly(
          "opening", [](const PoseSolution& s) { return s.pose.opening; }, "[m]")
      .def_property_readonly(
          "length_error",
          [](const py::object& self) { return vectorView(self.cast<PoseSolution&>().length_error, self); },
          "of the solution less measured, per string [m]")
      .def_readonly("residual", &PoseSolution::residual, "rms of length_error [m]")
      .def_readonly("iterations", &PoseSolution::iterations, "linearisations")
      .def_property_readonly(
          "converged", [](const PoseSolution& s) { return s.status == PoseStatus::kConverged; },
          "the next step would be rounding");
  py::class_<TensionReport>(m, "TensionReport", "String tensions, and the wrench that they present.")
      .def_property_readonly(
          "tension",
          [](const py::object& self) { return vectorView(self.cast<TensionReport&>().tension, self); }, "[N]")
      .def_property_readonly(
          "force", [](const TensionReport& r) { return r.F_G_B.force; }, "presented, in the base [N]")
      .def_property_readonly(
          "torque", [](const TensionReport& r) { return r.F_G_B.torque; },
          "about the grip's origin, in the base [N m]")
      .def_readonly("grasp_force", &TensionReport::grasp_force, "along the opening [N]")
      .def_readonly("error", &TensionReport::error,
                    "distance to the wrench asked for, torque over the knots' radius [N]")
      .def_readonly("kkt_residual", &TensionReport::kkt_residual,
                    "violation of the optimality conditions [1]")
      .def_property_readonly(
          "solved", [](const TensionReport& r) { return r.status == TensionStatus::kSolved; },
          "exactly; the tensions are within their bounds in any case");
}

}  // namespace

std::string findDevice(const std::string& file_or_name) {
  namespace fs = std::filesystem;
  if (fs::exists(file_or_name) || file_or_name.find('/') != std::string::npos) return file_or_name;
  const std::string file =
      resolveResource("package://haptic_description/devices/" + file_or_name + ".yaml", "");
  if (!file.empty()) return file;
  const std::string known = knownDevices();
  throw SetupError("device '" + file_or_name + "'", "is unknown",
                   known.empty() ? "give the path of its file, or source devel/setup.sh first"
                                 : "give a path, or one of: " + known);
}

void bindDevice(py::module_& m) {
  defineSolutions(m);
  py::class_<Device>(
      m, "Device",
      "Geometry of a string device: lengths from poses, poses from lengths, tensions for wrenches.")
      .def(py::init([](const py::object& file) { return std::make_unique<Device>(py::str(file)); }),
           py::arg("file_or_name") = "spidar_g6x3r")
      .def_property_readonly(
          "name", [](const Device& d) { return d.def.name; }, "model, as its file gives it")
      .def_property_readonly(
          "strings", [](const Device& d) { return d.kinematics.strings(); }, "how many it has")
      .def_property_readonly(
          "dof", [](const Device& d) { return d.kinematics.dof(); },
          "3: point grip; 6: rigid; 7: with one opening")
      .def_property_readonly(
          "exits", [](const Device& d) { return table(d.def, &StringDef::p_BE); },
          "strings x 3, in the base [m]")
      .def_property_readonly(
          "knots", [](const Device& d) { return table(d.def, &StringDef::p_GK); },
          "strings x 3, in the grip [m]")
      .def_property_readonly(
          "max_force", [](const Device& d) { return d.def.max_force; }, "[N]")
      .def_property_readonly(
          "max_torque", [](const Device& d) { return d.def.max_torque; }, "[N m]")
      .def(
          "lengths",
          [](const Device& d, const Matrix4& X_BG, double opening) {
            return Eigen::VectorXd(d.kinematics.lengths(gripAt(X_BG, opening)));
          },
          py::arg("X_BG") = Matrix4(Matrix4::Identity()), py::arg("opening") = 0.0,
          "Of the strings at a pose [m].")
      .def(
          "structure",
          [](const Device& d, const Matrix4& X_BG, double opening) {
            return Eigen::MatrixXd(d.kinematics.structure(gripAt(X_BG, opening)));
          },
          py::arg("X_BG") = Matrix4(Matrix4::Identity()), py::arg("opening") = 0.0,
          "A, strings x dof: force and torque on the grip = A.T @ tensions; columns force, torque, opening.")
      .def(
          "solve_pose",
          [](const Device& d, const Eigen::VectorXd& lengths, const Matrix4& guess, double opening) {
            return d.kinematics.solvePose(d.checkedLengths(lengths), gripAt(guess, opening));
          },
          py::arg("lengths"), py::arg("guess") = Matrix4(Matrix4::Identity()), py::arg("opening") = 0.0,
          "The pose that fits the lengths [m] best.")
      .def("tensions", &Device::tensions, py::arg("force"), py::arg("torque") = Vector3(Vector3::Zero()),
           py::arg("X_BG") = Matrix4(Matrix4::Identity()), py::arg("opening") = 0.0,
           py::arg("grasp_force") = 0.0,
           "Tensions that present a force [N] and torque [N m] on the hand, in the base.")
      .def("__repr__", [](const Device& d) {
        return "<haptic.Device " + d.def.name + ", " + std::to_string(d.kinematics.strings()) + " strings>";
      });
}

}  // namespace haptic::python
