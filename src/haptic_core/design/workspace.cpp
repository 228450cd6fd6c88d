#include "haptic_core/design/workspace.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "haptic_core/base/dense_matrix.h"

namespace haptic {
namespace {

using Gram = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxDof, kMaxDof>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDof, 1>;
constexpr double kRounding = 1e-9;  // of singular values of about 1

/// Overwrites the lower triangle with the Cholesky factor; false where there is none.
bool factor(Gram& G) {
  const int d = static_cast<int>(G.rows());
  for (int j = 0; j < d; ++j) {
    for (int k = 0; k < j; ++k) G(j, j) -= G(j, k) * G(j, k);
    if (!(G(j, j) > 0)) return false;
    G(j, j) = std::sqrt(G(j, j));
    for (int i = j + 1; i < d; ++i) {
      for (int k = 0; k < j; ++k) G(i, j) -= G(i, k) * G(j, k);
      G(i, j) /= G(j, j);
    }
  }
  return true;
}

bool isAbove(Gram G, double square) {
  for (int j = 0; j < G.rows(); ++j) G(j, j) -= square;
  return factor(G);
}

/// About the unit vector that A shortens most: inverse iteration. Any vector serves.
Column weakest(const Gram& G) {
  Gram L = G;
  const int d = static_cast<int>(G.rows());
  for (int j = 0; j < d; ++j) L(j, j) += 1e-6;
  Column x(d);
  for (int j = 0; j < d; ++j) x[j] = 1 + 0.1 * j;
  if (!factor(L)) return x.normalized();
  for (int pass = 0; pass < 6; ++pass) {
    for (int i = 0; i < d; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= L(i, k) * x[k];
      x[i] /= L(i, i);
    }
    for (int i = d - 1; i >= 0; --i) {
      for (int k = i + 1; k < d; ++k) x[i] -= L(k, i) * x[k];
      x[i] /= L(i, i);
    }
    x.normalize();
  }
  return x;
}

/// What is to be judged of a cell.
struct OpenCell {
  PoseCell cell;
  PresentableSet::Faces faces;
  bool singular;
  double share;  // of the searched box
};

/// Coordinate whose width is the greatest multiple of the width asked for.
int widest(const PoseCell& cell, const WorkspaceSettings& s, double& multiple) {
  int found = 0;
  multiple = 0;
  for (int j = 0; j < 6; ++j) {
    const double m = 2 * cell.half[j] / (j < 3 ? s.cell_m : s.cell_rad);
    if (m > multiple * (1 + 1e-12)) {
      multiple = m;
      found = j;
    }
  }
  return found;
}

/// Cells that bound the certified ones: a closed inside cell never touches a closed outside one, so undecided ones lie between. `stride`
/// leaves all but some of them out, for a search.
struct Border {
  const Workspace& w;
  std::size_t stride;

  /// Of a point: distance to the nearest of these cells, or to the border of the searched box; 0 in an outside cell.
  double clearance(const Vector6& at) const {
    double least = 1e9;
    for (int j = 0; j < 6; ++j)
      if (w.searched.half[j] > 0) least = std::min(least, w.searched.half[j] - std::fabs(at[j] - w.searched.centre[j]));
    for (std::size_t i = 0; i < w.undecided.size() && least > 0; i += stride)
      least = std::min(least, ((w.undecided[i].centre - at).cwiseAbs() - w.undecided[i].half).cwiseMax(0).norm());
    for (std::size_t i = 0; i < w.outside.size() && least > 0; ++i)
      if (w.outside[i].contains(at)) least = 0;
    return std::max(0.0, least);
  }

