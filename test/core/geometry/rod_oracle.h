/// An independent volume of two rods: plane sections, integrated adaptively, in a type with more bits than
/// double.
///
/// It shares with rod_integral.cpp that the planes lie along both axes, and nothing else: each outline is cut
/// at angles and places of its own, every piece is judged by its middle, arcs are Gauss sums, and it knows no
/// polynomial for the heights at which the outline changes. It finds them by bisection of its kind: which
/// lines and arcs take part. Between two such heights moments begin and end like powers of √x; a map that stands still at both ends
/// makes them smooth. What no scan saw, adaptive Gauss rules do.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

namespace haptic::oracle {

// Functions of the type: long double here; another type brings its own.
template <class T>
T root(T x) {
  return std::sqrt(x);
}
template <class T>
T sine(T x) {
  return std::sin(x);
}
template <class T>
T cosine(T x) {
  return std::cos(x);
}
template <class T>
T arcCosine(T x) {
  return std::acos(x);
}
template <class T>
T arcTangent(T y, T x) {
  return std::atan2(y, x);
}
template <class T>
T size(T x) {
  return x < 0 ? -x : x;
}

template <class T>
struct Vec {
  T x, y, z;
  Vec operator+(const Vec& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Vec operator-(const Vec& o) const { return {x - o.x, y - o.y, z - o.z}; }
  T dot(const Vec& o) const { return x * o.x + y * o.y + z * o.z; }
  Vec times(T s) const { return {s * x, s * y, s * z}; }
  Vec cross(const Vec& o) const { return {y * o.z - z * o.y, z * o.x - x * o.z, x * o.y - y * o.x}; }
};

/// Gauss's rule on [0, 1].
template <class T>
struct Rule {
  std::vector<T> at, weight;
  explicit Rule(int n) : at(n), weight(n) {
    const T pi = 4 * arcTangent(T(1), T(1));
    for (int i = 0; i < n; ++i) {
      T x = cosine(pi * (T(i) + T(3) / 4) / (T(n) + T(1) / 2)), slope = 1;
      for (int pass = 0; pass < 12; ++pass) {
        T p0 = 1, p1 = x;
        for (int j = 2; j <= n; ++j) {
          const T p2 = ((2 * j - 1) * x * p1 - (j - 1) * p0) / j;
          p0 = p1, p1 = p2;
        }
        slope = n * (x * p1 - p0) / (x * x - 1);
        x -= p1 / slope;
      }
      at[i] = (1 + x) / 2, weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
  }
};

/// ∫ 1, x, y, z, xx, xy, yy, xz, yz, zz, about a reference point near V, of the volume and of A's surface in
/// B by normal component.
template <class T>
struct Sums {
  T v[4][10] = {};
  void add(T w, const Sums& o) {
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < 10; ++i) v[k][i] += w * o.v[k][i];
  }
};

template <class T>
class RodOracle {
 public:
  struct Rod {
    T radius, half;
    bool round;
  };

  /// B's axis and centre in A's frame, whose z is A's axis. `hint`: a point where V may be, near which the
  /// scan is finer. `tolerance`: of the moments, relative. `heights` over the lowest plane are looked at besides: what changes and
  /// changes back between two steps of the scan, and between two nodes of every rule, is seen by nothing else.
  RodOracle(const Rod& A, const Rod& B, Vec<T> axis, const Vec<T>& p, const Vec<T>& hint, T tolerance = T(1e-14),
            const std::vector<T>& heights = {})
      : tolerance_(tolerance) {
    rod_[0] = A, rod_[1] = B;
    if (axis.z < 0) axis = axis.times(-1);
    const T s = root(axis.x * axis.x + axis.y * axis.y), d = root(p.x * p.x + p.y * p.y);
    n_ = s > T(1e-17) ? Vec<T>{-axis.y / s, axis.x / s, 0}
         : d > 0      ? Vec<T>{p.x / d, p.y / d, 0}
                      : Vec<T>{1, 0, 0};
    t_ = Vec<T>{n_.y, -n_.x, 0};
    u_[0] = {1, 0}, u_[1] = s > T(1e-17) ? P{axis.z, s} : P{1, 0};
    c_[0] = {0, 0}, c_[1] = {p.z, t_.dot(p)};
    h_[0] = 0, h_[1] = n_.dot(p);
    low_ = std::max(-A.radius, h_[1] - B.radius), high_ = std::min(A.radius, h_[1] + B.radius);
    if (low_ < high_) integrate(n_.dot(hint), heights);
  }

