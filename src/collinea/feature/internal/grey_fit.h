// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "collinea/raster/raster.h"

// Least squares of grey values: a model with some unknowns, the first two of which are a position [px], is fitted to
// the pixels of a window. A model has
//
//     kMostUnknowns                                      a bound of their number
//     bool is_possible(const VectorXd& unknowns) const   whether the iteration may come here
//     auto at(const VectorXd& unknowns) const            what gives double(const Vector2d& p, double* derivatives),
//                                                        derivatives may be null
namespace collinea {

/// Pixels of an image; those that are not used are of no account.
struct GreyWindow {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::vector<bool> used = {};  ///< empty: all

  [[nodiscard]] int count() const { return width * height; }
  [[nodiscard]] Eigen::Vector2d pixel(int i) const { return {x0 + i % width + 0.5, y0 + i / width + 0.5}; }
  [[nodiscard]] float grey(const FloatImage& image, int i) const { return image.at(x0 + i % width, y0 + i / width); }
  [[nodiscard]] bool uses(int i) const { return used.empty() || used[std::size_t(i)]; }
  [[nodiscard]] int count_used() const {
    return used.empty() ? count() : int(std::count(used.begin(), used.end(), true));
  }
  [[nodiscard]] bool lies_in(const FloatImage& image) const {
    return x0 >= 0 && y0 >= 0 && x0 + width <= image.width && y0 + height <= image.height;
  }
};

struct GreyFit {
  Eigen::VectorXd unknowns;
  Eigen::MatrixXd cofactors;    ///< covariance of the unknowns; zero of those that are not determined
  double sigma_grey = 0;        ///< from the residuals
  double residual_squares = 0;  ///< sum of them
  int redundancy = 0;
  bool has_correlated_residuals = false;
};

namespace grey_fit {

constexpr int kIterations = 30;

/// The normal equations at some unknowns; squares: of the residuals.
struct Normals {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double squares = 0;
};

template <class Model>
Normals normals_of(const FloatImage& image, const GreyWindow& window, const Model& model,
                   const Eigen::VectorXd& unknowns) {
  const Eigen::Index n = unknowns.size();
  Normals out{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0};
  const auto grey_at = model.at(unknowns);
  std::array<double, Model::kMostUnknowns> d{};
  for (int i = 0; i < window.count(); ++i) {
    if (!window.uses(i)) continue;
    const double residual = window.grey(image, i) - grey_at(window.pixel(i), d.data());
    out.squares += residual * residual;
    for (Eigen::Index a = 0; a < n; ++a) {
      out.right[a] += d[std::size_t(a)] * residual;
      double* const column = &out.matrix(0, a);
      for (Eigen::Index b = 0; b <= a; ++b) column[b] += d[std::size_t(b)] * d[std::size_t(a)];
    }
  }
  out.matrix.template triangularView<Eigen::StrictlyLower>() = out.matrix.transpose();
  return out;
}

/// Levenberg and Marquardt; the unknowns at the minimum, or nothing.
template <class Model>
std::optional<Eigen::VectorXd> minimum(const FloatImage& image, const GreyWindow& window, const Model& model,
                                       Eigen::VectorXd u) {
  double damping = 1e-3;
  Normals now = normals_of(image, window, model, u), then;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::MatrixXd damped = now.matrix;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-12;
    const Eigen::VectorXd step = damped.ldlt().solve(now.right);
    const Eigen::VectorXd next = u + step;
    if (!next.allFinite()) return std::nullopt;
    const bool possible = model.is_possible(next);
    if (possible) then = normals_of(image, window, model, next);
    const double moved_px = step.head<2>().norm();
    if (!possible || then.squares > now.squares * (1 + 1e-12)) {
      if (possible && moved_px < 1e-5 && damping < 1) return u;  // rounding alone decides
      damping *= 10;
      if (damping > 1e10) return std::nullopt;
      continue;
    }
    const bool is_done = moved_px < 1e-6 && damping < 1;
    u = next;
    std::swap(now, then);
    damping = std::max(1e-9, damping / 10);
    if (is_done) return u;
  }
  return std::nullopt;
}

struct Equations {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> design;  // rows of unused pixels are zero
  Eigen::VectorXd residuals;                                                      // observed minus model
};

template <class Model>
Equations equations_of(const FloatImage& image, const GreyWindow& window, const Model& model,
                       const Eigen::VectorXd& unknowns) {
  Equations out;
  out.design.setZero(window.count(), unknowns.size());
  out.residuals.setZero(window.count());
  const auto grey_at = model.at(unknowns);
  for (int i = 0; i < window.count(); ++i)
    if (window.uses(i)) out.residuals[i] = window.grey(image, i) - grey_at(window.pixel(i), out.design.row(i).data());
  return out;
}

/// A' C A with the correlations of residuals up to two pixels, tapered so that it stays a covariance; nothing where
/// those of direct neighbours are not significant.
[[nodiscard]] std::optional<Eigen::MatrixXd> correlated_moments(const GreyWindow& window, const Equations& e);

}  // namespace grey_fit

/// The model fitted to a window, from a start. Covariance: from the residuals, with their correlations where these are
/// significant. `determined`: unknowns that the pixels must determine, the first ones; `undetermined(unknowns)` tells
/// how many of the last are not. Nothing: an impossible start, an iteration that does not end, unknowns that are not
/// determined.
template <class Model, class Undetermined>
std::optional<GreyFit> fit_grey(const FloatImage& image, const GreyWindow& window, const Model& model,
                                const Eigen::VectorXd& start, const Undetermined& undetermined);

/// What is left of fit_grey() once the minimum is known.
[[nodiscard]] std::optional<GreyFit> grey_fit_at(const GreyWindow& window, const grey_fit::Equations& e,
                                                 const Eigen::VectorXd& unknowns, Eigen::Index determined);

template <class Model, class Undetermined>
std::optional<GreyFit> fit_grey(const FloatImage& image, const GreyWindow& window, const Model& model,
                                const Eigen::VectorXd& start, const Undetermined& undetermined) {
  if (!model.is_possible(start)) return std::nullopt;
  const auto u = grey_fit::minimum(image, window, model, start);
  if (!u) return std::nullopt;
  return grey_fit_at(window, grey_fit::equations_of(image, window, model, *u), *u, u->size() - undetermined(*u));
}

}  // namespace collinea
