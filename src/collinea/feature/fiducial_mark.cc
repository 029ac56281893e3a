// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/fiducial_mark.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kSpacing = 0.25;  // of drawn templates [px]
constexpr double kBlurs_px[] = {0.5, 0.7, 0.95, 1.25, 1.6, 2.05, 2.6};

// Whether a position, from the mark and along its axis, lies on the drawing.
bool is_drawn(MarkKind kind, const Vector2d& at, double size, double line) {
  const double r = at.norm(), half = size / 2;
  switch (kind) {
    case MarkKind::kCross:
      return std::max(std::abs(at.x()), std::abs(at.y())) <= half &&
             std::min(std::abs(at.x()), std::abs(at.y())) <= line / 2;
    case MarkKind::kDot:
      return r <= half;
    case MarkKind::kRing:
      return r <= half && r >= half - line;
    case MarkKind::kCorner: {
      // Arms at 45 degrees to both sides of the axis; the mark is where their middle lines meet.
      const double u = (at.x() + at.y()) / std::sqrt(2.0), v = (at.x() - at.y()) / std::sqrt(2.0);
      return u >= -line / 2 && v >= -line / 2 && std::max(u, v) <= half && std::min(u, v) <= line / 2;
    }
    case MarkKind::kNotch:
      return at.x() >= std::min(std::abs(at.y()), half);
  }
  return false;
}

// Shares of lattice cells that the drawing covers. Cells whose corners and middle agree lie within or without: no line
// is narrower than two cells.
FloatImage coverage(MarkKind kind, double size, double line, double inwards, int half_cells) {
  const int width = 2 * half_cells + 1;
  constexpr int kFiner = 16;
  FloatImage image(width, width);
  const double c = std::cos(inwards), s = std::sin(inwards);
  const auto is_bright = [&](double x, double y) {
    const double u = kSpacing * (x - half_cells - 0.5), v = kSpacing * (y - half_cells - 0.5);
    return is_drawn(kind, {c * u + s * v, -s * u + c * v}, size, line);
  };
  const bool has_wide_lines = line >= 2 * kSpacing;
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x) {
      const int agree = is_bright(x, y) + is_bright(x + 1, y) + is_bright(x, y + 1) + is_bright(x + 1, y + 1) +
                        is_bright(x + 0.5, y + 0.5);
      if (has_wide_lines && agree % 5 == 0) {
        image.at(x, y) = agree == 0 ? 0.0F : 1.0F;
        continue;
      }
      int drawn = 0;
      for (int k = 0; k < kFiner * kFiner; ++k) {
        // A lattice that is turned: edges along the cells or their diagonals cross it at 256 positions, not at 16; and
        // of an even number, so that edges through the middle of the mark meet none of its points.
        const double i = k % kFiner + 0.5, j = k / kFiner + 0.5;
        drawn +=
            is_bright(x + (i + (j - kFiner / 2.0) / kFiner) / kFiner, y + (j - (i - kFiner / 2.0) / kFiner) / kFiner);
      }
      image.at(x, y) = float(drawn) / float(kFiner * kFiner);
    }
  return image;
}

FloatImage transposed(const FloatImage& image) {
  FloatImage out(image.height, image.width);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.at(y, x) = image.at(x, y);
  return out;
}

FloatImage blurred_along_rows(const FloatImage& image, double sigma) {
  const int reach = int(std::ceil(3.5 * sigma));
  std::vector<float> kernel;
  float sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    kernel.push_back(float(std::exp(-0.5 * k * k / (sigma * sigma))));
    sum += kernel.back();
  }
  FloatImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float value = 0;
      for (int k = -reach; k <= reach; ++k)
        value += kernel[std::size_t(k + reach)] * image.at(std::clamp(x + k, 0, image.width - 1), y);
      out.at(x, y) = value / sum;
    }
  return out;
}

FloatImage blurred(const FloatImage& image, double sigma) {
  return transposed(blurred_along_rows(transposed(blurred_along_rows(image, sigma)), sigma));
}

struct Sample {
  double value = 0;
  Vector2d gradient;  // by the position in pixels of the raster
};

// Weights of four neighbours by Catmull and Rom's cubic at t in [0, 1), and their derivatives.
void cubic(double t, std::array<double, 4>& weight, std::array<double, 4>& slope) {
  const double t2 = t * t, t3 = t2 * t;
  weight = {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2, (t3 - t2) / 2};
  slope = {(-3 * t2 + 4 * t - 1) / 2, (9 * t2 - 10 * t) / 2, (-9 * t2 + 8 * t + 1) / 2, (3 * t2 - 2 * t) / 2};
}

