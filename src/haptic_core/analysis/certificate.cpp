#include "haptic_core/analysis/certificate.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "haptic_core/base/elementary.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/damper_limit.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr double kSafe = 1 - 1e-3;     ///< the limit is given a thousandth low: differences and bisection
constexpr double kMargin = 0.9;        ///< share of the limit that explicit steps may use: rest states move
constexpr int kMostSubsteps = 4;       ///< an implicit step costs about as much as this many explicit ones
constexpr double kLongest = 0.1;       ///< [s], the longest step a world may have
constexpr double kDifference = 1e-3;   ///< finite differences: share of the least depth
constexpr double kAside = 30;          ///< differences: how many steps aside of the rest state, 3 % of the depth
constexpr double kFinerToSettle = 8;   ///< the explicit steps that point contacts settle by: below any limit worth certifying
constexpr double kGrowthNoise = 1e-3;  ///< growth below this share of sqrt(g/size) is rounding of the differences

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// The linearisation of one settled world.
class Linearisation {
 public:
  explicit Linearisation(const World& world)
      : model_(world.model()),
        state_(world.state()),
        pairs_(state_.pairs),
        seams_(model_),
        held_by_(model_.links.size(), -1),
        work_(model_.links.size()),
        X_WS_(model_.shapes.size()) {
    model_.reserve(workspace_);
    // A hand at rest holds its link, whatever its coupling.
    for (std::size_t i = 0; i < state_.pointers.size(); ++i) held_by_[state_.pointers[i].link] = static_cast<int>(i);
    for (const ModelMotion& motion : model_.motions) held_by_[motion.link] = static_cast<int>(state_.pointers.size());
    gravity_ = world.settings().gravity;
    for (const ModelTree& tree : model_.trees) moves_.push_back(!tree.model->isStatic() && held_by_[tree.link] < 0);
    place(state_.q);
    linearise();
  }

  int dof() const { return model_.nv; }
  bool moves(int tree) const { return moves_[tree]; }

  struct Contact {
    int a, b, tree_a, tree_b;
    ContactVolume volume;
    PairLaw law;
    Matrix J;  ///< twist of B against A at P, P's axes: 6 × dof
    Matrix6 stiffness, damping;  ///< of the patch, P's axes
    Matrix6 mobility = Matrix6::Zero();  ///< of both bodies, their masses shared among their contacts
    int parts = 1;                       ///< contacts that share the mass of the body which has most of them
  };

  Matrix M, K;
  std::vector<Contact> contacts;

 private:
  void place(const std::vector<double>& q) {
    const std::vector<double> rest(model_.nv, 0.0);
    for (const ModelTree& tree : model_.trees) {
      forwardKinematics(*tree.model, q.data() + tree.q, rest.data() + tree.v, work_.data() + tree.link);
    }
    for (std::size_t s = 0; s < X_WS_.size(); ++s) {
      X_WS_[s] = work_[model_.shapes[s].link].X_WL * model_.shapes[s].X_LS;
    }
  }

  /// Calls `visit` with every pair that touches, its contact at rest, without friction's memory.
  template <class Visit>
  void forEachContact(Visit&& visit) {
    std::copy(state_.pairs.begin(), state_.pairs.end(), pairs_.begin());
    if (seams_.any()) seams_.find(pairs_.data(), nullptr, state_.pair_count, X_WS_.data(), workspace_);
    const ContactPlaces places{work_.data(), X_WS_.data(), held_by_.data()};
    ContactEvaluation contact;
    for (int i = 0; i < state_.pair_count; ++i) {
      if (!locateContact(model_, seams_, i, pairs_[i], places, workspace_, contact)) continue;
      contact.V_AB_P = Twist{};  // belts stand as well: their friction does not depend on poses
      contact.belt.setZero();
      contact.force = locatedForce(contact.volume, contact.X_AB, workspace_, contact.V_AB_P, FrictionMemory{}, contact.law, Advance{});
      visit(pairs_[i], contact);
    }
  }

