// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/level_disparities.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_model.h"
#include "collinea/dense/internal/pair_check.h"
#include "collinea/dense/internal/row_correlation.h"
#include "collinea/feature/interest.h"

namespace collinea {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kMostGuides = 1500;  // as many as `pair` looks for
constexpr double kEvenness = 0.7;
constexpr int kRows = 1;
constexpr double kRowSigma_px = 0.1;  // small enough that no more rows are searched
constexpr std::size_t kFewest = 3;

std::optional<LevelPoint> guide_at(const GreyImage& left, const GreyImage& right, const Eigen::Vector2i& pixel,
                                   const DisparityRange& range, const LevelOptions& options) {
  const int half = options.template_px / 2;
  // A column more on either side: the best at an end is none.
  const SearchBand band{pixel.x() - range.high - 1, pixel.x() - range.low + 1, pixel.y() - kRows, pixel.y() + kRows};
  const auto found = best_correlation(left, pixel, half, right, band);
  if (!found || found->ncc < options.min_ncc) return std::nullopt;
  const Eigen::Vector2i there = found->pixel;
  const auto back =
      best_correlation(right, there, half, left,
                       {there.x() + range.low - 1, there.x() + range.high + 1, there.y() - kRows, there.y() + kRows});
  if (!back || (back->pixel - pixel).cast<double>().norm() > options.return_px) return std::nullopt;
  return LevelPoint{pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5), pixel.x() - found->position_px.x() + 0.5,
                    found->position_px.y() - 0.5 - pixel.y(), found->ncc, found->sigma_px};
}

std::vector<LevelPoint> guides_of(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                                  const LevelOptions& options, const Run& run) {
  InterestOptions interest;
  interest.method = InterestOperator::kNoble;
  interest.max_points = kMostGuides;
  interest.evenness = kEvenness;
  const auto points = find_interest_points(left, interest).points;
  std::vector<std::optional<LevelPoint>> found(points.size());
  parallel_for(run, points.size(), [&](std::size_t i) {
    const Eigen::Vector2i pixel = points[i].position_px.array().floor().cast<int>().matrix();
    found[i] = guide_at(left, right, pixel, range, options);
  });
  std::vector<LevelPoint> guides;
  for (const auto& each : found)
    if (each) guides.push_back(*each);
  return without_spikes(std::move(guides));
}

DisparityMap map_of(const GreyImage& left, std::span<const LevelPoint> points) {
  DisparityMap map{FloatImage(left.width, left.height, 1, kNaN), FloatImage(left.width, left.height, 1, kNaN)};
  for (const LevelPoint& point : points) {
    const int x = int(point.left_px.x()), y = int(point.left_px.y());
    map.disparity.at(x, y) = float(point.disparity_px);
    map.sigma.at(x, y) = float(point.sigma_px);
  }
  return map;
}

}  // namespace

Result<LevelDisparities> match_rectified_by_levels(const GreyImage& left, const GreyImage& right,
                                                   const DisparityRange& range, const LevelOptions& options,
                                                   const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(dense::check_pair(left, right, range));
  const std::vector<LevelPoint> guides = guides_of(left, right, range, options, run);
  if (run.stopped()) return fail(Errc::kCancelled, "matching was stopped");
  if (guides.size() < kFewest)
    return fail(Errc::kIllPosed,
                "of the interest points of the left image " + std::to_string(guides.size()) +
                    " were found in the right one within the range of disparities: nothing guides the levels",
                {"min_disparity"_option, "max_disparity"_option, "min_ncc"_option});
  LevelDisparities made;
  COLLINEA_TRY(made.surface,
               match_by_levels(
                   left, right, guides, [](const Eigen::Vector2d&) { return kRowSigma_px; }, options, run));
  std::erase_if(made.surface.points, [&](const LevelPoint& point) {
    return point.disparity_px < range.low - 0.5 || point.disparity_px > range.high + 0.5;
  });
  made.map = map_of(left, made.surface.points);
  return made;
}

void fill_by_triangles(std::span<const LevelPoint> points, FloatImage& disparity, const Run& run) {
  const auto model = DisparityModel::of(points);
  if (!model) return;
  parallel_for(run, std::size_t(disparity.height), [&](std::size_t row) {
    float* values = disparity.row(int(row));
    for (int x = 0; x < disparity.width; ++x)
      if (std::isnan(values[x]))
        if (const auto filled = model->at({x + 0.5, double(row) + 0.5})) values[x] = float(*filled);
  });
}

}  // namespace collinea
