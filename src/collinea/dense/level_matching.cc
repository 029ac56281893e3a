// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/level_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_model.h"
#include "collinea/dense/internal/level_growth.h"
#include "collinea/dense/internal/level_pixels.h"
#include "collinea/dense/internal/shaped_window.h"
#include "collinea/dense/working_images.h"
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
constexpr std::size_t kBlock = 64;       // points of a piece of work
// The grid of a reduced pair only says which planes may be there: small windows find small roofs, and what correlates
// little for its grain, or is wrong, has to stand in the larger images.
constexpr int kGuideGrid_px = 4, kGuideTemplate_px = 9;
constexpr double kGuideNcc = 0.6;
constexpr double kReducedShare = 0.3;

// Everything a level needs to match points.
class LevelMatcher {
 public:
  LevelMatcher(const GreyImage& left, const GreyImage& right,
               const std::function<double(const Eigen::Vector2d&)>& row_sigma_px, const LevelOptions& options)
      : left_(left), right_(right), row_sigma_px_(row_sigma_px), options_(options) {}

  // Lets matches of a grid spread; matches of pixels by the planes of the nearest points of a model.
  [[nodiscard]] std::vector<LevelPoint> grow(const std::vector<Eigen::Vector2i>& pixels, std::vector<LevelPoint> points,
                                             const Run& run) const;
  [[nodiscard]] std::vector<LevelPoint> match_near(const std::vector<Eigen::Vector2i>& pixels,
                                                   const std::vector<LevelPoint>& model, const Run& run) const;

  // Matches of pixels near the model, in their order; intervals receives how far each was searched.
  Result<std::vector<LevelPoint>> match(const std::vector<Eigen::Vector2i>& pixels, const DisparityModel& model,
                                        int half, std::vector<double>& intervals, const Run& run) const;

 private:
  [[nodiscard]] std::optional<LevelPoint> best_shape(const Eigen::Vector2i& pixel, const DisparityModel& model,
                                                     int half, const ShapedSearch& search) const;
  [[nodiscard]] std::optional<LevelPoint> match_one(const Eigen::Vector2i& pixel, const DisparityModel& model, int half,
                                                    double& interval) const;

  [[nodiscard]] GrowthOptions growth_options() const;
  [[nodiscard]] int rows_at(const Eigen::Vector2i& pixel) const {
    return std::max(1, int(std::ceil(kRowSigmas * row_sigma_px_(pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5)))));
  }

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
  const auto found = best_shape(pixel, model, half,
                                {.low_px = searched.low_px - kMargin_px,
                                 .high_px = searched.high_px + kMargin_px,
                                 .rows = rows_at(pixel),
                                 .return_px = options_.return_px});
  return measured_match(left_, half, right_, found, options_.min_ncc);
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

GrowthOptions LevelMatcher::growth_options() const {
  GrowthOptions growth;
  growth.step_px = options_.grid_px;
  growth.half = (options_.grid_px > 0 ? options_.grid_template_px : options_.template_px) / 2;
  growth.min_ncc = options_.min_ncc;
  growth.return_px = options_.return_px;
  growth.rows = [this](const Eigen::Vector2i& pixel) { return rows_at(pixel); };
  return growth;
}

std::vector<LevelPoint> LevelMatcher::grow(const std::vector<Eigen::Vector2i>& pixels, std::vector<LevelPoint> points,
                                           const Run& run) const {
  return grown(left_, right_, pixels, std::move(points), growth_options(), run);
}

