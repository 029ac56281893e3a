// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/pair_points.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/feature/interest.h"
#include "collinea/match/area_matching.h"
#include "collinea/match/neighbour_matching.h"
#include "collinea/math/median.h"
#include "collinea/math/random.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

constexpr int kSmallest_px = 256;        // longer side of the images where everything is searched
constexpr int kLargestOfSmall_px = 512;  // of those that it is searched on again, where the smallest ones do not agree
constexpr int kSmallTemplate_px = 15;
constexpr double kSmallMinNcc = 0.75;
constexpr int kPointsOfStage = 300;  // of all but the last
constexpr int kSearchOfStage_px = 31;
constexpr std::size_t kFewest = 8;
constexpr int kSamples = 500;
constexpr double kFarther = 8;  // robust standard deviations from the map
constexpr double kLeastScatter_px = 1;
constexpr std::size_t kNearest = 5;

using Affine = Eigen::Matrix<double, 2, 3>;  // right = A (column, row, 1) of the left one

Eigen::Vector2d mapped(const Affine& map, const Eigen::Vector2d& at) { return map * at.homogeneous(); }

std::optional<Affine> affine_through(const std::vector<MatchedPoint>& points, const std::vector<std::size_t>& which) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
  for (const std::size_t i : which) {
    const Eigen::Vector3d row = points[i].left_px.homogeneous();
    normal += row * row.transpose();
    right += row * points[i].right_px.transpose();
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> factors(normal);
  if (!factors.isInvertible()) return std::nullopt;
  return Affine(factors.solve(right).transpose());
}

std::vector<double> distances_of(const std::vector<MatchedPoint>& points, const Affine& map) {
  std::vector<double> distances;
  for (const MatchedPoint& point : points) distances.push_back((mapped(map, point.left_px) - point.right_px).norm());
  return distances;
}

// Whether a map may be that of two images that were taken alike.
bool is_likely(const Affine& map) {
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(map.leftCols<2>());
  return map.leftCols<2>().determinant() > 0 && svd.singularValues()(0) < 2 && svd.singularValues()(1) > 0.5;
}

// The map that most points agree with, and those points.
struct Agreement {
  Affine map;
  std::vector<MatchedPoint> points;
};

std::optional<Agreement> agreement_of(const std::vector<MatchedPoint>& points, std::uint64_t seed) {
  if (points.size() < kFewest) return std::nullopt;
  Random random(seed, points.size());
  double least = std::numeric_limits<double>::infinity();
  Affine best = Affine::Zero();
  const auto draw = [&] { return std::size_t(random.below(std::uint32_t(points.size()))); };
  for (int sample = 0; sample < kSamples; ++sample) {
    const auto map = affine_through(points, {draw(), draw(), draw()});
    if (!map || !is_likely(*map)) continue;
    // Two fifths: more than half of the matches on small images may be wrong.
    if (const double part = quantile(distances_of(points, *map), 0.4); part < least) {
      least = part;
      best = *map;
    }
  }
  if (!std::isfinite(least)) return std::nullopt;
  Agreement found{best, {}};
  for (int round = 0; round < 3; ++round) {
    const auto distances = distances_of(points, found.map);
    const double farthest = kFarther * std::max(quantile(distances_of(points, found.map), 0.4), kLeastScatter_px);
    std::vector<std::size_t> near;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (distances[i] <= farthest) near.push_back(i);
    const auto map = affine_through(points, near);
    if (near.size() < kFewest || !map) return std::nullopt;
    found.map = *map;
    found.points.clear();
    for (const std::size_t i : near) found.points.push_back(points[i]);
  }
  return found;
}

// Where a point of the left image is about, in the right one.
Eigen::Vector2d predicted(const Agreement& known, const Eigen::Vector2d& at) {
  std::vector<std::pair<double, std::size_t>> nearest;
  for (std::size_t i = 0; i < known.points.size(); ++i)
    nearest.emplace_back((known.points[i].left_px - at).squaredNorm(), i);
  const std::size_t count = std::min(kNearest, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + std::ptrdiff_t(count), nearest.end());
  std::vector<double> columns, rows;
  for (std::size_t k = 0; k < count; ++k) {
    const MatchedPoint& point = known.points[nearest[k].second];
    const Eigen::Vector2d rest = point.right_px - mapped(known.map, point.left_px);
    columns.push_back(rest.x());
    rows.push_back(rest.y());
  }
  return mapped(known.map, at) + Eigen::Vector2d(median(columns), median(rows));
}

std::vector<InterestPoint> interest_points(const GreyImage& image, int count, double evenness) {
  InterestOptions options;
  options.method = InterestOperator::kNoble;
  options.max_points = count;
  options.evenness = evenness;
  return find_interest_points(image, options).points;
}

AreaOptions area_options(int template_px, int search_px, double min_ncc, double return_px) {
  AreaOptions options;
  options.template_px = template_px;
  options.search_px = search_px | 1;
  options.threshold = min_ncc;
  options.return_px = return_px;
  return options;
}