// Nothing within a cell and a half of the border.
std::optional<Sample> sample(const FloatImage& image, const Vector2d& at) {
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  if (!(x >= 1 && y >= 1 && x < image.width - 2 && y < image.height - 2)) return std::nullopt;
  const int x0 = int(x), y0 = int(y);
  std::array<double, 4> wx, wy, sx, sy;
  cubic(x - x0, wx, sx);
  cubic(y - y0, wy, sy);
  Sample out{0, Vector2d::Zero()};
  for (std::size_t j = 0; j < 4; ++j) {
    const float* row = image.row(y0 - 1 + int(j)) + x0 - 1;
    double value = 0, slope = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      value += wx[i] * double(row[i]);
      slope += sx[i] * double(row[i]);
    }
    out.value += wy[j] * value;
    out.gradient += Vector2d(wy[j] * slope, sy[j] * value);
  }
  return out;
}

// A drawing at two widths of blur, to be mixed; `wider` is missing where there is one only.
struct Blend {
  const MarkTemplate* narrower = nullptr;
  const MarkTemplate* wider = nullptr;
};

// Unknowns of a match: where the mark is, its map template = warp (pixel - centre), gain and offset, and the share of
// the wider drawing.
struct Placement {
  Vector2d centre;
  Matrix2d warp = Matrix2d::Identity();
  double gain = 0, offset = 0, wider = 0;
};

constexpr int kUnknowns = 9;  // shift x, y; warp by rows; gain, offset; wider
using Row = Eigen::Matrix<double, kUnknowns, 1>;
using Normals = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// Derivatives and residuals of the pixels of a square; pixels beyond the template have none.
struct Window {
  int left = 0, top = 0, width = 0;
  std::vector<Row> rows;
  std::vector<double> residuals;
  std::vector<char> is_there;
  int count = 0;
  double squares = 0;
};

// The square of pixels that a template covers about a position; nothing where it leaves the scan.
std::optional<Window> window_about(const GreyImage& scan, const MarkTemplate& drawing, const Vector2d& centre) {
  if (!centre.allFinite()) return std::nullopt;
  const int half = int(0.88 * drawing.half_px());
  Window w;
  w.width = 2 * half + 1;
  w.left = int(std::floor(centre.x())) - half;
  w.top = int(std::floor(centre.y())) - half;
  if (half < 2 || w.left < 0 || w.top < 0 || w.left + w.width > scan.width || w.top + w.width > scan.height)
    return std::nullopt;
  return w;
}

void fill(Window& w, const GreyImage& scan, const Blend& blend, const Placement& at) {
  const MarkTemplate& drawing = *blend.narrower;
  const auto n = std::size_t(w.width) * std::size_t(w.width);
  w.rows.assign(n, Row::Zero());
  w.residuals.assign(n, 0);
  w.is_there.assign(n, 0);
  w.count = 0;
  w.squares = 0;
  for (int y = 0; y < w.width; ++y)
    for (int x = 0; x < w.width; ++x) {
      const Vector2d d = Vector2d(w.left + x + 0.5, w.top + y + 0.5) - at.centre;
      const Vector2d on_drawing = drawing.centre + at.warp * d / drawing.spacing_px;
      auto s = sample(drawing.values, on_drawing);
      if (!s) continue;
      double by_wider = 0;
      if (blend.wider) {
        const auto other = sample(blend.wider->values, on_drawing);
        by_wider = other->value - s->value;
        s->value += at.wider * by_wider;
        s->gradient += at.wider * (other->gradient - s->gradient);
      }
      const auto i = std::size_t(y) * std::size_t(w.width) + std::size_t(x);
      const Vector2d g = at.gain * s->gradient / drawing.spacing_px, by_centre = -at.warp.transpose() * g;
      w.rows[i] << by_centre, g.x() * d.x(), g.x() * d.y(), g.y() * d.x(), g.y() * d.y(), s->value, 1,
          at.gain * by_wider;
      w.residuals[i] = double(scan.at(w.left + x, w.top + y)) - at.gain * s->value - at.offset;
      w.is_there[i] = 1;
      w.squares += w.residuals[i] * w.residuals[i];
      ++w.count;
    }
}

// What is known of the warp beforehand: scale and rotation as stated, affinity and shear likewise. Without it a
// ring would have no rotation. Its normal equations, in units of the variance of grey values.
struct Prior {
  Normals normals = Normals::Zero();
  Row right = Row::Zero();
};
Prior prior_of(const Placement& at, double variance, const MarkPrior& known) {
  const Matrix2d& warp = at.warp;
  Prior out;
  const auto prior = [&](const Eigen::Vector4d& by, double value, double sigma) {
    const double weight = variance / (sigma * sigma);
    out.normals.block<4, 4>(2, 2) += weight * by * by.transpose();
    out.right.segment<4>(2) -= weight * value * by;
  };
  const double a = warp(0, 0) - 1, b = warp(0, 1), c = warp(1, 0), d = warp(1, 1) - 1;
  prior({0.5, 0, 0, 0.5}, (a + d) / 2, known.sigma_scale);
  prior({0, -0.5, 0.5, 0}, (c - b) / 2 + std::sin(known.rotation_rad), known.sigma_rotation_rad);
  prior({0.5, 0, 0, -0.5}, (a - d) / 2, known.sigma_affinity);
  prior({0, 0.5, 0.5, 0}, (c + b) / 2, known.sigma_affinity);
  out.normals(8, 8) += variance;
  out.right[8] -= variance * (at.wider - 0.5);
  return out;
}

