// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/relative.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "collinea/epipolar/internal/epipolar_kernels.h"
#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/internal/matrix_fit.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Sum over the pairs of the squared Sampson distances r = c / sqrt(d), capped, with c = q' M p and
// d = |(M p)_xy|^2 / f2^2 + |(M' q)_xy|^2 / f1^2:
//   dr/dM = q p' / sqrt(d) - c / d^1.5 ((M p)_xy0 p' / f2^2 + q (M' q)_xy0' / f1^2).
// Of absolute distances, the cost 2 |r| rounded off within loss_px: r has the weight 1 / |r| (reweighted least
// squares).
template <bool kAbsolute = false>
MatrixNormal normal_equations(const Eigen::Matrix3d& matrix, const PointPairs& pairs, std::span<const int> support,
                              double loss_px) {
  double w1 = 1 / (pairs.focal_first_px * pairs.focal_first_px);
  double w2 = 1 / (pairs.focal_second_px * pairs.focal_second_px);
  const bool varies = !pairs.scale1.empty();
  const double inverse_loss2 = 1 / (loss_px * loss_px);
  MatrixNormal sum;
  Eigen::Matrix<double, 9, 1> row;
  for (const int i : support) {
    const Eigen::Vector3d p = pairs.first(i).homogeneous(), q = pairs.second(i).homogeneous();
    const Eigen::Vector3d line2 = matrix * p, line1 = matrix.transpose() * q;
    const double c = q.dot(line2);
    if (varies) [[unlikely]] {
      const Eigen::Vector2d pixels = pairs.squared_pixels(i);
      w1 = pixels[0], w2 = pixels[1];
    }
    const double d = w2 * line2.head<2>().squaredNorm() + w1 * line1.head<2>().squaredNorm();
    const double inverse_root = 1 / std::sqrt(d), r = c * inverse_root, slope = r / d;
    double cap;
    if constexpr (kAbsolute) {
      const double length = std::hypot(r, loss_px);
      cap = 1 / std::sqrt(length);
      sum.cost += 2 * length;
    } else {
      cap = 1 / (1 + r * r * inverse_loss2);
      sum.cost += r * r * cap;
    }
    const Eigen::Vector3d left = q * inverse_root - Eigen::Vector3d(line2.x(), line2.y(), 0) * (slope * w2);
    const Eigen::Vector3d right = Eigen::Vector3d(line1.x(), line1.y(), 0) * (slope * w1);
    for (int a = 0; a < 3; ++a) row.segment<3>(3 * a) = left(a) * p - q(a) * right;
    row *= cap;  // the weight is cap^2
    const double weighted = r * cap;
    for (int a = 0; a < 9; ++a) {
      sum.gradient(a) += row(a) * weighted;
      for (int b = a; b < 9; ++b) sum.hessian(b, a) += row(a) * row(b);
    }
  }
  return sum;
}

struct MotionChart {
  static constexpr int kFreedom = 5;
  Rigid3 motion;

  [[nodiscard]] Eigen::Matrix3d matrix() const { return essential_matrix(motion); }

  // Two unit vectors orthogonal to the translation and to each other.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> sideways() const {
    int smallest = 0;
    motion.translation.cwiseAbs().minCoeff(&smallest);
    Eigen::Matrix<double, 3, 2> b;
    b.col(0) = motion.translation.cross(Eigen::Vector3d::Unit(smallest)).normalized();
    b.col(1) = motion.translation.cross(b.col(0)).normalized();
    return b;
  }
  [[nodiscard]] Eigen::Matrix<double, 9, 5> tangent() const {
    const Eigen::Matrix3d r = motion.rotation.toRotationMatrix(), cross = skew(motion.translation);
    const Eigen::Matrix<double, 3, 2> b = sideways();
    Eigen::Matrix<double, 9, 5> t;
    for (int i = 0; i < 3; ++i) t.col(i) = by_rows(cross * skew(Eigen::Vector3d::Unit(i)) * r);
    for (int i = 0; i < 2; ++i) t.col(3 + i) = by_rows(skew(b.col(i)) * r);
    return t;
  }
  [[nodiscard]] MotionChart moved(const Eigen::Matrix<double, 5, 1>& step) const {
    return {Rigid3{(rotation_by(step.head<3>()) * motion.rotation).normalized(),
                   (motion.translation + sideways() * step.tail<2>()).normalized()}};
  }
};

