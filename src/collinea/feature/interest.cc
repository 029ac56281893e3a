// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/interest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>

#include "collinea/base/parallel.h"
#include "collinea/feature/foerstner.h"
#include "collinea/feature/internal/interest_responses.h"
#include "collinea/feature/internal/interest_window.h"
#include "collinea/feature/internal/response_paraboloid.h"
#include "collinea/feature/internal/spread.h"
#include "collinea/feature/internal/tensor_patch.h"
#include "collinea/feature/local_maxima.h"
#include "collinea/feature/sift.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr int kColumnsAtOnce = 2048;    // rows of all channels within the window stay in the cache
constexpr double kIsolatedShare = 0.5;  // of the response that a single pixel may make
constexpr double kSamePoint_px = 0.5;
constexpr double kLeastOfRegion = 0.02;  // of the contrast that the image asks for
constexpr double kCircleMisfit = 0.1;    // of a circle beside that of a corner: where both fit, it is a corner
constexpr int kStripRows = 256, kPlateauRows = 24;

// Pixels between a response and the farthest that it depends on.
int margin(const InterestOptions& o) { return window_radius(o) + (is_blob(o.method) ? 0 : 1); }

// What lies beyond is not known to be weaker: the end of an edge that runs out of the map looks like a maximum.
bool is_at_the_rim(const MapPixel& m, const GreyImage& image, const InterestOptions& o) {
  const int rim = margin(o);
  return m.column <= rim || m.row <= rim || m.column >= image.width - 1 - rim || m.row >= image.height - 1 - rim;
}

SubPixel location_of(const InterestOptions& o) {
  return o.sub_pixel.value_or(o.method == InterestOperator::kFoerstner ? SubPixel::kFoerstner : SubPixel::kParaboloid);
}

bool has_covariance(SubPixel location) { return location == SubPixel::kFoerstner || location == SubPixel::kFollowing; }

// A corner, or the centre of a circle where the lines of the window miss that by much less.
std::optional<InterestPoint> located(const GreyImage& image, InterestPoint point, const InterestOptions& o,
                                     double noise_grey) {
  const auto window = location_of(o) == SubPixel::kFollowing ? FoerstnerWindow::kFollowing : FoerstnerWindow::kFixed;
  std::optional<FoerstnerPoint> best;
  for (const FoerstnerModel model : {FoerstnerModel::kCorner, FoerstnerModel::kCircle}) {
    const auto found = foerstner_point(image, point.position_px, o.sigma_px, model, window, noise_grey);
    if (!found || (best && kCircleMisfit * best->misfit <= found->misfit)) continue;
    best = found;
    point.is_circle = model == FoerstnerModel::kCircle;
  }
  if (!best) return std::nullopt;
  if (o.method == InterestOperator::kFoerstner && best->roundness < o.least_roundness) return std::nullopt;
  point.position_px = best->position_px;
  point.covariance_px2 = best->covariance_px2;
  point.roundness = best->roundness;
  return point;
}

// Points by position, to ask whether one is there already.
class Taken {
 public:
  bool take(const Vector2d& p) {
    const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
    for (int y = row - 1; y <= row + 1; ++y)
      for (int x = column - 1; x <= column + 1; ++x)
        if (const auto cell = cells_.find({x, y}); cell != cells_.end())
          for (const Vector2d& other : cell->second)
            if ((other - p).norm() < kSamePoint_px) return false;
    cells_[{column, row}].push_back(p);
    return true;
  }

 private:
  std::map<std::pair<int, int>, std::vector<Vector2d>> cells_;
};

// Indices of the spots by their contrast beside what their regions ask for: how evenly they are spread then does not
// depend on the operator.
std::vector<std::size_t> in_order(std::span<const Spot> spots, const GreyImage& image, const InterestOptions& o) {
  const std::vector<float> strengths =
      regional_strengths(spots, image.width, image.height, o.max_points, o.evenness, kLeastOfRegion);
  std::vector<std::size_t> order(spots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return strengths[i]; });
  return order;
}

