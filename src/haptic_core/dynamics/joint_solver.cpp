#include "haptic_core/dynamics/joint_solver.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// ε of the rings' forces [1] (damped_cholesky.h). A row that the tree hardly moves is a spring of 1/(2 ε D h²) over a step h, implicit in
/// its gap, explicit in its direction. Smaller, and a straight chain between two points pulls with more than a step resolves: its n links
/// of length L are stable at gravity for ε > 48 n² h⁴/L³ or so, 8e-7 for four of 0.1 m. Larger, and it is longer by more than 1 µm.
constexpr double kRingDamping = 1e-5;
/// ε of the way that closes gaps [1]: only rows that the tree moves well are put back, in steps that leave ε² of their gap. The gap of
/// the others is what their spring pulls with.
constexpr double kClosingDamping = 0.1;

/// Friction of a thread that a further pass would change by less is found [1]; the row of its mimic leaves 1e-10 (damped_cholesky.h).
constexpr double kRubbed = 1e-9;

double dot(const double* a, const double* b, int n) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

/// Friction of a thread acts on the joint of link i.
bool isThreaded(const TreeDef& tree, int i) {
  return std::any_of(tree.links.begin(), tree.links.end(),
                     [i](const BodyDef& body) { return body.joint.mimic_joint == i && body.joint.thread_friction > 0; });
}

}  // namespace

void JointSolver::add(const Articulation& articulation, const std::vector<RingDef>& rings, const JointPlace& place) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& model = articulation.link(i);
    Law law;
    law.joint = ownLaw(articulation.def().links[i].joint);
    law.link = place.link + i;
    law.command = place.command + i;
    law.q = place.q + model.q;
    law.v = place.v + model.v;
    law.friction.sticks = law.joint.friction > 0 || isThreaded(articulation.def(), i);
    if (model.dof == 1 && (hasLaw(law.joint) || law.friction.sticks)) laws_.push_back(law);
    if (model.dof < 2 || model.floating || law.joint.damping <= 0) continue;
    for (int k = 0; k < model.dof; ++k) damped_.push_back({law.v + k, 0, law.joint.damping});
  }
  const int nv = articulation.nv();
  PlacedRings placed{Rings(articulation, rings), place, nv};
  if (!placed.rings.empty()) {
    placed.G = G_.size();
    G_.resize(G_.size() + static_cast<std::size_t>(placed.rings.rows()) * nv);
    addThreads(articulation, placed);
    rings_.push_back(placed);
  }
  for (auto* by_equation : {&gap_, &rate_, &mu_}) by_equation->resize(by_equation->size() + placed.rings.rows());
  S_ = DampedCholesky(static_cast<int>(gap_.size()));
  present_.reserve(laws_.size()), present_damped_.reserve(damped_.size()), present_rings_.reserve(rings_.size());
}

void JointSolver::addThreads(const Articulation& articulation, const PlacedRings& placed) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const JointDef& slide = articulation.def().links[i].joint;
    if (slide.mimic_joint < 0 || !(slide.thread_friction > 0)) continue;
    const int turn = placed.place.link + slide.mimic_joint;
    const auto law = std::find_if(laws_.begin(), laws_.end(), [turn](const Law& l) { return l.link == turn; });
    threads_.push_back({Thread(slide), static_cast<std::size_t>(law - laws_.begin()), rings_.size(), placed.rings.mimicRow(i)});
  }
}

void JointSolver::reserveRows(int most) {
  for (auto* by_row : {&force_, &ring_force_, &diag_}) by_row->resize(most);
  Y_.resize(gap_.size() * most);
}

/// The equations of present rings follow one another.
void JointSolver::orderRings() noexcept {
  equations_ = 0;
  for (const std::ptrdiff_t i : present_rings_) {
    rings_[i].first = equations_;
    equations_ += rings_[i].rings.rows();
  }
}

void JointSolver::start(const JointCommand* commands, const double* q, double h) noexcept {
  h_ = h;
  commands_ = commands;
  for (PlacedThread& thread : threads_) thread.friction = {}, thread.side = 0;
  for (const std::ptrdiff_t i : present_) {
    Law& law = laws_[i];
    law.q_start = q[law.q];
    law.force = 0;
    buildGraph(law);
  }
  std::fill(mu_.begin(), mu_.end(), 0.0);
}