// Matches of a stage, in the order of the interest points. `known` and what is found are in pixels of these images.
std::vector<MatchedPoint> matches(const GreyImage& left, const GreyImage& right,
                                  const std::vector<InterestPoint>& interest, const std::optional<Agreement>& known,
                                  const AreaOptions& options, const Run& run) {
  std::vector<std::optional<MatchedPoint>> found(interest.size());
  parallel_for(run, interest.size(), [&](std::size_t i) {
    const Eigen::Vector2d at = interest[i].position_px;
    const Eigen::Vector2d expected =
        known ? predicted(*known, at) : Eigen::Vector2d(right.width / 2.0, right.height / 2.0);
    const AreaMatching matching = match_area(left, at, right, expected, options);
    if (matching.outcome == AreaOutcome::kFound)
      found[i] = MatchedPoint{at, matching.match->position_px, matching.match->value};
  });
  std::vector<MatchedPoint> points;
  for (const auto& each : found)
    if (each) points.push_back(*each);
  return points;
}

// The same, by relaxation over all candidates.
std::vector<MatchedPoint> relaxed(const GreyImage& left, const GreyImage& right,
                                  const std::vector<InterestPoint>& interest, const std::optional<Agreement>& known,
                                  AreaOptions options, const Run& run) {
  options.decisive_ratio = std::numeric_limits<double>::infinity();  // all that are good enough
  std::vector<AreaPoint> points(interest.size());
  parallel_for(run, interest.size(), [&](std::size_t i) {
    const Eigen::Vector2d at = interest[i].position_px;
    if (known)
      points[i] = {at, predicted(*known, at)};
    else
      points[i] = {at, at, Eigen::Vector2d(right.width / 2.0, right.height / 2.0)};
  });
  std::vector<MatchedPoint> out;
  const auto decisions = match_areas(left, right, points, options, {}, run);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (decisions[i].match)
      out.push_back({points[i].position_px, decisions[i].match->position_px, decisions[i].likeness});
  return out;
}

void scale(Agreement& known, double times) {
  known.map.col(2) *= times;
  for (MatchedPoint& point : known.points) {
    point.left_px *= times;
    point.right_px *= times;
  }
}

PairPointStage stage_of(int shrink, std::size_t interest, std::size_t matched,
                        const std::vector<MatchedPoint>& agreeing) {
  PairPointStage stage{shrink, interest, matched, agreeing.size(), {0, 0}};
  for (const MatchedPoint& point : agreeing)
    stage.parallax_px += shrink * (point.left_px - point.right_px) / double(agreeing.size());
  return stage;
}

}  // namespace

Result<PairPoints> find_pair_points(const GreyImage& left, const GreyImage& right, const PairPointOptions& options,
                                    const Run& run) {
  COLLINEA_TRY(validate(options));
  if (options.decision == PointDecision::kRelaxation && options.return_px != PairPointOptions{}.return_px)
    return fail(Errc::kBadInput, "relaxation asks the neighbours of a point, not whether it comes back",
                {"point_return_px"_option, "point_decision"_option});
  int shrink = 1;
  while (std::max({left.width, left.height, right.width, right.height}) / shrink > kSmallest_px) shrink *= 2;
  PairPoints pair;
  std::optional<Agreement> known;
  for (; shrink >= 1; shrink /= 2) {
    const bool is_last = shrink == 1;
    const GreyImage small_left = is_last ? GreyImage() : shrunk(left, shrink);
    const GreyImage small_right = is_last ? GreyImage() : shrunk(right, shrink);
    const GreyImage &from = is_last ? left : small_left, &to = is_last ? right : small_right;
    const auto interest =
        interest_points(from, is_last ? options.max_points : kPointsOfStage, is_last ? options.evenness : 1.0);
    const int everywhere = 2 * std::max(to.width, to.height) + 1;
    const AreaOptions area =
        is_last ? area_options(options.template_px, known ? options.search_px : everywhere, options.min_ncc,
                               options.return_px)
                : area_options(kSmallTemplate_px, known ? kSearchOfStage_px : everywhere, kSmallMinNcc, 1.5);
    const std::vector<MatchedPoint> found = is_last && options.decision == PointDecision::kRelaxation
                                                ? relaxed(from, to, interest, known, area, run)
                                                : matches(from, to, interest, known, area, run);
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    if (is_last) {
      pair.points = found;
      pair.stages.push_back(stage_of(1, interest.size(), found.size(), found));
      break;
    }
    const auto agreement = agreement_of(found, run.seed);
    // Houses in rows, waves, fields: what images so small show looks alike everywhere, but larger ones tell it apart.
    if (!agreement && !known && shrink > 1 &&
        std::max({from.width, from.height, to.width, to.height}) <= kLargestOfSmall_px / 2)
      continue;
    if (!agreement)
      return fail(Errc::kIllPosed,
                  fmt::format("the two images do not show the same: of {} points on images of 1/{} of the size {} were "
                              "found in the right one, and these do not agree",
                              interest.size(), shrink, found.size()));
    pair.stages.push_back(stage_of(shrink, interest.size(), found.size(), agreement->points));
    known = agreement;
    scale(*known, 2);
  }
  return pair;
}

}  // namespace collinea