  T volume() const { return total_.v[0][0]; }
  /// In A's frame.
  Vec<T> centroid() const {
    return world(o_.x + total_.v[0][1] / volume(), o_.y + total_.v[0][2] / volume(),
                 zo_ + total_.v[0][3] / volume());
  }
  Vec<T> areaVector() const { return direction(total_.v[1][0], total_.v[2][0], total_.v[3][0]); }
  /// ∫ r × n dA about A's origin.
  Vec<T> torque() const {
    const auto& v = total_.v;
    const T ox = o_.x, oy = o_.y, oz = zo_;  // ∫ (r + o) × n
    const auto first = [&](int k, int i) { return v[k][i] + (i == 1 ? ox : i == 2 ? oy : oz) * v[k][0]; };
    return direction(first(3, 2) - first(2, 3), first(1, 3) - first(3, 1), first(2, 1) - first(1, 2));
  }
  /// ∫ (a·r)(b·r) about the centroid; directions in A's frame.
  T second(const Vec<T>& a, const Vec<T>& b) const { return moment(0, a, b) - volume() * mean(a) * mean(b); }
  /// The same of A's surface seen along n.
  T surfaceSecond(const Vec<T>& n, const Vec<T>& a, const Vec<T>& b) const {
    T out = 0;
    const T share[4] = {0, n.z, t_.dot(n), n_.dot(n)}, ma = mean(a), mb = mean(b);
    for (int k = 1; k < 4; ++k)
      out += share[k] *
             (moment(k, a, b) - ma * firstMoment(k, b) - mb * firstMoment(k, a) + ma * mb * total_.v[k][0]);
    return out;
  }
  int sections() const { return sections_; }  ///< that were taken
  bool gaveUp() const { return gave_up_; }    ///< an interval was divided as often as allowed

 private:
  struct P {
    T x, y;
  };
  struct Section {
    Sums<T> sums;
    unsigned kind = 0;
  };
  struct Outline {
    P c, u;
    T h, half;
    bool round;
  };

  Vec<T> direction(T x, T y, T z) const { return Vec<T>{0, 0, x} + t_.times(y) + n_.times(z); }
  Vec<T> world(T x, T y, T z) const { return direction(x, y, z); }
  T firstMoment(int k, const Vec<T>& a) const {
    return a.z * total_.v[k][1] + t_.dot(a) * total_.v[k][2] + n_.dot(a) * total_.v[k][3];
  }
  T mean(const Vec<T>& a) const { return firstMoment(0, a) / volume(); }
  T moment(int k, const Vec<T>& a, const Vec<T>& b) const {
    const T* m = total_.v[k];
    const T p[3] = {a.z, t_.dot(a), n_.dot(a)}, q[3] = {b.z, t_.dot(b), n_.dot(b)};
    return p[0] * q[0] * m[4] + (p[0] * q[1] + p[1] * q[0]) * m[5] + p[1] * q[1] * m[6] +
           (p[0] * q[2] + p[2] * q[0]) * m[7] + (p[1] * q[2] + p[2] * q[1]) * m[8] + p[2] * q[2] * m[9];
  }

  /// Or within `room` of it, relative to its half width.
  static bool inside(const Outline& s, const P& p, T room = 0) {
    const T dx = p.x - s.c.x, dy = p.y - s.c.y, h = s.h * (1 + room);
    const T u = size(dx * s.u.x + dy * s.u.y) - s.half, v = dy * s.u.x - dx * s.u.y;
    return u <= (s.round ? T(0) : room * s.h) ? size(v) <= h : s.round && u * u + v * v <= h * h;
  }

  /// Places at which an outline is cut, in order.
  struct Cuts {
    T at[14];
    int count = 0;
    void put(T x) { at[count++] = x; }
    void sort() { std::sort(at, at + count); }
  };

  /// At angle θ of the range's sine: z = low + (high − low) sin² θ. Its sums, or its kind alone.
  Section at(T theta, bool sums = true) {
    ++sections_;
    const T s = sine(theta), c = cosine(theta), w = high_ - low_, x = w * s * s, xb = w * c * c, z = low_ + x;
    Section out;
    Outline o[2];
    for (int i = 0; i < 2; ++i) {
      const T above = h_[i] + rod_[i].radius - high_, below = low_ - (h_[i] - rod_[i].radius);
      const T square = (xb + above) * (x + below);
      if (!(square > 0)) return out;
      o[i] = {c_[i], u_[i], root(square), rod_[i].half, rod_[i].round};
    }
    for (int me = 0; me < 2; ++me) {
      for (int sign = -1; sign <= 1; sign += 2) {
        line(o, me, sign, true, z, sums, out);
        if (o[me].round)
          halfCircle(o, me, sign, z, sums, out);
        else
          line(o, me, sign, false, z, sums, out);
      }
    }
    return out;
  }

