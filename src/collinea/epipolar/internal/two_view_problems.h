// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/homography.h"
#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/epipolar/internal/relative.h"

namespace collinea {

/// The pairs of a random sample.
template <std::size_t N>
struct SampledPairs {
  std::array<Eigen::Vector2d, N> first, second;

  SampledPairs(const PointPairs& pairs, const std::array<int, N>& sample) {
    for (std::size_t k = 0; k < N; ++k) {
      first[k] = pairs.first(sample[k]);
      second[k] = pairs.second(sample[k]);
    }
  }
};

/// The relations between two images as problems for robust_fit; loss_px caps the residuals of the refinement.
struct EssentialProblem {
  using Model = Eigen::Matrix3d;
  static constexpr int kSample = 5;
  const PointPairs& pairs;
  double loss_px;

  [[nodiscard]] int size() const { return pairs.size(); }
  [[nodiscard]] Few<Model, 10> solve(const std::array<int, 5>& sample) const {
    const SampledPairs<5> points(pairs, sample);
    return five_point(points.first, points.second);
  }
  void squared_errors(const Model& e, int begin, int end, double* out) const {
    squared_epipolar_errors(e, pairs, begin, end, out);
  }
  [[nodiscard]] std::optional<Model> refine(const Model& start, std::span<const int> support) const {
    const auto fit = refine_relative(motions(start)[0], pairs, support, loss_px);  // any of the four has this matrix
    if (!fit) return std::nullopt;
    return essential_matrix(fit->second_from_first);
  }
  [[nodiscard]] std::optional<Model> refine_absolute(const Model& start) const {
    const auto motion = refine_relative_absolute(motions(start)[0], pairs);
    if (!motion) return std::nullopt;
    return essential_matrix(*motion);
  }
};

struct FundamentalProblem {
  using Model = Eigen::Matrix3d;
  static constexpr int kSample = 7;
  const PointPairs& pairs;
  double loss_px;

  [[nodiscard]] int size() const { return pairs.size(); }
  [[nodiscard]] Few<Model, 3> solve(const std::array<int, 7>& sample) const {
    const SampledPairs<7> points(pairs, sample);
    return seven_point(points.first, points.second);
  }
  void squared_errors(const Model& f, int begin, int end, double* out) const {
    squared_epipolar_errors(f, pairs, begin, end, out);
  }
  [[nodiscard]] std::optional<Model> refine(const Model& start, std::span<const int> support) const {
    return refine_fundamental(start, pairs, support, loss_px);
  }
};

struct HomographyProblem {
  using Model = Eigen::Matrix3d;
  static constexpr int kSample = 4;
  const PointPairs& pairs;
  double loss_px;

  [[nodiscard]] int size() const { return pairs.size(); }
  [[nodiscard]] Few<Model, 1> solve(const std::array<int, 4>& sample) const {
    const SampledPairs<4> points(pairs, sample);
    Few<Model, 1> found;
    if (const auto h = four_point(points.first, points.second)) found.add(*h);
    return found;
  }
  void squared_errors(const Model& h, int begin, int end, double* out) const {
    collinea::squared_errors(h, pairs, begin, end, out);
  }
  [[nodiscard]] std::optional<Model> refine(const Model& start, std::span<const int> support) const {
    return refine_homography(start, pairs, support, loss_px);
  }
};

}  // namespace collinea
