// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/target.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collinea/feature/internal/grey_fit.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kX = 0, kY = 1, kBlur = 2, kGround = 3, kSlopeX = 4, kSlopeY = 5, kContrast = 6, kFirst = 7;
constexpr double kLeastBlurPx = 0.2, kLargestBlurPx = 4;
constexpr double kContrastSigmas = 5, kLeastContrast = 0.5;  // [grey]

int count_of(TargetKind kind) { return kind == TargetKind::kCircle ? 10 : kind == TargetKind::kCross ? 11 : 9; }

// Normal distribution and its density. So far out that a double does not tell them from 0 and 1, most pixels are.
constexpr double kFarOut = 9;
double phi(double u) {
  if (std::abs(u) > kFarOut) return u > 0 ? 1 : 0;
  return 0.5 * std::erfc(-u / std::numbers::sqrt2);
}
double density(double u) {
  if (std::abs(u) > kFarOut) return 0;
  return std::exp(-u * u / 2) / std::sqrt(2 * std::numbers::pi);
}

// Shape and its derivatives after x, y, blur and the unknowns from kFirst on.
struct Shape {
  double value = 0;
  std::array<double, 11> d{};
};

// Sine and cosine of an angle among the unknowns: once for all pixels.
struct Turn {
  double s = 0, c = 1;
  Turn() = default;
  explicit Turn(double angle) : s(std::sin(angle)), c(std::cos(angle)) {}
};
using Turns = std::array<Turn, 2>;
Turns turns_of(TargetKind kind, const VectorXd& u) {
  if (kind == TargetKind::kCircle) return {Turn(u[kFirst + 2]), Turn()};
  return {Turn(u[kFirst]), Turn(u[kFirst + 1])};
}

Shape circle_shape(const VectorXd& u, const Turns& turns, const Vector2d& q) {
  const double a = u[kFirst], b = u[kFirst + 1], c = turns[0].c, s = turns[0].s;
  const double x = c * q.x() + s * q.y(), y = -s * q.x() + c * q.y();  // in the axes
  const double f = std::sqrt(x * x / (a * a) + y * y / (b * b));
  Shape out;
  if (f < 0.05) {  // the middle, far from the border
    out.value = 1;
    return out;
  }
  // Distance inwards to first order: t = (1 - f) f / g, g = |(x / a^2, y / b^2)|.
  const double a2 = a * a, b2 = b * b, g = std::hypot(x / a2, y / b2), t = (1 - f) * f / g, w = t / u[kBlur];
  out.value = phi(w);
  const double slope = density(w) / u[kBlur];
  const double by_f = (1 - 2 * f) / g, by_g = -t / g;
  const auto after = [&](double dx, double dy, double da, double db) {  // of t, by what moves
    const double df = (x * dx / a2 + y * dy / b2 - x * x * da / (a2 * a) - y * y * db / (b2 * b)) / f;
    const double dg = (x / a2 * (dx / a2 - 2 * x * da / (a2 * a)) + y / b2 * (dy / b2 - 2 * y * db / (b2 * b))) / g;
    return slope * (by_f * df + by_g * dg);
  };
  out.d[kX] = after(-c, s, 0, 0);
  out.d[kY] = after(-s, -c, 0, 0);
  out.d[kBlur] = -density(w) * w / u[kBlur];
  out.d[kFirst] = after(0, 0, 1, 0);
  out.d[kFirst + 1] = after(0, 0, 0, 1);
  out.d[kFirst + 2] = after(y, -x, 0, 0);
  return out;
}

// Distance from the line through the centre in the direction of an angle, and what moves it.
struct FromLine {
  double t, by_x, by_y, by_angle;
  FromLine(const Turn& turn, const Vector2d& q)
      : t(-turn.s * q.x() + turn.c * q.y()), by_x(turn.s), by_y(-turn.c), by_angle(-turn.c * q.x() - turn.s * q.y()) {}
};