std::vector<LevelPoint> LevelMatcher::match_near(const std::vector<Eigen::Vector2i>& pixels,
                                                 const std::vector<LevelPoint>& model, const Run& run) const {
  return matched_near(left_, right_, pixels, model, growth_options(), run);
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

namespace {

using RowSigma = std::function<double(const Eigen::Vector2d& left_px)>;

// Points of a grid, or of corners, and what they count.
struct Matched {
  std::vector<LevelPoint> points;
  LevelCount count;
};

// Spikes go, and what is left of a grid spreads.
Matched settled(const LevelMatcher& matcher, const std::vector<Eigen::Vector2i>& pixels, std::vector<LevelPoint> points,
                LevelCount count, const Run& run) {
  const std::size_t matched = points.size();
  points = without_spikes(std::move(points), run);
  count.matched = matched;
  count.spikes = matched - points.size();
  if (count.threshold == 0) {
    const std::size_t spread = points.size();
    points = matcher.grow(pixels, std::move(points), run);
    count.grown = points.size() - spread;
    points = without_spikes(std::move(points), run);
    count.spikes += spread + count.grown - points.size();
  }
  return {std::move(points), count};
}

Result<LevelSurface> match_whole(const GreyImage& left, const GreyImage& right, std::span<const LevelPoint> guide,
                                 const RowSigma& row_sigma_px, const LevelOptions& options, const Run& run) {
  LevelSurface surface{{guide.begin(), guide.end()}, {}};
  const LevelMatcher matcher(left, right, row_sigma_px, options);
  const std::vector<MapPixel> corners = corners_of(left, options.last_threshold, run);
  const auto level = [&](const std::vector<Eigen::Vector2i>& pixels, double threshold, int template_px) -> Result<> {
    COLLINEA_TRY(const DisparityModel model, DisparityModel::of(surface.points));
    std::vector<double> intervals;
    COLLINEA_TRY(std::vector<LevelPoint> points, matcher.match(pixels, model, template_px / 2, intervals, run));
    Matched matched =
        settled(matcher, pixels, std::move(points), {.threshold = threshold, .interest = pixels.size()}, run);
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    if (!intervals.empty()) matched.count.median_interval_px = median(intervals);
    matched.count.least = guide.size() / 2;
    matched.count.is_dropped = matched.points.size() < matched.count.least;
    surface.levels.push_back(matched.count);
    if (!matched.count.is_dropped) surface.points = std::move(matched.points);
    return {};
  };
  const std::vector<double> thresholds = thresholds_of(options);
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    COLLINEA_TRY(level(above(corners, thresholds[i]), thresholds[i], options.template_px));
    run.report("levels", double(i + 1) / double(thresholds.size() + (options.grid_px > 0)));
  }
  if (options.grid_px > 0)
    COLLINEA_TRY(level(grid_pixels(left, options.grid_px, options.min_entropy, run), 0, options.grid_template_px));
  return surface;
}

std::vector<LevelPoint> scaled(std::span<const LevelPoint> points, double scale) {
  std::vector<LevelPoint> made(points.begin(), points.end());
  for (LevelPoint& point : made) {
    point.left_px *= scale;
    point.disparity_px *= scale;
    point.row_px *= scale;
    point.sigma_px *= scale;
  }
  return made;
}

GreyImage reduced(const GreyImage& image, int shrink) {
  GreyImage small = halved(image);
  for (int done = 2; done < shrink; done *= 2) small = halved(small);
  return small;
}

double megapixels(const GreyImage& image) { return 1e-6 * double(image.width) * double(image.height); }

Result<LevelSurface> match_any(const GreyImage& left, const GreyImage& right, std::span<const LevelPoint> guide,
                               const RowSigma& row_sigma_px, const LevelOptions& options, const Run& run) {
  if (megapixels(left) <= options.whole_mpx) return match_whole(left, right, guide, row_sigma_px, options, run);
  const int shrink = megapixels(left) <= 4 * options.whole_mpx ? 2 : 4;
  LevelOptions coarse = options;
  coarse.grid_px = kGuideGrid_px;
  coarse.grid_template_px = std::min(kGuideTemplate_px, options.grid_template_px);
  coarse.min_ncc = std::min(kGuideNcc, options.min_ncc);
  Run first = run, rest = run;  // of the time, about
  first.progress = [&](std::string_view stage, double done) { run.report(stage, kReducedShare * done); };
  rest.progress = [&](std::string_view stage, double done) {
    run.report(stage, kReducedShare + (1 - kReducedShare) * done);
  };
  COLLINEA_TRY(LevelSurface surface,
               match_any(
                   reduced(left, shrink), reduced(right, shrink), scaled(guide, 1.0 / shrink),
                   [&](const Eigen::Vector2d& at) { return row_sigma_px(shrink * at) / shrink; }, coarse, first));
  for (LevelCount& count : surface.levels) count.shrink *= shrink;
  const double threshold = options.grid_px > 0 ? 0 : options.last_threshold;
  const std::vector<Eigen::Vector2i> pixels = options.grid_px > 0
                                                  ? grid_pixels(left, options.grid_px, options.min_entropy, run)
                                                  : above(corners_of(left, threshold, run), threshold);
  const LevelMatcher matcher(left, right, row_sigma_px, options);
  Matched matched = settled(matcher, pixels, matcher.match_near(pixels, scaled(surface.points, shrink), rest),
                            {.threshold = threshold, .interest = pixels.size(), .least = guide.size() / 2}, run);
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  matched.count.is_dropped = matched.points.size() < matched.count.least;
  surface.levels.push_back(matched.count);
  surface.points = matched.count.is_dropped ? scaled(surface.points, shrink) : std::move(matched.points);
  return surface;
}

}  // namespace

Result<LevelSurface> match_by_levels(const GreyImage& left, const GreyImage& right, std::span<const LevelPoint> guide,
                                     const RowSigma& row_sigma_px, const LevelOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  if (left.height != right.height) return fail(Errc::kBadInput, "an epipolar pair has as many rows left as right");
  if (options.last_threshold > options.first_threshold)
    return fail(Errc::kBadInput, "thresholds fall from level to level: the last is above the first",
                {"first_threshold"_option, "last_threshold"_option});
  return match_any(left, right, guide, row_sigma_px, options, run);
}

}  // namespace collinea
