// Jolt and Rapier in WebAssembly, from npm (wasm/rigid_bodies.mjs). The scene goes to them as JSON, forces and states as numbers.
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "node_process.h"
#include "peer_world.h"

namespace haptic::peers {
namespace {

constexpr int kState = 13;  ///< numbers of a body: p_WC, q_WC, ω, v of C

/// Text of JSON, built by appending; no text in it needs an escape.
class Json {
 public:
  Json() { text_ << std::setprecision(17); }
  Json& key(const char* name) {
    text_ << (first_ ? "" : ",") << '"' << name << "\":";
    first_ = true;
    return *this;
  }
  Json& value(double x) { return put([&] { text_ << x; }); }
  Json& value(const char* x) { return put([&] { text_ << '"' << x << '"'; }); }
  Json& value(const Vector3& x) { return put([&] { text_ << '[' << x.x() << ',' << x.y() << ',' << x.z() << ']'; }); }
  Json& value(const Quaternion& q) {
    return put([&] { text_ << '[' << q.w() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ']'; });
  }
  Json& open(char bracket) {
    put([&] { text_ << bracket; });
    first_ = true;
    return *this;
  }
  Json& close(char bracket) {
    text_ << bracket;
    first_ = false;
    return *this;
  }
  std::string text() const { return text_.str(); }

 private:
  template <class Write>
  Json& put(Write&& write) {
    if (!first_) text_ << ',';
    write();
    first_ = false;
    return *this;
  }

  std::ostringstream text_;
  bool first_ = true;
};

class WasmWorld : public PeerWorld {
 public:
  WasmWorld(const WorldDef& def, const PeerSettings& settings)
      : bodies_(peerBodies(def, settings)),
        state_(kState * bodies_.size()),
        told_(1 + 6 * bodies_.size(), 0),
        node_(nodeOf(settings.peer == Peer::kJolt ? "Jolt" : "Rapier", "rigid_bodies.mjs")) {
    told_[0] = 1;
    const std::string scene = describe(def, settings);
    const double size = static_cast<double>(scene.size());
    node_->send(&size, sizeof size);
    node_->send(scene.data(), scene.size());
    receive();
  }
  ~WasmWorld() override {
    told_[0] = std::nan("");
    try {
      node_->send(told_.data(), told_.size() * sizeof(double));
    } catch (const std::exception&) {  // it has ended before
    }
  }

  void step() override {
    node_->send(told_.data(), told_.size() * sizeof(double));
    std::fill(told_.begin() + 1, told_.end(), 0.0);
    receive();
  }
  Pose linkPose(int i) const override {
    if (bodies_[i].fixed) return bodies_[i].X_WL;
    const double* s = state(i);
    const Matrix3 R = Quaternion(s[3], s[4], s[5], s[6]).normalized().toRotationMatrix();
    return {R, Vector3(s[0], s[1], s[2]) - R * bodies_[i].link->inertia.p_LC};
  }
  Twist linkTwist(int i) const override {
    if (bodies_[i].fixed) return {};
    const double* s = state(i);
    const Twist at_com{Vector3(s[7], s[8], s[9]), Vector3(s[10], s[11], s[12])};
    return at_com.shifted(-(linkPose(i).R * bodies_[i].link->inertia.p_LC));
  }
  void applyForce(int i, const Vector3& f, const Vector3& p) override {
    if (bodies_[i].fixed) return;
    const double* s = state(i);
    Eigen::Map<Vector3> force(&told_[1 + 6 * i]), torque(&told_[1 + 6 * i + 3]);
    force += f;
    torque += (p - Vector3(s[0], s[1], s[2])).cross(f);
  }
  void scaleFriction(double factor) override { told_[0] = factor; }

 private:
  const double* state(int i) const { return state_.data() + kState * i; }
  void receive() { node_->receive(state_.data(), state_.size() * sizeof(double)); }

  std::string describe(const WorldDef& def, const PeerSettings& settings) const {
    Json json;
    json.open('{').key("engine").value(settings.peer == Peer::kJolt ? "jolt" : "rapier");
    json.key("step").value(settings.step).key("firm").value(settings.tuning == Tuning::kAccurate);
    json.key("restitution").value(settings.restitution).key("gravity").value(def.settings.gravity).key("bodies").open('[');
    for (const PeerBody& body : bodies_) describe(body, json);
    return json.close(']').close('}').text();
  }

  static void describe(const PeerBody& body, Json& json) {
    const LinkInertia& inertia = body.link->inertia;
    const Vector3 p_LC = body.fixed ? Vector3(Vector3::Zero()) : inertia.p_LC;
    const Vector3 p_WC = body.X_WL * p_LC;
    const Twist V = body.V_WL.shifted(p_WC - body.X_WL.p);
    json.open('{').key("fixed").value(body.fixed).key("p").value(p_WC).key("q").value(Quaternion(body.X_WL.R)).key("mu").value(body.mu);
    json.key("v").value(V.linear).key("w").value(V.angular);
    if (!body.fixed) {
      const Eigen::SelfAdjointEigenSolver<Matrix3> principal(inertia.I_C);
      Matrix3 axes = principal.eigenvectors();
      if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
      json.key("mass").value(inertia.mass).key("inertia").value(Vector3(principal.eigenvalues())).key("axes").value(Quaternion(axes));
      json.key("about_c").open('[');
      for (int k = 0; k < 9; ++k) json.value(inertia.I_C(k));
      json.close(']');
    }
    json.key("shapes").open('[');
    for (const CollisionDef& collision : body.link->collisions) addShape(body, collision, p_LC, json);
    json.close(']').close('}');
  }

  static void addShape(const PeerBody& body, const CollisionDef& collision, const Vector3& p_LC, Json& json) {
    using Kind = PeerShape::Kind;
    Pose X_CS(collision.X_LS.R, collision.X_LS.p - p_LC);
    json.open('{').key("kind");
    if (isPlane(body)) {
      const UpperFace face = upperFace(collision);
      X_CS = Pose(rotationBetween(Vector3::UnitZ(), face.n_L), face.p_L - p_LC);
      json.value("plane");
    } else if (const auto round = roundShape(body, *collision.shape); round && round->kind != Kind::kCone) {  // cones go as their hulls
      json.value(round->kind == Kind::kSphere ? "sphere" : round->kind == Kind::kCapsule ? "capsule" : "cylinder");
      json.key("radius").value(round->radius).key("length").value(round->length);
      X_CS.R = X_CS.R * rotationBetween(Vector3::UnitY(), Vector3::UnitZ());  // theirs have the axis y
    } else {
      const ConvexPolyhedron& shape = *collision.shape->polyhedron();
      json.value(shape.isBox() ? "box" : "hull");
      if (shape.isBox()) {
        json.key("half").value(shape.halfSize());
      } else {
        json.key("points").open('[');
        for (const Vector3& v : shape.vertices()) json.value(v.x()).value(v.y()).value(v.z());
        json.close(']');
      }
    }
    json.key("p").value(X_CS.p).key("q").value(Quaternion(X_CS.R)).close('}');
  }

  static Matrix3 rotationBetween(const Vector3& from, const Vector3& to) { return Quaternion::FromTwoVectors(from, to).toRotationMatrix(); }

  std::vector<PeerBody> bodies_;
  std::vector<double> state_, told_;  ///< told: the factor on friction, forces and torques about C
  std::shared_ptr<NodeProcess> node_;
};

}  // namespace

std::unique_ptr<PeerWorld> makeWasm(const WorldDef& def, const PeerSettings& settings) {
  return std::make_unique<WasmWorld>(def, settings);
}

}  // namespace haptic::peers
