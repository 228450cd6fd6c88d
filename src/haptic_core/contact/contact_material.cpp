#include "haptic_core/contact/contact_material.h"

#include <cmath>
#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

bool given(double value) { return !std::isnan(value); }

template <class Mean>
double choose(double a, double b, double fallback, double last_resort, Mean mean) {
  if (given(a) && given(b)) return mean(a, b);
  if (given(a)) return a;
  if (given(b)) return b;
  return given(fallback) ? fallback : last_resort;
}

/// k where no number is given. fmin and fmax ignore NaN.
double chosen(const ContactMaterial& a, const ContactMaterial& b, bool rigid) {
  const double touch = std::fmin(a.touch_stiffness, b.touch_stiffness);
  if (given(touch)) return touch;
  if (!rigid) return std::fmax(DefaultMaterial::kStiffness, std::fmax(a.rest_stiffness, b.rest_stiffness));
  const double k = std::fmax(a.rigid_stiffness, b.rigid_stiffness);
  return std::fmax(k, DefaultMaterial::kRigid);
}

double harmonic(double a, double b) { return 2 * a * b / (a + b); }
double arithmetic(double a, double b) { return 0.5 * (a + b); }
double geometric(double a, double b) { return std::sqrt(a * b); }

void require(bool holds, const std::string& where, const char* field, double value, const char* remedy) {
  if (holds) return;
  std::ostringstream number;
  number << value;
  throw SetupError(where, std::string(field) + " is " + number.str(), remedy);
}

/// Stiffness that a surface gives; a surface without one is rigid where the world's default is.
double said(const ContactMaterial& surface, const ContactMaterial& fallback) {
  return given(surface.stiffness) || !fallback.rigid() ? surface.stiffness : ContactMaterial::kRigid;
}

double pairStiffness(const ContactMaterial& a, const ContactMaterial& b, const ContactMaterial& fallback) {
  const double k_a = said(a, fallback), k_b = said(b, fallback), softer = std::fmin(k_a, k_b), stiffer = std::fmax(k_a, k_b);
  const bool rigid = stiffer == ContactMaterial::kRigid;
  if (softer < ContactMaterial::kRigid) {  // somebody gives a number
    if (rigid) return 2 * softer;
    return given(k_a) && given(k_b) ? harmonic(k_a, k_b) : softer;
  }
  if (rigid) return chosen(a, b, true);
  return fallback.saysNumber() ? fallback.stiffness : chosen(a, b, false);
}

}  // namespace

bool isRigid(const ContactMaterial& a, const ContactMaterial& b, const ContactMaterial& fallback) {
  const double k_a = said(a, fallback), k_b = said(b, fallback);
  return std::fmax(k_a, k_b) == ContactMaterial::kRigid && !(std::fmin(k_a, k_b) < ContactMaterial::kRigid) &&
         !given(std::fmin(a.touch_stiffness, b.touch_stiffness));
}

ContactMaterial combine(const ContactMaterial& a, const ContactMaterial& b, const ContactMaterial& fallback) {
  using M = ContactMaterial;
  const auto pick = [&](double M::*field, double last_resort, auto mean) {
    return choose(a.*field, b.*field, fallback.*field, last_resort, mean);
  };
  M pair;
  pair.stiffness = pairStiffness(a, b, fallback);
  pair.damping = pick(&M::damping, DefaultMaterial::kDamping, arithmetic);
  pair.dissipation = pick(&M::dissipation, DefaultMaterial::kDissipation, arithmetic);
  pair.tangential_stiffness =
      pick(&M::tangential_stiffness, DefaultMaterial::kTangentialRatio * pair.stiffness, harmonic);
  pair.tangential_damping = pick(&M::tangential_damping, M::kUnset, arithmetic);
  pair.mu_static = pick(&M::mu_static, M::kUnset, geometric);
  pair.mu_dynamic = pick(&M::mu_dynamic, given(pair.mu_static) ? pair.mu_static : DefaultMaterial::kMu, geometric);
  if (!given(pair.mu_static)) pair.mu_static = pair.mu_dynamic;
  // Means of two ordered pairs are ordered, but a value taken from one side alone may not be.
  pair.mu_static = std::fmax(pair.mu_static, pair.mu_dynamic);
  return pair;
}

void check(const ContactMaterial& m, const std::string& where) {
  const auto positive = [&](double v, const char* field) {
    require(!given(v) || (v > 0 && std::isfinite(v)), where, field, v, "give a finite number > 0");
  };
  const auto notNegative = [&](double v, const char* field) {
    require(!given(v) || (v >= 0 && std::isfinite(v)), where, field, v, "give a finite number >= 0");
  };
  require(!given(m.stiffness) || m.stiffness > 0, where, "stiffness [N/m^3]", m.stiffness, "give a number > 0, or rigid");
  positive(m.tangential_stiffness, "tangential_stiffness [N/m^3]");
  notNegative(m.damping, "damping [N s/m^3]");
  notNegative(m.dissipation, "dissipation [s/m]");
  notNegative(m.tangential_damping, "tangential_damping [N s/m^3]");
  for (double mu : {m.mu_static, m.mu_dynamic}) {
    require(!given(mu) || (mu >= 0 && mu <= 10), where, "mu", mu, "give a coefficient from 0 to 10");
  }
  require(!given(m.mu_static) || !given(m.mu_dynamic) || m.mu_dynamic <= m.mu_static, where, "mu_dynamic",
          m.mu_dynamic, "it must not exceed mu_static");
}

}  // namespace haptic
