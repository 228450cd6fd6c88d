/// Sensors of a world: joint wrenches, contact wrenches, inertial units, from the results of a step.
///
/// A wrench is the mean over the step that ended: with P and H the momentum, and its moment about a point a fixed in W, of all that hangs
/// beyond the joint,
///     force  = (P₁ - P₀)/h - m g - Σ F,      torque = (H₁ - H₀)/h - ½ (p₀ + p₁ - 2a) × m g - Σ (τ + (p_F - a) × F),
/// where F are the mean contact wrenches that the report has and those of hands that pull, and a is S's origin at the
/// end of the step. So m a of a link is the sum of its wrenches to rounding, in impacts as well, and errors of an integrator appear
/// in the reading as in the motion. The reading is that of inverse dynamics of the motion, half a step late. In S's axes at the step's end.
///
/// An IMU's specific force is (v₁ - v₀)/h - g of S's origin in S's axes at the end: R_WS f + g adds up to v exactly.
///
/// Noise: Gaussian by G. Box, M. Muller, Ann. Math. Statist. 29, 1958, of words that are a hash of seed, name, step and component: no
/// state, so that a restored world repeats it bit for bit.
///
/// Cost: a pass over the links beyond the joint before and after a step in which a sample is due, and one over the contacts. A world
/// without sensors calls nothing of this.
#pragma once
#include <vector>

#include "haptic_core/dynamics/link_force.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/contact_reports.h"
#include "haptic_core/world/sensor_def.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// The sensors of one world.
class Sensors {
 public:
  /// Set-up. Throws SetupError that names the sensor: a link that is not there, a joint that carries nothing because it floats, a cut
  /// that a closed loop bridges, a name twice, noise or rate that are no sizes.
  Sensors(const Model& model, const std::vector<SensorDef>& defs);

  bool empty() const { return plans_.empty(); }             ///< nothing is measured
  const std::vector<SensorDef>& defs() const { return defs_; }  ///< as they were asked for
  const std::vector<SensorReading>& readings() const { return readings_; }  ///< the last samples, by sensor
  /// One line each: the quantity, and how often it is measured.
  std::string text() const;

  /// (in realtime) Before a step: keeps what samples that are due need to know of its start.
  void begin(const Model& model, const State& state, const Placement& placement) noexcept;
  /// (in realtime) After the step: takes the samples that are due.
  void finish(const Model& model, const State& state, const Placement& placement, const ContactReports& contacts) noexcept;
  /// (in realtime) The state was replaced: there is no sample.
  void clear() noexcept;

 private:
  /// Momentum of a part of the world about a point fixed in W, its mass and where that is.
  struct Motion {
    Vector3 about = Vector3::Zero();    ///< the point, in W [m]
    Vector3 linear = Vector3::Zero();   ///< P [N·s]
    Vector3 angular = Vector3::Zero();  ///< H about it [N·m·s]
    Vector3 first = Vector3::Zero();    ///< ∫ (p - a) dm [kg·m]
    void add(double mass, const Matrix3& I_C_W, const Vector3& p_WC, const Vector3& v_C, const Vector3& omega) noexcept;
    Motion movedTo(const Vector3& point, double mass) const noexcept;
  };
  /// Which side of a sensor a shape is on.
  enum Side : unsigned char { kElsewhere = 0, kOwn = 1, kPartner = 2 };
  struct Plan {
    int link = 0;                 ///< world link index of L
    std::vector<int> links;       ///< wrench: whole links beyond the joint
    std::vector<Side> side;       ///< by shape; empty: no contact counts
    std::vector<char> own;        ///< by world link: a hand that pulls at it counts
    double mass = 0;              ///< of all that is beyond [kg]
    std::uint64_t period = 1;     ///< steps between samples
    std::uint64_t key = 0;        ///< of the noise
  };
  /// Of the start of a step.
  struct Start {
    Motion motion;
    Vector3 velocity = Vector3::Zero();  ///< of S's origin [m/s]
  };

  Plan compile(const Model& model, const SensorDef& def) const;
  void compileWrench(const Model& model, const SensorDef& def, Plan& plan) const;
  void compileContact(const Model& model, const SensorDef& def, Plan& plan) const;
  bool due(const Plan& plan, std::uint64_t step) const noexcept { return step % plan.period == 0; }
  Motion motionOf(const Model& model, int i, const Placement& placement, const Vector3& about) const noexcept;
  Wrench contactsOn(const Plan& plan, const ContactReports& contacts, const Vector3& about) const noexcept;
  Wrench handsOn(const Model& model, const Plan& plan, const State& state, const Placement& placement, const Vector3& about) const noexcept;
  Wrench throughJoint(const Model& model, int i, const State& state, const Placement& placement, const ContactReports& contacts,
                      const Vector3& about) const noexcept;
  void addNoise(int i, SensorReading& reading) const noexcept;

  std::vector<SensorDef> defs_;
  std::vector<Plan> plans_;
  std::vector<SensorReading> readings_;
  std::vector<Start> start_;
  /// Wrench of a hand, or an applied one, in the step before, about a point of W.
  struct Pull {
    Wrench F_W;                      ///< on the link
    Vector3 at = Vector3::Zero();    ///< L's origin, or the wrench's point, then [m]
  };
  std::vector<Pull> pulls_;   ///< by pointer
  std::vector<Pull> pushes_;  ///< in the order of State::wrenches
  std::vector<LinkForce> forces_;  ///< by force element: at the start of the step
};

}  // namespace haptic