void JointSolver::buildGraph(Law& law) const noexcept {
  law.friction.forward = law.friction.backward = law.joint.friction;
  for (const PlacedThread& thread : threads_) {
    if (&laws_[thread.law] != &law) continue;
    law.friction.forward += thread.friction.forward;
    law.friction.backward += thread.friction.backward;
  }
  buildForceGraph(law.joint, law.friction, commands_[law.command], law.q_start, h_, law.graph);
}

void JointSolver::standAt(const double* v) noexcept {
  for (const std::ptrdiff_t i : present_) laws_[i].piece = laws_[i].graph.at(v[laws_[i].v]);
}

void JointSolver::putWithinLimits(double* v) const noexcept {
  for (const std::ptrdiff_t i : present_) {
    const Law& law = laws_[i];
    const ForcePiece &lowest = law.graph.pieces[0], &highest = law.graph.pieces[law.graph.count - 1];
    v[law.v] = std::min(std::max(v[law.v], lowest.from), highest.to);
  }
}

void JointSolver::settle(double* v) const noexcept {
  for (const std::ptrdiff_t i : present_) {
    if (laws_[i].now().vertical) v[laws_[i].v] = laws_[i].now().from;
  }
}

void JointSolver::follow(double* q, double* v) const noexcept {
  for (const std::ptrdiff_t i : present_rings_) rings_[i].rings.follow(q + rings_[i].place.q, v + rings_[i].place.v);
}

double JointSolver::gapAt(const LinkWork* work, const double* q) noexcept {
  for (const std::ptrdiff_t i : present_rings_) {
    const PlacedRings& r = rings_[i];
    r.rings.residual(work + r.place.link, q + r.place.q, &gap_[r.first]);
  }
  double largest = 0;
  for (int e = 0; e < equations_; ++e) largest = std::max(largest, std::abs(gap_[e]));
  return largest;
}

void JointSolver::lookAtRings(const LinkWork* work, const double* q, double share, const double* v) noexcept {
  gapAt(work, q);
  for (const std::ptrdiff_t i : present_rings_) {
    rings_[i].rings.jacobian(work + rings_[i].place.link, G_.data() + rings_[i].G);
  }
  forEachEquation([&](int e, const double* G, const PlacedRings& r) {
    rate_[e] = -share * gap_[e] / h_ - (v ? dot(G, v + r.place.v, r.nv) : 0);
  });
}

JointSolver::Found JointSolver::solve(JointOperator& A, const double* v, double* u) noexcept {
  const int most = kBlockPasses + kSinglePasses * static_cast<int>(present_.size());
  for (passes_ = 1;; ++passes_) {
    hold(v, u);
    if (!A.factor(diag_.data())) return Found::kUnsolved;
    A.solve(force_.data(), u);
    if (equations_ > 0) factorRings(A);
    closeRings(A, u);
    readForces(A, v, u);
    const Rubbed rubbed = rub();  // a friction that is not yet that of its force tells nothing of the piece
    const bool moved = rubbed != Rubbed::kNext && move(passes_ <= kBlockPasses, v, u);
    if (rubbed == Rubbed::kFound && !moved) return Found::kAll;
    if (passes_ > most) return Found::kCycled;
  }
}

void JointSolver::solveAgain(JointOperator& A, const double* v, double* u) noexcept {
  hold(v, u);
  A.solve(force_.data(), u);
  closeRings(A, u);
  readForces(A, v, u);
}

/// Forces, diagonal and prescribed changes of the pieces that the joints are on.
void JointSolver::hold(const double* v, double* u) noexcept {
  std::fill_n(force_.begin(), rows_, 0.0);
  std::fill_n(diag_.begin(), rows_, 0.0);
  for (const std::ptrdiff_t i : present_damped_) {
    const Damped& d = damped_[i];
    force_[d.row] = -d.damping * v[d.v];
    diag_[d.row] = h_ * d.damping;
  }
  for (const std::ptrdiff_t i : present_) {
    const Law& law = laws_[i];
    const ForcePiece& piece = law.now();
    if (piece.vertical) {
      diag_[law.row] = std::numeric_limits<double>::infinity();
      u[law.row] = piece.from - v[law.v];
    } else {
      force_[law.row] = piece.offset - piece.slope * v[law.v];
      diag_[law.row] = h_ * piece.slope;
    }
  }
}