InterestPoints sift_points(const GreyImage& image, const InterestOptions& o) {
  InterestPoints out;
  const Features features = detect_sift(image, {.max_features = o.max_points, .evenness = o.evenness});
  const bool with_covariance = has_covariance(location_of(o));
  if (with_covariance) out.noise_grey = o.noise_grey.value_or(noise_of(image));
  out.maxima = features.keypoints.size();
  Taken taken;
  for (const Keypoint& k : features.keypoints) {
    InterestPoint point{.position_px = {k.x, k.y}, .strength = k.strength, .scale_px = k.scale_px};
    if (with_covariance) {
      const auto better = located(image, point, o, out.noise_grey);
      if (!better) {
        ++out.not_located;
        continue;
      }
      point = *better;
    }
    if (taken.take(point.position_px)) out.points.push_back(point);  // of several directions at a position, one
  }
  return out;
}

// Of the 3 x 3 pixels round a pixel, the one that differs most from the median of its neighbours.
struct Outlier {
  int column, row;
  std::uint8_t expected = 0;
};

Outlier outlier_at(const GreyImage& image, int column, int row) {
  Outlier outlier{column, row};
  int worst = -1;
  for (int y = std::max(1, row - 1); y <= std::min(image.height - 2, row + 1); ++y)
    for (int x = std::max(1, column - 1); x <= std::min(image.width - 2, column + 1); ++x) {
      std::array<std::uint8_t, 8> around{};
      std::size_t n = 0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          if (i != 0 || j != 0) around[n++] = image.at(x + i, y + j);
      std::ranges::sort(around);
      const int median = (around[3] + around[4] + 1) / 2, difference = std::abs(image.at(x, y) - median);
      if (difference <= worst) continue;
      worst = difference;
      outlier = {x, y, static_cast<std::uint8_t>(median)};
    }
  return outlier;
}

bool is_within(const GreyImage& image, int column, int row, int reach) {
  return column >= reach && row >= reach && column + reach < image.width && row + reach < image.height;
}

// As is_isolated(), of the operators on the structure tensor.
bool is_isolated(const GreyImage& image, int column, int row, TensorPatch& patch) {
  patch.take(image, column, row);
  const float before = patch.strongest();
  const Outlier outlier = outlier_at(image, column, row);
  patch.replace(outlier.column - column, outlier.row - row, outlier.expected);
  return patch.strongest() < static_cast<float>(kIsolatedShare) * before;
}

}  // namespace

FloatImage interest_map(const GreyImage& image, const InterestOptions& o) {
  FloatImage map(image.width, image.height);
  const int border = margin(o);
  if (std::min(image.width, image.height) < 2 * border + 1) return map;
  for (int begin = 0; begin < image.width; begin += kColumnsAtOnce) {
    const int end = std::min(image.width, begin + kColumnsAtOnce);
    const int first = std::max(0, begin - border), last = std::min(image.width, end + border);
    const int from = std::max(begin, border), to = std::min(end, image.width - border);
    interest_responses({image, first, last - first}, o, [&](int y, const float* row) {
      if (y < border || y >= image.height - border) return;
      float* out = map.row(y);
      for (int x = from; x < to; ++x) out[x] = std::max(0.0f, row[x - first]);
    });
  }
  return map;
}

bool is_isolated(const GreyImage& image, int column, int row, const InterestOptions& o) {
  if (!is_blob(o.method) && o.method != InterestOperator::kMoravec) {
    TensorPatch patch = tensor_patch_of(o);
    if (is_within(image, column, row, patch.reach())) return is_isolated(image, column, row, patch);
  }
  const Outlier outlier = outlier_at(image, column, row);
  const int half = margin(o) + 1;
  const int left = std::max(0, column - half), right = std::min(image.width, column + half + 1);
  const int top = std::max(0, row - half), bottom = std::min(image.height, row + half + 1);
  GreyImage part(right - left, bottom - top);
  for (int y = top; y < bottom; ++y) std::copy_n(image.row(y) + left, part.width, part.row(y - top));
  const auto strongest = [&] {
    const FloatImage map = interest_map(part, o);
    float most = 0;
    for (int y = std::max(0, row - 1 - top); y <= std::min(part.height - 1, row + 1 - top); ++y)
      for (int x = std::max(0, column - 1 - left); x <= std::min(part.width - 1, column + 1 - left); ++x)
        most = std::max(most, map.at(x, y));
    return most;
  };
  const float before = strongest();
  part.at(outlier.column - left, outlier.row - top) = outlier.expected;
  return strongest() < static_cast<float>(kIsolatedShare) * before;
}

