#include "haptic_core/analysis/certificate.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "haptic_core/analysis/linearisation.h"
#include "haptic_core/analysis/strong_damper.h"
#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/base/disjoint_sets.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace {

constexpr double kSafe = 1 - 1e-3;     ///< the limit is given a thousandth low: differences and bisection
constexpr double kLongest = 0.1;       ///< [s], the longest step a world may have
constexpr double kGrowthNoise = 1e-3;  ///< growth below this share of sqrt(g/size) is rounding of the differences

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Trees connected by contacts, ascending.
std::vector<std::vector<int>> islandsOf(const Linearisation& linear, int trees) {
  DisjointSets touching(trees);
  for (const auto& c : linear.contacts) {
    if (linear.moves(c.tree_a) && linear.moves(c.tree_b)) touching.merge(c.tree_a, c.tree_b);
  }
  std::vector<int> number(trees, -1);
  std::vector<std::vector<int>> islands;
  for (int t = 0; t < trees; ++t) {
    if (linear.contacts_of.empty() || linear.contacts_of[t].empty()) continue;
    const int r = touching.root(t);
    if (number[r] < 0) number[r] = static_cast<int>(islands.size()), islands.emplace_back();
    islands[number[r]].push_back(t);
  }
  return islands;
}

/// Small motions of an island about rest, advanced by steps of velocity Verlet as the world takes them: strong dampers are settled contact
/// by contact (test/comparators/settled_damper.h). Linear, so that whether a step is stable is whether a motion that has all modes grows.
class VerletMotion {
 public:
  /// K: the island's stiffness, without modes of negative stiffness, which grow whatever the step.
  VerletMotion(std::vector<const Linearisation::Contact*> contacts, const Rows& rows, const Matrix& M, Matrix K)
      : contacts_(std::move(contacts)) {
    const auto m = static_cast<Eigen::Index>(6 * contacts_.size());
    Matrix J(m, rows.count);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      auto of = J.middleRows(6 * static_cast<Eigen::Index>(i), 6);
      of = rows.of(*contacts_[i]);
      K -= of.transpose().lazyProduct(contacts_[i]->stiffness.lazyProduct(of).eval());
    }
    J_ = J.sparseView();
    by_J_ = solveSymmetric(M, J.transpose()).sparseView();
    beside_ = solveSymmetric(M, K).sparseView();
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
      settles.push_back(strong ? Matrix6(Matrix6(inverse(of_D)) * sW) : Matrix6(Matrix6::Zero()));
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
double largestStep(const VerletMotion& motion, double start, const std::function<bool()>& goOn) {
  const auto grows = [&](double h) {
    if (goOn && !goOn()) throw Stopped{};
    return motion.grows(h);
  };
  double low = std::min(start, kLongest), high = low;
  for (int i = 0; i < 40 && grows(low); ++i) high = low, low *= 0.8;
  while (high == low) {
    high = std::min(1.25 * low, kLongest);
    if (grows(high)) break;
    if (high == kLongest) return std::numeric_limits<double>::infinity();
    low = high;
  }
  while (high > 1.0005 * low) {
    const double middle = 0.5 * (low + high);
    (grows(middle) ? high : low) = middle;
  }
  return low;
}

IslandCertificate judgeIsland(const Linearisation& linear, const Model& model, const std::vector<int>& trees,
                              const WorldSettings& settings, const std::function<bool()>& goOn) {
  IslandCertificate island;
  const Rows rows(linear, trees);
  double lightest = 1e300, heaviest = 0, size = 0;
  for (int t : trees) {
    const ModelTree& tree = model.trees[t];
    for (int l = 0; l < tree.model->linkCount(); ++l) {
      const ModelLink& link = model.links[tree.link + l];
      island.links.push_back(link.name);
      if (link.mass > 0) lightest = std::min(lightest, link.mass);
      heaviest = std::max(heaviest, link.mass);
      size = std::max(size, link.size);
    }
  }
  Matrix M = Matrix::Zero(rows.count, rows.count);
  std::vector<int> touching;  // indices of its contacts
  for (const int t : trees) {
    M.block(rows.first[t], rows.first[t], linear.M[t].rows(), linear.M[t].cols()) = linear.M[t];
    touching.insert(touching.end(), linear.contacts_of[t].begin(), linear.contacts_of[t].end());
  }
  std::sort(touching.begin(), touching.end());
  touching.erase(std::unique(touching.begin(), touching.end()), touching.end());
  std::vector<const Linearisation::Contact*> contacts;
  for (const int c : touching) contacts.push_back(&linear.contacts[c]);
  const Matrix K = linear.stiffness(trees, rows.first, rows.count);
  island.degrees = static_cast<int>(rows.count);
  island.mass_ratio = heaviest / lightest;
  const Modes modes = modesOf(K, M);
  island.frequency = std::sqrt(std::max(0.0, modes.values.maxCoeff()));
  Matrix stiff = K;
  for (Eigen::Index i = 0; i < modes.values.size(); ++i) {
    const Vector mode = M * modes.vectors.col(i);
    if (modes.values[i] < 0) stiff -= modes.values[i] * mode * mode.transpose();
  }
  island.limit = kSafe * largestStep(VerletMotion(contacts, rows, M, stiff), 0.999 * 2 / island.frequency, goOn);
  const double least = modes.values.minCoeff();
  const double noise = kGrowthNoise * std::sqrt(settings.gravity.norm() / size);
  island.growth = least < -noise * noise ? std::sqrt(-least) : 0;
  // The contact that holds most of the stiffest mode's energy.
  const Vector mode = modes.vectors.col(island.degrees - 1);
  double most = -1;
  for (const int c : touching) {
    const Vector u = rows.of(linear.contacts[c]) * mode;
    const double energy = u.dot(linear.contacts[c].stiffness * u);
    if (energy > most) {
      most = energy;
      island.worst_pair = c;
    }
  }
  if (island.growth > 0 &&
      std::all_of(trees.begin(), trees.end(), [&](int t) { return model.trees[t].model->isFreeBody(); })) {
    island.verdict = Verdict::kRefused;
  }
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
    case Verdict::kRefused:
      return "REFUSED";
  }
  return "unknown";
}

