// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/interest.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <tuple>

#include "collinea/base/parallel.h"
#include "collinea/feature/foerstner.h"
#include "collinea/feature/internal/interest_kernels.h"
#include "collinea/feature/internal/separable_rows.h"
#include "collinea/feature/internal/spread.h"
#include "collinea/feature/internal/tensor_patch.h"
#include "collinea/feature/local_maxima.h"
#include "collinea/feature/sift.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kDogRatio = 1.6;          // of the two blurs: nearest to the Laplacian (Marr and Hildreth 1980)
constexpr int kColumnsAtOnce = 2048;       // rows of all channels within the window stay in the cache
constexpr double kIsolatedShare = 0.5;     // of the response that a single pixel may make
constexpr double kLargestElongation = 10;  // of a blob (Lowe 2004)
constexpr double kSamePoint_px = 0.5;
constexpr double kLeastOfRegion = 0.02;  // of the contrast that the image asks for
constexpr double kCircleMisfit = 0.1;    // of a circle beside that of a corner: where both fit, it is a corner
constexpr int kStripRows = 256, kPlateauRows = 24;
constexpr float kRounding_grey = 1e-3f;  // of sums of floats: responses of blobs below it are none

bool is_blob(InterestOperator method) {
  return method == InterestOperator::kLog || method == InterestOperator::kDog || method == InterestOperator::kSift;
}

int window_radius(const InterestOptions& o) {
  if (o.window_radius_px) return *o.window_radius_px;
  if (o.method == InterestOperator::kMoravec) return 1;
  const double widest = o.method == InterestOperator::kDog || o.method == InterestOperator::kSift ? kDogRatio : 1;
  return std::max(1, static_cast<int>(std::ceil((is_blob(o.method) ? 4 : 3) * widest * o.sigma_px)));
}

// Pixels between a response and the farthest that it depends on.
int margin(const InterestOptions& o) { return window_radius(o) + (is_blob(o.method) ? 0 : 1); }

// What lies beyond is not known to be weaker: the end of an edge that runs out of the map looks like a maximum.
bool is_at_the_rim(const MapPixel& m, const GreyImage& image, const InterestOptions& o) {
  const int rim = margin(o);
  return m.column <= rim || m.row <= rim || m.column >= image.width - 1 - rim || m.row >= image.height - 1 - rim;
}

GradientMask mask_of(InterestOperator method) {
  return method == InterestOperator::kKovesi ? GradientMask::kPrewitt : GradientMask::kCentral;
}

CornerMeasure measure_of(InterestOperator method) {
  switch (method) {
    case InterestOperator::kNoble:
    case InterestOperator::kKovesi:
      return CornerMeasure::kNoble;
    case InterestOperator::kShiTomasi:
      return CornerMeasure::kSmallerEigenvalue;
    case InterestOperator::kFoerstner:
      return CornerMeasure::kRoundNoble;
    default:
      return CornerMeasure::kHarris;
  }
}

using Rows = std::span<float* const>;
// Receives the responses of a row of a strip.
using ResponseSink = std::function<void(int y, const float* row)>;

// A strip of an image: the operators see it as an image of its own.
struct Strip {
  const GreyImage& image;
  int begin, width;
};

float parameter_of(const InterestOptions& o) {
  return static_cast<float>(o.method == InterestOperator::kFoerstner ? o.least_roundness : o.harris_k);
}

TensorPatch patch_of(const InterestOptions& o) {
  return {gaussian_window(o.sigma_px, window_radius(o)), mask_of(o.method), measure_of(o.method), parameter_of(o)};
}

void tensor_responses(const Strip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const std::vector<float> window = gaussian_window(o.sigma_px, window_radius(o));
  const float parameter = parameter_of(o);
  FloatRows grey(strip.image, strip.begin, strip.width);
  SeparableRows(strip.width, strip.image.height, std::vector(3, SeparableFilter{window, window}))
      .run(
          [&](int y, Rows rows) {
            const float *above = grey.row(y - 1), *middle = grey.row(y), *below = grey.row(y + 1);
            gradient_products(above, middle, below, strip.width, mask_of(o.method), rows[0], rows[1], rows[2]);
          },
          [&](int y, Rows rows) {
            corner_response(rows[0], rows[1], rows[2], strip.width, measure_of(o.method), parameter, rows[0]);
            sink(y, rows[0]);
          });
}