void JointSolver::factorRings(JointResponse& A) noexcept {
  forEachEquation([&](int e, const double* G, const PlacedRings& r) {
    std::fill_n(ring_force_.begin(), rows_, 0.0);
    std::copy_n(G, r.nv, ring_force_.begin() + r.row);
    A.respond(ring_force_.data(), &Y_[static_cast<std::size_t>(e) * rows_]);
  });
  forEachEquation([&](int e, const double* G, const PlacedRings& r) {
    for (int c = 0; c < equations_; ++c) {
      S_.matrix()[e * equations_ + c] = dot(G, &Y_[static_cast<std::size_t>(c) * rows_ + r.row], r.nv);
    }
    S_.scale()[e] = S_.matrix()[e * equations_ + e];
  });
  for (const std::ptrdiff_t i : present_rings_) rings_[i].rings.shareScale(S_.scale() + rings_[i].first);
  S_.factor(equations_, kRingDamping);
}

void JointSolver::addResponse(const double* force, double* x) const noexcept {
  for (int e = 0; e < equations_; ++e) {
    for (int i = 0; i < rows_; ++i) x[i] += Y_[static_cast<std::size_t>(e) * rows_ + i] * force[e];
  }
}

void JointSolver::holdAccelerations(const LinkWork* work, double* v_dot) noexcept {
  for (const std::ptrdiff_t i : present_rings_) {
    const PlacedRings& r = rings_[i];
    r.rings.acceleration(work + r.place.link, v_dot + r.row, &mu_[r.first]);
  }
  for (int e = 0; e < equations_; ++e) mu_[e] = -mu_[e];
  S_.solve(mu_.data());
  addResponse(mu_.data(), v_dot);
}

double JointSolver::openingRate() const noexcept {
  double largest = 0;
  for (int e = 0; e < equations_; ++e) largest = std::max(largest, std::abs(rate_[e]));
  return largest;
}

void JointSolver::holdVelocities(double* v) noexcept {
  S_.factor(equations_, kRingDamping);
  S_.solve(rate_.data());
  addResponse(rate_.data(), v);
}

/// u again, with the forces Gᵀ μ that give G u = rate.
void JointSolver::closeRings(JointOperator& A, double* u) noexcept {
  std::fill_n(ring_force_.begin(), rows_, 0.0);
  if (equations_ == 0) return;
  forEachEquation([&](int e, const double* G, const PlacedRings& r) { mu_[e] = (rate_[e] - dot(G, u + r.row, r.nv)) / h_; });
  S_.solve(mu_.data());
  forEachEquation([&](int e, const double* G, const PlacedRings& r) {
    for (int k = 0; k < r.nv; ++k) ring_force_[r.row + k] += G[k] * mu_[e];
  });
  for (int i = 0; i < rows_; ++i) force_[i] += ring_force_[i];
  A.solve(force_.data(), u);
}

void JointSolver::readForces(JointOperator& A, const double* v, const double* u) noexcept {
  for (const std::ptrdiff_t i : present_) {
    Law& law = laws_[i];
    law.force = law.now().vertical ? A.required(law.link, law.row, u) - ring_force_[law.row]
                                   : law.forceAt(v[law.v] + u[law.row]);
  }
}

/// Friction of threads by the axial forces of this pass.
JointSolver::Rubbed JointSolver::rub() noexcept {
  Rubbed rubbed = Rubbed::kFound;
  for (PlacedThread& t : threads_) {
    Law& law = laws_[t.law];
    if (law.row == kAbsent) continue;
    const double force = mu_[rings_[t.rings].first + t.equation], size = std::abs(force);
    const double forward = t.thread.lever(t.thread.climbs(force, 1)), backward = t.thread.lever(t.thread.climbs(force, -1));
    JointFriction next{forward * size, backward * size};
    const ForcePiece& piece = law.now();
    const int side = piece.vertical ? 0 : piece.from >= 0 ? 1 : -1;
    if (side != 0) {
      const double was = side > 0 ? t.friction.forward : t.friction.backward, lever = side > 0 ? forward : backward;
      double& now = side > 0 ? next.forward : next.backward;
      if (std::abs(now - was) <= kRubbed * now) {
        now = was;
      } else {
        // The force of another friction, as both changed since an earlier pass; a thread that jams has no such friction that moves.
        if (t.side == side && (force > 0) == (t.force > 0) && was != t.rubbed) {
          const double slope = (size - std::abs(t.force)) / (was - t.rubbed);
          const bool jams = !(lever * slope < 1);
          now = jams ? 2 * now : std::max(0.0, lever * (size - slope * was) / (1 - lever * slope));
          if (jams && rubbed == Rubbed::kFound) rubbed = Rubbed::kJams;
          if (!jams) rubbed = Rubbed::kNext;
        } else {
          rubbed = Rubbed::kNext;
        }
      }
      t.force = force;
      t.rubbed = was;
    }
    t.side = side;
    t.friction = next;
    buildGraph(law);
  }
  return rubbed;
}