// The matrix of uncorrected coordinates: D2 E D1 with D = diag(1/k, 1/k, 1) where the focal length is in doubt.
struct FocalMotionChart {
  static constexpr int kFreedom = 6;
  MotionChart chart;
  double log_factor;
  FocalDoubt doubt;

  [[nodiscard]] Eigen::Matrix3d matrix() const { return corrected(chart.matrix()); }
  [[nodiscard]] Eigen::Matrix3d corrected(Eigen::Matrix3d m) const {
    const double inverse = std::exp(-log_factor);
    if (doubt.second) m.topRows<2>() *= inverse;
    if (doubt.first) m.leftCols<2>() *= inverse;
    return m;
  }
  [[nodiscard]] Eigen::Matrix<double, 9, 6> tangent() const {
    const Eigen::Matrix<double, 9, 5> motion = chart.tangent();
    Eigen::Matrix<double, 9, 6> t;
    for (int i = 0; i < 5; ++i)
      t.col(i) =
          by_rows(corrected(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(motion.col(i).data())));
    const Eigen::Matrix3d m = matrix();
    Eigen::Matrix3d by_log_factor = Eigen::Matrix3d::Zero();
    if (doubt.second) by_log_factor.topRows<2>() -= m.topRows<2>();
    if (doubt.first) by_log_factor.leftCols<2>() -= m.leftCols<2>();
    t.col(5) = by_rows(by_log_factor);
    return t;
  }
  [[nodiscard]] FocalMotionChart moved(const Eigen::Matrix<double, 6, 1>& step) const {
    return {chart.moved(step.head<5>()), log_factor + std::clamp(step(5), -0.3, 0.3), doubt};
  }
  [[nodiscard]] double prior_cost() const { return log_factor * log_factor / (doubt.sigma * doubt.sigma); }
  void add_prior(Eigen::Matrix<double, 6, 6>& hessian, Eigen::Matrix<double, 6, 1>& gradient) const {
    hessian(5, 5) += 1 / (doubt.sigma * doubt.sigma);
    gradient(5) += log_factor / (doubt.sigma * doubt.sigma);
  }
};

// F = left diag(1, ratio, 0) right'.
struct RankTwoChart {
  static constexpr int kFreedom = 7;
  Eigen::Matrix3d left, right;
  double ratio;

  explicit RankTwoChart(const Eigen::Matrix3d& m) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    left = svd.matrixU();
    right = svd.matrixV();
    ratio = svd.singularValues()(1) / svd.singularValues()(0);
  }
  [[nodiscard]] Eigen::Matrix3d matrix() const {
    return left.col(0) * right.col(0).transpose() + ratio * left.col(1) * right.col(1).transpose();
  }
  [[nodiscard]] Eigen::Matrix<double, 9, 7> tangent() const {
    const Eigen::Matrix3d f = matrix();
    Eigen::Matrix<double, 9, 7> t;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Matrix3d rotation = skew(Eigen::Vector3d::Unit(i));
      t.col(i) = by_rows(rotation * f);
      t.col(3 + i) = by_rows(-f * rotation);
    }
    t.col(6) = by_rows(left.col(1) * right.col(1).transpose());
    return t;
  }
  [[nodiscard]] RankTwoChart moved(const Eigen::Matrix<double, 7, 1>& step) const {
    RankTwoChart next = *this;
    next.left = rotation_by(step.head<3>()) * left;
    next.right = rotation_by(step.segment<3>(3)) * right;
    next.ratio = ratio + step(6);
    return next;
  }
};

