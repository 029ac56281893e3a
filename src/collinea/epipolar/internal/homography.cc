// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/homography.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "collinea/epipolar/internal/matrix_fit.h"
#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

// Coefficients that make p[3] from p[0], p[1], p[2] (homogeneous), up to a common factor: one is 0 when three of the
// four lie on a line with p[3], their sum when p[0], p[1], p[2] do.
Eigen::Vector3d bracket(const std::array<Eigen::Vector2d, 4>& p) {
  const auto area = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  return {area(p[3], p[1], p[2]), area(p[0], p[3], p[2]), area(p[0], p[1], p[3])};
}

bool collinear(const std::array<Eigen::Vector2d, 4>& p, const Eigen::Vector3d& bracket) {
  const double whole = std::abs(bracket.sum());  // the area of p[0] p[1] p[2]
  double size = 0;
  for (std::size_t i = 1; i < 4; ++i) size = std::max(size, (p[i] - p[0]).squaredNorm());
  return !(std::min(bracket.cwiseAbs().minCoeff(), whole) > 1e-9 * size);
}

// The 2x2 covariance of a transfer error and what follows from it, for one pair.
struct Transfer {
  double u, v, inverse_w;                  // H p
  double error_u, error_v;                 // [px of the second image]
  double weight_uu, weight_uv, weight_vv;  // inverse of the covariance for unit noise [1/px^2]
};

inline Transfer transfer(const double* h, double x1, double y1, double x2, double y2, double focal, double ratio) {
  Transfer t;
  t.inverse_w = 1 / (h[6] * x1 + h[7] * y1 + h[8]);
  t.u = (h[0] * x1 + h[1] * y1 + h[2]) * t.inverse_w;
  t.v = (h[3] * x1 + h[4] * y1 + h[5]) * t.inverse_w;
  t.error_u = focal * (t.u - x2);
  t.error_v = focal * (t.v - y2);
  const double scale = ratio * t.inverse_w;  // of the derivatives by the pixel of the first image
  const double ux = (h[0] - t.u * h[6]) * scale, uy = (h[1] - t.u * h[7]) * scale;
  const double vx = (h[3] - t.v * h[6]) * scale, vy = (h[4] - t.v * h[7]) * scale;
  const double c_uu = 1 + ux * ux + uy * uy, c_uv = ux * vx + uy * vy, c_vv = 1 + vx * vx + vy * vy;
  const double inverse_determinant = 1 / (c_uu * c_vv - c_uv * c_uv);
  t.weight_uu = c_vv * inverse_determinant;
  t.weight_uv = -c_uv * inverse_determinant;
  t.weight_vv = c_uu * inverse_determinant;
  return t;
}

// Pixels in a unit of the coordinates of one pair.
double focal_first_at(const PointPairs& pairs, int i) {
  return pairs.scale1.empty() ? pairs.focal_first_px : pairs.focal_first_px * pairs.scale1[std::size_t(i)];
}
double focal_second_at(const PointPairs& pairs, int i) {
  return pairs.scale2.empty() ? pairs.focal_second_px : pairs.focal_second_px * pairs.scale2[std::size_t(i)];
}

inline double squared(const Transfer& t) {
  return t.error_u * (t.weight_uu * t.error_u + 2 * t.weight_uv * t.error_v) + t.weight_vv * t.error_v * t.error_v;
}

