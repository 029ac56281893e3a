// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/resection.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "collinea/base/result.h"
#include "collinea/epipolar/p3p.h"
#include "collinea/epipolar/robust.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/least_median.h"

namespace collinea {
namespace {

struct View {
  Rigid3 cam_from_world;
  Camera camera;
};

template <int N>
struct ViewNormal {
  Eigen::Matrix<double, N, N> hessian = Eigen::Matrix<double, N, N>::Zero();
  Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();
  double cost = 0;
};

struct Measured {
  std::span<const Eigen::Vector2d> pixels;
  std::span<const Eigen::Vector3d> points_in_world;
};

// What an error counts: capped smoothly (Geman, McClure), or by its length (rounded off within the given one).
struct ErrorLoss {
  double loss_px = 0;
  bool is_absolute = false;

  // The root of the weight of an error, which adds to the cost.
  double root_weight(double squared, double& cost) const {
    if (is_absolute) {
      const double length = std::sqrt(squared + loss_px * loss_px);
      cost += 2 * length;
      return 1 / std::sqrt(length);
    }
    const double loss2 = loss_px * loss_px, cap = 1 / (1 + squared / loss2);
    cost += loss2 * (1 - cap);
    return cap;
  }
  // Of a point that is not seen.
  [[nodiscard]] double farthest() const { return is_absolute ? 2e5 : loss_px * loss_px; }
};

// Unknowns: rotation about the projection centre and shift, both in the camera, and when N is 7 the logarithm of the
// focal length.
template <int N>
ViewNormal<N> normal_equations(const View& view, const Measured& measured, std::span<const int> support,
                               const ErrorLoss& loss) {
  const Eigen::Matrix3d rotation = view.cam_from_world.rotation.toRotationMatrix();
  ViewNormal<N> sum;
  for (const int i : support) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3d point_in_cam = rotation * measured.points_in_world[k] + view.cam_from_world.translation;
    Matrix23 by_point;
    Matrix2P by_params;
    const auto pixel = project(view.camera, point_in_cam, &by_point, N > 6 ? &by_params : nullptr);
    if (!pixel) {
      sum.cost += loss.farthest();
      continue;
    }
    const Eigen::Vector2d error = *pixel - measured.pixels[k];
    const double cap = loss.root_weight(error.squaredNorm(), sum.cost);
    Eigen::Matrix<double, 2, N> j;
    j.template leftCols<3>() = -by_point * skew(point_in_cam);
    j.template middleCols<3>(3) = by_point;
    if constexpr (N > 6) j.col(6) = by_params.col(Camera::kF) * view.camera.focal_px();
    j *= cap;
    sum.hessian.noalias() += j.transpose() * j;
    sum.gradient.noalias() += j.transpose() * (cap * error);
  }
  return sum;
}

template <int N>
View moved(const View& view, const Eigen::Matrix<double, N, 1>& step) {
  View next = view;
  next.cam_from_world = Rigid3{rotation_by(step.template head<3>()), step.template segment<3>(3)} * view.cam_from_world;
  if constexpr (N > 6) {
    const double factor = std::exp(std::clamp(step(6), -0.5, 0.5));
    next.camera.params[Camera::kF] *= factor;
    next.camera.params[Camera::kB1] *= factor;
    next.camera.params[Camera::kB2] *= factor;
  }
  return next;
}

// The step of the damped normal equations; nothing when some combination of the unknowns has no effect.
template <int N>
std::optional<Eigen::Matrix<double, N, 1>> solved(const ViewNormal<N>& normal, double damping) {
  const Eigen::Matrix<double, N, 1> scale = normal.hessian.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  Eigen::Matrix<double, N, N> system = scale.asDiagonal() * normal.hessian * scale.asDiagonal();
  if (!(system.ldlt().vectorD().minCoeff() > 1e-11)) return std::nullopt;
  system.diagonal().array() += damping;
  return scale.asDiagonal() * system.ldlt().solve(-scale.cwiseProduct(normal.gradient));
}

template <int N>
std::optional<View> refined(const View& start, const Measured& measured, std::span<const int> support,
                            const ErrorLoss& loss, int most_iterations = 20) {
  View best = start;
  auto normal = normal_equations<N>(best, measured, support, loss);
  if (!std::isfinite(normal.cost)) return std::nullopt;
  double damping = 1e-6;
  for (int iteration = 0; iteration < most_iterations && damping < 1e4; ++iteration) {
    const auto solution = solved<N>(normal, damping);
    if (!solution) return std::nullopt;
    const Eigen::Matrix<double, N, 1>& step = *solution;
    const double predicted = -step.dot(normal.gradient);
    const View candidate = moved<N>(best, step);
    const auto at_candidate = normal_equations<N>(candidate, measured, support, loss);
    if (!(at_candidate.cost <= normal.cost)) {
      if (predicted < 1e-9 * normal.cost) break;
      damping = std::max(1e-3, damping * 10);
      continue;
    }
    best = candidate;
    normal = at_candidate;
    damping = std::max(1e-9, damping / 10);
    if (predicted < 1e-9 * normal.cost + 1e-20) break;
  }
  return best;
}

// Scores with the pinhole part of the camera only, in undistorted coordinates: the full model is for the refinement.
class PoseProblem {
 public:
  using Model = Rigid3;
  static constexpr int kSample = 3;