Shape cross_shape(const VectorXd& u, const Turns& turns, const Vector2d& q) {
  std::array<double, 2> bar{}, by_t{}, by_width{}, by_blur{};
  const std::array<FromLine, 2> lines{FromLine(turns[0], q), FromLine(turns[1], q)};
  for (std::size_t i = 0; i < 2; ++i) {
    const double s = u[kBlur], h = u[kFirst + 2 + int(i)], up = (h - lines[i].t) / s, down = (-h - lines[i].t) / s;
    bar[i] = phi(up) - phi(down);
    by_t[i] = (density(down) - density(up)) / s;
    by_width[i] = (density(up) + density(down)) / s;
    by_blur[i] = (density(down) * down - density(up) * up) / s;
  }
  Shape out;
  out.value = 1 - (1 - bar[0]) * (1 - bar[1]);
  for (std::size_t i = 0; i < 2; ++i) {
    const double other = 1 - bar[1 - i];
    out.d[kX] += other * by_t[i] * lines[i].by_x;
    out.d[kY] += other * by_t[i] * lines[i].by_y;
    out.d[kBlur] += other * by_blur[i];
    out.d[std::size_t(kFirst) + i] = other * by_t[i] * lines[i].by_angle;
    out.d[std::size_t(kFirst) + 2 + i] = other * by_width[i];
  }
  return out;
}

Shape chequerboard_shape(const VectorXd& u, const Turns& turns, const Vector2d& q) {
  std::array<double, 2> side{}, by_t{}, by_blur{};
  const std::array<FromLine, 2> lines{FromLine(turns[0], q), FromLine(turns[1], q)};
  for (std::size_t i = 0; i < 2; ++i) {
    const double w = lines[i].t / u[kBlur];
    side[i] = 2 * phi(w) - 1;
    by_t[i] = 2 * density(w) / u[kBlur];
    by_blur[i] = -by_t[i] * w;
  }
  Shape out;
  out.value = side[0] * side[1];
  for (std::size_t i = 0; i < 2; ++i) {
    const double other = side[1 - i];
    out.d[kX] += other * by_t[i] * lines[i].by_x;
    out.d[kY] += other * by_t[i] * lines[i].by_y;
    out.d[kBlur] += other * by_blur[i];
    out.d[std::size_t(kFirst) + i] = other * by_t[i] * lines[i].by_angle;
  }
  return out;
}

// --- adjustment
// -------------------------------------------------------------------------------------------------------

// The grey value at a pixel, and its derivatives after the unknowns.
double grey_of(TargetKind kind, const VectorXd& u, const Turns& turns, const Vector2d& p, double* derivatives) {
  const Vector2d q = p - u.head<2>();
  const Shape shape = kind == TargetKind::kCircle  ? circle_shape(u, turns, q)
                      : kind == TargetKind::kCross ? cross_shape(u, turns, q)
                                                   : chequerboard_shape(u, turns, q);
  if (derivatives) {
    for (Eigen::Index k = 0; k < u.size(); ++k) derivatives[k] = u[kContrast] * shape.d[std::size_t(k)];
    derivatives[kX] -= u[kSlopeX];
    derivatives[kY] -= u[kSlopeY];
    derivatives[kGround] = 1;
    derivatives[kSlopeX] = q.x();
    derivatives[kSlopeY] = q.y();
    derivatives[kContrast] = shape.value;
  }
  return u[kGround] + u[kSlopeX] * q.x() + u[kSlopeY] * q.y() + u[kContrast] * shape.value;
}

bool is_possible(const GreyWindow& window, TargetKind kind, const VectorXd& u) {
  const Vector2d middle(window.x0 + window.width / 2.0, window.y0 + window.height / 2.0);
  if (!u.allFinite() || !(u[kBlur] >= kLeastBlurPx && u[kBlur] <= kLargestBlurPx)) return false;
  if (std::abs(u[kX] - middle.x()) > window.width / 4.0 || std::abs(u[kY] - middle.y()) > window.height / 4.0)
    return false;
  if (kind == TargetKind::kCircle)
    return std::min(u[kFirst], u[kFirst + 1]) > 1 && std::max(u[kFirst], u[kFirst + 1]) < 0.75 * window.width;
  if (std::abs(std::sin(u[kFirst] - u[kFirst + 1])) < 0.25) return false;
  return kind == TargetKind::kChequerboard ||
         (std::min(u[kFirst + 2], u[kFirst + 3]) > 0.2 && std::max(u[kFirst + 2], u[kFirst + 3]) < 0.2 * window.width);
}

