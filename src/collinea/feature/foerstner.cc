// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/foerstner.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kDerivative_px = 0.8;  // standard deviation of the Gaussian whose derivative is taken
constexpr int kMaskRadius = 3;
constexpr int kMaskSize = 2 * kMaskRadius + 1;
constexpr double kWindowSigmas = 3.5;
constexpr double kFarthestSigmas = 2;
constexpr int kMostSteps = 100;
constexpr double kConverged_px = 1e-6;
constexpr double kLeastRoundness = 0.01;
constexpr double kRounding_grey = 0.28867513459481287;  // 1 / sqrt(12)

struct Mask {
  std::array<double, kMaskSize> smoothing, slope;
};

// A Gaussian and its derivative, sampled; the slope of a ramp comes out as it is.
const Mask& derivative_mask() {
  static const Mask kMask = [] {
    Mask mask;
    double sum = 0, moment = 0;
    for (int j = -kMaskRadius; j <= kMaskRadius; ++j) {
      const auto i = static_cast<std::size_t>(j + kMaskRadius);
      mask.smoothing[i] = std::exp(-0.5 * j * j / (kDerivative_px * kDerivative_px));
      mask.slope[i] = j * mask.smoothing[i];
      sum += mask.smoothing[i];
      moment += j * mask.slope[i];
    }
    for (double& value : mask.smoothing) value /= sum;
    for (double& value : mask.slope) value /= moment;
    return mask;
  }();
  return kMask;
}

// Pixels [left, left + size) x [top, top + size).
struct Square {
  int left = 0, top = 0, size = 0;

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>((y - top) * size + (x - left));
  }
};

// The gradients of a part of an image, or the normals of them: directions in which a line's distance is counted.
class Normals {
 public:
  Normals(const GreyImage& image, const Square& square, FoerstnerModel model)
      : square_(square), normals_(static_cast<std::size_t>(square.size * square.size)) {
    const Mask& mask = derivative_mask();
    const int width = square.size, height = square.size + 2 * kMaskRadius;
    std::vector<double> smoothed(static_cast<std::size_t>(width * height)), sloped(smoothed.size());
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::uint8_t* row = image.row(square.top - kMaskRadius + y) + square.left + x - kMaskRadius;
        const auto at = static_cast<std::size_t>(y * width + x);
        for (std::size_t j = 0; j < kMaskSize; ++j) {
          smoothed[at] += mask.smoothing[j] * row[j];
          sloped[at] += mask.slope[j] * row[j];
        }
      }
    for (int y = 0; y < square.size; ++y)
      for (int x = 0; x < square.size; ++x) {
        Vector2d g = Vector2d::Zero();
        for (int j = 0; j < kMaskSize; ++j) {
          const auto at = static_cast<std::size_t>((y + j) * width + x);
          g += Vector2d(mask.smoothing[static_cast<std::size_t>(j)] * sloped[at],
                        mask.slope[static_cast<std::size_t>(j)] * smoothed[at]);
        }
        normals_[static_cast<std::size_t>(y * width + x)] =
            model == FoerstnerModel::kCorner ? g : Vector2d(-g.y(), g.x());
      }
  }
  [[nodiscard]] const Vector2d& at(int x, int y) const { return normals_[square_.index(x, y)]; }
  [[nodiscard]] const Square& square() const { return square_; }

 private:
  Square square_;
  std::vector<Vector2d> normals_;
};

// The normal equations at a point.
struct Equations {
  Matrix2d normal = Matrix2d::Zero();    // N
  Matrix2d jacobian = Matrix2d::Zero();  // J: N, and what the weights change as they follow the point
  Vector2d right = Vector2d::Zero();
  double misfit = 0, weights = 0;

  [[nodiscard]] double roundness() const {
    const double trace = normal.trace();
    return trace > 0 ? 4 * normal.determinant() / (trace * trace) : 0;
  }
};

class Location {
 public:
  Location(const Normals& normals, double sigma_px)
      : normals_(normals),
        sigma2_(sigma_px * sigma_px),
        radius_(static_cast<int>(std::ceil(kWindowSigmas * sigma_px))) {}

  /// Calls visit(x, y, weight, normal, pixel minus point) for every pixel of the window around `middle`; false where it
  /// leaves the part of the image that is there.
  template <class Visit>
  bool visit(const Vector2d& middle, const Vector2d& point, const Visit& visit) const {
    const int column = static_cast<int>(std::floor(middle.x())), row = static_cast<int>(std::floor(middle.y()));
    const Square& s = normals_.square();
    if (column - radius_ < s.left || row - radius_ < s.top || column + radius_ >= s.left + s.size ||
        row + radius_ >= s.top + s.size)
      return false;
    for (int y = row - radius_; y <= row + radius_; ++y)
      for (int x = column - radius_; x <= column + radius_; ++x) {
        const Vector2d pixel(x + 0.5, y + 0.5);
        visit(x, y, std::exp(-0.5 * (pixel - middle).squaredNorm() / sigma2_), normals_.at(x, y), pixel - point);
      }
    return true;
  }

  [[nodiscard]] std::optional<Equations> equations(const Vector2d& middle, const Vector2d& point) const {
    Equations e;
    const bool is_inside = visit(middle, point, [&](int, int, double w, const Vector2d& v, const Vector2d& d) {
      const double distance = v.dot(d);
      e.normal += w * v * v.transpose();
      e.jacobian -= (w * distance / sigma2_) * v * d.transpose();
      e.right += w * distance * v;
      e.misfit += w * distance * distance;
      e.weights += w;
    });
    if (!is_inside || !(e.roundness() >= kLeastRoundness)) return std::nullopt;
    e.jacobian += e.normal;
    return e;
  }

