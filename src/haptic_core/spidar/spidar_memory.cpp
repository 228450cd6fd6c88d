// The memory of a Spidar from tick to tick, as numbers, and the settings that may be tuned while it runs.
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

std::vector<double> Spidar::save() const {
  std::vector<double> out;
  save(out);
  return out;
}

void Spidar::save(std::vector<double>& out) const {
  const int n = kinematics_.strings();
  out.assign({static_cast<double>(n), distribution_.ruleLambda()});
  for (const StringDef& string : def_.strings) out.insert(out.end(), string.p_BE.data(), string.p_BE.data() + 3);
  appendFields(*this, out);
  out.resize(out.size() + 2 * static_cast<std::size_t>(n));
  distribution_.saveActiveSet(out.data() + out.size() - 2 * n);
}

/// The exits as a calibration left them, three numbers per string.
void Spidar::placeExits(const double* numbers) {
  bool moved = false;
  for (StringDef& string : def_.strings) {
    const Vector3 p_BE(numbers[0], numbers[1], numbers[2]);
    moved = moved || p_BE != string.p_BE;
    string.p_BE = p_BE;
    numbers += 3;
  }
  if (!moved) return;
  kinematics_ = StringKinematics(def_);
  distribution_ = TensionDistribution(def_, kinematics_);
}

void Spidar::restore(const std::vector<double>& memory) {
  const std::size_t n = def_.strings.size();
  constexpr std::size_t kHead = 2;
  if (memory.size() != kHead + 3 * n + countFields(*this) + 2 * n || memory[0] != static_cast<double>(n))
    throw SetupError(def_.name, "the saved memory is of another device or version", "use the description it was saved with");
  const double* in = memory.data() + kHead;
  placeExits(in);
  distribution_.setRuleLambda(memory[1]);
  in += 3 * n;
  readFields(*this, in);
  distribution_.restoreActiveSet(in);  // a guess that may decide the last bit
  distribution_.setStructure(kinematics_.scaledStructure(solution_.pose));
}

void Spidar::tune(const Tuning& tuning) {
  const auto checked = [this](const char* what, double value, double low, double high) {
    if (value >= low && value <= high) return;
    std::ostringstream is, give;
    is << what << " is " << value;
    give << "give " << low << " to " << high;
    throw SetupError(def_.name, is.str(), give.str());
  };
  // Below 1e-6 tensions jump at the border of the presentable wrenches; above 1 a strong wrench loses half of itself.
  checked("lambda", tuning.lambda, 1e-6, 1);
  checked("max_force [N]", tuning.max_force, 1e-3, def_.max_force);
  checked("max_torque [N·m]", tuning.max_torque, 1e-5, def_.max_torque);
  distribution_.setRuleLambda(tuning.lambda);
  max_force_ = tuning.max_force;
  max_torque_ = tuning.max_torque;
}

}  // namespace haptic
