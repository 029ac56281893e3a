// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/polynomial.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace collinea {
namespace {

// x^3 + a x^2 + b x + c, after Cardano and Viete.
Few<double, 3> monic_cubic_roots(double a, double b, double c) {
  Few<double, 3> roots;
  const double q = (a * a - 3 * b) / 9, r = (a * (2 * a * a - 9 * b) + 27 * c) / 54;
  const double q3 = q * q * q, discriminant = r * r - q3;
  if (discriminant < 0) {
    const double angle = std::acos(std::clamp(r / std::sqrt(q3), -1.0, 1.0)), size = -2 * std::sqrt(q);
    for (const double turn : {0.0, 2 * std::numbers::pi, -2 * std::numbers::pi})
      roots.add(size * std::cos((angle + turn) / 3) - a / 3);
  } else {
    const double s = -std::copysign(std::cbrt(std::abs(r) + std::sqrt(discriminant)), r);
    const double t = s != 0 ? q / s : 0;
    roots.add(s + t - a / 3);
    if (discriminant <= 1e-14 * r * r) roots.add(-(s + t) / 2 - a / 3);  // a double root at rounding level
  }
  return roots;
}

double polished(double x, double a, double b, double c) {
  for (int i = 0; i < 2; ++i) {
    const double value = c + x * (b + x * (a + x)), slope = b + x * (2 * a + 3 * x);
    if (!(std::abs(value) < std::abs(slope))) break;  // a multiple root or a wild step
    x -= value / slope;
  }
  return x;
}

constexpr int kDegree = 10;

struct Polynomial {
  std::array<double, kDegree + 1> c;
  int degree;
};

// The polynomial at z = t, or (reversed) z^-degree times its value at z = 1 / t: no overflow for large roots.
double value(const Polynomial& p, double t, bool reversed) {
  double sum;
  if (reversed) {
    sum = p.c[0];
    for (int i = 1; i <= p.degree; ++i) sum = sum * t + p.c[static_cast<std::size_t>(i)];
  } else {
    sum = p.c[static_cast<std::size_t>(p.degree)];
    for (int i = p.degree - 1; i >= 0; --i) sum = sum * t + p.c[static_cast<std::size_t>(i)];
  }
  return sum;
}

class SturmChain {
 public:
  explicit SturmChain(const Polynomial& p) {
    chain_[0] = p;
    scale(chain_[0]);
    chain_[1].degree = p.degree - 1;
    for (int i = 1; i <= p.degree; ++i) chain_[1].c[index(i - 1)] = i * chain_[0].c[index(i)];
    scale(chain_[1]);
    size_ = 2;
    while (chain_[index(size_ - 1)].degree > 0 && add_remainder()) ++size_;
  }

  // Sign changes along the chain at z = t, or at z = 1 / t when reversed (t = +-0 stands for +-infinity).
  [[nodiscard]] int changes(double t, bool reversed) const {
    int count = 0;
    bool before = false;
    const bool flips = reversed && std::signbit(t);
    for (int i = 0; i < size_; ++i) {
      const Polynomial& p = chain_[index(i)];
      const bool negative = (value(p, t, reversed) < 0) != (flips && p.degree % 2 == 1);
      count += i > 0 && negative != before;
      before = negative;
    }
    return count;
  }

  [[nodiscard]] const Polynomial& front() const { return chain_[0]; }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  static double scale(Polynomial& p) {
    double largest = 0;
    for (int i = 0; i <= p.degree; ++i) largest = std::max(largest, std::abs(p.c[index(i)]));
    if (largest > 0)
      for (int i = 0; i <= p.degree; ++i) p.c[index(i)] /= largest;
    return largest;
  }

  bool add_remainder() {
    const Polynomial& by = chain_[index(size_ - 1)];
    std::array<double, kDegree + 1> rest = chain_[index(size_ - 2)].c;
    int degree = chain_[index(size_ - 2)].degree;
    const double lead = by.c[index(by.degree)];
    for (; degree >= by.degree; --degree) {
      const double factor = rest[index(degree)] / lead;
      for (int i = 0; i < by.degree; ++i) rest[index(degree - by.degree + i)] -= factor * by.c[index(i)];
    }
    while (degree > 0 && rest[index(degree)] == 0) --degree;
    Polynomial& next = chain_[index(size_)];
    next.degree = degree;
    for (int i = 0; i <= degree; ++i) next.c[index(i)] = -rest[index(i)];
    return scale(next) > 1e-13;  // what is left of a multiple root is rounding
  }