  /// Normal forces and weight on all degrees; without slip there is no friction.
  Vector forces(const std::vector<double>& q) {
    place(q);
    Vector f = Vector::Zero(model_.nv);
    forEachContact([&](const ActivePair& pair, const ContactEvaluation& contact) {
      const Wrench F_BP_W = contact.force.F_BP_P.rotated(contact.X_WP.R);
      push(model_.shapes[pair.shapeB()].link, F_BP_W, contact.X_WP.p, f);
      push(model_.shapes[pair.shapeA()].link, -F_BP_W, contact.X_WP.p, f);
    });
    for (std::size_t l = 0; l < model_.links.size(); ++l) {
      Wrench weight;
      weight.force = model_.links[l].mass * gravity_;
      push(static_cast<int>(l), weight, work_[l].p_WC(), f);
    }
    return f;
  }
  void push(int link, const Wrench& F_W, const Vector3& p, Vector& f) {
    const ModelTree& tree = model_.trees[model_.links[link].articulation];
    if (!moves_[model_.links[link].articulation]) return;
    addGeneralisedForce(*tree.model, work_.data() + tree.link, model_.links[link].local, F_W, p, f.data() + tree.v);
  }

  void linearise() {
    M = Matrix::Zero(model_.nv, model_.nv);
    K = M;
    double least_depth = 1e300;
    forEachContact([&](const ActivePair& pair, const ContactEvaluation& contact) {
      addContact(pair, contact);
      least_depth = std::min(least_depth, contact.volume.volume / contact.volume.A0);
    });
    for (std::size_t t = 0; t < model_.trees.size(); ++t) {
      const ModelTree& tree = model_.trees[t];
      const int n = tree.model->nv();
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> block(n, n);
      if (n == 0) continue;
      massMatrix(*tree.model, work_.data() + tree.link, block.data());
      M.block(tree.v, tree.v, n, n) = block;
    }
    if (contacts.empty()) return;
    for (const Contact& c : contacts) {
      Matrix6 springs = Matrix6::Zero();  // friction: the normal part comes from the differences
      springs.block<3, 3>(2, 2) = c.stiffness.block<3, 3>(2, 2);
      K += c.J.transpose() * springs * c.J;
    }
    shareMobility();
    addDifferences(kDifference * least_depth);
    K = (0.5 * (K + K.transpose())).eval();
  }

  void shareMobility() {
    std::vector<int> count(model_.trees.size(), 0);
    for (const Contact& c : contacts) {
      ++count[c.tree_a];
      ++count[c.tree_b];
    }
    for (Contact& c : contacts) {
      c.mobility.setZero();
      c.parts = std::max(moves_[c.tree_a] ? count[c.tree_a] : 1, moves_[c.tree_b] ? count[c.tree_b] : 1);
      for (int t : {c.tree_a, c.tree_b}) {
        const ModelTree& tree = model_.trees[t];
        const int n = tree.model->nv();
        if (!moves_[t] || n == 0) continue;
        const auto J = c.J.middleCols(tree.v, n);
        c.mobility += count[t] * (J * M.block(tree.v, tree.v, n, n).llt().solve(J.transpose()));
      }
    }
  }

  void addContact(const ActivePair& pair, const ContactEvaluation& contact) {
    Contact c;
    c.a = model_.shapes[pair.shapeA()].link;
    c.b = model_.shapes[pair.shapeB()].link;
    c.tree_a = model_.links[c.a].articulation;
    c.tree_b = model_.links[c.b].articulation;
    c.volume = contact.volume;
    c.law = contact.law;
    c.stiffness = contact.force.tangent.combined(1, 0);
    c.damping = contact.force.tangent.combined(0, 1);
    c.J = Matrix::Zero(6, model_.nv);
    addJacobian(c.b, contact.X_WP, 1, c.J);
    addJacobian(c.a, contact.X_WP, -1, c.J);
    contacts.push_back(c);
  }
  void addJacobian(int link, const Pose& X_WP, double sign, Matrix& J) {
    const ModelTree& tree = model_.trees[model_.links[link].articulation];
    if (!moves_[model_.links[link].articulation]) return;
    for (int i = 0; i < tree.model->nv(); ++i) {
      Vector unit = Vector::Zero(tree.model->nv());
      unit[i] = 1;
      const Twist V = pointTwist(*tree.model, work_.data() + tree.link, model_.links[link].local, X_WP.p, unit.data());
      J.col(tree.v + i) += sign * V.rotated(X_WP.R.transpose()).vector();
    }
  }

