// Figures of designing a device: certified workspaces of all device files against an exact solve of its own.
//   bench_design [POSES [DEVICE]]: random poses in all (1000000); one device alone.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <random>

#include "figure.h"
#include "haptic_core/design/interference.h"
#include "haptic_core/design/workspace.h"

namespace {

using namespace haptic;
using bench::figure;
using Real = long double;

std::vector<DeviceDef> devices(const std::string& only) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices"))
    if (entry.path().extension() == ".yaml" && (only.empty() || entry.path().stem() == only)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<DeviceDef> found;
  for (const std::string& file : files) found.push_back(loadDevice(file));
  return found;
}

/// Least of what every user would call force feedback, and the torque that it makes at the knots.
RequiredWrench required(const DeviceDef& def) {
  const double force = std::min(1.0, 0.1 * def.strings[0].max_tension);
  return {force, def.dof == 3 ? 0 : force * StringKinematics(def).knotRadius()};
}

/// The exact solve, in 64 bits of mantissa and by means of its own: rows from Rodrigues' formula, normals of faces by elimination with
/// full pivoting. Returns the least of h_Z - h_B over unit normals [N]; `singular` the least singular value, by bisection of LDLᵀ.
class Exact {
 public:
  Exact(const DeviceDef& def, const RequiredWrench& wanted) : def_(def), wanted_(wanted), radius_(StringKinematics(def).knotRadius()) {}

  void moveTo(const Vector6& at) {
    const Real x = at[3], y = at[4], z = at[5], angle = std::sqrt(x * x + y * y + z * z);
    const Real a = angle > 0 ? std::sin(angle) / angle : 1, b = angle > 1e-6L ? (1 - std::cos(angle)) / (angle * angle) : 0.5L;
    const Real R[3][3] = {{1 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y},
                          {b * x * y + a * z, 1 - b * (x * x + z * z), b * y * z - a * x},
                          {b * x * z - a * y, b * y * z + a * x, 1 - b * (x * x + y * y)}};
    for (std::size_t i = 0; i < def_.strings.size(); ++i) {
      const StringDef& s = def_.strings[i];
      Real k[3], g[3], d[3], l = 0;
      for (int c = 0; c < 3; ++c) {
        k[c] = g[c] = 0;
        for (int e = 0; e < 3; ++e) {
          k[c] += def_.dof == 3 ? 0 : R[c][e] * s.p_GK[e];
          g[c] += R[c][e] * s.dp_GK[e];
        }
        d[c] = s.p_BE[c] - at[c] - k[c];
        l += d[c] * d[c];
      }
      l = std::sqrt(l);
      for (int c = 0; c < 3; ++c) row_[i][c] = d[c] / l;
      if (def_.dof == 3) continue;
      for (int c = 0; c < 3; ++c) row_[i][3 + c] = (k[(c + 1) % 3] * d[(c + 2) % 3] - k[(c + 2) % 3] * d[(c + 1) % 3]) / l / radius_;
      row_[i][6] = (d[0] * g[0] + d[1] * g[1] + d[2] * g[2]) / l;
    }
  }

  Real margin() {
    least_ = 1e9L;
    any_ = false;
    int set[kMaxDof];
    visit(set, 0, 0);
    return any_ ? least_ : -1e9L;
  }

  Real singular() const {
    Real low = 0, high = 4;
    for (int i = 0; i < 50; ++i) {
      const Real middle = (low + high) / 2;
      (positive(middle * middle) ? low : high) = middle;
    }
    return low;
  }

 private:
  void visit(int* set, int size, int first) {
    if (size == def_.dof - 1) return judge(set);
    for (int i = first; i < static_cast<int>(def_.strings.size()); ++i) {
      set[size] = i;
      visit(set, size + 1, i + 1);
    }
  }

  void judge(const int* set) {
    const int D = def_.dof, rows = D - 1;
    Real m[kMaxDof][kMaxDof], n[kMaxDof];
    int column[kMaxDof];
    for (int c = 0; c < D; ++c) column[c] = c;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < D; ++c) m[r][c] = row_[set[r]][c];
    for (int p = 0; p < rows; ++p) {
      int best_r = p, best_c = p;
      for (int r = p; r < rows; ++r)
        for (int c = p; c < D; ++c)
          if (std::fabs(m[r][c]) > std::fabs(m[best_r][best_c])) best_r = r, best_c = c;
      if (std::fabs(m[best_r][best_c]) < 1e-12L) return;  // dependent rows: no face
      for (int c = 0; c < D; ++c) std::swap(m[p][c], m[best_r][c]);
      for (int r = 0; r < rows; ++r) std::swap(m[r][p], m[r][best_c]);
      std::swap(column[p], column[best_c]);
      for (int r = p + 1; r < rows; ++r)
        for (int c = D - 1; c >= p; --c) m[r][c] -= m[p][c] * (m[r][p] / m[p][p]);
    }
    Real y[kMaxDof], square = 1;
    y[D - 1] = 1;
    for (int r = rows - 1; r >= 0; --r) {
      y[r] = 0;
      for (int c = r + 1; c < D; ++c) y[r] -= m[r][c] * y[c] / m[r][r];
      square += y[r] * y[r];
    }
    for (int c = 0; c < D; ++c) n[column[c]] = y[c] / std::sqrt(square);
    compare(n, set);
  }

