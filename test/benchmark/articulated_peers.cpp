#include "articulated_peers.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "kdl_chain.h"

namespace haptic::bench {
namespace {

constexpr double kGravity = 9.8;  // [m/s²], as in every figure

/// KDL behind numbers alone; see kdl_chain.h.
class KdlChain : public PeerChain {
 public:
  explicit KdlChain(const TreeDef& def) : size_(def.links.size()) {
    std::vector<KdlSegment> segments;
    for (std::size_t i = 0; i < size_; ++i) {
      const BodyDef& body = def.links[i];
      // KDL's segment ends in its tip, where the next joint sits; inertia is given there.
      const Vector3 tip = i + 1 < size_ ? def.links[i + 1].joint.X_PJ.p : Vector3::Zero();
      const Vector3 cog = body.inertia.p_LC - tip;
      const Vector3& a = body.joint.axis;
      const Matrix3& I = body.inertia.I_C;
      segments.push_back({{a.x(), a.y(), a.z()},
                          {tip.x(), tip.y(), tip.z()},
                          body.inertia.mass,
                          {cog.x(), cog.y(), cog.z()},
                          {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}});
    }
    chain_.reset(kdlMake(segments.data(), static_cast<int>(size_), kGravity));
    state_.resize(2 * size_);
  }
  void setState(const double* q, const double* v) override {
    std::copy(q, q + size_, state_.begin());
    std::copy(v, v + size_, state_.begin() + static_cast<std::ptrdiff_t>(size_));
    kdlSetState(chain_.get(), q, v);
  }
  void getState(double* q, double* v) const override {
    std::copy(state_.begin(), state_.begin() + static_cast<std::ptrdiff_t>(size_), q);
    std::copy(state_.begin() + static_cast<std::ptrdiff_t>(size_), state_.end(), v);
  }
  void evaluate(double* v_dot) override { kdlEvaluate(chain_.get(), v_dot); }
  void step() override { throw std::logic_error("KDL has no stepper"); }
  void setStep(double) override {}

 private:
  struct Free {
    void operator()(KdlSolver* solver) const { kdlFree(solver); }
  };
  std::size_t size_;
  std::unique_ptr<KdlSolver, Free> chain_;
  std::vector<double> state_;
};

class MujocoChain : public PeerChain {
 public:
  MujocoChain(const TreeDef& def, bool runge_kutta) {
    std::ostringstream text;
    text.precision(17);
    text << "<mujoco><compiler inertiafromgeom='false' angle='radian'/><option timestep='0.001' gravity='0 0 "
         << -kGravity << "' integrator='" << (runge_kutta ? "RK4" : "Euler")
         << "'><flag contact='disable' constraint='disable' limit='disable'/></option><worldbody>";
    for (const BodyDef& body : def.links) {
      const Vector3 &p = body.joint.X_PJ.p, &a = body.joint.axis, &c = body.inertia.p_LC;
      const Matrix3& I = body.inertia.I_C;
      text << "<body pos='" << p.x() << ' ' << p.y() << ' ' << p.z() << "'><joint type='hinge' axis='"
           << a.x() << ' ' << a.y() << ' ' << a.z() << "'/><inertial pos='" << c.x() << ' ' << c.y() << ' '
           << c.z() << "' mass='" << body.inertia.mass << "' diaginertia='" << I(0, 0) << ' ' << I(1, 1)
           << ' ' << I(2, 2) << "'/>";
    }
    for (std::size_t i = 0; i < def.links.size(); ++i) text << "</body>";
    text << "</worldbody></mujoco>";
    const std::string model = text.str();
    auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "chain.xml", static_cast<int>(model.size()));
    std::memcpy(files->filedata[mj_findFileVFS(files.get(), "chain.xml")], model.data(), model.size());
    char error[500] = "";
    model_ = mj_loadXML("chain.xml", files.get(), error, sizeof(error));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(error);
    data_ = mj_makeData(model_);
  }
  ~MujocoChain() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  void setState(const double* q, const double* v) override {
    std::copy(q, q + model_->nq, data_->qpos);
    std::copy(v, v + model_->nv, data_->qvel);
  }
  void getState(double* q, double* v) const override {
    std::copy(data_->qpos, data_->qpos + model_->nq, q);
    std::copy(data_->qvel, data_->qvel + model_->nv, v);
  }
  void evaluate(double* v_dot) override {
    mj_forward(model_, data_);
    std::copy(data_->qacc, data_->qacc + model_->nv, v_dot);
  }
  void step() override { mj_step(model_, data_); }
  void setStep(double h) override { model_->opt.timestep = h; }

