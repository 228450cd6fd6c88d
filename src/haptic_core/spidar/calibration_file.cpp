#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iomanip>

#include "haptic_core/base/error.h"
#include "haptic_core/spidar/calibration.h"

namespace haptic {

void saveCalibration(const Calibration& calibration, const std::string& path) {
  std::ofstream out(path);
  out << std::setprecision(17);
  out << "device: \"" << calibration.device << "\"\n"
      << "time: \"" << calibration.time << "\"\n"
      << "residual: " << calibration.residual << "  # rms of the length errors [m]\n"
      << "exit_sigma: " << calibration.exit_sigma
      << "  # largest standard deviation, rigid motions removed [m]\n"
      << "samples: " << calibration.samples << "\n"
      << "strings:  # exit in REP-103 axes [m], length at count 0 [m] (valid until the counters are reset)\n";
  for (std::size_t i = 0; i < calibration.p_BE.size(); ++i) {
    const Vector3& p = calibration.p_BE[i];
    out << "- {exit: [" << p.x() << ", " << p.y() << ", " << p.z()
        << "], zero_length: " << calibration.zero_length[i] << "}\n";
  }
  out.flush();
  if (!out) throw SetupError(path, "cannot be written", "check the folder and its permissions");
}

Calibration loadCalibration(const DeviceDef& def, const std::string& path) {
  Calibration calibration;
  try {
    const YAML::Node root = YAML::LoadFile(path);
    calibration.device = root["device"].as<std::string>();
    calibration.time = root["time"].as<std::string>();
    calibration.residual = root["residual"].as<double>();
    calibration.exit_sigma = root["exit_sigma"].as<double>();
    calibration.samples = root["samples"].as<int>();
    const YAML::Node strings = root["strings"];
    calibration.zero_length.resize(std::min<int>(kMaxStrings, static_cast<int>(strings.size())));
    for (int i = 0; i < calibration.zero_length.size(); ++i) {
      const auto exit = strings[i]["exit"].as<std::vector<double>>();
      calibration.p_BE.emplace_back(exit.at(0), exit.at(1), exit.at(2));
      calibration.zero_length[i] = strings[i]["zero_length"].as<double>();
    }
  } catch (const std::exception& e) {
    throw SetupError(path, std::string("is no calibration file (") + e.what() + ")",
                     "calibrate again, or remove it");
  }
  if (calibration.device != def.name || calibration.p_BE.size() != def.strings.size())
    throw SetupError(path, "belongs to " + calibration.device + ", not to " + def.name,
                     "calibrate this device");
  calibration.converged = true;
  return calibration;
}

}  // namespace haptic