// Gain and offset that fit the template at a position best.
bool fit_grey(Window& w, const GreyImage& scan, const Blend& blend, Placement& at) {
  at.gain = at.offset = 0;
  fill(w, scan, blend, at);
  Matrix2d normals = Matrix2d::Zero();
  Vector2d right = Vector2d::Zero();
  for (std::size_t i = 0; i < w.rows.size(); ++i)
    if (w.is_there[i]) {
      const Vector2d row = w.rows[i].segment<2>(6);
      normals += row * row.transpose();
      right += row * w.residuals[i];
    }
  const double determinant = normals(0, 0) * normals(1, 1) - normals(0, 1) * normals(1, 0);
  if (!(determinant > 1e-9 * normals(0, 0) * normals(1, 1))) return false;
  const Vector2d grey = normals.ldlt().solve(right);
  at.gain = grey.x();
  at.offset = grey.y();
  return at.gain != 0;
}

// The products J(p)' J(p + d) and r(p) r(p + d) of neighbours at a distance d, in both directions.
struct Neighbours {
  Normals pairs = Normals::Zero();
  double covariance = 0;
};
Neighbours neighbours_at(const Window& w, int dx, int dy) {
  Neighbours out;
  long count = 0;
  for (int y = 0; y + dy < w.width; ++y)
    for (int x = std::max(0, -dx); x < w.width - std::max(0, dx); ++x) {
      const auto i = std::size_t(y * w.width + x), j = std::size_t((y + dy) * w.width + x + dx);
      if (!w.is_there[i] || !w.is_there[j]) continue;
      out.pairs.noalias() += w.rows[i] * w.rows[j].transpose();
      out.covariance += w.residuals[i] * w.residuals[j];
      ++count;
    }
  if (count > 0) out.covariance /= double(count);
  if (dx != 0 || dy != 0) out.pairs += out.pairs.transpose().eval();
  return out;
}

// Sum of c(d) J(p)' J(p + d) over neighbours, c the covariance of residuals at a distance d as it is found. Residuals
// of a fitted gain and offset have covariances that are too small, each by twice their sum over the pixels.
Normals correlated_normals(const Window& w) {
  constexpr int kReach = 4, kDistances = (2 * kReach + 1) * (2 * kReach + 1);
  std::vector<Neighbours> all;
  double total = 0;
  for (int dy = 0; dy <= kReach; ++dy)
    for (int dx = dy == 0 ? 0 : -kReach; dx <= kReach; ++dx) {
      all.push_back(neighbours_at(w, dx, dy));
      total += all.back().covariance * (dx == 0 && dy == 0 ? 1 : 2);
    }
  const double share = 2.0 / w.count;
  const double lost = std::max(0.0, total) / std::max(0.5, 1 - kDistances * share) * share;
  Normals sum = Normals::Zero();
  for (const Neighbours& one : all) sum += (one.covariance + lost) * one.pairs;
  return sum;
}

struct Match {
  FoundMark found;
  double variance = 0;  // of the residuals
};

// The result of a converged match.
std::optional<Match> finished(const Window& w, const Placement& at, const Normals& normals, const Normals& of_prior,
                              const GreyImage& scan) {
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < w.rows.size(); ++i)
    if (w.is_there[i]) {
      const double grey = double(scan.at(w.left + int(i) % w.width, w.top + int(i) / w.width));
      mean += grey;
      squares += grey * grey;
    }
  squares -= mean * mean / w.count;
  if (!(squares > 0)) return std::nullopt;
  const Eigen::LLT<Normals> root(normals);
  if (root.info() != Eigen::Success) return std::nullopt;
  const Normals inverse = root.solve(Normals::Identity());
  const Normals covariance = inverse * (correlated_normals(w) + of_prior) * inverse;
  const double variance = w.squares / (w.count - kUnknowns);
  Match match;
  match.variance = variance;
  match.found.pixel = at.centre;
  match.found.covariance = covariance.topLeftCorner<2, 2>();
  const Matrix2d white = variance * inverse.topLeftCorner<2, 2>();
  if (!(match.found.covariance.determinant() > 0 && match.found.covariance(0, 0) > 0)) match.found.covariance = white;
  match.found.correlation = std::copysign(std::sqrt(std::max(0.0, 1 - w.squares / squares)), at.gain);
  return match;
}