/// Moves joints that left their piece to the next one: all of them, or the last. False: all are where they belong.
bool JointSolver::move(bool all, const double* v, const double* u) noexcept {
  bool moved = false;
  for (auto i = present_.rbegin(); i != present_.rend() && (all || !moved); ++i) {
    Law& law = laws_[*i];
    moved |= law.graph.follow(v[law.v] + u[law.row], law.force, law.piece);
  }
  return moved;
}

void JointSolver::closingWay(double* way) noexcept {
  S_.factor(equations_, kClosingDamping);
  S_.solve(gap_.data());
  for (int e = 0; e < equations_; ++e) gap_[e] = -gap_[e];
  std::fill_n(way, rows_, 0.0);
  addResponse(gap_.data(), way);
}

double JointSolver::closure(const LinkWork* work) const noexcept {
  double largest = 0;
  for (const PlacedRings& r : rings_) largest = std::max(largest, r.rings.closure(work + r.place.link));
  return largest;
}

double JointSolver::slope(const double* v, const double* u) const noexcept {
  double sum = 0;
  for (const std::ptrdiff_t i : present_damped_) {
    const Damped& d = damped_[i];
    sum += h_ * d.damping * v[d.v] * u[d.v];
  }
  for (const std::ptrdiff_t i : present_) {
    const Law& law = laws_[i];
    const ForcePiece& piece = law.graph.pieces[law.graph.at(v[law.v])];
    const double force = piece.vertical ? std::min(std::max(law.force, piece.low), piece.high)
                                        : piece.offset - piece.slope * v[law.v];
    sum -= h_ * force * u[law.v];
  }
  for (int e = 0; e < equations_; ++e) sum -= h_ * mu_[e] * rate_[e];
  return sum;
}

bool JointSolver::isSmooth(const double* v0) const noexcept {
  for (const std::ptrdiff_t i : present_) {
    const Law& law = laws_[i];
    const ForcePiece& piece = law.now();
    const double start = v0[law.v];
    const bool stood = std::abs(start) * h_ <= kStandingWay;
    if (piece.vertical && !(stood && std::abs(piece.from) * h_ <= kStandingWay)) return false;
    if (piece.vertical || !law.friction.sticks) continue;
    if (stood || (start > 0 ? piece.to <= 0 : piece.from >= 0)) return false;
  }
  return true;
}

void JointSolver::account(const JointCommand* commands, double share, const double* q0, const double* v0, const double* v1,
                          JointForce* forces, JointWork& sum) const noexcept {
  for (const std::ptrdiff_t i : present_) {
    const Law& law = laws_[i];
    const double rate = v1[law.v], way = 0.5 * share * (v0[law.v] + rate);
    const double drive = driveForce(law.joint, commands[law.command], law.q_start, h_, rate);
    const double all = law.forceAt(rate);
    forces[law.link] = {drive, all};
    const auto mean = [&](double start, double end) { return q0 ? 0.5 * (start + end) : end; };
    sum.damping += law.joint.damping * mean(v0[law.v], rate) * way;
    sum.drives += mean(q0 ? driveForce(law.joint, commands[law.command], q0[law.q], 0, v0[law.v]) : 0, drive) * way;
    const double spring = law.joint.spring_stiffness * (law.joint.spring_position - law.q_start - h_ * rate);
    sum.friction -= (all - drive - spring + law.joint.damping * rate) * way;
  }
  for (const std::ptrdiff_t i : present_damped_) {
    const Damped& d = damped_[i];
    const double mean = 0.5 * (v0[d.v] + v1[d.v]);
    sum.damping += d.damping * (q0 ? mean : v1[d.v]) * share * mean;
  }
}

}  // namespace haptic
