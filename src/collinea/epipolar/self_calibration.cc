// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/self_calibration.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/relative.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/epipolar/spatial_parallax.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/math/median.h"
#include "collinea/math/polynomial.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Least squares of a few residuals in a few unknowns by differences, damped.
VectorXd least_squares(VectorXd at, const std::function<VectorXd(const VectorXd&)>& residuals) {
  VectorXd value = residuals(at);
  double damping = 1e-6;
  for (int iteration = 0; iteration < 100 && value.allFinite(); ++iteration) {
    MatrixXd by(value.size(), at.size());
    for (Index k = 0; k < at.size(); ++k) {
      const double step = 1e-6 * std::max(1.0, std::abs(at[k]));
      VectorXd before = at, after = at;
      before[k] -= step;
      after[k] += step;
      by.col(k) = (residuals(after) - residuals(before)) / (2 * step);
    }
    MatrixXd normal = by.transpose() * by;
    normal.diagonal() *= 1 + damping;
    const VectorXd step = normal.ldlt().solve(-by.transpose() * value);
    if (!step.allFinite()) break;
    const VectorXd next = residuals(at + step);
    if (next.allFinite() && next.squaredNorm() < value.squaredNorm()) {
      at += step;
      value = next;
      damping = std::max(1e-12, damping / 10);
      if (step.norm() < 1e-12 * at.norm()) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  return at;
}

// Unknowns of K: log of the principal distance, principal point over it, log of the ratio of axes, skew over it.
Matrix3d calibration_by(const Matrix3d& start, const VectorXd& change) {
  Matrix3d k = start;
  const auto n = change.size();
  if (n > 0) k.topLeftCorner<2, 2>() *= std::exp(change[0]);
  if (n > 1) k.topRightCorner<2, 1>() += start(0, 0) * change.segment<2>(1);
  if (n > 3) {
    k(1, 1) *= std::exp(change[3]);
    k(0, 1) += start(0, 0) * change[4];
  }
  return k;
}

Matrix3d shifted_by(const Vector2d& principal_point, double size) {
  Matrix3d out = Matrix3d::Identity();
  out.topLeftCorner<2, 2>() /= size;
  out.topRightCorner<2, 1>() = -principal_point / size;
  return out;
}

// --- fundamental matrices --------------------------------------------------------------------------------------------

// Kruppa's equations of w = diag(x, x, 1), polynomials of x = c^2: u' w v = (u v - u3 v3) x + u3 v3.
using Linear = std::array<double, 2>;
Linear form(const Vector3d& u, const Vector3d& v) { return {u.z() * v.z(), u.head<2>().dot(v.head<2>())}; }
double at(const Linear& f, double x) { return f[0] + f[1] * x; }

std::array<double, 3> product(const Linear& a, const Linear& b) {
  return {a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]};
}

// --- Euclidean upgrade -----------------------------------------------------------------------------------------------

// The cameras in normalised coordinates, the first one [I|0], and what brings points of the model there.
struct Canonical {
  std::vector<ProjectionMatrix> matrices;
  Matrix4d from_model;  // canonical point = from_model * point
};

std::optional<Canonical> canonical_of(const ProjectiveModel& model, const Matrix3d& normalise) {
  Canonical out;
  out.from_model.topRows<3>() = normalise * model.matrices[0];
  const Eigen::JacobiSVD<Eigen::Matrix<double, 3, 4>> svd(out.from_model.topRows<3>(), Eigen::ComputeFullV);
  out.from_model.row(3) = svd.matrixV().col(3).transpose();
  const Eigen::FullPivLU<Matrix4d> lu(out.from_model);
  if (!lu.isInvertible()) return std::nullopt;
  const Matrix4d to_model = lu.inverse();
  for (const ProjectionMatrix& matrix : model.matrices) {
    const ProjectionMatrix m = normalise * matrix * to_model;
    out.matrices.push_back(m.normalized() * std::sqrt(3.0));
  }
  return out;
}

// Six residuals of each camera but the first (Bolognesi 5.47, the scale lambda eliminated by norms).
VectorXd quadric_residuals(const Canonical& cameras, const Matrix3d& k, const Vector3d& plane) {
  Eigen::Matrix<double, 4, 3> root;  // of the absolute dual quadric
  root << k, plane.transpose();
  const Matrix3d expected = (k * k.transpose()).normalized();
  VectorXd out(6 * static_cast<Index>(cameras.matrices.size() - 1));
  Index row = 0;
  for (std::size_t i = 1; i < cameras.matrices.size(); ++i) {
    const Matrix3d half = cameras.matrices[i] * root;
    const Matrix3d off = (half * half.transpose()).normalized() - expected;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) out[row++] = (a == b ? 1 : std::sqrt(2.0)) * off(a, b);
  }
  return out;
}