 private:
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
};

class BulletChain : public PeerChain {
 public:
  explicit BulletChain(const TreeDef& def)
      : links_(static_cast<int>(def.links.size())), body_(links_, 1, btVector3(1, 1, 1), true, false) {
    Vector3 parent_centre = Vector3::Zero();
    for (int i = 0; i < links_; ++i) {
      const BodyDef& body = def.links[i];
      const Vector3 pivot = body.joint.X_PJ.p - parent_centre;
      const Vector3 &c = body.inertia.p_LC, &a = body.joint.axis;
      body_.setupRevolute(i, body.inertia.mass,
                          btVector3(body.inertia.I_C(0, 0), body.inertia.I_C(1, 1), body.inertia.I_C(2, 2)),
                          i - 1, btQuaternion(0, 0, 0, 1), btVector3(a.x(), a.y(), a.z()),
                          btVector3(pivot.x(), pivot.y(), pivot.z()), btVector3(c.x(), c.y(), c.z()), true);
      parent_centre = c;
      masses_.push_back(body.inertia.mass);
    }
    body_.finalizeMultiDof();
    body_.setLinearDamping(0);
    body_.setAngularDamping(0);
    body_.setUseGyroTerm(true);
    body_.setMaxCoordinateVelocity(1e30);
    r_.resize(links_ + 7);
    v_.resize(links_ + 7);
    m_.resize(links_ + 7);
  }
  void setState(const double* q, const double* v) override {
    for (int i = 0; i < links_; ++i) {
      body_.setJointPos(i, q[i]);
      body_.setJointVel(i, v[i]);
    }
  }
  void getState(double* q, double* v) const override {
    for (int i = 0; i < links_; ++i) {
      q[i] = body_.getJointPos(i);
      v[i] = body_.getJointVel(i);
    }
  }
  void evaluate(double* v_dot) override {
    velocityStep(1);
    for (int i = 0; i < links_; ++i) v_dot[i] = body_.getJointVel(i) - before_[i];
    for (int i = 0; i < links_; ++i) body_.setJointVel(i, before_[i]);
  }
  void step() override {
    velocityStep(h_);
    body_.stepPositionsMultiDof(h_);
  }
  void setStep(double h) override { h_ = h; }

 private:
  void velocityStep(double h) {
    before_.resize(links_);
    for (int i = 0; i < links_; ++i) before_[i] = body_.getJointVel(i);
    body_.clearForcesAndTorques();
    for (int i = 0; i < links_; ++i) body_.addLinkForce(i, btVector3(0, 0, -kGravity * masses_[i]));
    body_.computeAccelerationsArticulatedBodyAlgorithmMultiDof(h, r_, v_, m_, false, false, false);
  }
  int links_;
  double h_ = 1e-3;
  btMultiBody body_;
  std::vector<double> masses_, before_;
  btAlignedObjectArray<btScalar> r_;
  btAlignedObjectArray<btVector3> v_;
  btAlignedObjectArray<btMatrix3x3> m_;
};

}  // namespace

std::unique_ptr<PeerChain> kdlChain(const TreeDef& def) {
  return std::make_unique<KdlChain>(def);
}
std::unique_ptr<PeerChain> mujocoChain(const TreeDef& def, bool runge_kutta) {
  return std::make_unique<MujocoChain>(def, runge_kutta);
}
std::unique_ptr<PeerChain> bulletChain(const TreeDef& def) {
  return std::make_unique<BulletChain>(def);
}

}  // namespace haptic::bench