// d(H p) / d(rows of H) = [p, 0, -u p; 0, p, -v p] / w: the normal equations are a Kronecker product of 3x3 with p p'.
MatrixNormal normal_equations(const Eigen::Matrix3d& homography, const PointPairs& pairs, std::span<const int> support,
                              double loss_px) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = homography;
  const double loss2 = loss_px * loss_px;
  MatrixNormal sum;
  for (const int i : support) {
    const double focal = focal_second_at(pairs, i), ratio = focal / focal_first_at(pairs, i);
    const Eigen::Vector2d first = pairs.first(i), second = pairs.second(i);
    const Transfer t = transfer(rows.data(), first.x(), first.y(), second.x(), second.y(), focal, ratio);
    const double cap = 1 / (1 + squared(t) / loss2);
    sum.cost += loss2 * (1 - cap);
    const double robust = cap * cap;
    const double scale = focal * t.inverse_w;
    const double su = t.weight_uu * t.error_u + t.weight_uv * t.error_v;
    const double sv = t.weight_uv * t.error_u + t.weight_vv * t.error_v;
    const Eigen::Vector3d g = Eigen::Vector3d(su, sv, -(t.u * su + t.v * sv)) * (robust * scale);
    const double wu = -(t.weight_uu * t.u + t.weight_uv * t.v), wv = -(t.weight_uv * t.u + t.weight_vv * t.v);
    Eigen::Matrix3d block;
    block << t.weight_uu, t.weight_uv, wu, t.weight_uv, t.weight_vv, wv, wu, wv, -(t.u * wu + t.v * wv);
    block *= robust * scale * scale;
    const Eigen::Vector3d p = first.homogeneous();
    const Eigen::Matrix3d pp = p * p.transpose();
    for (int a = 0; a < 3; ++a) {
      sum.gradient.segment<3>(3 * a) += g(a) * p;
      for (int b = 0; b <= a; ++b) sum.hessian.block<3, 3>(3 * a, 3 * b) += block(a, b) * pp;
    }
  }
  return sum;
}

// Homographies of Frobenius norm 1; steps are orthogonal to the matrix, whose scale is free.
struct HomographyChart {
  static constexpr int kFreedom = 8;
  Eigen::Matrix3d homography;

  [[nodiscard]] const Eigen::Matrix3d& matrix() const { return homography; }
  [[nodiscard]] Eigen::Matrix<double, 9, 8> tangent() const {
    // The reflection that takes h to the last axis takes the other axes to an orthonormal complement of h.
    Eigen::Matrix<double, 9, 1> v = by_rows(homography);
    v(8) += std::copysign(1.0, v(8));
    const double factor = 2 / v.squaredNorm();
    return Eigen::Matrix<double, 9, 8>::Identity() - factor * v * v.head<8>().transpose();
  }
  [[nodiscard]] HomographyChart moved(const Eigen::Matrix<double, 8, 1>& step) const {
    const Eigen::Matrix<double, 9, 1> change = tangent() * step;
    const Eigen::Matrix3d by_columns = Eigen::Map<const Eigen::Matrix3d>(change.data());
    return {(homography + by_columns.transpose()).normalized()};
  }
};

struct RotationChart {
  static constexpr int kFreedom = 3;
  Eigen::Quaterniond rotation;

  [[nodiscard]] Eigen::Matrix3d matrix() const { return rotation.toRotationMatrix(); }
  [[nodiscard]] Eigen::Matrix<double, 9, 3> tangent() const {
    const Eigen::Matrix3d r = matrix();
    Eigen::Matrix<double, 9, 3> t;
    for (int i = 0; i < 3; ++i) t.col(i) = by_rows(skew(Eigen::Vector3d::Unit(i)) * r);
    return t;
  }
  [[nodiscard]] RotationChart moved(const Eigen::Vector3d& step) const {
    return {(rotation_by(step) * rotation).normalized()};
  }
};

constexpr int kMaxIterations = 12;

}  // namespace

std::optional<Eigen::Matrix3d> four_point(const std::array<Eigen::Vector2d, 4>& first,
                                          const std::array<Eigen::Vector2d, 4>& second) {
  const Eigen::Vector3d a = bracket(first), b = bracket(second);
  if (collinear(first, a) || collinear(second, b)) return std::nullopt;
  // w2 / w1 at the points: the same sign everywhere when the plane is in front of both cameras.
  const Eigen::Vector3d ratio = b.cwiseQuotient(a);
  const double sign = a.sum() * b.sum() > 0 ? 1 : -1;
  if (!((sign * ratio).minCoeff() > 0)) return std::nullopt;
  // H = B2 diag(b / a) inverse(B1); the columns of B are the points.
  Eigen::Matrix3d columns1, columns2;
  for (int i = 0; i < 3; ++i) {
    columns1.col(i) = first[static_cast<std::size_t>(i)].homogeneous();
    columns2.col(i) = (sign * ratio(i)) * Eigen::Vector3d(second[static_cast<std::size_t>(i)].homogeneous());
  }
  const Eigen::Matrix3d homography = columns2 * columns1.inverse();
  return homography.normalized();
}

