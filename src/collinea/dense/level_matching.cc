// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/level_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_model.h"
#include "collinea/dense/internal/shaped_window.h"
#include "collinea/feature/interest.h"
#include "collinea/feature/texture.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kMargin_px = 2;         // round the interval of columns
constexpr double kRowSigmas = 3;         // of the epipolar line's row
constexpr std::size_t kNeighbours = 16;  // that a spike is judged by
constexpr std::size_t kSupport = 4;      // of them that have to bear a point out
constexpr double kApart_px = 0.5;        // from the planes of those that do
constexpr double kBend = 0.1;            // and this part of their distance, by which the surface may bend
constexpr double kSurely = 0.95;         // correlation at which no other slope of the window is tried
constexpr double kTriedSlope = 0.25;     // of a window whose slope nothing tells
constexpr std::size_t kMostPoints = 2'000'000;
constexpr int kEntropySide_px = 9;
constexpr std::size_t kBlock = 64;  // points of a piece of work

// Everything a level needs to match points.
class LevelMatcher {
 public:
  LevelMatcher(const GreyImage& left, const GreyImage& right,
               const std::function<double(const Eigen::Vector2d&)>& row_sigma_px, const LevelOptions& options)
      : left_(left), right_(right), row_sigma_px_(row_sigma_px), options_(options) {}

  // Matches of pixels near the model, in their order; intervals receives how far each was searched.
  Result<std::vector<LevelPoint>> match(const std::vector<Eigen::Vector2i>& pixels, const DisparityModel& model,
                                        int half, std::vector<double>& intervals, const Run& run) const;

 private:
  [[nodiscard]] std::optional<LevelPoint> best_shape(const Eigen::Vector2i& pixel, const DisparityModel& model,
                                                     int half, const ShapedSearch& search) const;
  [[nodiscard]] std::optional<LevelPoint> match_one(const Eigen::Vector2i& pixel, const DisparityModel& model, int half,
                                                    double& interval) const;

  const GreyImage &left_, &right_;
  const std::function<double(const Eigen::Vector2d&)>& row_sigma_px_;
  const LevelOptions& options_;
};

// Planes that the surface at a pixel may have: that of the nearest point, none, that of the model's triangle, which may
// span a wall; and where no point lies within a window, so that nothing tells, slopes in all directions.
std::optional<LevelPoint> LevelMatcher::best_shape(const Eigen::Vector2i& pixel, const DisparityModel& model, int half,
                                                   const ShapedSearch& search) const {
  const Eigen::Vector2d at = pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  std::optional<LevelPoint> best;
  const ShapedMatcher matcher(left_, pixel, half, right_, search);
  const auto attempt = [&](const Eigen::Vector2d& gradient) {
    const auto found = matcher.match(gradient);
    if (found && (!best || found->ncc > best->ncc)) best = found;
  };
  const auto is_enough = [&](double ncc) { return best && best->ncc >= ncc; };
  const LevelPoint& nearest = model.nearest(at);
  attempt(nearest.gradient.cwiseMax(-kSteepest).cwiseMin(kSteepest));
  if (is_enough(kSurely)) return best;
  if (nearest.gradient != Eigen::Vector2d::Zero()) attempt({0, 0});
  if (is_enough(options_.min_ncc)) return best;
  if (const auto gradient = model.gradient_at(at)) attempt(*gradient);
  if ((nearest.left_px - at).norm() <= 2 * half + 1) return best;
  for (int i = 0; i < 9 && !is_enough(options_.min_ncc); ++i)
    if (i != 4) attempt(kTriedSlope * Eigen::Vector2d(i % 3 - 1, i / 3 - 1));
  return best;
}

std::optional<LevelPoint> LevelMatcher::match_one(const Eigen::Vector2i& pixel, const DisparityModel& model, int half,
                                                  double& interval) const {
  const Eigen::Vector2d at = pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  const DisparityInterval searched = model.around(at, options_.square_px);
  interval = searched.high_px - searched.low_px + 2 * kMargin_px;
  const int rows = std::max(1, int(std::ceil(kRowSigmas * row_sigma_px_(at))));
  const auto found = best_shape(pixel, model, half,
                                {.low_px = searched.low_px - kMargin_px,
                                 .high_px = searched.high_px + kMargin_px,
                                 .rows = rows,
                                 .return_px = options_.return_px});
  if (!found || found->ncc < options_.min_ncc) return std::nullopt;
  const auto fitted = fitted_plane(left_, half, right_, *found);
  return fitted && fitted->ncc >= options_.min_ncc ? fitted : std::nullopt;
}

Result<std::vector<LevelPoint>> LevelMatcher::match(const std::vector<Eigen::Vector2i>& pixels,
                                                    const DisparityModel& model, int half,
                                                    std::vector<double>& intervals, const Run& run) const {
  std::vector<std::optional<LevelPoint>> found(pixels.size());
  intervals.assign(pixels.size(), 0);
  parallel_for(run, (pixels.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, pixels.size()); ++i)
      found[i] = match_one(pixels[i], model, half, intervals[i]);
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  std::vector<LevelPoint> points;
  for (const auto& each : found)
    if (each) points.push_back(*each);
  return points;
}

// Corners that any level may match, strongest first.
std::vector<MapPixel> corners_of(const GreyImage& image, double least_threshold, const Run& run) {
  InterestOptions options;
  options.method = InterestOperator::kKovesi;
  options.threshold = least_threshold;
  options.radius_px = 2;
  std::vector<MapPixel> corners = interest_pixels(image, options, run);
  if (corners.size() > kMostPoints) {
    corners.resize(kMostPoints);
    corners.shrink_to_fit();
  }
  return corners;
}