  /// Where faces end exactly above one another, a shift to either side uncovers an edge: the force has a kink there
  /// (of the size N d/a, harmless under friction). The differences are taken beside it, each body aside by its own
  /// part of kAside steps, so that none straddles it.
  void addDifferences(double epsilon) {
    std::vector<double> beside = state_.q;
    for (std::size_t t = 0; t < model_.trees.size(); ++t) {
      const ModelTree& tree = model_.trees[t];
      Vector aside(tree.model->nv());
      for (int i = 0; i < tree.model->nv(); ++i) {
        const double golden = 0.6180339887 * (tree.v + i + 1);  // neighbours differ by 0.29 at least
        const bool turns = tree.model->isFreeBody() && i < 3;   // a turn would shift faces back over one another
        aside[i] = turns ? 0 : kAside * (golden - std::floor(golden)) / reach(tree, i);
      }
      if (moves_[t]) integratePositions(*tree.model, beside.data() + tree.q, aside.data(), epsilon);
    }
    for (std::size_t t = 0; t < model_.trees.size(); ++t) {
      const ModelTree& tree = model_.trees[t];
      if (!moves_[t]) continue;
      for (int i = 0; i < tree.model->nv(); ++i) {
        const double step = epsilon / reach(tree, i);
        Vector direction = Vector::Zero(tree.model->nv());
        Vector change = Vector::Zero(model_.nv);
        for (double sign : {1.0, -1.0}) {
          direction[i] = sign;
          std::vector<double> q = beside;
          integratePositions(*tree.model, q.data() + tree.q, direction.data(), step);
          change += sign * forces(q);
        }
        K.col(tree.v + i) -= change / (2 * step);
      }
    }
    place(state_.q);
  }
  /// What turns a step of a degree into one of the body's ends: its size for a rotation, one for a translation.
  double reach(const ModelTree& tree, int degree) const {
    return !tree.model->isFreeBody() || degree < 3 ? model_.links[tree.link].size : 1;
  }

  const Model& model_;
  const State& state_;
  std::vector<ActivePair> pairs_;  ///< the state's, whose caches advance
  Seams seams_;
  ContactWorkspace workspace_;
  std::vector<int> held_by_;
  std::vector<char> moves_;
  std::vector<LinkWork> work_;
  std::vector<Pose> X_WS_;
  Vector3 gravity_;
};

/// Trees connected by contacts; −1 for those that do not move or touch nothing.
std::vector<int> islandsOf(const Linearisation& linear, int trees, int& count) {
  std::vector<int> root(trees);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int t) {
    while (root[t] != t) t = root[t];
    return t;
  };
  std::vector<char> touches(trees, 0);
  for (const auto& c : linear.contacts) {
    if (linear.moves(c.tree_a) && linear.moves(c.tree_b)) root[find(c.tree_a)] = find(c.tree_b);
    touches[c.tree_a] = touches[c.tree_b] = 1;
  }
  std::vector<int> island(trees, -1), number(trees, -1);
  count = 0;
  for (int t = 0; t < trees; ++t) {
    if (!linear.moves(t) || !touches[t]) continue;
    const int r = find(t);
    if (number[r] < 0) number[r] = count++;
    island[t] = number[r];
  }
  return island;
}