// A kind of target in a window, for fit_grey().
struct TargetModel {
  static constexpr std::size_t kMostUnknowns = 11;
  TargetKind kind;
  const GreyWindow& window;

  [[nodiscard]] bool is_possible(const VectorXd& u) const { return collinea::is_possible(window, kind, u); }
  [[nodiscard]] auto at(const VectorXd& u) const {
    return [this, &u, turns = turns_of(kind, u)](const Vector2d& p, double* derivatives) {
      return grey_of(kind, u, turns, p, derivatives);
    };
  }
};

std::optional<Target> adjusted(const FloatImage& image, GreyWindow window, TargetKind kind, const VectorXd& start) {
  if (const int radius = window.width / 2; radius < kLeastSquareRadius_px)
    for (int i = 0; i < window.count(); ++i)
      window.used.push_back(counts_in_window(radius, window.pixel(i) - start.head<2>()));
  // The angle of a circle is not determined; all else must be.
  const auto undetermined = [&](const VectorXd& u) {
    return kind == TargetKind::kCircle &&
                   std::abs(u[kFirst] - u[kFirst + 1]) < 1e-3 * std::max(u[kFirst], u[kFirst + 1])
               ? 1
               : 0;
  };
  const auto fit = fit_grey(image, window, TargetModel{kind, window}, start, undetermined);
  if (!fit) return std::nullopt;
  const Target out{.kind = kind,
                   .at = fit->unknowns.head<2>(),
                   .covariance = fit->cofactors.topLeftCorner<2, 2>(),
                   .unknowns = fit->unknowns,
                   .cofactors = fit->cofactors,
                   .sigma_grey = fit->sigma_grey,
                   .redundancy = fit->redundancy,
                   .has_correlated_residuals = fit->has_correlated_residuals};
  if (!(std::abs(out.contrast()) > std::max(kLeastContrast / 2, kContrastSigmas * out.sigma_grey))) return std::nullopt;
  return out;
}

// --- starts
// -----------------------------------------------------------------------------------------------------------

GreyWindow window_about(const Vector2d& p, int radius) {
  return {int(std::floor(p.x())) - radius, int(std::floor(p.y())) - radius, 2 * radius + 1, 2 * radius + 1};
}

VectorXd start_of(TargetKind kind, const Vector2d& at, double ground, double contrast) {
  VectorXd u = VectorXd::Zero(count_of(kind));
  u.head<2>() = at;
  u[kBlur] = 0.8;
  u[kGround] = ground;
  u[kContrast] = contrast;
  return u;
}

// Grey values on a circle about the centre, evenly over a turn.
std::vector<double> ring_of(const FloatImage& image, const Vector2d& at, double radius_px, int count) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    out.push_back(bilinear(image, at.x() + radius_px * std::cos(angle), at.y() + radius_px * std::sin(angle)));
  }
  return out;
}

// Angles where a ring crosses the middle between its extremes, upwards (+1) and downwards (-1).
struct Crossing {
  double angle_rad;
  int sense;
};
struct Ring {
  double low = 0, high = 0;
  std::vector<Crossing> crossings;
};
Ring crossings_of(const FloatImage& image, const Vector2d& at, double radius_px) {
  const int count = std::max(32, int(8 * radius_px));
  const std::vector<double> grey = ring_of(image, at, radius_px, count);
  Ring ring{*std::min_element(grey.begin(), grey.end()), *std::max_element(grey.begin(), grey.end()), {}};
  const double middle = (ring.low + ring.high) / 2;
  for (int k = 0; k < count; ++k) {
    const double a = grey[std::size_t(k)] - middle, b = grey[std::size_t((k + 1) % count)] - middle;
    if ((a < 0) != (b < 0))
      ring.crossings.push_back({2 * std::numbers::pi * (k + a / (a - b)) / count, a < 0 ? 1 : -1});
  }
  return ring;
}