  std::array<Polynomial, kDegree + 1> chain_;
  int size_ = 0;
};

// The root in [low, high], where the values at both ends differ in sign: Newton's method that may not leave the
// bracket.
double bracketed_root(const Polynomial& p, double low, double high, bool reversed) {
  double at_low = value(p, low, reversed);
  double x = (low + high) / 2;
  for (int iteration = 0; iteration < 60; ++iteration) {
    double f = 0, slope = 0;
    for (int i = 0; i <= p.degree; ++i) {
      slope = slope * x + f;
      f = f * x + p.c[static_cast<std::size_t>(reversed ? i : p.degree - i)];
    }
    if (f == 0) return x;
    if ((f < 0) == (at_low < 0)) {
      low = x;
      at_low = f;
    } else {
      high = x;
    }
    const double newton = x - f / slope;
    const double next = newton > low && newton < high ? newton : (low + high) / 2;
    if (std::abs(next - x) < 1e-16 * std::max(1e-3, std::abs(x))) return next;
    x = next;
  }
  return x;
}

struct Piece {
  double low, high;
  int changes_low, changes_high;
  int depth;
};

// Nearer than this (2^-depth of the piece) roots are one: around a double root the signs are rounding.
constexpr int kMostSplits = 24;

// Splits a piece until it holds one root; along t of reversed pieces z runs downwards, hence the absolute difference.
void isolate(const SturmChain& chain, const Piece& whole, bool reversed, Few<double, 10>& roots) {
  std::array<Piece, 64> stack;
  int top = 0;
  stack[0] = whole;
  while (top >= 0) {
    const Piece piece = stack[static_cast<std::size_t>(top--)];
    const int inside = std::abs(piece.changes_low - piece.changes_high);
    if (inside == 0) continue;
    const bool differ =
        (value(chain.front(), piece.low, reversed) < 0) != (value(chain.front(), piece.high, reversed) < 0);
    if ((inside == 1 && differ) || piece.depth > kMostSplits) {
      const double t =
          differ ? bracketed_root(chain.front(), piece.low, piece.high, reversed) : (piece.low + piece.high) / 2;
      if (roots.count < kDegree && (!reversed || std::abs(t) > 1e-8)) roots.add(reversed ? 1 / t : t);
      continue;
    }
    const double middle = (piece.low + piece.high) / 2;
    const int changes = chain.changes(middle, reversed);
    stack[static_cast<std::size_t>(++top)] = {piece.low, middle, piece.changes_low, changes, piece.depth + 1};
    stack[static_cast<std::size_t>(++top)] = {middle, piece.high, changes, piece.changes_high, piece.depth + 1};
  }
}

}  // namespace

Few<double, 2> real_roots(const std::array<double, 3>& c) {
  Few<double, 2> roots;
  if (std::abs(c[2]) <= 1e-14 * std::abs(c[1])) {
    if (c[1] != 0) roots.add(-c[0] / c[1]);
    return roots;
  }
  const double discriminant = c[1] * c[1] - 4 * c[2] * c[0];
  if (!(discriminant >= 0) || c[2] == 0) return roots;
  const double q = -(c[1] + std::copysign(std::sqrt(discriminant), c[1])) / 2;  // no cancellation
  const double first = q / c[2], second = q != 0 ? c[0] / q : first;
  roots.add(std::min(first, second));
  if (first != second) roots.add(std::max(first, second));
  return roots;
}

Few<double, 3> real_roots(const std::array<double, 4>& c) {
  Few<double, 3> roots;
  const bool reversed =
      std::abs(c[0]) > std::abs(c[3]);  // then 1 / x is the better unknown: a leading term near 0 is no harm
  const double lead = reversed ? c[0] : c[3];
  if (lead == 0) {  // both ends vanish: x (c1 + c2 x)
    roots.add(0);
    if (c[2] != 0 && c[1] != 0) roots.add(-c[1] / c[2]);
    return roots;
  }
  const double a = (reversed ? c[1] : c[2]) / lead, b = (reversed ? c[2] : c[1]) / lead;
  const double d = (reversed ? c[3] : c[0]) / lead;
  for (const double raw : monic_cubic_roots(a, b, d)) {
    const double root = polished(raw, a, b, d);
    if (!reversed)
      roots.add(root);
    else if (std::abs(root) > 1e-12)
      roots.add(1 / root);
  }
  return roots;
}

Few<double, 10> real_roots(const std::array<double, 11>& c) {
  Few<double, 10> roots;
  Polynomial p{c, kDegree};
  double largest = 0;
  for (const double value : c) largest = std::max(largest, std::abs(value));
  if (!(largest > 0) || !std::isfinite(largest)) return roots;
  while (p.degree > 0 && std::abs(p.c[static_cast<std::size_t>(p.degree)]) < 1e-15 * largest) --p.degree;
  if (p.degree == 0) return roots;

  const SturmChain chain(p);
  const int at_minus_infinity = chain.changes(-0.0, true), at_infinity = chain.changes(0.0, true);
  const int at_minus_one = chain.changes(-1, false), at_one = chain.changes(1, false);
  isolate(chain, {-1, 1, at_minus_one, at_one, 0}, false, roots);
  isolate(chain, {-1, -0.0, at_minus_one, at_minus_infinity, 0}, true, roots);
  isolate(chain, {0, 1, at_infinity, at_one, 0}, true, roots);
  return roots;
}

}  // namespace collinea
