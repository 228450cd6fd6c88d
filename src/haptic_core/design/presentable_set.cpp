#include "haptic_core/design/presentable_set.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kSlack = 1e-10;      // of the greatest tension: see "Rounding"
constexpr double kDependent = 1e-10;  // of a row's length that is left after projection: its set has no normal

/// max(least y, most y) and its tangent.
struct Support {
  double least, most;
  double value(double y) const { return y > 0 ? most * y : least * y; }
  double slope(double y) const { return y > 0 ? most : least; }
};

/// Of an upper triangular matrix; what lies below its diagonal is not read.
template <class Matrix>
Matrix inverseOf(const Matrix& upper) {
  Matrix inverse = Matrix::Zero();
  for (int j = 0; j < upper.cols(); ++j) {
    inverse(j, j) = 1 / upper(j, j);
    for (int i = j - 1; i >= 0; --i) {
      double sum = 0;
      for (int k = i + 1; k <= j; ++k) sum += upper(i, k) * inverse(k, j);
      inverse(i, j) = -sum / upper(i, i);
    }
  }
  return inverse;
}

}  // namespace

class PresentableSet::Part {
 public:
  virtual ~Part() = default;
  virtual void markDegenerate(const std::vector<RowBounds>& at) = 0;
  virtual double least(const RowBounds& rows, double force, double torque, int kind) const = 0;
  virtual CellVerdict judge(const RowBounds& rows, const Faces& open, Faces& still_open) const = 0;
  Faces faces;
  RequiredWrench required;
  double radius = 1;
};

template <int D>
class PresentableSet::Columns final : public PresentableSet::Part {
  static constexpr int kRows = D - 1;
  using Vector = Eigen::Matrix<double, D, 1>;
  using Set = std::array<std::uint8_t, kRows>;

 public:
  explicit Columns(const DeviceDef& def) : strings_(static_cast<int>(def.strings.size())) {
    for (int i = 0; i < strings_; ++i) {
      tension_[i] = {def.strings[i].min_tension, def.strings[i].max_tension};
      slack_ = std::max(slack_, kSlack * tension_[i].most);
    }
    Set set{};
    addSets(set, 0, 0);
  }

  void markDegenerate(const std::vector<RowBounds>& at) override {
    const auto none = [&](std::uint16_t s) {
      Normal normal;
      return std::none_of(at.begin(), at.end(), [&](const RowBounds& rows) { return normal.find(rows, sets_[s]); });
    };
    faces.erase(std::remove_if(faces.begin(), faces.end(), none), faces.end());
  }

  /// Least over the faces of (h_Z - h_B)/|n| (kind 0), of (h_Z - h_B)/|n_f| (1) or /|n_τ| (2).
  double least(const RowBounds& rows, double force, double torque, int kind) const override {
    double found = std::numeric_limits<double>::infinity();
    bool any = false;
    Normal normal;
    for (const std::uint16_t s : faces) {
      if (!normal.find(rows, sets_[s])) continue;
      any = true;
      const Vector& n = normal.n;
      double up = 0, down = 0;
      for (int i = 0; i < strings_; ++i) {
        const double y = normal.has[i] ? 0 : n.dot(rows.row[i].template head<D>());
        up += tension_[i].value(y);
        down += tension_[i].value(-y);
      }
      const double size = kind == 0 ? 1 : kind == 1 ? forceOf(n).norm() : torqueOf(n).norm();
      const double excess = std::min(up, down) - force * forceOf(n).norm() - torque / radius * torqueOf(n).norm();
      if (excess < 0 || size > 1e-12) found = std::min(found, excess / std::max(size, 1e-12));
    }
    return any ? found : -std::numeric_limits<double>::infinity();
  }

  CellVerdict judge(const RowBounds& rows, const Faces& open, Faces& still_open) const override {
    still_open.clear();
    if (!rows.bounded) {
      still_open = open;
      return CellVerdict::kUndecided;
    }
    Face face;
    double least = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0;  // of still_open: the face of least value at the centre; a part that lies outside is outside of it first
    for (const std::uint16_t s : open) {
      double value = std::numeric_limits<double>::infinity();
      Found found = judgeFace(rows, sets_[s], face, value);
      if (found == Found::kIrregular && settlesDegenerate(rows, sets_[s])) found = Found::kSettled;
      if (found == Found::kOutside) return CellVerdict::kOutside;
      if (found == Found::kSettled) continue;
      if (value < least) {
        least = value;
        nearest = still_open.size();
      }
      still_open.push_back(s);
    }
    if (nearest > 0) std::rotate(still_open.begin(), still_open.begin() + nearest, still_open.begin() + nearest + 1);
    return still_open.empty() && !faces.empty() ? CellVerdict::kInside : CellVerdict::kUndecided;
  }

