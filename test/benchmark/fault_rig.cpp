#include "fault_rig.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>

#include "haptic_core/base/error.h"

namespace haptic::bench {
namespace {

constexpr double kVoltPerDigit = 3.3 / 4096;
constexpr int kSettleTicks = 400;    // hand home and at rest: 0.4 s, ten of its time constants
constexpr int kBringUpTicks = 2500;  // to become enabled, with the ramp of 0.5 s and boards that are taught anew
constexpr unsigned kAlarms = kSampleStale | kLinkLost | kEncoderJump | kResidualHigh | kCommandNotFinite | kAnswersLost |
                             kDelayTooLong | kCounterRestarted | kPoseNotConverged | kCountRefused | kStringCorrected | kCountersStill;
constexpr std::size_t kTruths = 200;  // instants that are remembered: 0.2 s

}  // namespace

FaultRig::FaultRig(const DeviceDef& def) : device(def), plant(def, {}), bus(plant), line(bus), spidar(def) {
  int id = 1;
  for (const std::string& model : device.boards) bus.addBoard(model, id++);
  UartSettings settings;
  settings.reopen_s = 0.001;
  driver = std::make_unique<UartBoards>(device, settings, "memory", [this] {
    if (!line.plugged) throw SetupError("memory", "unplugged", "plug it in");
    return std::make_unique<MemoryLink>(line);
  });
  start_ns_ = line.now_ns;
}

void FaultRig::tick() {
  line.now_ns = std::max(line.now_ns, start_ns_ + ++ticks_ * static_cast<std::int64_t>(kPeriod * 1e9));
  plant.advance(line.now_ns);
  truth_.push_back({line.now_ns, plant.twin().pose().X_BG.p});
  if (truth_.size() > kTruths) truth_.pop_front();
  sample = driver->exchange(spidar.drive());
  spidar.sense(sample, kPeriod);
  measure();
  spidar.actuate(command, 0, kPeriod, command_age);
  tell();
  checkBounds();
  const LinkReport r = driver->linkReport();
  const std::uint64_t disturbances =
      r.lost + r.doubled + r.foreign_bytes + r.refused_counts + r.restarts + r.bad_commands + r.retaught;
  alarmed_ = sample.status != LinkStatus::kOk || (spidar.flags() & kAlarms) || disturbances != disturbances_ ||
             sample.age_ticks > 0 || seriouslyAlarmed();
  disturbances_ = disturbances;
}

bool FaultRig::seriouslyAlarmed() const {
  return spidar.state() == DeviceState::kReduced || spidar.state() == DeviceState::kFault;
}

void FaultRig::run(int ticks) {
  for (int k = 0; k < ticks; ++k) tick();
}

void FaultRig::order(const std::string& text) {
  bool stop = false;
  if (text == "unplug" || text == "plug") {
    line.plugged = text == "plug";
    if (!line.plugged) bus.clearLine();
    return;
  }
  const std::string error = carryOut(text, bus, plant, nullptr, stop);
  if (!error.empty()) std::fprintf(stderr, "order %s: %s\n", text.c_str(), error.c_str());
}

/// More than the least tension on some string.
bool FaultRig::pulls() const {
  for (std::size_t i = 0; i < device.strings.size(); ++i) {
    const StringDef& s = device.strings[i];
    const double digit = kVoltPerDigit / std::abs(s.volt_per_newton);
    if (plant.command().voltage[i] / s.volt_per_newton > s.min_tension + digit) return true;
  }
  return false;
}

Vector3 FaultRig::truthAt(std::int64_t at_ns) const {
  for (std::size_t i = truth_.size(); i-- > 1;) {
    const Truth &a = truth_[i - 1], &b = truth_[i];
    if (at_ns < a.at_ns) continue;
    const double share = static_cast<double>(at_ns - a.at_ns) / static_cast<double>(b.at_ns - a.at_ns);
    return a.p + std::min(share, 1.0) * (b.p - a.p);
  }
  return truth_.front().p;
}

double FaultRig::poseError() const {
  return (spidar.pose().p - truthAt(spidar.poseStamp())).norm();
}

void FaultRig::startMeasuring() {
  effect_ = FaultEffect{};
  work_ = 0;
}

void FaultRig::tell() {
  told_[2] = told_[1], told_[1] = told_[0];
  const StructureMatrix A = spidar.kinematics().structure({spidar.pose(), spidar.opening()});
  int channel = 0, board = 0;
  for (const auto& b : bus.boards()) {
    Vector3& force = told_[0][static_cast<std::size_t>(board++)];
    force.setZero();
    for (int m = 0; m < b->shape().motors && channel < spidar.kinematics().strings(); ++m, ++channel)
      force += A.row(channel).head<3>().transpose() * spidar.toldTension()[channel];
  }
}

/// The command on the wire is the last tick's; while it takes over, the one before acts, board by board.
Vector3 FaultRig::forceError() const {
  const std::size_t boards = bus.boards().size();
  const Vector3 force = plant.twin().stringWrench().force;
  Vector3 least = Vector3::Constant(1e9);
  int choices = 1;
  for (std::size_t b = 0; b < boards; ++b) choices *= static_cast<int>(told_.size());
  for (int choice = 0; choice < choices; ++choice) {
    Vector3 error = force;
    int rest = choice;
    for (std::size_t b = 0; b < boards; ++b, rest /= static_cast<int>(told_.size()))
      error -= told_[static_cast<std::size_t>(rest) % told_.size()][b];
    if (error.norm() < least.norm()) least = error;
  }
  return least;
}

void FaultRig::measure() {
  if (spidar.poseValid() && spidar.poseIsNew()) effect_.pose_error = std::max(effect_.pose_error, poseError());
  if (spidar.poseStamp() > line.now_ns) effect_.wrong_stamp = true;
  const Vector3 error = forceError();
  effect_.force_error = std::max(effect_.force_error, error.norm());
  work_ += error.dot(plant.twin().twist().linear) * kPeriod;
  effect_.energy = std::max(effect_.energy, work_);
  if (pulls())
    effect_.stale_force = std::max(effect_.stale_force, 1e-9 * static_cast<double>(line.now_ns - spidar.poseStamp()));
}

/// What the boards drive: all zero, or each string between its tensions; digits are cut towards zero, so one
/// digit below the least tension is that tension.
void FaultRig::checkBounds() {
  if (boards_may_misread || bus.allCurrentsZero()) return;
  int channel = 0;
  for (const auto& b : bus.boards())
    for (int m = 0; m < b->shape().motors && channel < static_cast<int>(device.strings.size());
         ++m, ++channel) {
      const StringDef& s = device.strings[channel];
      const double tension = b->digit(m) * kVoltPerDigit / s.volt_per_newton;
      const double digit = kVoltPerDigit / std::abs(s.volt_per_newton);
      const bool off = b->digit(m) == 0;  // a board that started anew, or is told last
      if (!off && !(tension > s.min_tension - digit && tension < s.max_tension + 1e-9)) ++out_of_bounds_;
    }
}

/// "board N does not answer: check its power", or "switch its power off and on": the user does.
bool FaultRig::bringUp() {
  if (tryBringUp()) return true;
  if (sample.status != LinkStatus::kSilent && driver->trouble().find("power off and on") == std::string::npos) return false;
  ++power_cycles;
  for (const auto& b : bus.boards()) b->replace();
  return tryBringUp();
}

bool FaultRig::tryBringUp() {
  command = Wrench{};
  command_age = 0;
  setHand(handPath("rest"));
  spidar.setForceEnabled(false);
  run(kSettleTicks);
  for (int k = 0; k < kBringUpTicks && sample.status == LinkStatus::kSilent; ++k) tick();
  spidar.recover();
  spidar.calibrateAtHome();
  // A device that believed a wrong pose pulled the grip aside, and the hand that holds it is no rigid jig:
  // with the tensions balanced it goes home, and a second calibration finds it there.
  run(kSettleTicks);
  spidar.recover();
  spidar.calibrateAtHome();
  spidar.setForceEnabled(true);
  for (int k = 0; k < kBringUpTicks; ++k) {
    tick();
    if (enabled() && k > 600) break;
  }
  return enabled() && poseError() < 1e-3;
}

double FaultRig::countError(int string) const {
  const double true_count = static_cast<double>(plant.trueCount(string));
  return std::abs((plant.position(string) - true_count) * device.strings[string].length_per_count);
}

}  // namespace haptic::bench