double mean_direction(double a, double b) {  // of two lines' angles, modulo half a turn
  const double pi = std::numbers::pi;
  return a + std::remainder(b - a, pi) / 2;
}

// Where the chords between opposite ones of four points of a ring meet; the middle of the ring where they do not.
Vector2d meeting_point(const Vector2d& at, double radius_px, const std::array<double, 4>& angles) {
  std::array<Vector2d, 4> p;
  for (std::size_t k = 0; k < 4; ++k) p[k] = at + radius_px * Vector2d(std::cos(angles[k]), std::sin(angles[k]));
  Matrix2d along;
  along << p[2] - p[0], p[1] - p[3];
  if (!(std::abs(along.determinant()) > 0.1 * radius_px * radius_px)) return at;
  return p[0] + along.inverse().row(0).dot(p[1] - p[0]) * (p[2] - p[0]);
}

std::optional<VectorXd> chequerboard_start(const FloatImage& image, const Vector2d& at, double radius_px) {
  const Ring ring = crossings_of(image, at, radius_px);
  const auto& c = ring.crossings;
  if (c.size() != 4 || ring.high - ring.low < kLeastContrast) return std::nullopt;
  VectorXd u = start_of(TargetKind::kChequerboard, at, (ring.low + ring.high) / 2, 0);
  u[kFirst] = mean_direction(c[0].angle_rad, c[2].angle_rad);
  u[kFirst + 1] = mean_direction(c[1].angle_rad, c[3].angle_rad);
  const double between = (c[0].angle_rad + c[1].angle_rad) / 2;  // the field behind the first crossing
  const Vector2d field(std::cos(between), std::sin(between));
  VectorXd unit = u;
  unit[kContrast] = 1;
  unit[kGround] = 0;
  const double shape = target_grey(TargetKind::kChequerboard, unit, at + radius_px * field);
  u.head<2>() = meeting_point(at, radius_px, {c[0].angle_rad, c[1].angle_rad, c[2].angle_rad, c[3].angle_rad});
  u[kContrast] = std::copysign((ring.high - ring.low) / 2, shape * c[0].sense);
  return u;
}

std::optional<VectorXd> cross_start(const FloatImage& image, const Vector2d& at, double radius_px) {
  const Ring ring = crossings_of(image, at, radius_px);
  if (ring.crossings.size() != 8 || ring.high - ring.low < kLeastContrast) return std::nullopt;
  const double middle = (ring.low + ring.high) / 2;
  const bool is_bright = bilinear(image, at.x(), at.y()) > middle;
  // The four bars begin with a crossing into their grey value.
  const std::size_t first = (ring.crossings[0].sense > 0) == is_bright ? 0 : 1;
  std::array<double, 4> angle{}, width{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double a = ring.crossings[first + 2 * k].angle_rad;
    double b = ring.crossings[(first + 2 * k + 1) % 8].angle_rad;
    if (b < a) b += 2 * std::numbers::pi;
    angle[k] = (a + b) / 2;
    width[k] = radius_px * std::sin((b - a) / 2);
  }
  VectorXd u = start_of(TargetKind::kCross, at, is_bright ? ring.low : ring.high,
                        is_bright ? ring.high - ring.low : ring.low - ring.high);
  u.head<2>() = meeting_point(at, radius_px, angle);
  for (int i = 0; i < 2; ++i) {
    u[kFirst + i] = mean_direction(angle[std::size_t(i)], angle[std::size_t(i + 2)]);
    u[kFirst + 2 + i] = std::max(0.4, (width[std::size_t(i)] + width[std::size_t(i + 2)]) / 2);
  }
  return u;
}