Certificate certify(const WorldDef& def, double settle_s, const std::function<bool()>& goOn) try {
  WorldDef quiet = def;
  quiet.settings.attempts = Attempts::kImplicitEuler;
  quiet.settings.comparator = nullptr;
  quiet.settings.step = 5e-3;  // dissipative, and long enough that a second costs 200 steps
  quiet.settings.energy_ledger = false;
  World world(quiet);
  const int steps = std::max(1, static_cast<int>(std::lround(settle_s / quiet.settings.step)));
  for (int i = 0; i < steps; ++i) {
    if (goOn && !goOn()) throw Stopped{};
    world.step();
  }

  Certificate certificate;
  certificate.step = def.settings.step;
  double speed = 0;
  for (double v : world.state().v) speed = std::max(speed, std::abs(v));
  certificate.settled = speed < 1e-3;
  const Model& model = world.model();
  const Linearisation linear(world, goOn);
  for (const auto& c : linear.contacts) {
    PairCertificate pair;
    pair.a = model.links[c.a].name;
    pair.b = model.links[c.b].name;
    pair.stiffness = c.law.material.stiffness * c.volume.A0;
    double inverse_mass = 0;
    c.eachTree([&](int t, const Matrix& J) {
      const Matrix& M = linear.M[t];
      const Vector n = J.row(5).transpose();
      std::vector<int> rows;
      for (int i = 0; i < static_cast<int>(n.size()); ++i) {
        if (M(i, i) > 0 && n[i] != 0) rows.push_back(i);
      }
      const Vector n_rows = n(rows);
      if (!rows.empty()) inverse_mass += n_rows.dot(Vector(solveSymmetric(M(rows, rows), n_rows)));
    });
    pair.mass = inverse_mass > 0 ? 1 / inverse_mass : std::numeric_limits<double>::infinity();
    const double b = c.damping(5, 5);
    const double settled = 2 * std::sqrt(pair.mass / pair.stiffness);
    pair.heave_limit = settled * b < kStrongDamper * pair.mass
                           ? 2 * (std::sqrt(b * b + pair.stiffness * pair.mass) - b) / pair.stiffness  // k h² + 4 b h = 4 m
                           : settled;
    certificate.pairs.push_back(pair);
  }
  for (const std::vector<int>& trees : islandsOf(linear, static_cast<int>(model.trees.size()))) {
    certificate.islands.push_back(judgeIsland(linear, model, trees, def.settings, goOn));
    certificate.verdict = std::max(certificate.verdict, certificate.islands.back().verdict);
  }
  return certificate;
} catch (const Stopped&) {
  return {};
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
    out << "; velocity Verlet to " << milliseconds(island.limit) << ", stiffest mode " << island.frequency
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