/// Small motions of an island about rest, advanced by steps of velocity Verlet as the world takes them: strong dampers are settled contact
/// by contact (stepping/settled_damper.h). Linear, so that whether a step is stable is whether a motion that has all modes grows.
class VerletMotion {
 public:
  /// K: the island's stiffness, without modes of negative stiffness, which grow whatever the step.
  VerletMotion(const Linearisation& linear, const std::vector<int>& trees, const std::vector<int>& rows, const Matrix& M, Matrix K) {
    const auto inside = [&](int tree) { return std::find(trees.begin(), trees.end(), tree) != trees.end(); };
    for (const auto& c : linear.contacts) {
      if (inside(c.tree_a) || inside(c.tree_b)) contacts_.push_back(&c);
    }
    const auto n = static_cast<Eigen::Index>(rows.size()), m = static_cast<Eigen::Index>(6 * contacts_.size());
    Matrix J(m, n);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      auto of = J.middleRows(6 * static_cast<Eigen::Index>(i), 6);
      of = contacts_[i]->J(Eigen::all, rows);
      K -= of.transpose() * contacts_[i]->stiffness * of;
    }
    J_ = J.sparseView();
    by_J_ = Matrix(M.llt().solve(J.transpose())).sparseView();
    beside_ = Matrix(M.llt().solve(K)).sparseView();
  }

  /// Whether a motion grows in steps of length h [s]: the largest change of acceleration from one step to the next by a fifth, from the
  /// second quarter of kSteps steps to the last. Undamped motions beat, and are as large in each. Slow motions, which take long to decay,
  /// change their acceleration by the square of h ω, so that they do not hide those that grow.
  bool grows(double h) const {
    constexpr int kSteps = 8000;
    constexpr double kGrown = 1.2;
    const Eigen::Index n = J_.cols(), m = J_.rows();
    std::vector<Matrix6> settles;  // (1 + h/2 W D)⁻¹ h/2 W; 0 where the damper is weak
    for (const auto* c : contacts_) {
      const bool strong = isStrong(c->damping, layerArea(c->volume), c->parts, h, c->law.reduced_mass);
      const Matrix6 sW = 0.5 * h * c->mobility, of_D = Matrix6::Identity() + sW * c->damping;
      settles.push_back(strong ? Matrix6(of_D.partialPivLu().solve(sW)) : Matrix6(Matrix6::Zero()));
    }
    Vector x = Vector::Zero(n), v(n), F = Vector::Zero(m), F_before(m), a = Vector::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = elementary::cos(2.0 * static_cast<double>(i * i) + 1);  // in no mode's kernel
    double largest[4] = {0, 0, 0, 0};
    for (int step = 0; step < kSteps; ++step) {
      v += 0.5 * h * a;
      x += h * v;
      const Vector u = J_ * x, V = J_ * Vector(v + 0.5 * h * a);
      F_before = F;
      for (std::size_t i = 0; i < contacts_.size(); ++i) {
        const Eigen::Index at = 6 * static_cast<Eigen::Index>(i);
        const Matrix6 &K = contacts_[i]->stiffness, &D = contacts_[i]->damping;
        const Vector6 predicted = -K * u.segment<6>(at) - D * V.segment<6>(at);
        F.segment<6>(at) = predicted - D * (settles[i] * (predicted - F_before.segment<6>(at)));
      }
      const Vector a_before = a;
      a = by_J_ * F - beside_ * x;
      v += 0.5 * h * a;
      const double now = (a - a_before).norm();
      if (!(now < 1e100)) return true;
      double& most = largest[4 * step / kSteps];
      most = std::max(most, now);
    }
    return largest[3] > kGrown * largest[1];
  }

 private:
  std::vector<const Linearisation::Contact*> contacts_;
  Eigen::SparseMatrix<double> J_, by_J_, beside_;  ///< J; M⁻¹ Jᵀ; M⁻¹ (K - Σ Jᵀ K_c J): gravity, turning normals
};