// The plane at infinity from one camera with known calibration, for either sign of it (Gherardi and Fusiello 2010):
// rows 2 and 3 of A + t r', the frame turned so that t is its x axis, are those of A; row 1 is their product.
std::optional<Vector3d> plane_by(const ProjectionMatrix& camera, const Matrix3d& k, double sign) {
  const Matrix3d inverse = k.inverse();
  const Vector3d t = sign * inverse * camera.col(3);
  if (!(t.norm() > 1e-9)) return std::nullopt;
  const Matrix3d turn = Eigen::Quaterniond::FromTwoVectors(t, Vector3d::UnitX()).toRotationMatrix();
  const Matrix3d w = turn * (sign * inverse * camera.leftCols<3>() * k);
  const Vector3d second = w.row(1), third = w.row(2);
  if (!(third.norm() > 1e-12)) return std::nullopt;
  const Vector3d first = second.cross(third) / third.norm();
  return Vector3d((first - w.row(0).transpose()) / t.norm());
}

struct Candidate {
  Matrix3d calibration;
  Vector3d plane;
  double cost;
};

// Cameras and points of a canonical model by T; the sign by which most points are before the cameras.
std::optional<EuclideanUpgrade> upgraded(const Canonical& cameras, const ProjectiveModel& model,
                                         const Candidate& candidate, const Matrix3d& normalise, std::size_t unit_base) {
  Matrix4d transformation = Matrix4d::Zero();
  transformation.topLeftCorner<3, 3>() = candidate.calibration;
  transformation.bottomLeftCorner<1, 3>() = candidate.plane.transpose();
  transformation(3, 3) = 1;
  EuclideanUpgrade out;
  out.plane_at_infinity = candidate.plane;
  const Matrix3d inverse = candidate.calibration.inverse();
  for (const ProjectionMatrix& matrix : cameras.matrices) {
    const ProjectionMatrix euclidean = inverse * matrix * transformation;
    const double scale = std::cbrt(euclidean.leftCols<3>().determinant());
    if (!(std::abs(scale) > 1e-9)) return std::nullopt;
    const auto rotation = rotation_nearest_to(euclidean.leftCols<3>() / scale);
    if (!rotation) return std::nullopt;
    out.bundles.cam_from_model.push_back({Eigen::Quaterniond(*rotation).normalized(), euclidean.col(3) / scale});
  }
  const Eigen::Matrix4Xd points = transformation.inverse() * cameras.from_model * model.points;
  const double base = centre_of(out.bundles.cam_from_model[unit_base]).norm();
  if (!(base > 1e-9)) return std::nullopt;
  int before = 0;
  for (Index p = 0; p < points.cols(); ++p) {
    if (std::abs(points(3, p)) < 1e-12) return std::nullopt;
    out.bundles.points.emplace_back(points.col(p).hnormalized() / base);
  }
  for (Rigid3& pose : out.bundles.cam_from_model) pose.translation /= base;
  for (const Vector3d& point : out.bundles.points)
    for (const Rigid3& pose : out.bundles.cam_from_model) before += (pose * point).z() > 0 ? 1 : -1;
  if (before < 0) {  // the mirrored model: points behind all cameras
    for (Vector3d& point : out.bundles.points) point = -point;
    for (Rigid3& pose : out.bundles.cam_from_model) pose.translation = -pose.translation;
  }
  for (const Vector3d& point : out.bundles.points)
    out.in_front += std::all_of(out.bundles.cam_from_model.begin(), out.bundles.cam_from_model.end(),
                                [&](const Rigid3& pose) { return (pose * point).z() > 0; });
  out.bundles.calibration = normalise.inverse() * candidate.calibration;
  out.misfit = std::sqrt(candidate.cost / (6.0 * double(cameras.matrices.size() - 1)));
  return out;
}

