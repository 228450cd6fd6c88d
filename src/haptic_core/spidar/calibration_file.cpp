#include <iomanip>
#include <sstream>

#include "haptic_core/base/whole_file.h"
#include "haptic_core/base/yaml_map.h"
#include "haptic_core/spidar/calibration.h"

namespace haptic {
namespace {

constexpr double kFarthestExit = 100;  // from the origin [m], as in a device's file
constexpr double kLongestReel = 1e6;   // [m] 32-bit counters of the coarsest encoder do not reach it
constexpr double kMostSamples = 1e9;   // [1] a wave of a hundred days

}  // namespace

void saveCalibration(const Calibration& calibration, const std::string& path) {
  std::ostringstream out;
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
  writeWholeFile(path, out.str());
}

Calibration loadCalibration(const DeviceDef& def, const std::string& path) {
  const YamlMap map(path, loadYaml(path), "calibration", {"device", "time", "residual", "exit_sigma", "samples", "strings"});
  for (const char* key : {"device", "time", "residual", "exit_sigma", "samples", "strings"}) {
    map.require(key, "calibration's; or calibrate again, or remove the file");
  }
  Calibration calibration;
  calibration.device = map.text("device");
  calibration.time = map.text("time");
  calibration.residual = map.number("residual", 0, 0, kFarthestExit);
  calibration.exit_sigma = map.number("exit_sigma", 0, 0, kFarthestExit);
  calibration.samples = static_cast<int>(map.number("samples", 0, 0, kMostSamples));
  const YAML::Node strings = map["strings"];
  if (!strings.IsSequence() || strings.size() > kMaxStrings) {
    throw SetupError(map.where("strings"), "is no list of strings", "calibrate again, or remove the file");
  }
  calibration.zero_length.resize(static_cast<int>(strings.size()));
  for (int i = 0; i < calibration.zero_length.size(); ++i) {
    const YamlMap string(path, strings[i], "strings[" + std::to_string(i) + "]", {"exit", "zero_length"});
    string.require("exit", "string's exit [m]");
    string.require("zero_length", "string's length at count 0 [m]");
    calibration.p_BE.push_back(string.vector("exit", kFarthestExit));
    calibration.zero_length[i] = string.number("zero_length", 0, -kLongestReel, kLongestReel);
  }
  if (calibration.device != def.name || calibration.p_BE.size() != def.strings.size())
    throw SetupError(path, "belongs to " + calibration.device + ", not to " + def.name,
                     "calibrate this device");
  calibration.converged = true;
  return calibration;
}

}  // namespace haptic