std::vector<MapPixel> interest_pixels(const GreyImage& image, const InterestOptions& o, const Run& run) {
  COLLINEA_CHECK(o.threshold && o.method != InterestOperator::kSift);
  // Rows around a strip on which its responses, and whether they are maxima, depend.
  const int around = 2 * margin(o) + 2 * o.radius_px + kPlateauRows;
  std::vector<std::vector<MapPixel>> found(std::size_t((image.height + kStripRows - 1) / kStripRows));
  parallel_for(run, found.size(), [&](std::size_t i) {
    const int begin = int(i) * kStripRows, end = std::min(begin + kStripRows, image.height);
    const int top = std::max(begin - around, 0), bottom = std::min(end + around, image.height);
    GreyImage strip(image.width, bottom - top);
    std::copy(image.row(top), image.row(top) + strip.data.size(), strip.data.begin());
    std::optional<TensorPatch> patch;
    if (!is_blob(o.method) && o.method != InterestOperator::kMoravec) patch = tensor_patch_of(o);
    const auto isolated = [&](const MapPixel& m) {
      return patch && is_within(image, m.column, m.row, patch->reach()) ? is_isolated(image, m.column, m.row, *patch)
                                                                        : is_isolated(image, m.column, m.row, o);
    };
    for (MapPixel m : local_maxima(interest_map(strip, o), o.radius_px, static_cast<float>(*o.threshold))) {
      m.row += top;
      if (m.row < begin || m.row >= end || is_at_the_rim(m, image, o)) continue;
      if (o.keep_isolated || !isolated(m)) found[i].push_back(m);
    }
  });
  std::vector<MapPixel> all;
  for (const std::vector<MapPixel>& part : found) all.insert(all.end(), part.begin(), part.end());
  std::ranges::sort(all, {}, [](const MapPixel& m) { return std::tuple(-m.value, m.row, m.column); });
  return all;
}

double contrast_power(InterestOperator method) {
  if (is_blob(method)) return 1;
  return method == InterestOperator::kHarris ? 0.25 : 0.5;
}

InterestPoints find_interest_points(const GreyImage& image, const FloatImage& map, const InterestOptions& o) {
  if (o.method == InterestOperator::kSift) return sift_points(image, o);
  InterestPoints out;
  const float highest = map.empty() ? 0 : *std::ranges::max_element(map.data);
  out.threshold = o.threshold.value_or(o.relative_threshold * highest);
  const std::vector<MapPixel> maxima = local_maxima(map, o.radius_px, static_cast<float>(out.threshold));
  out.maxima = maxima.size();
  const SubPixel location = location_of(o);
  if (has_covariance(location)) out.noise_grey = o.noise_grey.value_or(noise_of(image));

  std::vector<Spot> spots;
  const double power = contrast_power(o.method);
  for (const MapPixel& m : maxima)
    spots.push_back({static_cast<float>(m.column) + 0.5f, static_cast<float>(m.row) + 0.5f,
                     static_cast<float>(std::pow(m.value, power))});
  Taken taken;
  for (const std::size_t i : in_order(spots, image, o)) {
    if (out.points.size() == static_cast<std::size_t>(o.max_points)) break;
    const MapPixel& m = maxima[i];
    if (is_at_the_rim(m, image, o)) continue;
    if (!o.keep_isolated && is_isolated(image, m.column, m.row, o)) {
      ++out.isolated;
      continue;
    }
    const ResponseParaboloid paraboloid([&](int x, int y) { return map.at(m.column + x, m.row + y); });
    if (is_blob(o.method) && paraboloid.is_ridge()) {
      ++out.on_edges;
      continue;
    }
    InterestPoint point{.position_px = {m.column + 0.5, m.row + 0.5}, .strength = m.value, .scale_px = o.sigma_px};
    if (location != SubPixel::kNone) point.position_px += paraboloid.top().value_or(Vector2d::Zero());
    if (location == SubPixel::kParaboloid) point.pixel = m;
    if (has_covariance(location)) {
      const auto better = located(image, point, o, out.noise_grey);
      if (!better) {
        ++out.not_located;
        continue;
      }
      point = *better;
    }
    if (taken.take(point.position_px)) out.points.push_back(point);
  }
  return out;
}

InterestPoints find_interest_points(const GreyImage& image, const InterestOptions& options) {
  if (options.method == InterestOperator::kSift) return sift_points(image, options);
  return find_interest_points(image, interest_map(image, options), options);
}

}  // namespace collinea