std::vector<Candidate> scanned(const Canonical& cameras) {
  constexpr int kFocals = 40;
  std::vector<Candidate> out;
  for (int step = 0; step < kFocals; ++step) {
    const double focal = 0.2 * std::pow(100, step / (kFocals - 1.0));
    Matrix3d k = Matrix3d::Identity();
    k(0, 0) = k(1, 1) = focal;
    Candidate best{k, Vector3d::Zero(), std::numeric_limits<double>::infinity()};
    for (std::size_t i = 1; i < cameras.matrices.size(); ++i)
      for (const double sign : {1.0, -1.0})
        if (const auto plane = plane_by(cameras.matrices[i], k, sign)) {
          const double cost = quadric_residuals(cameras, k, *plane).squaredNorm();
          if (cost < best.cost) best = {k, *plane, cost};
        }
    if (std::isfinite(best.cost)) out.push_back(best);
  }
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  return out;
}

Candidate refined(const Canonical& cameras, const Candidate& start, CalibrationUnknowns unknowns) {
  const Index of_k = count_of(unknowns);
  const auto split = [&](const VectorXd& x) {
    return std::pair(calibration_by(start.calibration, x.head(of_k)), Vector3d(x.tail<3>()));
  };
  VectorXd x = VectorXd::Zero(of_k + 3);
  x.tail<3>() = start.plane;
  x = least_squares(x, [&](const VectorXd& at) {
    const auto [k, plane] = split(at);
    return quadric_residuals(cameras, k, plane);
  });
  const auto [k, plane] = split(x);
  return {k, plane, quadric_residuals(cameras, k, plane).squaredNorm()};
}

}  // namespace

std::optional<double> focal_from_fundamental(const Matrix3d& fundamental, const Vector2d& principal_point) {
  // Coordinates about the principal point, of about unit size.
  Matrix3d shift = Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = principal_point;
  Matrix3d f = shift.transpose() * fundamental * shift;
  const double plane = f.topLeftCorner<2, 2>().norm();
  const double unit = plane > 0 ? std::max({std::sqrt(std::abs(f(2, 2)) / plane), f.col(2).head<2>().norm() / plane,
                                            f.row(2).head<2>().norm() / plane})
                                : 0;
  if (!(unit > 0 && std::isfinite(unit))) return std::nullopt;
  const Vector3d scale(unit, unit, 1);
  f = scale.asDiagonal() * f * scale.asDiagonal();
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double a = svd.singularValues()[0], b = svd.singularValues()[1];
  if (!(b > 1e-12 * a)) return std::nullopt;
  const Vector3d u1 = svd.matrixU().col(0), u2 = svd.matrixU().col(1), v1 = svd.matrixV().col(0),
                 v2 = svd.matrixV().col(1);
  const auto left = product(form(u2, u2), form(v2, v2)), right = product(form(u1, u1), form(v1, v1));
  std::array<double, 3> quadratic;
  for (std::size_t k = 0; k < 3; ++k) quadratic[k] = b * b * left[k] - a * a * right[k];
  const double largest = std::max({std::abs(quadratic[0]), std::abs(quadratic[1]), std::abs(quadratic[2])});
  if (!(largest > 1e-12 * a * a)) return std::nullopt;
  std::optional<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (const double x : real_roots(quadratic)) {
    if (!(x > 1e-12)) continue;
    // The middle one of Kruppa's equations, without denominators.
    const double off =
        std::abs(b * at(form(u2, u2), x) * at(form(v1, v2), x) + a * at(form(u1, u2), x) * at(form(v1, v1), x)) /
        (a * (1 + x) * (1 + x));
    if (off < least) {
      least = off;
      best = unit * std::sqrt(x);
    }
  }
  return best;
}

std::vector<PairFundamental> fundamentals_of_pairs(const ImageCoordinates& measured, const Vector2d& principal_point) {
  std::vector<PairFundamental> out;
  const double size = std::max(1e-12, (measured.xy[0].colwise() - principal_point).colwise().norm().maxCoeff());
  const Matrix3d normalise = shifted_by(principal_point, size);
  std::vector<int> all(static_cast<std::size_t>(measured.points()));
  std::iota(all.begin(), all.end(), 0);
  for (std::size_t i = 0; i < measured.images(); ++i)
    for (std::size_t j = i + 1; j < measured.images(); ++j) {
      PointPairs pairs;
      pairs.focal_first_px = pairs.focal_second_px = size;
      for (Index p = 0; p < measured.points(); ++p)
        pairs.add((measured.xy[i].col(p) - principal_point) / size, (measured.xy[j].col(p) - principal_point) / size);
      const auto linear = eight_point(pairs, all);
      if (!linear) continue;
      const auto fine = refine_fundamental(*linear, pairs, all, size);  // a loss so wide that it is none
      if (!fine) continue;
      PairFundamental pair{i, j, (normalise.transpose() * *fine * normalise).normalized(), {}};
      pair.focal = focal_from_fundamental(pair.fundamental, principal_point);
      out.push_back(pair);
    }
  return out;
}