// Sums of squared differences for the shifts (1, 0), (0, 1), (1, 1), (-1, 1); the opposite shifts have the sums of the
// pixel that they lead to.
void moravec_responses(const Strip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const std::vector<float> window = box_window(window_radius(o));
  FloatRows grey(strip.image, strip.begin, strip.width);
  std::vector<std::vector<float>> before(3, std::vector<float>(static_cast<std::size_t>(strip.width) + 2 * kRowSlack));
  std::vector<float> least(before[0].size()), right(before[0].size());
  SeparableRows(strip.width, strip.image.height, std::vector(4, SeparableFilter{window, window}))
      .run(
          [&](int y, Rows rows) {
            const float *at = grey.row(y), *below = grey.row(y + 1);
            squared_differences(at + 1, at, strip.width, rows[0]);
            squared_differences(below, at, strip.width, rows[1]);
            squared_differences(below + 1, at, strip.width, rows[2]);
            squared_differences(below - 1, at, strip.width, rows[3]);
          },
          [&](int y, Rows rows) {
            const auto width = static_cast<std::size_t>(strip.width);
            std::copy_n(rows[0], width, right.begin() + 1);
            std::copy_n(rows[0], width, least.begin());
            lower_to(right.data(), strip.width, least.data());
            for (std::size_t k = 1; k < 4; ++k) lower_to(rows[k], strip.width, least.data());
            lower_to(before[0].data() + 1, strip.width, least.data());  // (0, -1)
            lower_to(before[1].data(), strip.width, least.data());      // (-1, -1): of the pixel to the left
            lower_to(before[2].data() + 2, strip.width, least.data());  // (1, -1): of the pixel to the right
            for (std::size_t k = 1; k < 4; ++k) std::copy_n(rows[k], width, before[k - 1].begin() + 1);
            sink(y, least.data());
          });
}

// sigma^2 times the Laplacian of the blurred image, or the difference of two blurs; as sizes.
void blob_responses(const Strip& strip, const InterestOptions& o, const ResponseSink& sink) {
  const int radius = window_radius(o);
  const bool is_log = o.method == InterestOperator::kLog;
  const std::vector<float> fine = gaussian_window(o.sigma_px, radius);
  const std::vector<float> other =
      is_log ? gaussian_curvature(o.sigma_px, radius) : gaussian_window(kDogRatio * o.sigma_px, radius);
  std::vector<SeparableFilter> filters = {{other, is_log ? fine : other}, {fine, is_log ? other : fine}};
  const float factor = is_log ? static_cast<float>(o.sigma_px * o.sigma_px) : 1.0f, sign = is_log ? 1.0f : -1.0f;
  FloatRows grey(strip.image, strip.begin, strip.width);
  SeparableRows(strip.width, strip.image.height, std::move(filters))
      .run(
          [&](int y, Rows rows) {
            for (float* row : rows) std::copy_n(grey.row(y), strip.width, row);
          },
          [&](int y, Rows rows) {
            for (int x = 0; x < strip.width; ++x) {
              const float size = std::abs(factor * (rows[0][x] + sign * rows[1][x]));
              rows[0][x] = size > kRounding_grey ? size : 0;
            }
            sink(y, rows[0]);
          });
}

void responses(const Strip& strip, const InterestOptions& o, const ResponseSink& sink) {
  if (o.method == InterestOperator::kMoravec)
    moravec_responses(strip, o, sink);
  else if (is_blob(o.method))
    blob_responses(strip, o, sink);
  else
    tensor_responses(strip, o, sink);
}

// The surface of second degree through 3 x 3 values, by least squares.
struct Paraboloid {
  Vector2d slope;
  Matrix2d curvature;

  Paraboloid(const FloatImage& map, int column, int row) : slope(Vector2d::Zero()), curvature(Matrix2d::Zero()) {
    double xx = 0, yy = 0, xy = 0;
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x) {
        const double value = map.at(column + x, row + y);
        slope += Vector2d(x, y) * value / 6;
        xx += (x * x - 2.0 / 3) * value;  // twice the coefficient is the second derivative
        yy += (y * y - 2.0 / 3) * value;
        xy += x * y * value / 4;
      }
    curvature << xx, xy, xy, yy;
  }

  /// Where its top lies from the middle; zero where it has none within a pixel.
  [[nodiscard]] Vector2d top() const {
    if (!(curvature.determinant() > 0 && curvature.trace() < 0)) return Vector2d::Zero();
    const Vector2d shift = -(curvature.inverse() * slope);
    return shift.cwiseAbs().maxCoeff() <= 1 ? shift : Vector2d::Zero();
  }
  /// Whether it is a ridge: its two curvatures differ by more than the largest elongation.
  [[nodiscard]] bool is_ridge() const {
    const double det = curvature.determinant(), trace = curvature.trace();
    constexpr double kMost = (kLargestElongation + 1) * (kLargestElongation + 1) / kLargestElongation;
    return !(det > 0) || trace * trace > kMost * det;
  }
};

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
    responses({image, first, last - first}, o, [&](int y, const float* row) {
      if (y < border || y >= image.height - border) return;
      float* out = map.row(y);
      for (int x = from; x < to; ++x) out[x] = std::max(0.0f, row[x - first]);
    });
  }
  return map;
}

bool is_isolated(const GreyImage& image, int column, int row, const InterestOptions& o) {
  if (!is_blob(o.method) && o.method != InterestOperator::kMoravec) {
    TensorPatch patch = patch_of(o);
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
    if (!is_blob(o.method) && o.method != InterestOperator::kMoravec) patch = patch_of(o);
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
    const Paraboloid paraboloid(map, m.column, m.row);
    if (is_blob(o.method) && paraboloid.is_ridge()) {
      ++out.on_edges;
      continue;
    }
    InterestPoint point{.position_px = {m.column + 0.5, m.row + 0.5}, .strength = m.value, .scale_px = o.sigma_px};
    if (location != SubPixel::kNone) point.position_px += paraboloid.top();
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
