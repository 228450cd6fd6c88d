#include "haptic_core/dynamics/force_kinds.h"

#include <sstream>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

std::string parametersOf(const ForceKind& kind) {
  std::string list;
  for (const ForceParameter& p : kind.parameters) {
    if (p.name) list += (list.empty() ? "" : ", ") + std::string(p.name) + " [" + p.unit + "]";
  }
  return list;
}

}  // namespace

void ForceDef::set(const std::string& parameter_name, double value) {
  const ForceKind& kind = kindOf(type);
  for (int i = 0; i < kMostForceParameters; ++i) {
    if (!kind.parameters[i].name || parameter_name != kind.parameters[i].name) continue;
    parameter[i] = value;
    return;
  }
  throw SetupError("force " + name, "a " + std::string(kind.name) + " has no parameter " + parameter_name,
                   "give " + parametersOf(kind));
}

void check(const ForceDef& def, const std::string& where) {
  const ForceKind& kind = kindOf(def.type);
  for (int i = 0; i < kMostForceParameters; ++i) {
    const ForceParameter& p = kind.parameters[i];
    if (!p.name || (def.parameter[i] >= p.least && def.parameter[i] <= p.most)) continue;
    std::ostringstream given, least;
    given << p.name << " is " << def.parameter[i] << " " << p.unit;
    least << "give a number >= " << p.least;
    throw SetupError(where, given.str(), least.str());
  }
  if (!def.p_A.allFinite() || !def.p_B.allFinite()) throw SetupError(where, "a point is not finite", "give metres");
}

}  // namespace haptic