std::optional<Matrix3d> calibration_from_fundamentals(std::span<const PairFundamental> pairs, const Matrix3d& start,
                                                      CalibrationUnknowns unknowns) {
  const Index count = count_of(unknowns);
  if (static_cast<Index>(2 * pairs.size()) < count || count == 0) return std::nullopt;
  std::vector<Vector3d> epipoles;  // in the second images
  for (const PairFundamental& pair : pairs)
    epipoles.push_back(Eigen::JacobiSVD<Matrix3d>(pair.fundamental, Eigen::ComputeFullU).matrixU().col(2));
  const auto residuals = [&](const VectorXd& change) {
    const Matrix3d k = calibration_by(start, change);
    VectorXd out(2 * static_cast<Index>(pairs.size()));
    Index row = 0;
    for (const PairFundamental& pair : pairs) {
      const Matrix3d e = k.transpose() * pair.fundamental * k;
      const Eigen::Matrix<double, 3, 2> across =
          tangents_of((k.inverse() * epipoles[static_cast<std::size_t>(row / 2)]).normalized());
      const Eigen::Matrix2d p = across.transpose() * e * e.transpose() * across;
      out[row++] = (p(0, 0) - p(1, 1)) / p.trace();
      out[row++] = 2 * p(0, 1) / p.trace();
    }
    return out;
  };
  const VectorXd change = least_squares(VectorXd::Zero(count), residuals);
  if (!change.allFinite() || std::abs(change[0]) > 3) return std::nullopt;
  // The equations must determine what is asked for.
  MatrixXd by(2 * static_cast<Index>(pairs.size()), count);
  for (Index k = 0; k < count; ++k) {
    VectorXd before = change, after = change;
    before[k] -= 1e-5;
    after[k] += 1e-5;
    by.col(k) = (residuals(after) - residuals(before)) / 2e-5;
  }
  const Eigen::JacobiSVD<MatrixXd> svd(by);
  if (!(svd.singularValues()[count - 1] > 1e-4)) return std::nullopt;
  return calibration_by(start, change);
}

std::vector<EuclideanUpgrade> euclidean_upgrades(const ProjectiveModel& model, const Vector2d& principal_point,
                                                 double size, CalibrationUnknowns unknowns, std::size_t unit_base) {
  std::vector<EuclideanUpgrade> out;
  if (model.matrices.size() < 3) return out;
  const Matrix3d normalise = shifted_by(principal_point, size);
  const auto cameras = canonical_of(model, normalise);
  if (!cameras) return out;
  constexpr std::size_t kStarts = 12, kKept = 4;
  std::vector<Candidate> starts = scanned(*cameras), found;
  for (std::size_t k = 0; k < std::min(kStarts, starts.size()); ++k) {
    // The principal distance alone first: a start far off takes the principal point along.
    Candidate candidate = refined(*cameras, starts[k], CalibrationUnknowns::kFocal);
    if (unknowns != CalibrationUnknowns::kFocal) candidate = refined(*cameras, candidate, unknowns);
    const bool is_known = std::any_of(found.begin(), found.end(), [&](const Candidate& other) {
      return (other.calibration - candidate.calibration).norm() < 1e-3 * candidate.calibration.norm() &&
             (other.plane - candidate.plane).norm() < 1e-3 * (1 + candidate.plane.norm());
    });
    if (!is_known && std::isfinite(candidate.cost)) found.push_back(candidate);
  }
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  for (const Candidate& candidate : found) {
    if (out.size() == kKept) break;
    if (const auto one = upgraded(*cameras, model, candidate, normalise, unit_base)) out.push_back(*one);
  }
  return out;
}

std::size_t farthest_from_first(const ImageBundles& bundles) {
  std::size_t farthest = 1;
  const Vector3d origin = centre_of(bundles.cam_from_model[0]);
  for (std::size_t i = 2; i < bundles.cam_from_model.size(); ++i)
    if ((centre_of(bundles.cam_from_model[i]) - origin).norm() >
        (1 + 1e-6) * (centre_of(bundles.cam_from_model[farthest]) - origin).norm())
      farthest = i;
  return farthest;
}