  /// Adds ∫ over a straight or short piece at p with tangent normal n and length l.
  void addPoint(int me, const P& p, const P& n, T l, T wz, T z, Section& out) const {
    const T x = p.x - o_.x, y = p.y - o_.y, zz = z - zo_,
            m[10] = {1, x, y, zz, x * x, x * y, y * y, x * zz, y * zz, zz * zz};
    const T tangent = n.x * x + n.y * y;
    constexpr int kDegree[10] = {0, 1, 1, 0, 2, 2, 2, 1, 1, 0};
    for (int i = 0; i < 10; ++i) {
      out.sums.v[0][i] += l * tangent * m[i] / (2 + kDegree[i]);
      if (me == 0)
        out.sums.v[1][i] += l * n.x * m[i], out.sums.v[2][i] += l * n.y * m[i],
            out.sums.v[3][i] += l * wz * m[i];
    }
  }

  void line(const Outline* o, int me, int sign, bool is_side, T z, bool sums, Section& out) const {
    const Outline &X = o[me], &Y = o[1 - me];
    const P t = is_side ? X.u : P{-X.u.y, X.u.x},
            n = is_side ? P{-sign * X.u.y, sign * X.u.x} : P{sign * X.u.x, sign * X.u.y};
    const T off = is_side ? X.h : X.half, half = is_side ? X.half : X.h;
    const P base{X.c.x + off * n.x, X.c.y + off * n.y};
    Cuts cut;
    cut.put(-half), cut.put(half);
    const auto put = [&](T x) {
      if (size(x) < half) cut.put(x);
    };
    const T dx = base.x - Y.c.x, dy = base.y - Y.c.y, ku = dx * Y.u.x + dy * Y.u.y,
            kv = dy * Y.u.x - dx * Y.u.y;
    const T mu = t.x * Y.u.x + t.y * Y.u.y, mv = t.y * Y.u.x - t.x * Y.u.y;
    for (int e = -1; e <= 1; e += 2) {
      if (mv != 0) put((e * Y.h - kv) / mv);
      if (!Y.round && mu != 0) put((e * Y.half - ku) / mu);
      if (!Y.round) continue;
      const T k = ku - e * Y.half, middle = -(k * mu + kv * mv), away = k * mv - kv * mu,
              square = (Y.h - away) * (Y.h + away);
      if (square > 0) put(middle - root(square)), put(middle + root(square));
    }
    cut.sort();
    static const T at = root(T(3) / 5) / 2;
    for (int i = 0; i + 1 < cut.count; ++i) {
      const T l = cut.at[i + 1] - cut.at[i], middle = (cut.at[i] + cut.at[i + 1]) / 2;
      if (!(l > 0) || !inside(Y, {base.x + middle * t.x, base.y + middle * t.y})) continue;
      for (int k = -1; k <= 1 && sums; ++k) {  // exact up to degree 5
        const T s = middle + k * at * l;
        addPoint(me, {base.x + s * t.x, base.y + s * t.y}, n, l * (k ? T(5) : T(8)) / 18,
                 is_side && me == 0 ? (z - h_[0]) / X.h : T(0), z, out);
      }
      out.kind |= 1u << (8 * me + 2 * (sign > 0) + is_side);
    }
  }