// Those above a threshold, row by row.
std::vector<Eigen::Vector2i> above(const std::vector<MapPixel>& corners, double threshold) {
  std::vector<Eigen::Vector2i> pixels;
  for (const MapPixel& corner : corners) {
    if (!(corner.value > float(threshold))) break;
    pixels.emplace_back(corner.column, corner.row);
  }
  std::sort(pixels.begin(), pixels.end(),
            [](const auto& a, const auto& b) { return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x()); });
  return pixels;
}

std::vector<Eigen::Vector2i> grid_pixels(const GreyImage& image, int step, double min_entropy, const Run& run) {
  std::vector<std::vector<Eigen::Vector2i>> found(std::size_t(image.height / step + 1));
  parallel_for(run, found.size(), [&](std::size_t i) {
    const int row = step / 2 + int(i) * step;
    if (row >= image.height) return;
    const std::vector<float> entropy = entropy_of_row(image, kEntropySide_px, row);
    for (int column = step / 2; column < image.width; column += step)
      if (image.at(column, row) != 0 && double(entropy[std::size_t(column)]) > min_entropy)
        found[i].emplace_back(column, row);
  });
  std::vector<Eigen::Vector2i> pixels;
  for (const auto& row : found) pixels.insert(pixels.end(), row.begin(), row.end());
  return pixels;
}

// Thresholds of the levels, falling by the same factor each time.
std::vector<double> thresholds_of(const LevelOptions& options) {
  std::vector<double> thresholds;
  for (int i = 0; i < options.levels; ++i) {
    const double part = options.levels == 1 ? 1 : double(i) / (options.levels - 1);
    thresholds.push_back(std::pow(options.first_threshold, 1 - part) * std::pow(options.last_threshold, part));
  }
  return thresholds;
}

// Whether too few of the nearest points bear a disparity out, and how far these reach. A point bears another out when
// the mean of their planes leads from one to the other: neighbours on the same roof do, however many lie on the ground.
bool is_spike(const std::vector<LevelPoint>& points, std::size_t index, const PlaneSquares& squares, double& reach_px) {
  const LevelPoint& point = points[index];
  std::size_t support = 0;
  for (const std::size_t k : squares.nearest(point.left_px, kNeighbours)) {
    if (k == index) continue;
    const LevelPoint& other = points[k];
    const Eigen::Vector2d step = other.left_px - point.left_px;
    const double predicted = point.disparity_px + 0.5 * (point.gradient + other.gradient).dot(step);
    support += std::abs(other.disparity_px - predicted) <= kApart_px + kBend * step.norm();
    reach_px = step.norm();
  }
  return support < kSupport;
}

}  // namespace

std::vector<LevelPoint> without_spikes(std::vector<LevelPoint> points, const Run& run) {
  // How far the nearest points of each reach; a point that had no spike among them stays as it was judged.
  std::vector<double> reaches(points.size(), std::numeric_limits<double>::infinity());
  std::vector<LevelPoint> spikes = points;
  while (points.size() > kNeighbours && !spikes.empty()) {
    const PlaneSquares squares(left_positions(points)), rejected(left_positions(spikes));
    std::vector<char> rejects(points.size(), 0);
    parallel_for(run, (points.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
      for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, points.size()); ++i) {
        bool is_new = !std::isfinite(reaches[i]);
        if (!is_new) rejected.in_square(points[i].left_px, reaches[i], [&](std::size_t) { is_new = true; });
        rejects[i] = is_new && is_spike(points, i, squares, reaches[i]);
      }
    });
    spikes.clear();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (rejects[i]) {
        spikes.push_back(points[i]);
        continue;
      }
      points[kept] = points[i];
      reaches[kept++] = reaches[i];
    }
    points.resize(kept);
    reaches.resize(kept);
  }
  return points;
}

Result<LevelSurface> match_by_levels(const GreyImage& left, const GreyImage& right, std::span<const LevelPoint> guide,
                                     const std::function<double(const Eigen::Vector2d&)>& row_sigma_px,
                                     const LevelOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (left.height != right.height) return fail(Errc::kBadInput, "an epipolar pair has as many rows left as right");
  if (options.last_threshold > options.first_threshold)
    return fail(Errc::kBadInput, "thresholds fall from level to level: the last is above the first",
                {"first_threshold"_option, "last_threshold"_option});
  LevelSurface surface{{guide.begin(), guide.end()}, {}};
  const LevelMatcher matcher(left, right, row_sigma_px, options);
  const std::vector<MapPixel> corners = corners_of(left, options.last_threshold, run);
  const auto level = [&](const std::vector<Eigen::Vector2i>& pixels, double threshold, int template_px) -> Result<> {
    COLLINEA_TRY(const DisparityModel model, DisparityModel::of(surface.points));
    LevelCount count{.threshold = threshold, .interest = pixels.size()};
    std::vector<double> intervals;
    COLLINEA_TRY(std::vector<LevelPoint> points, matcher.match(pixels, model, template_px / 2, intervals, run));
    count.matched = points.size();
    points = without_spikes(std::move(points), run);
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    count.spikes = count.matched - points.size();
    if (!intervals.empty()) count.median_interval_px = median(intervals);
    count.least = guide.size() / 2;
    count.is_dropped = points.size() < count.least;
    surface.levels.push_back(count);
    if (!count.is_dropped) surface.points = std::move(points);
    return {};
  };
  const std::vector<double> thresholds = thresholds_of(options);
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    COLLINEA_TRY(level(above(corners, thresholds[i]), thresholds[i], options.template_px));
    run.report("levels", double(i + 1) / double(thresholds.size() + (options.grid_px > 0)));
  }
  if (options.grid_px > 0) {
    COLLINEA_TRY(level(grid_pixels(left, options.grid_px, options.min_entropy, run), 0, options.grid_template_px));
  }
  return surface;
}

}  // namespace collinea