 private:
  enum class Found { kSettled, kOutside, kOpen, kIrregular };

  static auto forceOf(const Vector& n) { return n.template head<3>(); }
  static Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> torqueOf(const Vector& n) {
    if constexpr (D >= 6) return n.template segment<3>(3);
    return Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>::Zero(1);
  }

  /// The unit null vector of the rows of S, and A_S = Lᵀ Qᵀ factored: Q orthonormal, `inverse` = L⁻¹ upper triangular.
  struct Normal {
    Vector n;
    Eigen::Matrix<double, D, kRows> Q;
    Eigen::Matrix<double, kRows, kRows> upper, inverse;
    std::array<bool, kMaxStrings> has{};
    Set held{};
    int done = 0;  // columns of Q that belong to `held`

    /// Columns that the set shares with the one before, at the same rows, are kept: sets come in lexicographic order.
    bool find(const RowBounds& rows, const Set& set) {
      int first = 0;
      while (first < done && held[first] == set[first]) ++first;
      held = set;
      for (done = first; done < kRows; ++done) {
        const int j = done;
        Vector q = rows.row[set[j]].template head<D>();
        const double size = q.norm();
        for (int pass = 0; pass < 2; ++pass)  // twice is enough (Kahan)
          for (int k = 0; k < j; ++k) {
            const double share = Q.col(k).dot(q);
            upper(k, j) = pass == 0 ? share : upper(k, j) + share;
            q -= share * Q.col(k);
          }
        upper(j, j) = q.norm();
        if (upper(j, j) <= kDependent * size) return false;
        Q.col(j) = q / upper(j, j);
      }
      Vector left = Vector::Ones();  // squares of what each axis keeps outside of Q's span
      has.fill(false);
      for (int j = 0; j < kRows; ++j) {
        has[set[j]] = true;
        left -= Q.col(j).cwiseAbs2();
      }
      int axis = 0;
      left.maxCoeff(&axis);
      n = Vector::Unit(axis);
      for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < kRows; ++k) n -= Q.col(k).dot(n) * Q.col(k);
      n.normalize();
      return true;
    }

