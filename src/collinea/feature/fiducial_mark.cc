// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/fiducial_mark.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/feature/internal/mark_drawings.h"
#include "collinea/feature/internal/mark_tone.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Unknowns of a match: where the mark is, its map template = warp (pixel - centre), gain and offset, and the square of
// its blur.
struct Placement {
  Vector2d centre;
  Matrix2d warp = Matrix2d::Identity();
  double gain = 0, offset = 0, blur_px2 = 0;
  double tone = 1;  // not among them
};

constexpr int kUnknowns = 9;  // shift x, y; warp by rows; gain, offset; blur
using Row = Eigen::Matrix<double, kUnknowns, 1>;
using Normals = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// Derivatives and residuals of the pixels of a square; pixels beyond the template have none.
struct Window {
  int left = 0, top = 0, width = 0;
  std::vector<Row> rows;
  std::vector<double> residuals, shares;  // shares: the drawing between 0 and 1
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

void fill(Window& w, const GreyImage& scan, const Drawings& drawings, const Placement& at) {
  const MarkTemplate& drawing = drawings.middle();
  const auto n = std::size_t(w.width) * std::size_t(w.width);
  w.rows.assign(n, Row::Zero());
  w.residuals.assign(n, 0);
  w.shares.assign(n, 0);
  w.is_there.assign(n, 0);
  w.count = 0;
  w.squares = 0;
  const ToneCurve curve(at.gain, at.offset, at.tone);
  const Mixture mixture = mixture_at(drawings, at.blur_px2);
  for (int y = 0; y < w.width; ++y)
    for (int x = 0; x < w.width; ++x) {
      const Vector2d d = Vector2d(w.left + x + 0.5, w.top + y + 0.5) - at.centre;
      const Vector2d on_drawing = drawing.centre + at.warp * d / drawing.spacing_px;
      const auto s = sample(drawings, mixture, on_drawing);
      if (!s) continue;
      const auto i = std::size_t(y) * std::size_t(w.width) + std::size_t(x);
      const TonedGrey toned = curve.at(s->value);
      const Vector2d g = toned.by_share * s->gradient / drawing.spacing_px, by_centre = -at.warp.transpose() * g;
      w.rows[i] << by_centre, g.x() * d.x(), g.x() * d.y(), g.y() * d.x(), g.y() * d.y(), toned.by_gain,
          toned.by_offset, toned.by_share * s->by_blur;
      w.residuals[i] = double(scan.at(w.left + x, w.top + y)) - toned.grey;
      w.shares[i] = s->value;
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
Prior prior_of(const Drawings& drawings, const Placement& at, double variance, const MarkPrior& known) {
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
  // The blur lies about the middle drawing; of a single one it is no unknown.
  const double spread = drawings.count < 3 ? 1 : (drawings.blur_px2(2) - drawings.blur_px2(0)) / 2;
  const double middle = drawings.count < 3 ? at.blur_px2 : drawings.blur_px2(1);
  out.normals(8, 8) += variance / (spread * spread);
  out.right[8] -= variance / (spread * spread) * (at.blur_px2 - middle);
  return out;
}

// Gain and offset that fit the template at a position best.
bool fit_grey(Window& w, const GreyImage& scan, const Drawings& drawings, Placement& at) {
  at.gain = at.offset = 0;
  fill(w, scan, drawings, at);
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
using RowWithTone = Eigen::Matrix<double, kUnknowns + 1, 1>;  // derivatives by the unknowns and by the tone
using WithTone = Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1>;
struct Neighbours {
  WithTone pairs = WithTone::Zero();
  double covariance = 0;
};
Neighbours neighbours_at(const Window& w, const std::vector<RowWithTone>& rows, int dx, int dy) {
  Neighbours out;
  long count = 0;
  for (int y = 0; y + dy < w.width; ++y)
    for (int x = std::max(0, -dx); x < w.width - std::max(0, dx); ++x) {
      const auto i = std::size_t(y * w.width + x), j = std::size_t((y + dy) * w.width + x + dx);
      if (!w.is_there[i] || !w.is_there[j]) continue;
      out.pairs.noalias() += rows[i] * rows[j].transpose();
      out.covariance += w.residuals[i] * w.residuals[j];
      ++count;
    }
  if (count > 0) out.covariance /= double(count);
  if (dx != 0 || dy != 0) out.pairs += out.pairs.transpose().eval();
  return out;
}

// Sum of c(d) J(p)' J(p + d) over neighbours, c the covariance of residuals at a distance d as it is found. Residuals
// of a fitted gain and offset have covariances that are too small, each by twice their sum over the pixels.
WithTone correlated_normals(const Window& w, const std::vector<RowWithTone>& rows) {
  constexpr int kReach = 4, kDistances = (2 * kReach + 1) * (2 * kReach + 1);
  std::vector<Neighbours> all;
  double total = 0;
  for (int dy = 0; dy <= kReach; ++dy)
    for (int dx = dy == 0 ? 0 : -kReach; dx <= kReach; ++dx) {
      all.push_back(neighbours_at(w, rows, dx, dy));
      total += all.back().covariance * (dx == 0 && dy == 0 ? 1 : 2);
    }
  const double share = 2.0 / w.count;
  const double lost = std::max(0.0, total) / std::max(0.5, 1 - kDistances * share) * share;
  WithTone sum = WithTone::Zero();
  for (const Neighbours& one : all) sum += (one.covariance + lost) * one.pairs;
  return sum;
}

struct Match {
  FoundMark found;
  double variance = 0;  // of the residuals
};

// Standard deviations of grey values over that of all: grain is strongest in middle densities. The variance is a
// parabola in the share of the mark, by the squares of residuals, at least a quarter of its mean.
std::vector<double> grain_by_share(const Window& w) {
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const double mean = w.squares / w.count;
  for (std::size_t i = 0; i < w.shares.size(); ++i)
    if (w.is_there[i]) {
      const Eigen::Vector3d by(1, w.shares[i], w.shares[i] * w.shares[i]);
      normals += by * by.transpose();
      right += by * (w.residuals[i] * w.residuals[i] - mean);
    }
  const Eigen::Vector3d parabola = normals.ldlt().solve(right);
  std::vector<double> out(w.shares.size(), 1);
  if (!(mean > 0) || !parabola.allFinite()) return out;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] =
        std::sqrt(std::max(0.25, 1 + parabola.dot(Eigen::Vector3d(1, w.shares[i], w.shares[i] * w.shares[i])) / mean));
  return out;
}

// Of residuals r with their own standard deviations s: the covariances of r / s, and s J in the place of J.
WithTone spread_of(Window w, std::vector<RowWithTone> rows) {
  const std::vector<double> grain = grain_by_share(w);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    w.residuals[i] /= grain[i];
    rows[i] *= grain[i];
  }
  return correlated_normals(w, rows);
}

// What is left of the derivative by the tone when the unknowns have taken their part, and what that says of the tone.
ToneEvidence tone_evidence(const RowWithTone& profile, const WithTone& normals, const WithTone& spread,
                           const RowWithTone& right, double variance) {
  ToneEvidence out;
  out.slope = profile.dot(right) / variance;
  out.information = profile.dot(normals * profile) / variance;
  out.variance = profile.dot(spread * profile) / (variance * variance);
  return out;
}

// The correlation of drawing and pixels, by what the residuals leave of the variance of grey values.
double correlation_of(const Window& w, double gain, const GreyImage& scan) {
  double mean = 0, squares = 0;
  for (std::size_t i = 0; i < w.rows.size(); ++i)
    if (w.is_there[i]) {
      const double grey = double(scan.at(w.left + int(i) % w.width, w.top + int(i) / w.width));
      mean += grey;
      squares += grey * grey;
    }
  squares -= mean * mean / w.count;
  return squares > 0 ? std::copysign(std::sqrt(std::max(0.0, 1 - w.squares / squares)), gain) : 0;
}

// The result of a converged match.
std::optional<Match> finished(const Window& w, const Placement& at, const Prior& prior, double weight,
                              const GreyImage& scan, const MarkPrior& known) {
  const ToneCurve curve(at.gain, at.offset, at.tone);
  std::vector<RowWithTone> rows(w.rows.size(), RowWithTone::Zero());
  WithTone normals = WithTone::Zero();
  RowWithTone right = RowWithTone::Zero();
  normals.topLeftCorner<kUnknowns, kUnknowns>() = prior.normals;
  right.head<kUnknowns>() = prior.right;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (w.is_there[i]) {
      rows[i] << w.rows[i], curve.by_tone(w.shares[i]);
      normals.noalias() += rows[i] * rows[i].transpose();
      right += rows[i] * w.residuals[i];
    }
  const Eigen::LLT<Normals> root(normals.topLeftCorner<kUnknowns, kUnknowns>());
  Match match;
  match.found.correlation = correlation_of(w, at.gain, scan);
  if (root.info() != Eigen::Success || match.found.correlation == 0) return std::nullopt;
  WithTone spread = spread_of(w, rows);
  spread.topLeftCorner<kUnknowns, kUnknowns>() += weight * prior.normals;
  const Normals inverse = root.solve(Normals::Identity());
  const Normals covariance = inverse * spread.topLeftCorner<kUnknowns, kUnknowns>() * inverse;
  match.variance = w.squares / (w.count - kUnknowns);
  match.found.pixel = at.centre;
  match.found.blur_px = std::sqrt(std::max(0.0, at.blur_px2));
  match.found.covariance = covariance.topLeftCorner<2, 2>();
  RowWithTone profile;
  profile << -inverse * normals.col(kUnknowns).head<kUnknowns>(), 1;
  match.found.tone = tone_evidence(profile, normals, spread, right, match.variance);
  match.found.by_tone = profile.head<2>();
  match.found.sigma_tone = known.sigma_tone;
  Matrix2d of_tone = Matrix2d::Zero();
  if (known.tone_information > 0) {
    of_tone = known.sigma_tone * known.sigma_tone * match.found.by_tone * match.found.by_tone.transpose();
    // The grain of this mark is part of what the tone errs by: covariance of the position with its share of the slope.
    const Vector2d shared = (inverse * (spread * profile).head<kUnknowns>()).head<2>() / match.variance;
    const Vector2d with_tone = shared / known.tone_information;
    match.found.covariance +=
        of_tone + with_tone * match.found.by_tone.transpose() + match.found.by_tone * with_tone.transpose();
  }
  // Sampled covariances of grain and those cross terms may leave none that is positive: white noise and the tone then.
  if (!(match.found.covariance.determinant() > 0 && match.found.covariance(0, 0) > 0))
    match.found.covariance = match.variance * inverse.topLeftCorner<2, 2>() + of_tone;
  return match;
}

std::optional<Match> match_one(const GreyImage& scan, const Drawings& drawings, const Vector2d& start,
                               const MarkPrior& known) {
  const MarkTemplate& drawing = drawings.middle();
  auto window = window_about(scan, drawing, start);
  if (!window) return std::nullopt;
  Placement at{start};
  at.blur_px2 = drawings.middle().blur_px * drawings.middle().blur_px;
  at.warp << std::cos(known.rotation_rad), std::sin(known.rotation_rad), -std::sin(known.rotation_rad),
      std::cos(known.rotation_rad);
  if (!fit_grey(*window, scan, drawings, at)) return std::nullopt;
  at.tone = known.tone;
  const double farthest = std::max(3.0, drawing.half_px() / 2);
  for (int round = 0; round < 40; ++round) {
    fill(*window, scan, drawings, at);
    if (window->count < 4 * kUnknowns) return std::nullopt;
    Normals normals = Normals::Zero();
    Row right = Row::Zero();
    for (std::size_t i = 0; i < window->rows.size(); ++i)
      if (window->is_there[i]) {
        normals.noalias() += window->rows[i] * window->rows[i].transpose();
        right += window->rows[i] * window->residuals[i];
      }
    const double variance = std::max(1e-3, window->squares / window->count);
    const Prior prior = prior_of(drawings, at, variance, known);
    normals += prior.normals;
    right += prior.right;
    const Row step = normals.ldlt().solve(right);
    if (!step.allFinite()) return std::nullopt;
    const Vector2d shift = step.head<2>();
    if (shift.norm() < 1e-3 && step.segment<4>(2).norm() < 1e-3)
      return finished(*window, at, prior, variance, scan, known);
    // Shorter when they go to and fro: of a round mark rotation is known from grain and prior only.
    const double shorter = std::min(round < 8 ? 1.0 : 0.5, 1.5 / std::max(1e-9, shift.norm()));
    at.centre += shorter * shift;
    at.warp(0, 0) += shorter * step[2];
    at.warp(0, 1) += shorter * step[3];
    at.warp(1, 0) += shorter * step[4];
    at.warp(1, 1) += shorter * step[5];
    at.gain += shorter * step[6];
    at.offset += shorter * step[7];
    at.blur_px2 += shorter * step[8];
    if ((at.centre - start).norm() > farthest) return std::nullopt;
    // The window follows by whole pixels only when it must: it would go to and fro about a pixel's edge.
    const double middle = window->width / 2.0;
    if ((at.centre - Vector2d(window->left + middle, window->top + middle)).cwiseAbs().maxCoeff() <= 1) continue;
    window = window_about(scan, drawing, at.centre);
    if (!window) return std::nullopt;
  }
  return std::nullopt;
}

// The drawing whose blur fits best, and where.
struct Fitting {
  std::size_t drawing = 0;
  std::optional<FoundMark> found;
  double variance = 0;
};
std::optional<Fitting> best_drawing(const GreyImage& scan, const MarkModel& mark, const Vector2d& start,
                                    const MarkPrior& prior) {
  std::optional<Fitting> best;
  Vector2d from = start;
  // From the widest blur, which draws in from farthest, to the narrowest.
  for (std::size_t k = mark.blurred.size(); k-- > 0;) {
    const auto match = match_one(scan, {{&mark.blurred[k]}}, from, prior);
    if (!match || std::abs(match->found.correlation) < 0.3) {
      if (!best && k + 2 < mark.blurred.size()) return std::nullopt;
      continue;
    }
    from = match->found.pixel;
    if (!best || match->variance < best->variance) best = Fitting{k, match->found, match->variance};
  }
  if (!best || std::abs(best->found->correlation) < 0.5) return std::nullopt;
  return best;
}

// Between three drawings: those about the blur that fits are another three when it lies beyond. Changes `k`, the middle
// one, to that.
std::optional<FoundMark> between_drawings(const GreyImage& scan, const MarkModel& mark, const Vector2d& start,
                                          const MarkPrior& prior, std::size_t& k) {
  std::optional<FoundMark> found;
  Vector2d from = start;
  for (int round = 0; round < 3; ++round) {
    k = std::clamp(k, std::size_t{1}, mark.blurred.size() - 2);
    const auto match =
        match_one(scan, {{&mark.blurred[k - 1], &mark.blurred[k], &mark.blurred[k + 1]}, 3}, from, prior);
    if (!match) break;
    found = match->found;
    from = found->pixel;
    const bool is_narrower = found->blur_px < mark.blurred[k - 1].blur_px && k > 1;
    const bool is_wider = found->blur_px > mark.blurred[k + 1].blur_px && k + 2 < mark.blurred.size();
    if (!is_narrower && !is_wider) break;
    k = is_narrower ? k - 1 : k + 1;
  }
  return found;
}

}  // namespace

std::optional<FoundMark> match_mark(const GreyImage& scan, const MarkModel& mark, const Vector2d& start,
                                    const MarkPrior& prior) {
  if (mark.blurred.empty()) return std::nullopt;
  Fitting about;
  if (prior.blur_px > 0) {
    for (std::size_t k = 1; k < mark.blurred.size(); ++k)
      if (std::abs(mark.blurred[k].blur_px - prior.blur_px) <
          std::abs(mark.blurred[about.drawing].blur_px - prior.blur_px))
        about.drawing = k;
  } else {
    const auto best = best_drawing(scan, mark, start, prior);
    if (!best) return std::nullopt;
    about = *best;
  }
  if (mark.blurred.size() >= 3)
    if (auto found = between_drawings(scan, mark, about.found ? about.found->pixel : start, prior, about.drawing))
      return found;
  if (about.found) return about.found;
  const auto single = match_one(scan, {{&mark.blurred[about.drawing]}}, start, prior);
  return single ? std::optional<FoundMark>(single->found) : std::nullopt;
}

}  // namespace collinea