  PoseProblem(const Camera& camera, const Measured& measured, double loss_px)
      : camera_(camera), measured_(measured), loss_px_(loss_px) {
    const std::size_t count = measured.pixels.size();
    for (auto* values : {&x_, &y_, &focal2_}) values->reserve(count);
    for (const Eigen::Vector2d& pixel : measured.pixels) {
      const Eigen::Vector2d xy = normalized(camera, pixel);
      x_.push_back(xy.x());
      y_.push_back(xy.y());
      const double focal = pixels_per_unit(camera, xy);
      focal2_.push_back(focal * focal);
    }
  }

  [[nodiscard]] int size() const { return static_cast<int>(x_.size()); }

  [[nodiscard]] Few<Rigid3, 4> solve(const std::array<int, 3>& sample) const {
    std::array<Eigen::Vector3d, 3> rays, points;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(sample[k]);
      rays[k] = Eigen::Vector3d(x_[i], y_[i], 1).normalized();
      points[k] = measured_.points_in_world[i];
    }
    return p3p(rays, points);
  }

  void squared_errors(const Rigid3& cam_from_world, int begin, int end, double* out) const {
    const Eigen::Matrix3d r = cam_from_world.rotation.toRotationMatrix();
    const Eigen::Vector3d& t = cam_from_world.translation;
    for (int i = begin; i < end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector3d& p = measured_.points_in_world[k];
      const double z = r(2, 0) * p.x() + r(2, 1) * p.y() + r(2, 2) * p.z() + t.z(), w = 1 / z;
      const double ex = (r(0, 0) * p.x() + r(0, 1) * p.y() + r(0, 2) * p.z() + t.x()) * w - x_[k];
      const double ey = (r(1, 0) * p.x() + r(1, 1) * p.y() + r(1, 2) * p.z() + t.y()) * w - y_[k];
      out[i - begin] = z > 0 ? focal2_[k] * (ex * ex + ey * ey) : std::numeric_limits<double>::infinity();
    }
  }

  [[nodiscard]] std::optional<Rigid3> refine(const Rigid3& start, std::span<const int> support) const {
    const auto view = refined<6>({start, camera_}, measured_, support, {loss_px_});
    if (!view) return std::nullopt;
    return view->cam_from_world;
  }

  [[nodiscard]] std::optional<Rigid3> refine_absolute(const Rigid3& start) const {
    constexpr double kRounded_px = 1e-3;
    constexpr int kMostIterations = 60;  // reweighting converges linearly
    std::vector<int> all(x_.size());
    std::iota(all.begin(), all.end(), 0);
    const auto view = refined<6>({start, camera_}, measured_, all, {kRounded_px, true}, kMostIterations);
    if (!view) return std::nullopt;
    return view->cam_from_world;
  }

 private:
  const Camera& camera_;
  Measured measured_;
  double loss_px_;
  std::vector<double> x_, y_;   // undistorted image coordinates
  std::vector<double> focal2_;  // squared pixels in a squared unit of them
};

RobustOptions search_options(const ResectOptions& options) {
  RobustOptions search;
  search.max_error_px = options.max_error_px;
  search.confidence = options.confidence;
  search.max_trials = options.max_trials;
  search.min_inlier_ratio = options.min_inlier_ratio;
  return search;
}

// Pairs in random order, so that neighbours in the search are not neighbours in the image.
struct Shuffled {
  std::vector<int> order;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> points_in_world;

  Shuffled(const Measured& measured, Random& random)
      : order(shuffled(static_cast<int>(measured.pixels.size()), random)) {
    for (const int i : order) {
      pixels.push_back(measured.pixels[static_cast<std::size_t>(i)]);
      points_in_world.push_back(measured.points_in_world[static_cast<std::size_t>(i)]);
    }
  }
  [[nodiscard]] Measured measured() const { return {pixels, points_in_world}; }
};

std::vector<int> agreeing(const View& view, const Measured& measured, double max_error_px, double* squared_sum) {
  std::vector<int> items;
  for (std::size_t i = 0; i < measured.pixels.size(); ++i) {
    const auto pixel = project(view.camera, view.cam_from_world * measured.points_in_world[i]);
    if (!pixel) continue;
    const double squared = (*pixel - measured.pixels[i]).squaredNorm();
    if (!(squared < max_error_px * max_error_px)) continue;
    items.push_back(static_cast<int>(i));
    if (squared_sum) *squared_sum += squared;
  }
  return items;
}

