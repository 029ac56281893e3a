// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/robust_projection.h"

#include <algorithm>
#include <array>
#include <limits>

#include "collinea/epipolar/robust_start.h"
#include "collinea/math/least_median.h"

namespace collinea {
namespace {

using Matrix = Eigen::Matrix<double, 3, Eigen::Dynamic>;

double squared_error(const Matrix& matrix, const ProjectedPoint& point) {
  const Eigen::Index dimensions = matrix.cols() - 1;
  const Eigen::Vector3d at = matrix.leftCols(dimensions) * point.in_object.head(dimensions) + matrix.rightCols<1>();
  return at.z() > 0 ? (at.head<2>() / at.z() - point.in_image).squaredNorm() : std::numeric_limits<double>::infinity();
}

template <int kPoints>
class Problem {
 public:
  static constexpr int kSample = kPoints;
  using Model = Matrix;

  explicit Problem(std::span<const ProjectedPoint> points) : points_(points) {}
  [[nodiscard]] int size() const { return static_cast<int>(points_.size()); }
  [[nodiscard]] std::vector<Matrix> solve(const std::array<int, kSample>& sample) const {
    const auto matrix = linear_projection(selected(sample), kIsPlane);
    return matrix ? std::vector<Matrix>{*matrix} : std::vector<Matrix>{};
  }
  void squared_errors(const Matrix& matrix, int begin, int end, double* out) const {
    for (int i = begin; i < end; ++i) *out++ = squared_error(matrix, points_[static_cast<std::size_t>(i)]);
  }
  [[nodiscard]] std::optional<Matrix> refine(const Matrix& /*start*/, std::span<const int> support) const {
    const auto points = selected(support);
    const auto fit = kIsPlane ? fit_plane_projection(points) : fit_projection(points);
    return fit ? std::optional(fit->matrix) : std::nullopt;
  }

 private:
  static constexpr bool kIsPlane = kPoints == 4;

  [[nodiscard]] std::vector<ProjectedPoint> selected(std::span<const int> items) const {
    std::vector<ProjectedPoint> out;
    for (const int i : items) out.push_back(points_[static_cast<std::size_t>(i)]);
    return out;
  }

  std::span<const ProjectedPoint> points_;
};

template <int kPoints>
std::optional<RobustProjection> found(std::span<const ProjectedPoint> points, std::uint64_t seed) {
  if (points.size() < kPoints + 2) return std::nullopt;
  Random random(seed);
  const auto fit = robust_start(Problem<kPoints>(points), RobustStart::kLeastMedian, 2, random);
  if (!fit) return std::nullopt;
  RobustProjection out{{}, fit->scale_px};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double limit = wrong_beyond(2) * std::max(fit->scale_px, points[i].sigma);
    if (!(squared_error(fit->model, points[i]) <= limit * limit)) out.contradicting.push_back(i);
  }
  return out;
}

}  // namespace

std::optional<RobustProjection> robust_projection(std::span<const ProjectedPoint> points, bool is_plane,
                                                  std::uint64_t seed) {
  return is_plane ? found<4>(points, seed) : found<6>(points, seed);
}

}  // namespace collinea