  void halfCircle(const Outline* o, int me, int sign, T z, bool sums, Section& out) const {
    const Outline &X = o[me], &Y = o[1 - me];
    const P a{sign * X.u.x, sign * X.u.y}, b{-a.y, a.x}, e{X.c.x + X.half * a.x, X.c.y + X.half * a.y};
    static const T pi = 4 * arcTangent(T(1), T(1));
    Cuts cut;
    cut.put(-pi / 2), cut.put(pi / 2);
    const auto put = [&](T cx, T cy, T level) {  // cx cos φ + cy sin φ = level
      const T length = root(cx * cx + cy * cy);
      if (!(size(level) < length)) return;
      const T middle = arcTangent(cy, cx), off = arcCosine(level / length);
      for (int k = -1; k <= 1; k += 2) {
        T phi = middle + k * off;
        if (phi > pi) phi -= 2 * pi;
        if (phi < -pi) phi += 2 * pi;
        if (size(phi) < pi / 2) cut.put(phi);
      }
    };
    const T dx = e.x - Y.c.x, dy = e.y - Y.c.y, ku = dx * Y.u.x + dy * Y.u.y, kv = dy * Y.u.x - dx * Y.u.y;
    const T au = a.x * Y.u.x + a.y * Y.u.y, av = a.y * Y.u.x - a.x * Y.u.y, bu = b.x * Y.u.x + b.y * Y.u.y,
            bv = b.y * Y.u.x - b.x * Y.u.y;
    for (int f = -1; f <= 1; f += 2) {
      put(av, bv, (f * Y.h - kv) / X.h);
      if (!Y.round) {
        put(au, bu, (f * Y.half - ku) / X.h);
        continue;
      }
      const T k = ku - f * Y.half, level = ((Y.h - X.h) * (Y.h + X.h) - k * k - kv * kv) / (2 * X.h);
      put(k * au + kv * av, k * bu + kv * bv, level);
    }
    cut.sort();
    for (int i = 0; i + 1 < cut.count; ++i) {
      const T half = (cut.at[i + 1] - cut.at[i]) / 2, middle = (cut.at[i] + cut.at[i + 1]) / 2;
      if (!(half > 0)) continue;
      const T c = cosine(middle), s = sine(middle);
      const auto at_angle = [&](T cosine_of, T sine_of) {
        return P{e.x + X.h * (cosine_of * a.x + sine_of * b.x), e.y + X.h * (cosine_of * a.y + sine_of * b.y)};
      };
      if (!inside(Y, at_angle(c, s))) continue;
      // Where outlines only just touch, rounding may hide the crossings: then the piece's ends are far outside.
      if (!inside(Y, at_angle(cosine(cut.at[i]), sine(cut.at[i])), T(1e-6))) continue;
      if (!inside(Y, at_angle(cosine(cut.at[i + 1]), sine(cut.at[i + 1])), T(1e-6))) continue;
      out.kind += 1u << (16 + 4 * me + 2 * (sign > 0));
      if (!sums) continue;
      // Of degree 5 in sine and cosine: 8 points for a quarter of a radian, and 20 for half a turn, err by 1e-20.
      static const Rule<T> kShort(8), kLong(20);
      const Rule<T>& arcs = half < T(1) / 8 ? kShort : kLong;
      const std::size_t points = arcs.at.size();
      for (std::size_t k = 0; k < points / 2; ++k) {  // two points share one sine and cosine
        const T angle = half * (2 * arcs.at[k] - 1), ck = cosine(angle), sk = sine(angle);
        for (int way = -1; way <= 1; way += 2) {
          const T cp = c * ck - way * s * sk, sp = s * ck + way * c * sk;
          const P n{cp * a.x + sp * b.x, cp * a.y + sp * b.y};
          addPoint(me, {e.x + X.h * n.x, e.y + X.h * n.y}, n, X.h * 2 * half * arcs.weight[k],
                   me == 0 ? (z - h_[0]) / X.h : T(0), z, out);
        }
      }
    }
  }

  /// A piece between two changes of kind, in θ; t from 0 to 1 goes over it as θ = from + (to − from) t² (3 − 2t).
  struct Piece {
    T from, to;
  };

  Sums<T> gauss(const Piece& piece, T from, T to) {
    static const Rule<T> kRule(16);
    Sums<T> q;
    const T w = high_ - low_, length = piece.to - piece.from;
    for (std::size_t k = 0; k < kRule.at.size(); ++k) {
      const T t = from + (to - from) * kRule.at[k], theta = piece.from + length * t * t * (3 - 2 * t);
      const T rate = length * 6 * t * (1 - t) * 2 * w * sine(theta) * cosine(theta);
      q.add((to - from) * kRule.weight[k] * rate, at(theta).sums);
    }
    return q;
  }

