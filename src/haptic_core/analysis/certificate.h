/// Where a scene is stable: stiffness, mass and, for comparison, the largest step of velocity Verlet of each contact and island; and
/// whether it stands.
///
/// About rest the equations of an island are linear: M a = -K x - D v, all its bodies coupled, lever arms and friction springs included.
/// Without dampers velocity Verlet is stable up to h = 2/ω of the stiffest mode. A strong damper is settled contact by contact, with the
/// masses shared among them (test/comparators/settled_damper.h): alone it lowers nothing, several of them do, by motions that no closed
/// form names. So the linear step itself is taken 8000 times from a motion that has all modes, and the largest step that lets none grow is
/// found by bisection. The heave of one contact alone, h² k A = 4 m, or h² k A + 4 h b A = 4 m where its damper is weak, may be unsafe by a
/// factor of 2.6. A negative eigenvalue of K is no matter of the step: the scene buckles or topples under its own weight.
///
/// K is the derivative of the contact and gravity forces by central differences (so it has the turn of the normals and
/// the weight's share), plus the friction springs; D is that of located_force.h.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

/// Whether an island or a scene stands.
enum class Verdict : unsigned char {
  kPass,      ///< it stands
  kRefused    ///< no step helps: free bodies that buckle or topple under their own weight
};
const char* toString(Verdict verdict);  ///< PASS or REFUSED

/// Stability of one contact, with the stiffness and mass that decide it.
struct PairCertificate {
  std::string a, b;           ///< names of the links
  double stiffness = 0;       ///< k_eff = k·A0 [N/m]
  double mass = 0;            ///< effective along n at the patch, lever arms included [kg]
  double heave_limit = 0;     ///< largest step of this contact alone, in heave [s]
};

/// Stability of one island: its largest step of velocity Verlet, and a verdict.
struct IslandCertificate {
  std::vector<std::string> links;  ///< their names
  int degrees = 0;                 ///< of freedom
  double limit = 0;           ///< largest stable step of velocity Verlet, coupled [s]; infinite without stiffness
  double frequency = 0;       ///< of the stiffest undamped mode [rad/s]
  double mass_ratio = 1;      ///< heaviest to lightest
  double growth = 0;          ///< [1/s] of buckling or toppling; 0: none
  int worst_pair = -1;        ///< index into `pairs`: most energy of the stiffest mode
  Verdict verdict = Verdict::kPass;  ///< of the island
};

/// Whether a scene is stable at its step: verdicts on every contact and island.
struct Certificate {
  double step = 0;            ///< of the definition [s]
  bool settled = true;        ///< the scene came to rest; otherwise judged where the settling ended
  std::vector<PairCertificate> pairs;      ///< every contact of the settled scene
  std::vector<IslandCertificate> islands;  ///< every island of it
  Verdict verdict = Verdict::kPass;  ///< the worst of the islands
  std::string text() const;          ///< several lines, for people
};

/// Lets a copy of the world settle by implicit steps (`settle_s` of simulated time, hands at rest), and judges where
/// it lies. At set-up: allocates. Throws SetupError as `World` does. `goOn` is asked every now and then; where it says no the certificate
/// is empty. Cost: of the contacts, and of each island the cube of its degrees.
Certificate certify(const WorldDef& def, double settle_s = 1.0, const std::function<bool()>& goOn = {});

}  // namespace haptic
