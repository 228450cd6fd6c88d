#include "kdl_chain.h"

#include <kdl/chain.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <string>

namespace haptic::bench {

struct KdlSolver {
  KdlSolver(KDL::Chain of, double gravity) : chain(std::move(of)), solver(chain, KDL::Vector(0, 0, -gravity)) {
    const unsigned n = chain.getNrOfJoints();
    for (KDL::JntArray* array : {&q, &v, &a, &tau}) array->resize(n);
    KDL::SetToZero(tau);
    wrenches.assign(n, KDL::Wrench::Zero());
  }
  KDL::Chain chain;
  KDL::ChainFdSolver_RNE solver;
  KDL::JntArray q, v, a, tau;
  KDL::Wrenches wrenches;
};

__attribute__((visibility("default"))) KdlSolver* kdlMake(const KdlSegment* segments, int count, double gravity) {
  KDL::Chain chain;
  for (int i = 0; i < count; ++i) {
    const KdlSegment& s = segments[i];
    const auto vector = [](const double* x) { return KDL::Vector(x[0], x[1], x[2]); };
    const double* I = s.inertia;
    chain.addSegment(KDL::Segment(
        KDL::Joint("joint" + std::to_string(i), KDL::Vector::Zero(), vector(s.axis), KDL::Joint::RotAxis),
        KDL::Frame(vector(s.tip)),
        KDL::RigidBodyInertia(s.mass, vector(s.centre), KDL::RotationalInertia(I[0], I[1], I[2], I[3], I[4], I[5]))));
  }
  return new KdlSolver(std::move(chain), gravity);
}

__attribute__((visibility("default"))) void kdlFree(KdlSolver* solver) { delete solver; }

__attribute__((visibility("default"))) void kdlSetState(KdlSolver* solver, const double* q, const double* v) {
  for (unsigned i = 0; i < solver->q.rows(); ++i) {
    solver->q(i) = q[i];
    solver->v(i) = v[i];
  }
}

__attribute__((visibility("default"))) void kdlEvaluate(KdlSolver* solver, double* v_dot) {
  solver->solver.CartToJnt(solver->q, solver->v, solver->tau, solver->wrenches, solver->a);
  for (unsigned i = 0; i < solver->a.rows(); ++i) v_dot[i] = solver->a(i);
}

}  // namespace haptic::bench