/// Largest stable step, searched from `start` on; infinite from kLongest on.
double largestStep(const VerletMotion& motion, double start) {
  double low = std::min(start, kLongest), high = low;
  for (int i = 0; i < 40 && motion.grows(low); ++i) high = low, low *= 0.8;
  while (high == low) {
    high = std::min(1.25 * low, kLongest);
    if (motion.grows(high)) break;
    if (high == kLongest) return std::numeric_limits<double>::infinity();
    low = high;
  }
  while (high > 1.0005 * low) {
    const double middle = 0.5 * (low + high);
    (motion.grows(middle) ? high : low) = middle;
  }
  return low;
}

IslandCertificate judgeIsland(const Linearisation& linear, const Model& model, const std::vector<int>& trees,
                              const WorldSettings& settings, double step) {
  IslandCertificate island;
  std::vector<int> rows;
  double lightest = 1e300, heaviest = 0, size = 0;
  for (int t : trees) {
    const ModelTree& tree = model.trees[t];
    for (int i = 0; i < tree.model->nv(); ++i) rows.push_back(tree.v + i);
    for (int l = 0; l < tree.model->linkCount(); ++l) {
      const ModelLink& link = model.links[tree.link + l];
      island.links.push_back(link.name);
      if (link.mass > 0) lightest = std::min(lightest, link.mass);
      heaviest = std::max(heaviest, link.mass);
      size = std::max(size, link.size);
    }
  }
  const Matrix M = linear.M(rows, rows), K = linear.K(rows, rows);
  island.degrees = static_cast<int>(rows.size());
  island.mass_ratio = heaviest / lightest;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> modes(K, M);
  island.frequency = std::sqrt(std::max(0.0, modes.eigenvalues().maxCoeff()));
  Matrix stiff = K;
  for (Eigen::Index i = 0; i < modes.eigenvalues().size(); ++i) {
    const Vector mode = M * modes.eigenvectors().col(i);
    if (modes.eigenvalues()[i] < 0) stiff -= modes.eigenvalues()[i] * mode * mode.transpose();
  }
  island.limit = kSafe * largestStep(VerletMotion(linear, trees, rows, M, stiff), 0.999 * 2 / island.frequency);
  const double least = modes.eigenvalues().minCoeff();
  const double noise = kGrowthNoise * std::sqrt(settings.gravity.norm() / size);
  island.growth = least < -noise * noise ? std::sqrt(-least) : 0;
  // The contact that holds most of the stiffest mode's energy.
  const Vector mode = modes.eigenvectors().col(island.degrees - 1);
  double most = -1;
  for (std::size_t c = 0; c < linear.contacts.size(); ++c) {
    const Vector u = linear.contacts[c].J(Eigen::all, rows) * mode;
    const double energy = u.dot(linear.contacts[c].stiffness * u);
    if (energy > most) {
      most = energy;
      island.worst_pair = static_cast<int>(c);
    }
  }
  if (island.growth > 0 &&
      std::all_of(trees.begin(), trees.end(), [&](int t) { return model.trees[t].model->isFreeBody(); })) {
    island.verdict = Verdict::kRefused;
    return island;
  }
  if (settings.attempts != Attempts::kVerlet || step <= kMargin * island.limit) return island;
  island.substeps = static_cast<int>(std::ceil(step / (kMargin * island.limit)));
  island.verdict = island.substeps <= kMostSubsteps ? Verdict::kSubstep : Verdict::kImplicit;
  return island;
}

std::string milliseconds(double seconds) {
  std::ostringstream out;
  out.precision(3);
  if (std::isinf(seconds)) {
    out << "> 100 ms";
  } else {
    out << seconds * 1e3 << " ms";
  }
  return out.str();
}

}  // namespace

const char* toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return "PASS";
    case Verdict::kSubstep:
      return "SUBSTEP";
    case Verdict::kImplicit:
      return "IMPLICIT";
    case Verdict::kRefused:
      return "REFUSED";
  }
  return "unknown";
}