void squared_errors(const Eigen::Matrix3d& homography, const PointPairs& pairs, int begin, int end, double* out) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = homography;
  const double focal = pairs.focal_second_px, ratio = focal / pairs.focal_first_px;
  const double *x1 = pairs.x1.data(), *y1 = pairs.y1.data(), *x2 = pairs.x2.data(), *y2 = pairs.y2.data();
  if (!pairs.scale1.empty()) {
    for (int i = begin; i < end; ++i) {
      const double own = focal_second_at(pairs, i);
      out[i - begin] = squared(transfer(rows.data(), x1[i], y1[i], x2[i], y2[i], own, own / focal_first_at(pairs, i)));
    }
    return;
  }
  for (int i = begin; i < end; ++i)
    out[i - begin] = squared(transfer(rows.data(), x1[i], y1[i], x2[i], y2[i], focal, ratio));
}

std::optional<Eigen::Matrix3d> refine_homography(const Eigen::Matrix3d& start, const PointPairs& pairs,
                                                 std::span<const int> support, double loss_px) {
  if (support.size() < 4) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& h) { return normal_equations(h, pairs, support, loss_px); };
  const auto fit = fit_matrix(HomographyChart{start.normalized()}, normal_at, kMaxIterations);
  if (!fit) return std::nullopt;
  return fit->value.homography;
}

Few<PlanarMotion, 2> planar_motions(const Eigen::Matrix3d& homography, const PointPairs& pairs,
                                    std::span<const int> support) {
  Few<PlanarMotion, 2> found;
  double side = 0;
  for (const int i : support)
    side += pairs.second(i).homogeneous().dot(homography * pairs.first(i).homogeneous()) > 0 ? 1 : -1;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(homography, Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues() / svd.singularValues()(1);
  const Eigen::Matrix3d h = homography * ((side < 0 ? -1 : 1) / svd.singularValues()(1));
  const double s1 = singular(0) * singular(0), s3 = singular(2) * singular(2);
  if (!std::isfinite(s1) || !(s1 - s3 > 1e-9)) return found;
  const Eigen::Vector3d v1 = svd.matrixV().col(0), v2 = svd.matrixV().col(1), v3 = svd.matrixV().col(2);
  for (const double sign : {1.0, -1.0}) {
    // v2 and u span a plane whose lengths H keeps; its normal is the normal of the scene plane.
    const Eigen::Vector3d u =
        (std::sqrt(std::max(0.0, 1 - s3)) * v1 + sign * std::sqrt(std::max(0.0, s1 - 1)) * v3) / std::sqrt(s1 - s3);
    Eigen::Matrix3d from, to;
    from << v2, u, v2.cross(u);
    to << h * v2, h * u, (h * v2).cross(h * u);
    const Eigen::Matrix3d rotation = to * from.transpose();
    Eigen::Vector3d normal = v2.cross(u);
    double front = 0;
    for (const int i : support) front += normal.dot(pairs.first(i).homogeneous()) > 0 ? 1 : -1;
    if (front < 0) normal = -normal;
    const Eigen::Vector3d translation = (h - rotation) * normal;
    const double length = translation.norm();
    if (!(length > 1e-9)) continue;
    found.add({Rigid3{Eigen::Quaterniond(rotation).normalized(), translation / length}, normal, length});
  }
  return found;
}

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& homography) {
  const Eigen::Matrix3d h = homography.determinant() < 0 ? Eigen::Matrix3d(-homography) : homography;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0) rotation = -rotation;
  return Eigen::Quaterniond(rotation).normalized();
}

std::optional<Eigen::Quaterniond> refine_rotation(const Eigen::Quaterniond& start, const PointPairs& pairs,
                                                  std::span<const int> support, double loss_px) {
  if (support.size() < 2) return std::nullopt;
  const auto normal_at = [&](const Eigen::Matrix3d& r) { return normal_equations(r, pairs, support, loss_px); };
  const auto fit = fit_matrix(RotationChart{start}, normal_at, kMaxIterations);
  if (!fit) return std::nullopt;
  return fit->value.rotation;
}

}  // namespace collinea
