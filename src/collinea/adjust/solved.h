// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/internal/problem.h"
#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea {

namespace bundle {
class KeptFactor;
class Normals;
}  // namespace bundle

/// An adjusted block with all that its quality follows from: the estimate, the structure of the equations, the unknowns
/// and the normal equations there.
///
/// Model. The observations l have the covariance P^-1 (their sigmas, enlarged by the robust losses) and the derivatives
/// A by all unknowns at the estimate. The normal matrix is A' P A; of it only N remains, of images, cameras and what
/// stands among the global parameters with them, after every point is eliminated (Schur complement). N^-1 is the
/// covariance of these unknowns by the given sigmas (sigma0 = 1); the points follow from it one by one (PointSystem).
///
/// Rank and datum. Where nothing fixes position, attitude or scale of a part of the block, N is singular in as many
/// directions as Problem::datum has constraints. factor() adds these as very heavy observations (inner constraints over
/// a few images), so that N^-1 is the covariance in that datum. Any other datum, above all that of all points, is a
/// transformation of it (FreeNetwork).
///
/// Example, the standard deviation of the first free unknown (a turn of image 0 about the x axis of the camera):
///
///     COLLINEA_TRY(Solved solved, solve_bundle(block, {}, {}, run));
///     auto [factor, failed_row] = solved.factor(run);
///     if (!factor) ...  // the unknown in that row is not determined
///     factor->invert(run);  // the selected inverse: elements where N has tiles
///     const double sigma_rad = sigma_scale(solved.estimate()) * std::sqrt(factor->at(0, 0));
///
/// Cost: a factor is O(n^1.5) for n images of a usual block, its selected inverse about three times that.
/// Refers to the block, which has to outlive it; holds the memory of the normal equations.
class Solved {
 public:
  Solved(const Block& block, std::unique_ptr<const bundle::Problem> problem, bundle::State state,
         std::shared_ptr<bundle::KeptFactor> kept, std::unique_ptr<bundle::Normals> normals, Adjusted estimate);
  ~Solved();
  Solved(Solved&&) noexcept;
  Solved& operator=(Solved&&) noexcept;

  [[nodiscard]] const Block& block() const { return *block_; }
  [[nodiscard]] const bundle::Problem& problem() const { return *problem_; }
  [[nodiscard]] const bundle::State& state() const { return state_; }
  [[nodiscard]] const Adjusted& estimate() const { return estimate_; }
  [[nodiscard]] Adjusted take_estimate() { return std::move(estimate_); }

  /// The Cholesky factor of N; nothing when N is singular beyond its datum (or the run was stopped). `failed_row` is
  /// then the first unknown that those before it leave undetermined.
  struct Factored {
    std::optional<bundle::TileCholesky> factor;
    int failed_row = -1;
  };
  [[nodiscard]] Factored factor(const Run& run);
  /// The same of N + `part` D, D being its diagonal before the points were eliminated: also of a singular N.
  [[nodiscard]] Factored factor_stiffened(double part, const Run& run);
  /// That diagonal, of the last factor.
  [[nodiscard]] const std::vector<double>& diagonal() const;

 private:
  const Block* block_;
  std::unique_ptr<const bundle::Problem> problem_;
  bundle::State state_;
  std::shared_ptr<bundle::KeptFactor> kept_;
  std::unique_ptr<bundle::Normals> normals_;
  Adjusted estimate_;
};

}  // namespace collinea