std::vector<BundleMark> marks_of(const ImageCoordinates& measured) {
  std::vector<BundleMark> marks;
  for (Index p = 0; p < measured.points(); ++p)
    for (std::size_t i = 0; i < measured.images(); ++i)
      marks.push_back({i, static_cast<std::size_t>(p), measured.xy[i].col(p), measured.sigma[i][p]});
  return marks;
}

namespace {

// The base to another image becomes the unit.
void rescale(ImageBundles& bundles, std::size_t unit_base) {
  const double base = (centre_of(bundles.cam_from_model[unit_base]) - centre_of(bundles.cam_from_model[0])).norm();
  for (Rigid3& pose : bundles.cam_from_model) pose.translation /= base;
  for (Vector3d& point : bundles.points) point /= base;
}

}  // namespace

Result<AdjustedBundles> self_calibrated(const ProjectiveModel& model, const ImageCoordinates& measured,
                                        std::span<const EuclideanUpgrade> upgrades, CalibrationUnknowns unknowns,
                                        std::size_t unit_base) {
  if (model.matrices.size() < 3)
    return fail(Errc::kIllPosed, "self-calibration needs three images: two leave the plane at infinity open");
  if (upgrades.empty()) return fail(Errc::kIllPosed, "no calibration makes the projective cameras Euclidean ones");
  const std::vector<BundleMark> marks = marks_of(measured);
  Result<AdjustedBundles> best =
      fail(Errc::kIllPosed,
           "no Euclidean upgrade has the points in front of the images: wrong points, or images "
           "so little turned against each other that the noise decides");
  bool is_adjusted = false;
  for (const EuclideanUpgrade& upgrade : upgrades) {
    if (static_cast<std::size_t>(upgrade.in_front) < upgrade.bundles.points.size()) continue;
    ImageBundles start = upgrade.bundles;
    rescale(start, unit_base);
    Result<AdjustedBundles> found = adjust_bundles(start, marks, unknowns, unit_base);
    // Of errors a critical motion says more than steps that do not settle.
    const bool says_less = !best && !found && found.error().code == Errc::kNotConverged && is_adjusted;
    if (!best ? !says_less : found && found->sigma0 < best->sigma0) best = std::move(found);
    is_adjusted = true;
  }
  return best;
}

Result<AdjustedBundles> calibrated(const ImageCoordinates& measured, const Matrix3d& calibration, std::size_t unit_base,
                                   std::uint64_t seed) {
  const Matrix3d inverse = calibration.inverse();
  const auto n = static_cast<std::size_t>(measured.points());
  std::vector<std::vector<Vector2d>> rays(measured.images());
  for (std::size_t i = 0; i < measured.images(); ++i)
    for (std::size_t p = 0; p < n; ++p)
      rays[i].emplace_back((inverse * Vector2d(measured.xy[i].col(static_cast<Index>(p))).homogeneous()).hnormalized());
  ImageBundles start;
  start.calibration = calibration;
  start.cam_from_model.resize(measured.images());
  std::vector<std::vector<double>> distances(measured.images());
  for (std::size_t i = 1; i < measured.images(); ++i) {
    std::vector<PairPoint> pairs;
    for (std::size_t p = 0; p < n; ++p) {
      const auto at = static_cast<Index>(p);
      pairs.push_back({rays[0][p], rays[i][p], measured.sigma[0][at] / calibration(0, 0),
                       measured.sigma[i][at] / calibration(0, 0)});
    }
    RelativeOptions options;
    options.rejection = PairRejection::kNone;
    COLLINEA_TRY(const RelativeOrientation pair, relative_orientation(pairs, options, seed));
    start.cam_from_model[i] = pair.second_from_first;
    for (const PairPoint& point : pairs) {
      const auto meeting = spatial_parallax(pair.second_from_first, point.first, point.second);
      distances[i].push_back(meeting ? meeting->along_first : std::numeric_limits<double>::infinity());
      if (i == unit_base && meeting) start.points.push_back(meeting->point_in_first);
    }
  }
  if (start.points.size() != n) return fail(Errc::kIllPosed, "rays of the calibrated pair are parallel");
  // The distance of a point from the first image is the same in all pairs but for the length of their bases.
  for (std::size_t i = 1; i < measured.images(); ++i) {
    std::vector<double> ratios;
    for (std::size_t p = 0; p < n; ++p) ratios.push_back(distances[unit_base][p] / distances[i][p]);
    start.cam_from_model[i].translation *= median(std::move(ratios));
  }
  rescale(start, unit_base);
  return adjust_bundles(start, marks_of(measured), CalibrationUnknowns::kNone, unit_base);
}

}  // namespace collinea