// The last word: full model, all who agree, three times, because refinement may bring more to agree.
template <int N>
std::optional<Resection> concluded(View view, const Measured& measured, const ResectOptions& options) {
  for (int round = 0; round < 3; ++round) {
    const std::vector<int> support = agreeing(view, measured, options.max_error_px, nullptr);
    if (static_cast<int>(support.size()) < options.min_inliers) return std::nullopt;
    const auto better = refined<N>(view, measured, support, {options.max_error_px});
    if (!better) return std::nullopt;
    view = *better;
  }
  double squared_sum = 0;
  const std::vector<int> inliers = agreeing(view, measured, options.max_error_px, &squared_sum);
  const double ratio = static_cast<double>(inliers.size()) / static_cast<double>(measured.pixels.size());
  if (static_cast<int>(inliers.size()) < options.min_inliers || ratio < options.min_inlier_ratio) return std::nullopt;
  Resection result{view.cam_from_world, view.camera, std::vector<std::uint8_t>(measured.pixels.size()), 0, 0};
  for (const int i : inliers) result.inlier[static_cast<std::size_t>(i)] = 1;
  result.inliers = static_cast<int>(inliers.size());
  result.rms_px = std::sqrt(squared_sum / static_cast<double>(inliers.size()));
  return result;
}

Camera with_focal_factor(const Camera& camera, double factor) {
  Camera result = camera;
  for (const auto p : {Camera::kF, Camera::kB1, Camera::kB2}) result.params[p] *= factor;
  return result;
}

// Without a limit for errors but that which they show.
std::optional<Resection> resect_without_limit(const Camera& camera, const Measured& measured, const Measured& mixed,
                                              ResectOptions options, Random& random) {
  constexpr double kUncapped_px = 1e6;
  const auto fit = robust_start(PoseProblem(camera, mixed, kUncapped_px), options.start, 2, random);
  if (!fit) return std::nullopt;
  options.max_error_px = std::min(options.max_error_px, std::max(1.0, wrong_beyond(2) * fit->scale_px));
  return concluded<6>({fit->model, camera}, measured, options);
}

}  // namespace

std::optional<Resection> resect(const Camera& camera, std::span<const Eigen::Vector2d> pixels,
                                std::span<const Eigen::Vector3d> points_in_world, const ResectOptions& options,
                                std::uint64_t seed) {
  COLLINEA_CHECK(pixels.size() == points_in_world.size());
  if (static_cast<int>(pixels.size()) < options.min_inliers) return std::nullopt;
  Random random(seed);
  const Measured measured{pixels, points_in_world};
  const Shuffled mixed(measured, random);
  if (options.start != RobustStart::kTruncated)
    return resect_without_limit(camera, measured, mixed.measured(), options, random);
  const auto fit =
      robust_fit(PoseProblem(camera, mixed.measured(), options.max_error_px), search_options(options), random);
  if (!fit) return std::nullopt;
  return concluded<6>({fit->model, camera}, measured, options);
}

std::optional<Resection> resect_with_focal(const Camera& camera, std::span<const Eigen::Vector2d> pixels,
                                           std::span<const Eigen::Vector3d> points_in_world,
                                           const ResectOptions& options, std::uint64_t seed) {
  COLLINEA_CHECK(pixels.size() == points_in_world.size());
  if (static_cast<int>(pixels.size()) < std::max(4, options.min_inliers)) return std::nullopt;
  Random random(seed);
  const Measured measured{pixels, points_in_world};
  const Shuffled mixed(measured, random);
  RobustOptions search = search_options(options);
  search.max_error_px = 3 * options.max_error_px;  // neighbouring factors differ by up to a tenth
  search.max_trials = std::min(options.max_trials, 1000);

  std::optional<View> best;
  double least = std::numeric_limits<double>::infinity();
  for (const double factor : {1.0, 0.85, 1.18, 0.71, 1.4, 0.6, 1.67, 0.5, 2.0}) {
    const Camera trial = with_focal_factor(camera, factor);
    const auto fit = robust_fit(PoseProblem(trial, mixed.measured(), search.max_error_px), search, random);
    if (!fit) continue;
    const auto view = refined<7>({fit->model, trial}, mixed.measured(), fit->inliers, {search.max_error_px});
    if (!view) continue;
    double sum = 0;
    const auto inliers = agreeing(*view, mixed.measured(), options.max_error_px, &sum);
    const double outliers = static_cast<double>(pixels.size() - inliers.size());
    const double cost = sum + outliers * options.max_error_px * options.max_error_px;
    if (cost < least) {
      least = cost;
      best = view;
    }
  }
  if (!best) return std::nullopt;
  return concluded<7>(*best, measured, options);
}

}  // namespace collinea