  void refine(const Piece& piece, T from, T to, const Sums<T>& whole, int depth) {
    const T middle = (from + to) / 2;
    const Sums<T> a = gauss(piece, from, middle), b = gauss(piece, middle, to);
    bool fine = depth >= kDeepest;
    gave_up_ = gave_up_ || fine;
    if (!fine) {
      fine = true;
      for (int k = 0; k < 4; ++k)
        for (int i : {0, 4, 6, 9})
          fine = fine && size(a.v[k][i] + b.v[k][i] - whole.v[k][i]) <= tolerance_ * scale_.v[k ? 1 : 0][i];
    }
    if (fine) {
      total_.add(1, a), total_.add(1, b);
      return;
    }
    refine(piece, from, middle, a, depth + 1), refine(piece, middle, to, b, depth + 1);
  }

  /// Until there are `most` changes: where arcs coincide kinds flicker by rounding.
  void split(T from, unsigned kind_from, T to, unsigned kind_to, int depth, std::size_t most, std::vector<T>& at_change) {
    if (kind_from == kind_to || at_change.size() >= most) return;
    const T middle = (from + to) / 2;
    if (depth == kBits || !(from < middle && middle < to)) {
      at_change.push_back(middle);
      return;
    }
    const unsigned kind = at(middle, false).kind;
    split(from, kind_from, middle, kind, depth + 1, most, at_change);
    split(middle, kind, to, kind_to, depth + 1, most, at_change);
  }

  void integrate(T hint, const std::vector<T>& heights) {
    const T quarter = 2 * arcTangent(T(1), T(1)), w = high_ - low_;
    zo_ = (low_ + high_) / 2;
    // Even steps, and steps that double on both sides of the hint.
    std::vector<T> scan;
    for (int i = 1; i < kScan; ++i) scan.push_back(quarter * i / kScan);
    T step = w;
    for (int k = 0; k < 60; ++k, step = step / 2) {
      for (const T z : {hint - step, hint + step}) {
        if (z > low_ && z < high_) scan.push_back(arcTangent(root(z - low_), root(high_ - z)));
      }
    }
    for (const T x : heights) {
      if (x > 0 && x < w) scan.push_back(arcTangent(root(x), root(w - x)));
    }
    std::sort(scan.begin(), scan.end());
    std::vector<T> change;
    T last = quarter * T(1e-9);
    unsigned kind = at(last, false).kind;
    scan.push_back(quarter * (1 - T(1e-9)));
    for (const T next : scan) {
      const unsigned now = at(next, false).kind;
      split(last, kind, next, now, 0, change.size() + kMostChanges, change);
      last = next, kind = now;
    }
    change.insert(change.begin(), T(0)), change.push_back(quarter);
    // About the middle of the first piece that holds anything.
    std::vector<Piece> pieces;
    bool any = false;  // a piece may be empty in its middle alone: changes beyond kMostChanges were not looked for
    for (std::size_t i = 0; i + 1 < change.size(); ++i) {
      any |= at((change[i] + change[i + 1]) / 2, false).kind != 0;
      pieces.push_back({change[i], change[i + 1]});
    }
    if (!any) return;
    std::vector<Sums<T>> whole(pieces.size());
    const auto measure = [&] {
      T first[4] = {0, 0, 0, 0};
      for (std::size_t i = 0; i < pieces.size(); ++i) {
        whole[i] = gauss(pieces[i], 0, 1);
        for (int k = 0; k < 4; ++k) first[k] += whole[i].v[0][k];
      }
      return Vec<T>{first[1] / first[0], first[2] / first[0], first[3] / first[0]};
    };
    for (int pass = 0; pass < 2; ++pass) {
      const Vec<T> mean = measure();
      o_ = {o_.x + mean.x, o_.y + mean.y}, zo_ += mean.z;
    }
    measure();
    for (const Sums<T>& each : whole) {
      for (int k = 0; k < 4; ++k)
        for (int i = 0; i < 10; ++i) scale_.v[k ? 1 : 0][i] += size(each.v[k][i]);
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) refine(pieces[i], 0, 1, whole[i], 0);
  }

  static constexpr int kScan = 200;                 ///< even steps
  static constexpr std::size_t kMostChanges = 64;   ///< of kind between two steps of the scan; beyond it is rounding
  static constexpr int kDeepest = 40;               ///< divisions of an interval
  static constexpr int kBits = 60;                  ///< divisions onto a change of kind
  Rod rod_[2];
  Vec<T> n_, t_;
  P u_[2], c_[2];
  T h_[2], low_, high_;
  P o_{0, 0};
  T zo_ = 0;
  Sums<T> total_, scale_;
  int sections_ = 0;
  bool gave_up_ = false;
  T tolerance_;
};

}  // namespace haptic::oracle