  /// Largest multiple of `side` to either side of the point.
  double multiple(const Vector6& at, const Vector6& side) const {
    double least = 1e9;
    for (int j = 0; j < 6; ++j)
      if (side[j] > 0) least = std::min(least, (w.searched.half[j] - std::fabs(at[j] - w.searched.centre[j])) / side[j]);
    for (std::size_t i = 0; i < w.undecided.size(); i += stride) {
      double apart = 0;
      for (int j = 0; j < 6; ++j)
        if (side[j] > 0) apart = std::max(apart, (std::fabs(w.undecided[i].centre[j] - at[j]) - w.undecided[i].half[j]) / side[j]);
      least = std::min(least, apart);
    }
    return std::max(0.0, least);
  }
};

constexpr std::size_t kSearched = 4000;  // border cells that a search looks at; its result looks at all

PoseCell ballAt(const Workspace& w, const Vector6& at) {
  PoseCell ball;
  ball.centre = at;
  ball.half = (w.searched.half.array() > 0).cast<double>().matrix() * Border{w, 1}.clearance(at);
  return ball;
}

/// Largest ball that a pattern search from home and from the largest certified cell finds.
PoseCell largestBall(const Workspace& w) {
  const Border border{w, 1 + w.undecided.size() / kSearched};
  const auto larger = [](const PoseCell& a, const PoseCell& b) { return a.volume() < b.volume(); };
  std::vector<Vector6> starts{Vector6::Zero()};
  if (!w.inside.empty()) starts.push_back(std::max_element(w.inside.begin(), w.inside.end(), larger)->centre);
  PoseCell best = ballAt(w, starts[0]);
  for (Vector6 at : starts) {
    double radius = border.clearance(at);
    for (double step = 0.2 * w.searched.half.maxCoeff(); step > 4e-3 * w.searched.half.maxCoeff();) {
      bool moved = false;
      for (int j = 0; j < 12; ++j) {
        if (w.searched.half[j / 2] == 0) continue;
        Vector6 next = at;
        next[j / 2] += j % 2 ? step : -step;
        const double r = border.clearance(next);
        if (!(r > radius * (1 + 1e-9))) continue;
        at = next;
        radius = r;
        moved = true;
      }
      if (!moved) step *= 0.5;
    }
    const PoseCell ball = ballAt(w, at);
    if (ball.half.maxCoeff() > best.half.maxCoeff()) best = ball;
  }
  return best;
}

/// Largest box about a point of which it is known that it lies inside, of the proportions tried.
PoseCell largestBox(const Workspace& w, const PoseCell& about) {
  constexpr std::array<double, 9> kTried{0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 2.8, 4};  // proportions of two axes to the first
  PoseCell best;
  best.centre = about.centre;
  if (about.half.maxCoeff() == 0) return best;
  const Border border{w, 1 + w.undecided.size() / kSearched};
  double best_volume = 0;
  Vector6 best_side = about.half;
  for (std::size_t code = 0; code < kTried.size() * kTried.size(); ++code) {
    const std::array<double, 3> share{1, kTried[code % kTried.size()], kTried[code / kTried.size()]};
    Vector6 side = Vector6::Zero();
    for (int j = 0; j < 6; ++j)
      if (w.searched.half[j] > 0) side[j] = share[j % 3];
    PoseCell box;
    box.half = border.multiple(about.centre, side) * side;
    if (box.volume() > best_volume && box.half.maxCoeff() > 0) {
      best_volume = box.volume();
      best_side = side;
    }
  }
  best.half = Border{w, 1}.multiple(about.centre, best_side) * best_side;
  return best;
}

/// Poses of the box by a sequence of low discrepancy (additive, powers of the inverse of the root of x⁷ = x + 1).
Vector6 spreadPose(const PoseCell& box, int index) {
  Vector6 at;
  double alpha = 1;
  for (int j = 0; j < 6; ++j) {
    alpha /= 1.1127756842787055;
    const double x = 0.5 + alpha * (index + 1);
    at[j] = box.centre[j] + box.half[j] * (2 * (x - std::floor(x)) - 1);
  }
  return at;
}

}  // namespace

PoseCell translations(const DeviceDef& def) {
  Vector3 low = def.strings[0].p_BE, high = low;
  for (const StringDef& s : def.strings) {
    low = low.cwiseMin(s.p_BE);
    high = high.cwiseMax(s.p_BE);
  }
  PoseCell box;
  box.centre.head<3>() = 0.5 * (low + high);
  box.half.head<3>() = 0.5 * (high - low);
  return box;
}

PoseCell rotations() {
  PoseCell box;
  box.half.tail<3>().setConstant(M_PI / 2);
  return box;
}

CellJudge::CellJudge(const DeviceDef& def, const PoseCell& searched, const WorkspaceSettings& settings)
    : rows_(def), set_(def, settings.required), least_singular_(settings.least_singular) {
  constexpr int kDrawn = 12;
  std::vector<RowBounds> drawn;
  for (int i = 0; static_cast<int>(drawn.size()) < kDrawn && i < 100; ++i) {
    PoseCell point;
    point.centre = spreadPose(searched, i);
    RowBounds rows;
    rows_.evaluate(point, rows);
    if (rows.bounded) drawn.push_back(rows);
  }
  set_.markDegenerate(drawn);
}

CellVerdict CellJudge::judgeSingular(const RowBounds& rows) const {
  const int d = rows_.dof(), n = rows.strings;
  double bend = kRounding, spread = kRounding;
  Gram G = Gram::Zero(d, d);
  for (int i = 0; i < n; ++i) {
    bend = std::sqrt(bend * bend + rows.bend[i] * rows.bend[i]);
    spread = std::sqrt(spread * spread + rows.spread[i] * rows.spread[i]);
    G += rows.row[i].head(d) * rows.row[i].head(d).transpose();
  }
  const double s = least_singular_;
  if (isAbove(G, (s + spread) * (s + spread))) return CellVerdict::kInside;
  std::array<Gram, 6> change;
  for (int m = 0; m < rows.moves; ++m) {
    change[m] = Gram::Zero(d, d);
    for (int i = 0; i < n; ++i) {
      const Gram half = rows.half[m] * rows.row[i].head(d) * rows.slope[i][m].head(d).transpose();
      change[m] += half + half.transpose();
    }
  }
  bool above = true;
  for (int corner = 0; corner < 1 << rows.moves && above; ++corner) {
    Gram at = G;
    for (int m = 0; m < rows.moves; ++m) corner >> m & 1 ? at += change[m] : at -= change[m];
    above = isAbove(at, (s + bend) * (s + bend));
  }
  if (above) return CellVerdict::kInside;
  const Column x = weakest(G);
  double most = 0;
  for (int corner = 0; corner < 1 << rows.moves; ++corner) {
    double square = 0;
    for (int i = 0; i < n; ++i) {
      double y = rows.row[i].head(d).dot(x);
      for (int m = 0; m < rows.moves; ++m) y += (corner >> m & 1 ? 1 : -1) * rows.half[m] * rows.slope[i][m].head(d).dot(x);
      square += y * y;
    }
    most = std::max(most, square);
  }
  return std::sqrt(most) + bend < s ? CellVerdict::kOutside : CellVerdict::kUndecided;
}

CellVerdict CellJudge::judge(const PoseCell& cell, const PresentableSet::Faces& open, bool singular_open, PresentableSet::Faces& still_open,
                             bool& still_singular) const {
  RowBounds rows;
  rows_.evaluate(cell, rows);
  still_singular = singular_open;
  const CellVerdict presents = open.empty() && !set_.faces().empty() ? CellVerdict::kInside : set_.judge(rows, open, still_open);
  if (open.empty()) still_open.clear();
  if (presents == CellVerdict::kOutside || !rows.bounded) return presents;
  const CellVerdict determines = singular_open ? judgeSingular(rows) : CellVerdict::kInside;
  still_singular = determines != CellVerdict::kInside;
  if (determines == CellVerdict::kOutside) return determines;
  return still_singular ? determines : presents;
}

bool CellJudge::contains(const Vector6& at) const {
  PoseCell point;
  point.centre = at;
  RowBounds rows;
  rows_.evaluate(point, rows);
  if (!rows.bounded || !(set_.margin(rows) > 0)) return false;
  const int d = rows_.dof();
  Gram G = Gram::Zero(d, d);
  for (int i = 0; i < rows.strings; ++i) G += rows.row[i].head(d) * rows.row[i].head(d).transpose();
  return isAbove(G, least_singular_ * least_singular_);
}

Workspace certifyWorkspace(const DeviceDef& def, const PoseCell& searched, const WorkspaceSettings& settings) {
  const CellJudge judge(def, searched, settings);
  Workspace w;
  w.searched = searched;
  w.undecided_share = 1;
  std::deque<OpenCell> queue{{searched, judge.set().faces(), true, 1}};  // the largest first
  PresentableSet::Faces open;
  for (long work = 0; !queue.empty();) {
    double multiple = 0;
    const int j = widest(queue.front().cell, settings, multiple);
    w.exhausted = work >= settings.work;
    if (w.exhausted || (multiple <= 1 && w.undecided_share <= settings.undecided)) break;
    const OpenCell c = std::move(queue.front());
    queue.pop_front();
    bool singular = true;
    const CellVerdict verdict = judge.judge(c.cell, c.faces, c.singular, open, singular);
    work += 2 + static_cast<long>(c.faces.size());
    if (verdict != CellVerdict::kUndecided) {
      w.undecided_share -= c.share;
      if (verdict == CellVerdict::kInside) w.inside_share += c.share;
      (verdict == CellVerdict::kInside ? w.inside : w.outside).push_back(c.cell);
      continue;
    }
    OpenCell part{c.cell, open, singular, 0.5 * c.share};
    part.cell.half[j] *= 0.5;
    for (const double sign : {-1.0, 1.0}) {
      part.cell.centre[j] = c.cell.centre[j] + sign * part.cell.half[j];
      queue.push_back(part);
    }
  }
  for (const OpenCell& c : queue) w.undecided.push_back(c.cell);
  w.home_ball = ballAt(w, Vector6::Zero());
  w.ball = largestBall(w);
  w.home_box = largestBox(w, w.home_ball);
  w.box = largestBox(w, w.ball);
  if (w.home_box.volume() > w.box.volume()) w.box = w.home_box;
  return w;
}

}  // namespace haptic