  void compare(const Real* n, const int* set) {
    any_ = true;
    Real up = 0, down = 0, force = 0, torque = 0;
    for (std::size_t i = 0; i < def_.strings.size(); ++i) {
      if (std::find(set, set + def_.dof - 1, static_cast<int>(i)) != set + def_.dof - 1) continue;
      Real y = 0;
      for (int c = 0; c < def_.dof; ++c) y += n[c] * row_[i][c];
      const StringDef& s = def_.strings[i];
      up += std::max(y * s.min_tension, y * s.max_tension);
      down += std::max(-y * s.min_tension, -y * s.max_tension);
    }
    for (int c = 0; c < 3; ++c) force += n[c] * n[c];
    for (int c = 3; c < 6 && def_.dof >= 6; ++c) torque += n[c] * n[c];
    least_ = std::min(least_, std::min(up, down) - wanted_.force * std::sqrt(force) - wanted_.torque / radius_ * std::sqrt(torque));
  }

  bool positive(Real square) const {
    const int D = def_.dof;
    Real G[kMaxDof][kMaxDof] = {};
    for (int a = 0; a < D; ++a)
      for (int b = 0; b < D; ++b)
        for (std::size_t i = 0; i < def_.strings.size(); ++i) G[a][b] += row_[i][a] * row_[i][b];
    for (int p = 0; p < D; ++p) {
      G[p][p] -= square;
      if (!(G[p][p] > 0)) return false;
      for (int r = p + 1; r < D; ++r)
        for (int c = r; c < D; ++c) G[c][r] = G[r][c] -= G[p][r] * G[p][c] / G[p][p];
    }
    return true;
  }

  const DeviceDef& def_;
  RequiredWrench wanted_;
  Real radius_, least_ = 0;
  bool any_ = false;
  Real row_[kMaxStrings][kMaxDof] = {};
};

Vector6 randomPose(std::mt19937_64& random, const PoseCell& cell) {
  Vector6 at;
  for (int j = 0; j < 6; ++j) at[j] = cell.centre[j] + std::uniform_real_distribution<double>(-1, 1)(random) * cell.half[j];
  return at;
}

/// Cells that the exact solve contradicts at one of `poses` random poses; half of the poses in small cells, which lie at the border.
long wrongCells(const Workspace& w, const DeviceDef& def, const WorkspaceSettings& settings, long poses, std::mt19937_64& random) {
  Exact exact(def, settings.required);
  std::vector<std::pair<const PoseCell*, bool>> cells;
  std::vector<double> volume;
  for (const bool is_inside : {true, false})
    for (const PoseCell& cell : is_inside ? w.inside : w.outside) {
      cells.emplace_back(&cell, is_inside);
      volume.push_back(cell.volume());
    }
  if (cells.empty()) return 0;
  std::discrete_distribution<std::size_t> by_volume(volume.begin(), volume.end());
  std::vector<bool> wrong(cells.size());
  for (long i = 0; i < poses; ++i) {
    const std::size_t at = i % 2 ? by_volume(random) : random() % cells.size();
    const Vector6 pose = randomPose(random, *cells[at].first);
    exact.moveTo(pose);
    const bool is_inside = exact.margin() > 0 && exact.singular() > settings.least_singular;
    if (is_inside != cells[at].second) wrong[at] = true;
  }
  return std::count(wrong.begin(), wrong.end(), true);
}

/// Distance of two segments by a search of the quadratic over its edges and its interior, in 64 bits of mantissa.
Real exactDistance(const Vector3& a0, const Vector3& a1, const Vector3& b0, const Vector3& b1) {
  Real u[3], v[3], w[3], uu = 0, uv = 0, vv = 0, uw = 0, vw = 0, ww = 0;
  for (int c = 0; c < 3; ++c) {
    u[c] = static_cast<Real>(a1[c]) - a0[c], v[c] = static_cast<Real>(b1[c]) - b0[c], w[c] = static_cast<Real>(a0[c]) - b0[c];
    uu += u[c] * u[c], uv += u[c] * v[c], vv += v[c] * v[c], uw += u[c] * w[c], vw += v[c] * w[c], ww += w[c] * w[c];
  }
  const auto at = [&](Real s, Real t) { return ww + s * s * uu + t * t * vv + 2 * (s * uw - t * vw - s * t * uv); };
  const auto clamped = [](Real x) { return std::min<Real>(1, std::max<Real>(0, x)); };
  Real least = 1e9L;
  for (const Real end : {0.0L, 1.0L}) {
    least = std::min(least, at(end, clamped((vw + end * uv) / vv)));
    least = std::min(least, at(clamped((end * uv - uw) / uu), end));
  }
  if (const Real det = uu * vv - uv * uv; det > 0) {
    const Real s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, at(s, t));
  }
  return std::sqrt(std::max<Real>(0, least));
}

