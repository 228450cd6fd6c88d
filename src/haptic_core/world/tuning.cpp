#include "haptic_core/world/tuning.h"

#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"

namespace haptic {
namespace {

/// A hundred times the earth's [m/s²]: beyond it a step of 1 ms falls through bodies thinner than a millimetre.
constexpr double kMostGravity = 1000;

void require(bool good, const std::string& what, double value, const std::string& remedy) {
  if (good) return;
  std::ostringstream is;
  is << "is " << value;
  throw SetupError(what, is.str(), remedy);
}

double shareOfBound(double stiffness, double damping, double load, double h) {
  return (stiffness * h * h + 2 * damping * h) / load;
}

void resolve(double& stiffness, double& damping, double load, double h, bool cap) {
  const double omega = 0.236 / h;
  if (stiffness == PointerCoupling::kDerived) stiffness = load * omega * omega;
  if (damping == PointerCoupling::kDerived) damping = 2 * load * omega;
  const double excess = shareOfBound(stiffness, damping, load, h);
  if (!cap || excess <= 1) return;
  stiffness /= excess;
  damping /= excess;
}

}  // namespace

std::vector<double> WorldTuning::numbers() const {
  std::vector<double> out;
  appendFields(*this, out);
  return out;
}

WorldTuning WorldTuning::fromNumbers(const std::vector<double>& numbers) {
  const std::size_t per_pointer = countFields(PointerCoupling{}), head = countFields(WorldTuning{});
  if (numbers.size() < head || (numbers.size() - head) % per_pointer != 0) {
    throw SetupError("tuning of the world", "has " + std::to_string(numbers.size()) + " numbers",
                     "give " + std::to_string(head) + " and " + std::to_string(per_pointer) + " per pointer");
  }
  WorldTuning tuning;
  tuning.coupling.resize((numbers.size() - head) / per_pointer);
  const double* next = numbers.data();
  readFields(tuning, next);
  return tuning;
}

void check(const WorldTuning& tuning, const std::vector<CouplingLoad>& loads, double h) {
  const double k = tuning.stiffness_scale, mu = tuning.friction_scale;
  require(k >= 0.01 && k <= 10, "stiffness_scale", k, "give 0.01 to 10");
  require(mu >= 0 && mu <= 3, "friction_scale", mu, "give 0 to 3");
  require(tuning.gravity.allFinite() && tuning.gravity.norm() <= kMostGravity, "gravity", tuning.gravity.norm(),
          "give three finite numbers in m/s^2, at most 1000");
  require(tuning.budget >= 0 && std::isfinite(tuning.budget), "budget", tuning.budget, "give units >= 0 of counted work, 0 for none");
  require(tuning.coupling.size() == loads.size(), "number of couplings", double(tuning.coupling.size()),
          "give one per pointer: " + std::to_string(loads.size()));
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const PointerCoupling& c = tuning.coupling[i];
    for (const double value : {c.stiffness, c.damping, c.rotational_stiffness, c.rotational_damping}) {
      const bool good = value == PointerCoupling::kDerived || (value >= 0 && std::isfinite(value));
      require(good, "a coupling value", value, "give a number >= 0, or -1 to have it derived");
    }
    for (const AxisShares* axes : {&c.along_stiffness, &c.along_damping, &c.about_stiffness, &c.about_damping}) {
      for (const double share : axes->share) require(share >= 0 && share <= 1, "an axis's share of a coupling value", share, "give 0 to 1");
    }
    if (c.mode == PointerCoupling::Mode::kDirect) continue;
    const PointerCoupling r = resolved(c, loads[i], h, false);
    const auto bear = [h](const char* what, double stiffness, double damping, double load, const char* unit) {
      const double share = shareOfBound(stiffness, damping, load, h);
      std::ostringstream remedy;
      remedy << "lower them: k h²/m + 2 b h/m must be at most 1, with m = " << load << " " << unit << " and h = "
             << 1e3 * h << " ms; -1 derives them";
      require(share <= 1 + 1e-9, std::string("virtual coupling: ") + what + ", k h²/m + 2 b h/m", share, remedy.str());
    };
    bear("stiffness and damping", r.stiffness, r.damping, loads[i].mass, "kg");
    bear("rotational stiffness and damping", r.rotational_stiffness, r.rotational_damping, loads[i].least_inertia, "kg·m²");
  }
}

PointerCoupling resolved(const PointerCoupling& coupling, const CouplingLoad& load, double h, bool cap) noexcept {
  PointerCoupling c = coupling;
  resolve(c.stiffness, c.damping, load.mass, h, cap);
  resolve(c.rotational_stiffness, c.rotational_damping, load.least_inertia, h, cap);
  return c;
}

}  // namespace haptic