    /// z = A_S⁺ᵀ y.
    Eigen::Matrix<double, kRows, 1> weights(const Vector& y) const { return inverse * (Q.transpose() * y); }
  };

  /// One S over a cell: all that both signs share.
  struct Face {
    Normal normal;
    double H = 0;                                                  // bound of |η|
    Eigen::Matrix<double, 6, kRows> turn;                          // n·J_j
    Eigen::Matrix<double, kRows, 1> rest;                          // bend_j + spread_j H
    double base = 0, base_rest = 0, base_more = 0;                 // h_B at the centre; remainder of its linear part; of its upper bound
    Eigen::Matrix<double, 6, 1> base_slope;
    int others = 0;
    std::array<int, kMaxStrings> string;
    std::array<double, kMaxStrings> D0, R;
    std::array<Eigen::Matrix<double, 6, 1>, kMaxStrings> g;
  };

  Found judgeFace(const RowBounds& rows, const Set& set, Face& face, double& value) const {
    if (!face.normal.find(rows, set) || !expand(rows, set, face)) return Found::kIrregular;
    bool settled = true;
    for (const double sign : {1.0, -1.0}) {
      double most = 0;
      if (lowerBound(rows, face, sign, most) > slack_) continue;
      settled = false;
      value = std::min(value, most);
      if (most < 0 && upperBound(rows, face, sign) < -slack_) return Found::kOutside;
    }
    return settled ? Found::kSettled : Found::kOpen;
  }

  /// "Irregular S" of the header: the rows of S but the weakest, by Gram-Schmidt with pivoting, then the plane across them.
  bool settlesDegenerate(const RowBounds& rows, const Set& set) const {
    Eigen::Matrix<double, D, kRows> left;
    for (int j = 0; j < kRows; ++j) left.col(j) = rows.row[set[j]].template head<D>();
    Set order = set;
    Eigen::Matrix<double, D, kRows - 1> Q;
    Eigen::Matrix<double, kRows - 1, kRows - 1> upper = Eigen::Matrix<double, kRows - 1, kRows - 1>::Zero();
    for (int k = 0; k < kRows - 1; ++k) {
      int pivot = k;
      for (int j = k + 1; j < kRows; ++j)
        if (left.col(j).squaredNorm() > left.col(pivot).squaredNorm()) pivot = j;
      left.col(k).swap(left.col(pivot));
      std::swap(order[k], order[pivot]);
      const Vector a = rows.row[order[k]].template head<D>();
      upper(k, k) = left.col(k).norm();
      if (!(upper(k, k) > kDependent)) return false;
      Q.col(k) = left.col(k) / upper(k, k);
      for (int l = 0; l < k; ++l) upper(l, k) = Q.col(l).dot(a);
      for (int j = k + 1; j < kRows; ++j) left.col(j) -= Q.col(k).dot(left.col(j)) * Q.col(k);
    }
    const auto inverse = inverseOf(upper);
    double tilt = 0;
    for (int k = 0; k < kRows - 1; ++k) tilt += inverse.row(k).norm() * rows.spread[order[k]];
    if (!(tilt < 0.9)) return false;
    Eigen::Matrix<double, D, 2> plane;
    for (int c = 0; c < 2; ++c) {
      Vector rest = Vector::Ones() - Q.cwiseAbs2().rowwise().sum();
      if (c == 1) rest -= plane.col(0).cwiseAbs2();
      int axis = 0;
      rest.maxCoeff(&axis);
      Vector v = Vector::Unit(axis);
      for (int pass = 0; pass < 2; ++pass) {
        v -= Q * (Q.transpose() * v);
        if (c == 1) v -= plane.col(0).dot(v) * plane.col(0);
      }
      plane.col(c) = v.normalized();
    }
    return std::sqrt(1 - tilt * tilt) * leastInPlane(rows, set, plane) - changeBeside(rows, set, Q, tilt) > slack_;
  }

  /// Least of Σ h_i(n·a_i), i outside of S, over unit n of the plane: between the n across one of the strings each term is a sinusoid
  /// that is concave where the sum is positive.
  double leastInPlane(const RowBounds& rows, const Set& set, const Eigen::Matrix<double, D, 2>& plane) const {
    std::array<Vector2, kMaxStrings> flat;
    int count = 0;
    std::array<int, kMaxStrings> string;
    for (int i = 0; i < strings_; ++i)
      if (std::find(set.begin(), set.end(), i) == set.end()) {
        flat[count] = plane.transpose() * rows.row[i].template head<D>();
        string[count++] = i;
      }
    double least = count < 2 ? 0 : std::numeric_limits<double>::infinity();
    for (int k = 0; k < count; ++k) {
      const double size = flat[k].norm();
      if (!(size > kDependent)) continue;
      for (const double sign : {1.0, -1.0}) {
        const Vector2 n(-sign * flat[k].y() / size, sign * flat[k].x() / size);
        double sum = 0;
        for (int o = 0; o < count; ++o) sum += o == k ? 0 : tension_[string[o]].value(n.dot(flat[o]));
        least = std::min(least, sum);
      }
    }
    return std::isfinite(least) ? least : 0;
  }

  /// Most that the rows' change and the tilt of n out of the plane take away, and the most of h_B over unit n.
  double changeBeside(const RowBounds& rows, const Set& set, const Eigen::Matrix<double, D, kRows - 1>& Q, double tilt) const {
    const double torque = D >= 6 ? required.torque / radius : 0;
    double sum = std::sqrt(required.force * required.force + torque * torque);
    for (int i = 0; i < strings_; ++i)
      if (std::find(set.begin(), set.end(), i) == set.end())
        sum += tension_[i].most * (tilt * (Q.transpose() * rows.row[i].template head<D>()).norm() + rows.spread[i]);
    return sum;
  }

  bool expand(const RowBounds& rows, const Set& set, Face& face) const {
    face.normal.inverse = inverseOf(face.normal.upper);
    const Vector& n = face.normal.n;
    double share = 0, tilt = 0;
    for (int j = 0; j < kRows; ++j) {
      const double weight = face.normal.inverse.row(j).norm();
      share += weight * rows.spread[set[j]];
      tilt += weight * rows.bend[set[j]];
    }
    if (!(share < 0.9)) return false;
    face.turn.setZero();
    face.others = 0;
    face.base = face.base_more = 0;
    for (int m = 0; m < rows.moves; ++m) {
      for (int j = 0; j < kRows; ++j) face.turn(m, j) = n.dot(rows.slope[set[j]][m].template head<D>());
      tilt += rows.half[m] * (face.turn.row(m) * face.normal.inverse).norm();
    }
    face.H = tilt / (1 - share);
    for (int j = 0; j < kRows; ++j) face.rest[j] = rows.bend[set[j]] + rows.spread[set[j]] * face.H;
    for (int i = 0; i < strings_; ++i)
      if (!face.normal.has[i]) addString(rows, i, face);
    expandRequired(face);
    return true;
  }

  void addString(const RowBounds& rows, int i, Face& face) const {
    const Vector a = rows.row[i].template head<D>();
    const auto z = face.normal.weights(a);
    const int o = face.others++;
    face.string[o] = i;
    face.D0[o] = face.normal.n.dot(a);
    face.R[o] = rows.bend[i] + rows.spread[i] * face.H + z.cwiseAbs().dot(face.rest);
    face.g[o] = -face.turn * z;
    for (int m = 0; m < rows.moves; ++m) face.g[o][m] += face.normal.n.dot(rows.slope[i][m].template head<D>());
  }

  void expandRequired(Face& face) const {
    Vector gradient = Vector::Zero();
    const auto add = [&](double size, int first) {
      const double norm = face.normal.n.template segment<3>(first).norm();
      face.base += size * norm;
      if (norm > 0) gradient.template segment<3>(first) = size / norm * face.normal.n.template segment<3>(first);
      face.base_more += size * (norm > 0 ? std::min(0.5 * face.H * face.H / norm, 2 * face.H) : face.H);
    };
    add(required.force, 0);
    if constexpr (D >= 6) add(required.torque / radius, 3);
    const auto z = face.normal.weights(gradient);
    face.base_rest = z.cwiseAbs().dot(face.rest);
    face.base_slope = -face.turn * z;
  }

  static double reach(const RowBounds& rows, const Eigen::Matrix<double, 6, 1>& slope) {
    double sum = 0;
    for (int m = 0; m < rows.moves; ++m) sum += std::fabs(slope[m]) * rows.half[m];
    return sum;
  }

  /// Of h_Z - h_B over the cell; `centre` becomes its value at the centre.
  double lowerBound(const RowBounds& rows, const Face& face, double sign, double& centre) const {
    double value = -face.base, rest = face.base_rest + face.base_more;
    Eigen::Matrix<double, 6, 1> slope = -face.base_slope;
    for (int o = 0; o < face.others; ++o) {
      const Support& t = tension_[face.string[o]];
      const double y = sign * face.D0[o], tangent = t.slope(y);
      value += t.value(y);
      slope += sign * tangent * face.g[o];
      rest += tangent * face.R[o];
    }
    centre = value;
    return value - reach(rows, slope) - rest;
  }

  double upperBound(const RowBounds& rows, const Face& face, double sign) const {
    double value = -face.base, rest = face.base_rest;
    Eigen::Matrix<double, 6, 1> slope = -face.base_slope;
    for (int o = 0; o < face.others; ++o) {
      const Support& t = tension_[face.string[o]];
      const double y = sign * face.D0[o], way = reach(rows, face.g[o]) + face.R[o];
      const double low = t.value(y - way), high = t.value(y + way);
      const double chord = way > 0 ? (high - low) / (2 * way) : t.slope(y);
      value += way > 0 ? 0.5 * (low + high) : t.value(y);
      slope += sign * chord * face.g[o];
      rest += chord * face.R[o];
    }
    return value + reach(rows, slope) + rest;
  }

  void addSets(Set& set, int size, int first) {
    if (size == kRows) {
      faces.push_back(static_cast<std::uint16_t>(sets_.size()));
      sets_.push_back(set);
      return;
    }
    for (int i = first; i < strings_; ++i) {
      set[size] = static_cast<std::uint8_t>(i);
      addSets(set, size + 1, i + 1);
    }
  }

  int strings_;
  double slack_ = 0;
  std::array<Support, kMaxStrings> tension_{};
  std::vector<Set> sets_;
};