  /// C: the sum over pixels of the squared derivatives of the right side by their grey value.
  [[nodiscard]] Matrix2d spread(const Vector2d& middle, const Vector2d& point, FoerstnerModel model) const {
    const Mask& mask = derivative_mask();
    const int size = 2 * (radius_ + kMaskRadius) + 1;
    const Square square{static_cast<int>(std::floor(middle.x())) - radius_ - kMaskRadius,
                        static_cast<int>(std::floor(middle.y())) - radius_ - kMaskRadius, size};
    std::vector<Vector2d> by_pixel(static_cast<std::size_t>(size * size), Vector2d::Zero());
    visit(middle, point, [&](int x, int y, double w, const Vector2d& v, const Vector2d& d) {
      Matrix2d by_gradient = w * (v.dot(d) * Matrix2d::Identity() + v * d.transpose());
      if (model == FoerstnerModel::kCircle) {
        Matrix2d rotation;
        rotation << 0, -1, 1, 0;
        by_gradient = by_gradient * rotation;
      }
      for (int j = 0; j < kMaskSize; ++j)
        for (int i = 0; i < kMaskSize; ++i) {
          const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
          by_pixel[square.index(x + i - kMaskRadius, y + j - kMaskRadius)] +=
              by_gradient * Vector2d(mask.slope[a] * mask.smoothing[b], mask.smoothing[a] * mask.slope[b]);
        }
    });
    Matrix2d sum = Matrix2d::Zero();
    for (const Vector2d& c : by_pixel) sum += c * c.transpose();
    return sum;
  }

 private:
  const Normals& normals_;
  double sigma2_;
  int radius_;
};

// The pixels that windows around points near the start can reach, as far as the image goes.
std::optional<Square> reach(const GreyImage& image, const Vector2d& start, double sigma_px) {
  const int half = static_cast<int>(std::ceil((kWindowSigmas + kFarthestSigmas) * sigma_px)) + 1;
  const int column = static_cast<int>(std::floor(start.x())), row = static_cast<int>(std::floor(start.y()));
  const int room = std::min({column, row, image.width - 1 - column, image.height - 1 - row}) - kMaskRadius;
  const int radius = std::min(half, room);
  if (radius < static_cast<int>(std::ceil(kWindowSigmas * sigma_px))) return std::nullopt;
  return Square{column - radius, row - radius, 2 * radius + 1};
}

}  // namespace

std::optional<FoerstnerPoint> foerstner_point(const GreyImage& image, const Vector2d& start_px, double sigma_px,
                                              FoerstnerModel model, FoerstnerWindow window, double noise_grey) {
  const auto square = reach(image, start_px, sigma_px);
  if (!square) return std::nullopt;
  const Normals normals(image, *square, model);
  const Location location(normals, sigma_px);
  Vector2d middle = start_px;  // of the window
  for (int step = 0; step < kMostSteps; ++step) {
    const auto at = location.equations(middle, middle);
    if (!at) return std::nullopt;
    const Vector2d shift = at->normal.inverse() * at->right, point = middle + shift;
    if (!((point - start_px).norm() <= kFarthestSigmas * sigma_px)) return std::nullopt;
    if (window == FoerstnerWindow::kFollowing && shift.norm() > kConverged_px) {
      middle = point;
      continue;
    }
    const auto last = location.equations(middle, point);
    if (!last) return std::nullopt;
    const Matrix2d jacobian = window == FoerstnerWindow::kFixed ? last->normal : last->jacobian;
    if (!(std::abs(jacobian.determinant()) > 1e-6 * last->normal.determinant())) return std::nullopt;
    const Matrix2d inverse = jacobian.inverse();
    FoerstnerPoint found{.position_px = point, .covariance_px2 = {}};
    found.covariance_px2 =
        noise_grey * noise_grey * inverse * location.spread(middle, point, model) * inverse.transpose();
    found.roundness = last->roundness();
    found.weight = last->normal.determinant() / last->normal.trace() / last->weights;
    found.misfit = last->misfit / last->weights;
    return found;
  }
  return std::nullopt;
}

double noise_of(const GreyImage& image) {
  if (image.width < 3 || image.height < 3) return kRounding_grey;
  // |second difference in x and y|: 16 times 255 at most.
  std::vector<std::uint64_t> histogram(16 * 255 + 1);
  for (int y = 1; y + 1 < image.height; ++y) {
    const std::uint8_t *a = image.row(y - 1), *b = image.row(y), *c = image.row(y + 1);
    for (int x = 1; x + 1 < image.width; ++x) {
      const int value = a[x - 1] + a[x + 1] + c[x - 1] + c[x + 1] - 2 * (a[x] + b[x - 1] + b[x + 1] + c[x]) + 4 * b[x];
      ++histogram[static_cast<std::size_t>(std::abs(value))];
    }
  }
  std::uint64_t total = 0, below = 0;
  for (const std::uint64_t n : histogram) total += n;
  std::size_t median = 0;
  while (2 * (below + histogram[median]) < total) below += histogram[median++];
  // Within the class of the median values are taken as spread evenly, from half below it to half above.
  const double inside = (0.5 * static_cast<double>(total) - static_cast<double>(below)) /
                        static_cast<double>(std::max<std::uint64_t>(1, histogram[median]));
  const double exact = median == 0 ? 0.5 * inside : static_cast<double>(median) - 0.5 + inside;
  return std::max(kRounding_grey, exact / (0.674489750196082 * 6));  // 36: the sum of the squared coefficients
}

}  // namespace collinea