constexpr int kMaxIterations = 12;

}  // namespace

void squared_epipolar_errors(const Eigen::Matrix3d& m, const PointPairs& pairs, int begin, int end, double* out) {
  const std::array<double, 9> rows = {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
  const auto from = [&](int i) {
    return PairRows{pairs.x1.data() + i, pairs.y1.data() + i, pairs.x2.data() + i, pairs.y2.data() + i};
  };
  if (pairs.scale1.empty()) {
    const double w1 = 1 / (pairs.focal_first_px * pairs.focal_first_px);
    const double w2 = 1 / (pairs.focal_second_px * pairs.focal_second_px);
    return sampson_distances(rows, from(begin), end - begin, {&w1, &w2, false}, out);
  }
  constexpr int kBlock = 64;
  std::array<double, kBlock> w1, w2;
  for (int at = begin; at < end; at += kBlock) {
    const int count = std::min(kBlock, end - at);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixels = pairs.squared_pixels(at + i);
      w1[static_cast<std::size_t>(i)] = pixels[0], w2[static_cast<std::size_t>(i)] = pixels[1];
    }
    sampson_distances(rows, from(at), count, {w1.data(), w2.data(), true}, out + at - begin);
  }
}

std::optional<RelativeFit> refine_relative(const Rigid3& start, const PointPairs& pairs, std::span<const int> support,
                                           double loss_px) {
  if (support.size() < 5) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& e) { return normal_equations(e, pairs, support, loss_px); };
  const auto fit = fit_matrix(MotionChart{{start.rotation, start.translation.normalized()}}, normal_at, kMaxIterations);
  if (!fit) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix<double, 5, 5>> solver(fit->hessian);
  if (!(solver.vectorD().minCoeff() > 1e-14 * solver.vectorD().maxCoeff())) return std::nullopt;
  RelativeFit result;
  result.second_from_first = fit->value.motion;
  result.rms_px = std::sqrt(fit->cost / static_cast<double>(support.size()));
  result.covariance = solver.solve(Eigen::Matrix<double, 5, 5>::Identity());
  return result;
}

std::optional<Rigid3> refine_relative_absolute(const Rigid3& start, const PointPairs& pairs) {
  constexpr double kRounded_px = 1e-3;
  constexpr int kMostIterations = 40;  // reweighting converges linearly
  std::vector<int> all(static_cast<std::size_t>(pairs.size()));
  std::iota(all.begin(), all.end(), 0);
  if (all.size() < 5) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& e) { return normal_equations<true>(e, pairs, all, kRounded_px); };
  const auto fit =
      fit_matrix(MotionChart{{start.rotation, start.translation.normalized()}}, normal_at, kMostIterations);
  if (!fit) return std::nullopt;
  return fit->value.motion;
}

std::optional<RelativeFocalFit> refine_relative_and_focal(const Rigid3& start, const PointPairs& pairs,
                                                          std::span<const int> support, double loss_px,
                                                          const FocalDoubt& doubt) {
  if (support.size() < 6) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& m) { return normal_equations(m, pairs, support, loss_px); };
  const MotionChart motion{{start.rotation, start.translation.normalized()}};
  const auto fit = fit_matrix(FocalMotionChart{motion, 0, doubt}, normal_at, 2 * kMaxIterations);
  if (!fit) return std::nullopt;
  return RelativeFocalFit{fit->value.chart.motion, std::exp(fit->value.log_factor)};
}

std::optional<Eigen::Matrix3d> refine_fundamental(const Eigen::Matrix3d& start, const PointPairs& pairs,
                                                  std::span<const int> support, double loss_px) {
  if (support.size() < 7) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& f) { return normal_equations(f, pairs, support, loss_px); };
  const auto fit = fit_matrix(RankTwoChart(start), normal_at, kMaxIterations);
  if (!fit) return std::nullopt;
  return fit->value.matrix().normalized();
}

}  // namespace collinea
