// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/additional.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace collinea {
namespace {

constexpr int kDegrees = 5;  // 0 to 4

// Polynomials in one variable, orthogonal on positions spread evenly from -1 to 1, with their derivatives.
struct Polynomials {
  std::array<double, kDegrees> value, slope;
};

// t^2 - a, t^3 - b t, t^4 - c t^2 + d, and the share that parts x y from t^2 - a in tilts (theory: camera).
struct Orthogonal {
  int highest;  // degree in one variable
  int total;    // degree of a product
  double a, b, c, d, tilt;
};

Orthogonal orthogonal(AdditionalSet set) {
  if (set == AdditionalSet::kEbner) return {2, 4, 2.0 / 3, 0, 0, 0, 2};                            // 3 positions
  if (set == AdditionalSet::kGruen) return {4, 8, 0.5, 17.0 / 20, 31.0 / 28, 9.0 / 70, 10.0 / 7};  // 5 positions
  return {3, 3, 1.0 / 3, 0.6, 0, 0, 1.25};                                                         // all positions
}

Polynomials polynomials(const Orthogonal& o, double t) {
  const double t2 = t * t;
  return {{1, t, t2 - o.a, t * (t2 - o.b), t2 * (t2 - o.c) + o.d}, {0, 1, 2 * t, 3 * t2 - o.b, t * (4 * t2 - 2 * o.c)}};
}

// One parameter: a product of polynomials for the column, one for the row.
struct Part {
  enum Factor { kNothing, kOne, kWidth, kHeight, kMinusWidthTilt, kMinusHeightTilt, kMinusWidth } factor = kNothing;
  int x = 0, y = 0;  // degrees
};
struct Product {
  Part column, row;
};

// Products of both variables that orientation, principal point and focal length do not imitate.
std::vector<Product> products_of(const Orthogonal& o) {
  std::vector<Product> list = {{{Part::kHeight, 1, 0}, {Part::kMinusWidth, 0, 1}},      // not the scale
                               {{Part::kWidth, 0, 1}, {Part::kHeight, 1, 0}},           // not the rotation
                               {{Part::kMinusHeightTilt, 2, 0}, {Part::kWidth, 1, 1}},  // not the tilts
                               {{Part::kHeight, 1, 1}, {Part::kMinusWidthTilt, 0, 2}}};
  for (int degree = 2; degree <= o.total; ++degree)
    for (int x = 0; x <= std::min(degree, o.highest); ++x) {
      const int y = degree - x;
      if (y > o.highest || (degree == 2 && y < 2)) continue;
      list.push_back({{Part::kOne, x, y}, {}});
      list.push_back({{}, {Part::kOne, y, x}});
    }
  return list;
}

const std::vector<Product>& products(AdditionalSet set) {
  static const std::array<std::vector<Product>, 3> kProducts = {products_of(orthogonal(AdditionalSet::kPolynomial)),
                                                                products_of(orthogonal(AdditionalSet::kEbner)),
                                                                products_of(orthogonal(AdditionalSet::kGruen))};
  return kProducts[static_cast<std::size_t>(set) - static_cast<std::size_t>(AdditionalSet::kPolynomial)];
}

double factor_of(Part::Factor factor, const Orthogonal& o, double width, double height) {
  switch (factor) {
    case Part::kNothing:
      return 0;
    case Part::kOne:
      return 1;
    case Part::kWidth:
      return width;
    case Part::kHeight:
      return height;
    case Part::kMinusWidthTilt:
      return -o.tilt * width;
    case Part::kMinusHeightTilt:
      return -o.tilt * height;
    case Part::kMinusWidth:
      return -width;
  }
  return 0;
}

// The waves of the Fourier set: m u + n v; their cosines come first, then their sines, for the column, then the row.
constexpr std::array<std::array<int, 2>, 4> kWaves = {{{1, 0}, {0, 1}, {1, -1}, {1, 1}}};

struct NormalisedPosition {
  double x, y;           // -1 to 1 over the image
  double by_x, by_y;     // of them by the pixel
  double width, height;  // of the longer side
};

NormalisedPosition normalised_position(ImageExtent size, const Eigen::Vector2d& pixel) {
  const double half_width = std::max(1.0, size.width_px) / 2, half_height = std::max(1.0, size.height_px) / 2;
  const double longer = std::max(half_width, half_height);
  return {(pixel.x() - half_width) / half_width,
          (pixel.y() - half_height) / half_height,
          1 / half_width,
          1 / half_height,
          half_width / longer,
          half_height / longer};
}

// Legendre's polynomials, with their derivatives; beyond -1 and 1 as there.
constexpr int kFilmDegree = 6;
struct Legendre {
  std::array<double, kFilmDegree + 1> value{}, slope{};

