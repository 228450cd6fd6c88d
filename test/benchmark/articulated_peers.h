/// The chain of the figures in other libraries: KDL, MuJoCo, Bullet; same state vectors, same units.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/dynamics/articulation_def.h"

namespace haptic::bench {

/// A chain of revolute joints on the world under gravity (0, 0, −9.8), n degrees.
class PeerChain {
 public:
  virtual ~PeerChain() = default;
  virtual void setState(const double* q, const double* v) = 0;
  virtual void getState(double* q, double* v) const = 0;
  /// Forward dynamics once, at the state; v̇ [n].
  virtual void evaluate(double* v_dot) = 0;
  /// One step of 1 ms, or as `setStep` said.
  virtual void step() = 0;
  virtual void setStep(double h) = 0;
};

/// Recursive Newton–Euler for the bias, composite inertia, dense solve (ChainFdSolver_RNE); it has no
/// stepper.
std::unique_ptr<PeerChain> kdlChain(const TreeDef& def);
/// MuJoCo with contacts and constraints switched off; Euler or classical Runge–Kutta.
std::unique_ptr<PeerChain> mujocoChain(const TreeDef& def, bool runge_kutta);
/// btMultiBody's articulated-body algorithm with its own Euler step; double precision.
std::unique_ptr<PeerChain> bulletChain(const TreeDef& def);

}  // namespace haptic::bench