std::optional<Match> match_one(const GreyImage& scan, const Blend& blend, const Vector2d& start,
                               const MarkPrior& known) {
  const MarkTemplate& drawing = *blend.narrower;
  auto window = window_about(scan, drawing, start);
  if (!window) return std::nullopt;
  Placement at{start};
  at.wider = blend.wider ? 0.5 : 0;
  at.warp << std::cos(known.rotation_rad), std::sin(known.rotation_rad), -std::sin(known.rotation_rad),
      std::cos(known.rotation_rad);
  if (!fit_grey(*window, scan, blend, at)) return std::nullopt;
  const double farthest = std::max(3.0, drawing.half_px() / 2);
  for (int round = 0; round < 40; ++round) {
    fill(*window, scan, blend, at);
    if (window->count < 4 * kUnknowns) return std::nullopt;
    Normals normals = Normals::Zero();
    Row right = Row::Zero();
    for (std::size_t i = 0; i < window->rows.size(); ++i)
      if (window->is_there[i]) {
        normals.noalias() += window->rows[i] * window->rows[i].transpose();
        right += window->rows[i] * window->residuals[i];
      }
    const double variance = std::max(1e-3, window->squares / window->count);
    const Prior prior = prior_of(at, variance, known);
    normals += prior.normals;
    right += prior.right;
    const Row step = normals.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    const Vector2d shift = step.head<2>();
    if (shift.norm() < 1e-3 && step.segment<4>(2).norm() < 1e-3)
      return finished(*window, at, normals, variance * prior.normals, scan);
    // Shorter when they go to and fro: of a round mark rotation is known from grain and prior only.
    const double shorter = std::min(round < 8 ? 1.0 : 0.5, 1.5 / std::max(1e-9, shift.norm()));
    at.centre += shorter * shift;
    at.warp(0, 0) += shorter * step[2];
    at.warp(0, 1) += shorter * step[3];
    at.warp(1, 0) += shorter * step[4];
    at.warp(1, 1) += shorter * step[5];
    at.gain += shorter * step[6];
    at.offset += shorter * step[7];
    if (blend.wider) at.wider += shorter * step[8];
    if ((at.centre - start).norm() > farthest) return std::nullopt;
    // The window follows by whole pixels only when it must: it would go to and fro about a pixel's edge.
    const double middle = window->width / 2.0;
    if ((at.centre - Vector2d(window->left + middle, window->top + middle)).cwiseAbs().maxCoeff() <= 1) continue;
    window = window_about(scan, drawing, at.centre);
    if (!window) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

MarkModel drawn_mark(MarkKind kind, double size_px, double line_px, double inwards_rad) {
  const int half_cells = int(std::ceil((0.75 * size_px + 5) / kSpacing));
  const FloatImage sharp = coverage(kind, size_px, line_px, inwards_rad, half_cells);
  MarkModel model;
  for (const double blur : kBlurs_px)
    model.blurred.push_back({blurred(sharp, blur / kSpacing), kSpacing, Vector2d(half_cells + 0.5, half_cells + 0.5)});
  return model;
}

std::optional<FoundMark> match_mark(const GreyImage& scan, const MarkModel& mark, const Vector2d& start,
                                    const MarkPrior& prior) {
  std::vector<std::optional<Match>> matches(mark.blurred.size());
  std::optional<std::size_t> best;
  Vector2d from = start;
  // From the widest blur, which draws in from farthest, to the narrowest.
  for (std::size_t k = mark.blurred.size(); k-- > 0;) {
    matches[k] = match_one(scan, {&mark.blurred[k]}, from, prior);
    if (!matches[k] || std::abs(matches[k]->found.correlation) < 0.3) {
      matches[k].reset();
      if (!best && k + 2 < mark.blurred.size()) return std::nullopt;
      continue;
    }
    from = matches[k]->found.pixel;
    if (!best || matches[k]->variance < matches[*best]->variance) best = k;
  }
  if (!best || std::abs(matches[*best]->found.correlation) < 0.5) return std::nullopt;
  // Between the best blur and the better one of its neighbours.
  const auto variance_at = [&](std::size_t k) {
    return k < matches.size() && matches[k] ? matches[k]->variance : std::numeric_limits<double>::infinity();
  };
  const std::size_t narrower = variance_at(*best - 1) < variance_at(*best + 1) ? *best - 1 : *best;
  if (narrower + 1 < matches.size() && matches[narrower] && matches[narrower + 1])
    if (const auto between =
            match_one(scan, {&mark.blurred[narrower], &mark.blurred[narrower + 1]}, matches[*best]->found.pixel, prior))
      return between->found;
  return matches[*best]->found;
}

}  // namespace collinea