// From grey values alone: ground along the border of the window, size by the area beyond the middle grey value.
std::optional<VectorXd> circle_start(const FloatImage& image, const Vector2d& at, int radius) {
  const GreyWindow w = window_about(at, radius);
  double border = 0, inside = bilinear(image, at.x(), at.y());
  int count = 0;
  for (int i = 0; i < w.count(); ++i)
    if (i % w.width == 0 || i % w.width == w.width - 1 || i / w.width == 0 || i / w.width == w.height - 1) {
      border += image.at(w.x0 + i % w.width, w.y0 + i / w.width);
      ++count;
    }
  border /= count;
  double area = 0;
  Vector2d centre = Vector2d::Zero();
  for (int i = 0; i < w.count(); ++i) {
    const double share = (image.at(w.x0 + i % w.width, w.y0 + i / w.width) - border) / (inside - border);
    if (!(share > 0.5)) continue;
    area += 1;
    centre += w.pixel(i);
  }
  if (area < 3) return std::nullopt;
  VectorXd u = start_of(TargetKind::kCircle, centre / area, border, inside - border);
  u[kFirst] = 1.02 * std::sqrt(area / std::numbers::pi);
  u[kFirst + 1] = 0.98 * u[kFirst];
  return u;
}

}  // namespace

double target_grey(TargetKind kind, const TargetUnknowns& u, const Vector2d& p, VectorXd* derivatives) {
  if (derivatives) derivatives->resize(u.size());
  return grey_of(kind, u, turns_of(kind, u), p, derivatives ? derivatives->data() : nullptr);
}

double Target::sigma_px() const {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Matrix2d>(covariance).eigenvalues()[1]);
}

namespace {

// The start about a position, which follows the centre that the ring shows.
std::optional<VectorXd> centred_start(const FloatImage& image, TargetKind kind, const Vector2d& near_px, int radius_px,
                                      double ring_px) {
  std::optional<VectorXd> start;
  Vector2d centre = near_px;
  for (int pass = 0; pass < 3; ++pass) {
    if (!window_about(centre, radius_px).lies_in(image)) return std::nullopt;
    start = kind == TargetKind::kCircle  ? circle_start(image, centre, radius_px)
            : kind == TargetKind::kCross ? cross_start(image, centre, ring_px)
                                         : chequerboard_start(image, centre, ring_px);
    if (!start || (start->head<2>() - near_px).norm() > radius_px / 2.0) return std::nullopt;
    centre = start->head<2>();
  }
  return start;
}

}  // namespace

std::optional<Target> measure_target(const FloatImage& image, TargetKind kind, const Vector2d& near_px, int radius_px) {
  const int least_radius_px = kind == TargetKind::kChequerboard ? 3 : kLeastSquareRadius_px;
  if (radius_px < least_radius_px || !near_px.allFinite() || !(near_px.cwiseAbs().maxCoeff() < 1e6))
    return std::nullopt;
  for (const double part : {0.75, 0.5}) {  // of the window, where the ring runs
    const auto start = centred_start(image, kind, near_px, radius_px, part * radius_px);
    if (!start || !window_about(start->head<2>(), radius_px).lies_in(image)) continue;
    if (auto target = adjusted(image, window_about(start->head<2>(), radius_px), kind, *start)) return target;
  }
  return std::nullopt;
}

std::optional<Target> measure_circle(const FloatImage& image, const Ellipse& start) {
  VectorXd u = start_of(TargetKind::kCircle, start.centre, 0, 0);
  u.segment<3>(kFirst) << start.major_px, start.minor_px, start.angle_rad;
  const int radius = int(std::ceil(start.major_px)) + 4;
  const GreyWindow window = window_about(start.centre, radius);
  if (!window.lies_in(image)) return std::nullopt;
  const double inside = bilinear(image, start.centre.x(), start.centre.y());
  double outside = 0;
  for (int k = 0; k < 16; ++k) {
    const double t = k * std::numbers::pi / 8;
    const Vector2d p = start.centre + (1 + 2.5 / start.minor_px) * (start.at(t) - start.centre);
    outside += bilinear(image, p.x(), p.y()) / 16;
  }
  u[kGround] = outside;
  u[kContrast] = inside - outside;
  return adjusted(image, window, TargetKind::kCircle, u);
}

}  // namespace collinea