/// Poses of the cells at which a pair of strings is nearer than its bound says: random ones, over all pairs.
long falseFree(const Workspace& w, const DeviceDef& def, long poses, std::mt19937_64& random, double& seconds) {
  const std::clock_t start = std::clock();
  const std::vector<Nearest> pairs = nearestOver(def, w.inside);
  seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  long wrong = 0;
  for (long i = 0; i < poses && !w.inside.empty(); ++i) {
    const PoseCell& cell = w.inside[random() % w.inside.size()];
    const GripPose x = cell.pose(randomPose(random, cell));
    for (const Nearest& n : pairs) {
      if (n.second < 0) continue;
      const StringDef &a = def.strings[n.first], &b = def.strings[n.second];
      const Vector3 zero = Vector3::Zero();
      const Vector3 p = x.X_BG * (def.dof == 3 ? zero : a.p_GK), q = x.X_BG * (def.dof == 3 ? zero : b.p_GK);
      wrong += exactDistance(a.p_BE, p, b.p_BE, q) < n.at_least - 1e-12L;
    }
  }
  return wrong;
}

void workspaceFigures(const std::vector<DeviceDef>& all, long poses) {
  std::mt19937_64 random(1);
  double undecided = 0, seconds = 0, widest_m = 0, widest_rad = 0;
  double near_seconds = 0;
  long wrong = 0, regions = 0, asked = 0, touching = 0;
  for (const DeviceDef& def : all) regions += def.dof == 3 ? 1 : 2;
  for (const DeviceDef& def : all) {
    WorkspaceSettings settings;
    settings.required = required(def);
    double device_seconds = 0;
    for (const PoseCell& searched : {translations(def), rotations()}) {
      const bool turns = searched.half[3] > 0;
      if (def.dof == 3 && turns) continue;
      const std::clock_t start = std::clock();
      const Workspace w = certifyWorkspace(def, searched, settings);
      const double cost = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      const double width = w.undecided.empty() ? 0 : 2 * w.undecided[0].half.maxCoeff();
      device_seconds += cost;
      undecided = std::max(undecided, 100 * w.undecided_share);
      (turns ? widest_rad : widest_m) = std::max(turns ? widest_rad : widest_m, width);
      const long here = wrongCells(w, def, settings, poses / regions, random);
      wrong += here;
      asked += poses / regions;
      double cost_near = 0;
      touching += falseFree(w, def, poses / regions, random, cost_near);
      near_seconds = std::max(near_seconds, cost_near);
      std::printf("%-24s %-12s %5.1f %% inside, %.2f %% undecided at %.2f %s; ball %.1f, about home %.1f; %zu cells, %.2f s; %ld wrong%s"
                  "\n",
                  def.name.c_str(), turns ? "turns" : "translations", 100 * w.inside_share, 100 * w.undecided_share,
                  turns ? width * 180 / M_PI : 1e3 * width, turns ? "deg" : "mm", w.ball.half.maxCoeff() * (turns ? 180 / M_PI : 1e3),
                  w.home_ball.half.maxCoeff() * (turns ? 180 / M_PI : 1e3),
                  w.inside.size() + w.outside.size() + w.undecided.size(), cost, here,
                  w.exhausted ? " (bound of the work)" : "");
      std::fflush(stdout);
    }
    seconds = std::max(seconds, device_seconds);
  }
  figure("workspace.wrong_cells", static_cast<double>(wrong), "cells");
  figure("interference.false_free", static_cast<double>(touching), "poses");
  figure("interference.seconds", near_seconds, "s");
  figure("workspace.poses", static_cast<double>(asked), "poses");
  figure("workspace.undecided_pct", undecided, "%");
  figure("workspace.seconds", seconds, "s");
  figure("workspace.undecided_mm_max", 1e3 * widest_m, "mm");
  figure("workspace.undecided_deg_max", widest_rad * 180 / M_PI, "deg");
}

}  // namespace

int main(int argc, char** argv) {
  const long poses = argc > 1 ? std::atol(argv[1]) : 1000000;
  workspaceFigures(devices(argc > 2 ? argv[2] : ""), poses);
  return 0;
}