  explicit Legendre(double t) {
    const bool is_beyond = !(t >= -1 && t <= 1);
    t = std::clamp(t, -1.0, 1.0);
    value[0] = 1, value[1] = t, slope[1] = 1;
    for (std::size_t n = 1; n + 1 < value.size(); ++n) {
      value[n + 1] = (double(2 * n + 1) * t * value[n] - double(n) * value[n - 1]) / double(n + 1);
      slope[n + 1] = slope[n - 1] + double(2 * n + 1) * value[n];
    }
    if (is_beyond) slope.fill(0);
  }
};

// Calls visit(function, its value, its derivatives by x and y) for the functions of film.
template <class Visit>
void for_each_film(const NormalisedPosition& at, Visit&& visit) {
  const Legendre x(at.x), y(at.y);
  std::size_t k = 0;
  for (std::size_t degree = 0; degree <= kFilmDegree; ++degree)
    for (std::size_t i = 0; i <= degree; ++i, ++k) {
      const std::size_t j = degree - i;
      visit(k, x.value[i] * y.value[j], x.slope[i] * y.value[j], x.value[i] * y.slope[j]);
    }
}

// Calls visit(number, column, row, their derivatives by x and y) for every parameter.
template <class Visit>
void for_each(AdditionalSet set, const NormalisedPosition& at, Visit&& visit) {
  if (set == AdditionalSet::kFourier) {
    constexpr double kPi = std::numbers::pi;
    for (std::size_t w = 0; w < kWaves.size(); ++w) {
      const double m = kPi * kWaves[w][0], n = kPi * kWaves[w][1], phase = m * at.x + n * at.y;
      const double cosine = std::cos(phase), sine = std::sin(phase);
      for (const std::size_t axis : {0u, 1u}) {
        const double column = axis == 0 ? 1 : 0, row = 1 - column;
        visit(8 * axis + w, column * cosine, row * cosine, -column * m * sine, -column * n * sine, -row * m * sine,
              -row * n * sine);
        visit(8 * axis + 4 + w, column * sine, row * sine, column * m * cosine, column * n * cosine, row * m * cosine,
              row * n * cosine);
      }
    }
    return;
  }
  if (set == AdditionalSet::kFilm) {
    for_each_film(at, [&](std::size_t k, double value, double by_x, double by_y) {
      visit(2 * k, value, 0, by_x, by_y, 0, 0);
      visit(2 * k + 1, 0, value, 0, 0, by_x, by_y);
    });
    return;
  }
  const Orthogonal o = orthogonal(set);
  const Polynomials x = polynomials(o, at.x), y = polynomials(o, at.y);
  const auto value = [&](const Part& p) { return x.value[std::size_t(p.x)] * y.value[std::size_t(p.y)]; };
  const auto by_x = [&](const Part& p) { return x.slope[std::size_t(p.x)] * y.value[std::size_t(p.y)]; };
  const auto by_y = [&](const Part& p) { return x.value[std::size_t(p.x)] * y.slope[std::size_t(p.y)]; };
  const std::vector<Product>& list = products(set);
  for (std::size_t k = 0; k < list.size(); ++k) {
    const Part &c = list[k].column, &r = list[k].row;
    const double u = factor_of(c.factor, o, at.width, at.height), v = factor_of(r.factor, o, at.width, at.height);
    visit(k, u * value(c), v * value(r), u * by_x(c), u * by_y(c), v * by_x(r), v * by_y(r));
  }
}

}  // namespace

std::size_t count_of(AdditionalSet set) {
  if (set == AdditionalSet::kNone) return 0;
  if (set == AdditionalSet::kFilm) return 2 * kFilmFunctions;
  return set == AdditionalSet::kFourier ? 4 * kWaves.size() : products(set).size();
}

AdditionalShift additional_shift(AdditionalSet set, const double* values, ImageExtent size,
                                 const Eigen::Vector2d& pixel) {
  AdditionalShift sum;
  if (set == AdditionalSet::kNone) return sum;
  const NormalisedPosition at = normalised_position(size, pixel);
  for_each(set, at, [&](std::size_t k, double column, double row, double cx, double cy, double rx, double ry) {
    const double a = values[k];
    sum.shift_px += a * Eigen::Vector2d(column, row);
    sum.by_pixel(0, 0) += a * cx * at.by_x;
    sum.by_pixel(0, 1) += a * cy * at.by_y;
    sum.by_pixel(1, 0) += a * rx * at.by_x;
    sum.by_pixel(1, 1) += a * ry * at.by_y;
  });
  return sum;
}

Eigen::Matrix<double, kFilmFunctions, 1> film_functions(ImageExtent size, const Eigen::Vector2d& pixel) {
  Eigen::Matrix<double, kFilmFunctions, 1> values;
  for_each_film(normalised_position(size, pixel),
                [&](std::size_t k, double value, double, double) { values[Eigen::Index(k)] = value; });
  return values;
}

void additional_effect(AdditionalSet set, ImageExtent size, const Eigen::Vector2d& pixel, AdditionalEffect& effect) {
  if (set == AdditionalSet::kNone) return;
  for_each(set, normalised_position(size, pixel),
           [&](std::size_t k, double column, double row, double, double, double, double) {
             effect.column[k] = column;
             effect.row[k] = row;
           });
}

}  // namespace collinea
