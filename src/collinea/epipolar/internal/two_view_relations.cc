// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/two_view_relations.h"

#include <algorithm>
#include <cmath>

#include "collinea/epipolar/internal/two_view_criteria.h"
#include "collinea/epipolar/internal/two_view_problems.h"
#include "collinea/epipolar/robust.h"

namespace collinea {
namespace {

RobustOptions search_options(const TwoViews& views, double threshold_px, int size) {
  RobustOptions search;
  search.max_error_px = threshold_px;
  search.confidence = views.options.confidence;
  search.max_trials = views.options.max_trials;
  search.min_inlier_ratio = static_cast<double>(views.options.min_inliers) / size;
  search.preferred = views.preferred;
  return search;
}

// A focal length from the EXIF data may be some per cent wrong, which costs matches that are right: lets it vary
// within its uncertainty, as long as that brings the pairs clearly closer to the relation.
void adapt_focal(const TwoViews& views, EpipolarRelation& relation) {
  FocalDoubt doubt{views.first.prior.sigma_f_px > 0, views.second.prior.sigma_f_px > 0,
                   std::max(relative_sigma_f(views.first), relative_sigma_f(views.second))};
  const PointPairs nominal = relation.pairs;
  std::vector<double> errors = errors_of(relation.matrix, nominal, false);
  double cost = truncated_cost(errors, views.threshold_px);
  for (int round = 0; round < 5 && relation.motion; ++round) {
    // Wide at first: the wrong focal length has pushed right matches across the threshold.
    const double reach_px = round < 2 ? 3 * views.threshold_px : views.threshold_px;
    const auto fit = refine_relative_and_focal(*relation.motion, nominal, below(errors, reach_px), reach_px, doubt);
    if (!fit) return;
    PointPairs pairs =
        with_focal_factor(nominal, doubt.first ? fit->focal_factor : 1, doubt.second ? fit->focal_factor : 1);
    const Eigen::Matrix3d matrix = essential_matrix(fit->second_from_first);
    errors = errors_of(matrix, pairs, false);
    const double better = truncated_cost(errors, views.threshold_px);
    if (!(better < 0.99 * cost)) {
      if (round < 2) continue;
      return;
    }
    cost = better;
    relation.inliers = below(errors, views.threshold_px);
    relation.motion = in_front(motions(matrix), pairs, relation.inliers, blind_angle_rad(views, pairs));
    relation.matrix = matrix;
    relation.pairs = std::move(pairs);
    relation.parameters = 6;
  }
}

// The factor of the assumed focal length under which the fundamental matrix comes nearest to an essential one, and
// its motion.
void calibrate(const TwoViews& views, EpipolarRelation& relation) {
  const PointPairs nominal = relation.pairs;
  const Eigen::Matrix3d fundamental = relation.matrix;
  std::size_t most = 0;
  for (const double factor : {1.0, 0.85, 1.18, 0.71, 1.4, 0.6, 1.67, 0.5, 2.0}) {
    const double k1 = relative_sigma_f(views.first) > kAssumedFocal ? factor : 1;
    const double k2 = relative_sigma_f(views.second) > kAssumedFocal ? factor : 1;
    const PointPairs pairs = with_focal_factor(nominal, k1, k2);
    const Eigen::Matrix3d nearly_essential =
        Eigen::DiagonalMatrix<double, 3>(k2, k2, 1) * fundamental * Eigen::DiagonalMatrix<double, 3>(k1, k1, 1);
    const auto motion = in_front(motions(nearly_essential), pairs, relation.inliers, blind_angle_rad(views, pairs));
    if (!motion) continue;
    const auto fit = refine_relative(*motion, pairs, relation.inliers, views.threshold_px);
    if (!fit) continue;
    const auto kept = below(errors_of(essential_matrix(fit->second_from_first), pairs, false), views.threshold_px);
    if (kept.size() <= most ||
        static_cast<double>(kept.size()) < kMotionShare * static_cast<double>(relation.inliers.size()))
      continue;
    most = kept.size();
    relation.motion = fit->second_from_first;
    relation.pairs = pairs;
  }
  // The criterion and the inliers stay with the fundamental matrix, in whichever coordinates.
  const double k1 = relation.pairs.focal_first_px / nominal.focal_first_px;
  const double k2 = relation.pairs.focal_second_px / nominal.focal_second_px;
  relation.matrix =
      Eigen::DiagonalMatrix<double, 3>(k2, k2, 1) * fundamental * Eigen::DiagonalMatrix<double, 3>(k1, k1, 1);
}

std::optional<RotationRelation> fit_rotation(const TwoViews& views, const PlaneRelation& plane, const PointPairs& pairs,
                                             double factor) {
  const auto rotation = refine_rotation(nearest_rotation(conjugated(plane.matrix, factor, factor)), pairs,
                                        plane.inliers, kPlaneThreshold * views.threshold_px);
  if (!rotation) return std::nullopt;
  return RotationRelation{*rotation, errors_of(rotation->toRotationMatrix(), pairs, true), factor == 1 ? 3 : 4};
}

}  // namespace

double blind_angle_rad(const TwoViews& views, const PointPairs& pairs) {
  return 2 * views.threshold_px / std::min(pairs.focal_first_px, pairs.focal_second_px);
}

Eigen::Matrix3d conjugated(const Eigen::Matrix3d& h, double first, double second) {
  return Eigen::DiagonalMatrix<double, 3>(1 / second, 1 / second, 1) * h *
         Eigen::DiagonalMatrix<double, 3>(first, first, 1);
}

EpipolarRelation by_essential(const TwoViews& views, const PointPairs& pairs, Random& random) {
  EpipolarRelation relation;
  const auto fit = robust_fit(EssentialProblem{pairs, views.threshold_px},
                              search_options(views, views.threshold_px, pairs.size()), random);
  if (!fit) return relation;
  relation.matrix = fit->model;
  relation.pairs = pairs;
  relation.inliers = fit->inliers;
  relation.motion = in_front(motions(fit->model), pairs, fit->inliers, blind_angle_rad(views, pairs));
  if (views.first.prior.sigma_f_px > 0 || views.second.prior.sigma_f_px > 0) adapt_focal(views, relation);
  return relation;
}

EpipolarRelation by_fundamental(const TwoViews& views, const PointPairs& pairs, Random& random) {
  EpipolarRelation relation;
  const auto fit = robust_fit(FundamentalProblem{pairs, views.threshold_px},
                              search_options(views, views.threshold_px, pairs.size()), random);
  if (!fit) return relation;
  relation.matrix = fit->model;
  relation.pairs = pairs;
  relation.inliers = fit->inliers;
  relation.parameters = 7;
  calibrate(views, relation);
  return relation;
}

std::optional<PlaneRelation> by_plane(const TwoViews& views, const PointPairs& pairs, std::size_t epipolar_inliers,
                                      Random& random) {
  const double threshold_px = kPlaneThreshold * views.threshold_px;
  RobustOptions search = search_options(views, threshold_px, pairs.size());
  search.min_inlier_ratio =
      std::max(search.min_inlier_ratio, 0.5 * static_cast<double>(epipolar_inliers) / pairs.size());
  search.max_trials = std::min(search.max_trials, 1000);
  const auto fit = robust_fit(HomographyProblem{pairs, threshold_px}, search, random);
  if (!fit || 2 * fit->inliers.size() < epipolar_inliers) return std::nullopt;
  return PlaneRelation{fit->model, fit->inliers, errors_of(fit->model, pairs, true)};
}

std::optional<RotationRelation> by_rotation(const TwoViews& views, const PlaneRelation& plane,
                                            const PointPairs& pairs) {
  const double sigma = std::max(relative_sigma_f(views.first), relative_sigma_f(views.second));
  double best_factor = 1, nearest = distance_from_rotation(plane.matrix);
  constexpr int kSteps = 40;
  for (int i = 1; sigma > 0 && i < kSteps; ++i) {
    const double factor = std::exp((i - kSteps / 2) * std::min(3 * sigma, std::log(2.0)) / (kSteps / 2));
    const double distance = distance_from_rotation(conjugated(plane.matrix, factor, factor));
    if (distance < nearest) {
      nearest = distance;
      best_factor = factor;
    }
  }
  std::optional<RotationRelation> best = fit_rotation(views, plane, pairs, 1);
  if (best_factor != 1) {
    const std::optional<RotationRelation> other =
        fit_rotation(views, plane, with_focal_factor(pairs, best_factor, best_factor), best_factor);
    const double threshold_px = kPlaneThreshold * views.threshold_px;
    if (other && (!best || truncated_cost(other->errors, threshold_px) < truncated_cost(best->errors, threshold_px)))
      best = other;
  }
  return best;
}

}  // namespace collinea