Certificate certify(const WorldDef& def, double settle_s) {
  WorldDef quiet = def;
  quiet.settings.attempts = Attempts::kImplicitEuler;
  quiet.settings.substeps = 1;
  quiet.settings.step = 5e-3;  // dissipative, and long enough that a second costs 200 steps
  quiet.settings.energy_ledger = false;
  if (def.settings.contact_model) {  // goes with explicit steps only
    quiet.settings.attempts = Attempts::kVerlet;
    quiet.settings.step = def.settings.step / def.settings.substeps / kFinerToSettle;
  }
  World world(quiet);
  const int steps = std::max(1, static_cast<int>(std::lround(settle_s / quiet.settings.step)));
  for (int i = 0; i < steps; ++i) world.step();

  Certificate certificate;
  certificate.step = def.settings.step / def.settings.substeps;
  double speed = 0;
  for (double v : world.state().v) speed = std::max(speed, std::abs(v));
  certificate.settled = speed < 1e-3;
  const Model& model = world.model();
  const Linearisation linear(world);
  for (const auto& c : linear.contacts) {
    PairCertificate pair;
    pair.a = model.links[c.a].name;
    pair.b = model.links[c.b].name;
    pair.stiffness = c.law.material.stiffness * c.volume.A0;
    const Vector n = c.J.row(5).transpose();
    std::vector<int> rows;
    for (int i = 0; i < linear.dof(); ++i) {
      if (linear.M(i, i) > 0 && n[i] != 0) rows.push_back(i);
    }
    const Vector n_rows = n(rows);
    const double inverse_mass = rows.empty() ? 0 : n_rows.dot(Matrix(linear.M(rows, rows)).llt().solve(n_rows));
    pair.mass = inverse_mass > 0 ? 1 / inverse_mass : std::numeric_limits<double>::infinity();
    const double b = c.damping(5, 5);
    const double settled = 2 * std::sqrt(pair.mass / pair.stiffness);
    pair.heave_limit = settled * b < kStrongDamper * pair.mass
                           ? 2 * (std::sqrt(b * b + pair.stiffness * pair.mass) - b) / pair.stiffness  // k h² + 4 b h = 4 m
                           : settled;
    certificate.pairs.push_back(pair);
  }
  int count = 0;
  const std::vector<int> island_of = islandsOf(linear, static_cast<int>(model.trees.size()), count);
  for (int i = 0; i < count; ++i) {
    std::vector<int> trees;
    for (int t = 0; t < static_cast<int>(island_of.size()); ++t) {
      if (island_of[t] == i) trees.push_back(t);
    }
    certificate.islands.push_back(judgeIsland(linear, model, trees, def.settings, certificate.step));
    certificate.verdict = std::max(certificate.verdict, certificate.islands.back().verdict);
  }
  return certificate;
}

std::string Certificate::text() const {
  std::ostringstream out;
  out.precision(3);
  out << "certificate: " << toString(verdict) << " at " << milliseconds(step)
      << (settled ? "" : " (judged in motion: the scene does not come to rest)") << "\n"
      << "  it holds for small motions about the contacts below; where patches grow, hit or slide in motion, the energy ledger "
         "shows the gain of each step\n";
  for (const IslandCertificate& island : islands) {
    out << "  island of " << island.links.size() << " (" << island.links.front()
        << (island.links.size() > 1 ? ", ...)" : ")") << ": " << toString(island.verdict);
    if (island.verdict == Verdict::kSubstep) out << " " << island.substeps;
    out << "; explicit to " << milliseconds(island.limit) << ", stiffest mode " << island.frequency
        << " rad/s, mass ratio " << island.mass_ratio;
    if (island.worst_pair >= 0) {
      const PairCertificate& pair = pairs[island.worst_pair];
      out << ", limited by " << pair.a << " on " << pair.b;
    }
    if (island.growth > 0) {
      out << "; BUCKLES or topples under its own weight at " << island.growth
          << " 1/s: no step helps, raise the stiffness or support it";
    }
    out << "\n";
  }
  for (const PairCertificate& pair : pairs) {
    out << "  contact " << pair.a << " - " << pair.b << ": k_eff " << pair.stiffness << " N/m on " << pair.mass
        << " kg, heave alone to " << milliseconds(pair.heave_limit) << "\n";
  }
  return out.str();
}

}  // namespace haptic