PresentableSet::PresentableSet(const DeviceDef& def, const RequiredWrench& required) {
  if (def.dof == 3)
    part_ = std::make_unique<Columns<3>>(def);
  else if (def.dof == 6)
    part_ = std::make_unique<Columns<6>>(def);
  else
    part_ = std::make_unique<Columns<7>>(def);
  part_->required = required;
  part_->radius = StringKinematics(def).knotRadius();
}

PresentableSet::~PresentableSet() = default;

PresentableSet::Faces PresentableSet::faces() const { return part_->faces; }

void PresentableSet::markDegenerate(const std::vector<RowBounds>& at) { part_->markDegenerate(at); }

double PresentableSet::margin(const RowBounds& rows) const {
  return part_->least(rows, part_->required.force, part_->required.torque, 0);
}

double PresentableSet::largestForce(const RowBounds& rows) const {
  return std::max(0.0, part_->least(rows, 0, part_->required.torque, 1));
}

double PresentableSet::largestTorque(const RowBounds& rows) const {
  return std::max(0.0, part_->radius * part_->least(rows, part_->required.force, 0, 2));
}

CellVerdict PresentableSet::judge(const RowBounds& rows, const Faces& open, Faces& still_open) const {
  return part_->judge(rows, open, still_open);
}

}  // namespace haptic
