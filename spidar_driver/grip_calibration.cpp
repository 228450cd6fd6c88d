#include "spidar_driver/grip_calibration.h"

#include <ros/console.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/realtime.h"
#include "spidar_driver/device_answer.h"

namespace haptic {
namespace {

// A hand moves 10 mm between two samples of a fast wave; denser ones say nothing new and only cost time.
constexpr std::int64_t kSamplePeriodNs = 10000000;

std::string now() {
  const std::time_t time = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&time, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f mm", 1e3 * metres);
  return text;
}

}  // namespace

DeviceDef withSavedCalibration(const DriverParameters& parameters, const DeviceDef& def, StringVector& zero_length) {
  if (parameters.calibration_file.empty() || !std::ifstream(parameters.calibration_file)) return def;
  const Calibration saved = loadCalibration(def, parameters.calibration_file);
  if (parameters.restore_calibration) zero_length = saved.zero_length;
  ROS_INFO_STREAM(def.name << ": exits of " << parameters.calibration_file << " (" << saved.time << ", residual "
                           << millimetres(saved.residual) << ")");
  return saved.applied(def);
}

GripCalibration::GripCalibration(ros::NodeHandle& priv, const DriverParameters& parameters, const DeviceDef& def,
                                 DevicePort& port, PortOffer& offer)
    : parameters_(parameters), def_(def), port_(port), offer_(offer) {
  calibrate_ = priv.advertiseService("calibrate", &GripCalibration::onCalibrate, this);
  calibrate_wave_ = priv.advertiseService("calibrate_wave", &GripCalibration::onWave, this);
}

GripCalibration::~GripCalibration() {
  calibrate_.shutdown();
  calibrate_wave_.shutdown();
  if (solver_.joinable()) solver_.join();
}

/// Empty: nothing is under way.
std::string GripCalibration::whyNotNow() const {
  return wave_ != Wave::kIdle ? "a wave is being recorded or solved: wait for it" : "";
}

bool GripCalibration::onCalibrate(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.message = whyNotNow();
  if (!response.message.empty()) return true;
  const DeviceAnswer answer = askDevice(port_, offer_, {true, false, -1, parameters_.jig_pose});
  response.success = answer.done && answer.after.record.calibrated && !(answer.after.record.flags & kCalibrationRefused);
  response.message = (response.success ? "calibrated; " : "") + answer.message;
  if (!response.success) return true;
  Calibration calibration = answer.after.calibration;
  calibration.samples = 1;
  try {
    keep(calibration);
  } catch (const SetupError& error) {
    response.message = std::string("calibrated, but not saved: ") + error.what();
  }
  return true;
}

bool GripCalibration::onWave(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.message = whyNotNow();
  if (!response.message.empty()) return true;
  if (static_cast<int>(def_.strings.size()) <= def_.dof) {
    response.message = def_.name + " has no redundant string: only ~calibrate is possible";
    return true;
  }
  DeviceCopy now;
  if (!offer_.send(port_, DevicePort::Copy{&now}) || !now.record.calibrated || offer_.holder().empty()) {
    response.message = "hold the grip at home and call ~calibrate first: the wave refines that";
    return true;
  }
  if (solver_.joinable()) solver_.join();
  start_zero_ = now.calibration.zero_length;
  wanted_samples_ = static_cast<std::size_t>(parameters_.wave_seconds * 1e9 / kSamplePeriodNs);
  samples_.clear();
  samples_.reserve(wanted_samples_);
  next_sample_ns_ = 0;
  wave_ = Wave::kRecording;
  response.success = true;
  char text[96];
  std::snprintf(text, sizeof text, "wave the grip through its whole workspace for %.0f s, turning it",
                parameters_.wave_seconds);
  response.message = text;
  setNote(text);
  return true;
}

void GripCalibration::see(const DeviceRecord& record) {
  if (wave_ != Wave::kRecording) return;
  const bool usable = record.pose_valid && bringsCounts(record.sample.status);
  if (!usable || record.stamp_ns < next_sample_ns_) return;
  next_sample_ns_ = record.stamp_ns + kSamplePeriodNs;
  CalibrationSample sample;
  sample.counts = record.sample.counts;
  sample.guess = {record.X_BG, record.opening};
  samples_.push_back(sample);
  if (samples_.size() < wanted_samples_) return;
  wave_ = Wave::kSolving;
  setNote("the wave is recorded; solving");
  solver_ = std::thread([this] { solveWave(); });
}

void GripCalibration::solveWave() {
  try {
    Calibration calibration = calibrateFromWave(def_, start_zero_, samples_);
    if (!calibration.converged) throw SetupError("the wave", "did not converge", "wave more slowly, and turn the grip");
    const LoopCommand adopt{adoptionOf(calibration)};
    if (!offer_.send(port_, Tell{&adopt})) throw SetupError("the wave", "was solved, but nobody took it up", "call ~calibrate_wave again");
    keep(calibration);
    setNote("calibrated from a wave of " + std::to_string(calibration.samples) + " samples: residual " +
            millimetres(calibration.residual) + ", exits to " + millimetres(calibration.exit_sigma));
  } catch (const SetupError& error) {
    setNote(error.what());
  }
  ROS_INFO_STREAM(def_.name << ": " << note());
  wave_ = Wave::kIdle;
}

void GripCalibration::keep(Calibration calibration) {
  if (parameters_.calibration_file.empty()) return;
  calibration.device = def_.name;
  calibration.time = now();
  saveCalibration(calibration, parameters_.calibration_file);
}

std::string GripCalibration::note() const {
  const std::lock_guard<std::mutex> lock(note_mutex_);
  return note_;
}

void GripCalibration::setNote(const std::string& note) {
  const std::lock_guard<std::mutex> lock(note_mutex_);
  note_ = note;
}

}  // namespace haptic
