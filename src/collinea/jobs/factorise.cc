// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/factorise.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "collinea/epipolar/projective_factorisation.h"
#include "collinea/epipolar/self_calibration.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/text_table.h"
#include "collinea/jobs/internal/image_marks.h"
#include "collinea/jobs/internal/orientation_findings.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / std::numbers::pi;

// The points that all images show.
struct Common {
  ImageCoordinates measured;
  std::vector<std::string> names, left_out;
};

Common common_points(const ImageMarks& table) {
  Common out;
  const std::size_t images = table.images.size();
  std::vector<std::vector<const BundleMark*>> of_points(table.points.size(),
                                                        std::vector<const BundleMark*>(images, nullptr));
  for (const BundleMark& mark : table.marks) of_points[mark.point][mark.image] = &mark;
  std::vector<std::size_t> kept;
  for (std::size_t p = 0; p < table.points.size(); ++p) {
    const bool is_common = std::find(of_points[p].begin(), of_points[p].end(), nullptr) == of_points[p].end();
    (is_common ? out.names : out.left_out).push_back(table.points[p]);
    if (is_common) kept.push_back(p);
  }
  for (std::size_t i = 0; i < images; ++i) {
    Eigen::Matrix2Xd xy(2, static_cast<Index>(kept.size()));
    Eigen::RowVectorXd sigma(static_cast<Index>(kept.size()));
    for (std::size_t k = 0; k < kept.size(); ++k) {
      xy.col(static_cast<Index>(k)) = of_points[kept[k]][i]->in_image;
      sigma[static_cast<Index>(k)] = of_points[kept[k]][i]->sigma;
    }
    out.measured.xy.push_back(std::move(xy));
    out.measured.sigma.push_back(std::move(sigma));
  }
  return out;
}

// What is known of the image: the principal point as stated or the middle of the measurements, half their extent.
struct ImageFrame {
  Vector2d principal_point;
  double size = 1;
};

ImageFrame image_frame(const ImageCoordinates& measured, const PhotoFrame& frame) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vector2d low(kInfinity, kInfinity), high(-low);
  for (const Eigen::Matrix2Xd& xy : measured.xy) {
    low = low.cwiseMin(xy.rowwise().minCoeff());
    high = high.cwiseMax(xy.rowwise().maxCoeff());
  }
  const Vector2d stated(frame.camera.params[Camera::kCx], frame.camera.params[Camera::kCy]);
  const bool is_stated = frame.y_up || !stated.isZero(0);
  return {is_stated ? stated : Vector2d((low + high) / 2), std::max(1e-9, (high - low).maxCoeff() / 2)};
}

// c_x, c_y, angle of the axes, x0, y0 in the axes of the table, of K in those of the camera.
using Interior = Eigen::Matrix<double, 5, 1>;
Interior interior_of(const Matrix3d& k, bool y_up) {
  const double skew = y_up ? -k(0, 1) : k(0, 1), angle = std::atan2(k(0, 0), -skew);
  return (Interior() << k(0, 0), k(1, 1) * std::sin(angle), angle * kDegrees, k(0, 2), y_up ? -k(1, 2) : k(1, 2))
      .finished();
}

// `covariance`: of c_x, c_y, skew, x0, y0; what it has no variance of is not estimated.
std::vector<Estimate> interior_estimates(const Matrix3d& k, const MatrixXd& covariance, bool y_up,
                                         const std::string& unit) {
  const auto changed = [&](Index parameter, double by) {
    Matrix3d other = k;
    constexpr int kRow[] = {0, 1, 0, 0, 1}, kColumn[] = {0, 1, 1, 2, 2};
    other(kRow[parameter], kColumn[parameter]) += by;
    return interior_of(other, y_up);
  };
  Eigen::Matrix<double, 5, 5> by;
  const double step = 1e-5 * k(0, 0);
  for (Index p = 0; p < 5; ++p) by.col(p) = (changed(p, step) - changed(p, -step)) / (2 * step);
  const Interior values = interior_of(k, y_up);
  const char* names[] = {"c_x", "c_y", "axes", "x0", "y0"};
  std::vector<Estimate> out;
  for (Index p = 0; p < 5; ++p) {
    out.push_back({names[p], p == 2 ? "deg" : unit, values[p], {}});
    if (!covariance.size()) continue;
    const double variance = (by.row(p) * covariance * by.row(p).transpose())(0, 0);
    // Rounding of the differences apart, what is fixed has none.
    if (variance > 1e-18 * values[p] * values[p] && covariance.diagonal().maxCoeff() > 0)
      out.back().sigma = std::sqrt(variance);
  }
  return out;
}

FactorisationReport::Euclidean euclidean_of(const AdjustedBundles& found, const FactorisationReport& report,
                                            bool sigmas_are_stated, double alpha) {
  FactorisationReport::Euclidean out;
  out.variance = {found.sigma0, found.redundancy, sigmas_are_stated, alpha};
  out.conditioning = found.conditioning;
  out.iterations = found.iterations;
  const double factor = out.variance.factor();
  const AdjustedBundles model = in_photo_axes(found, 1);
  const MatrixXd covariance = factor * factor * model.covariance;
  out.interior =
      interior_estimates(found.bundles.calibration, covariance.bottomRightCorner<5, 5>(), report.y_up, report.unit);
  for (std::size_t i = 0; i < report.images.size(); ++i) {
    const auto row = static_cast<Index>(6 * i);
    std::vector<Estimate> exterior = estimates_of_pose(model.bundles.cam_from_model[i]);
    add_sigmas(exterior, covariance_of_estimates(model.bundles.cam_from_model[i], covariance.block<6, 6>(row, row)));
    for (Estimate& e : exterior) {
      if (e.unit == "m") e.unit = "";
      if (i == 0) e = {e.name, e.unit, 0, {}};  // the datum
    }
    out.exterior.push_back(std::move(exterior));
  }
  for (std::size_t p = 0; p < model.bundles.points.size(); ++p) {
    out.points.push_back(model.bundles.points[p]);
    out.sigma_points.push_back(factor * model.point_covariances[p].diagonal().cwiseSqrt());
  }
  const Vector2d axes(1, report.y_up ? -1 : 1);
  for (const BundleMarkTest& mark : found.marks)
    out.marks.push_back(
        {mark.misfit.cwiseProduct(axes), mark.redundancy, mark.w.cwiseProduct(axes) / out.variance.of_tests()});
  return out;
}

std::vector<FactorisationReport::Difference> differences_of(const AdjustedBundles& self,
                                                            const AdjustedBundles& calibrated, double factor) {
  std::vector<FactorisationReport::Difference> out;
  for (std::size_t i = 0; i < self.bundles.cam_from_model.size(); ++i) {
    const Rigid3 &a = self.bundles.cam_from_model[i], &b = calibrated.bundles.cam_from_model[i];
    const auto row = static_cast<Index>(6 * i);
    out.push_back({(centre_of(a) - centre_of(b)).norm(), kDegrees * angle_between(a.rotation, b.rotation),
                   factor * std::sqrt(self.covariance.block<3, 3>(row + 3, row + 3).trace()),
                   kDegrees * factor * std::sqrt(self.covariance.block<3, 3>(row, row).trace())});
  }
  return out;
}

// The projective model in the axes of the table.
ProjectiveModel in_table(ProjectiveModel model, bool y_up) {
  if (!y_up) return model;
  for (ProjectionMatrix& matrix : model.matrices) matrix.row(1) *= -1;
  for (Eigen::Matrix2Xd& misfits : model.misfits) misfits.row(1) *= -1;
  return model;
}

std::vector<PairFundamental> in_table(std::vector<PairFundamental> pairs, bool y_up) {
  if (y_up)
    for (PairFundamental& pair : pairs) {
      pair.fundamental.row(1) *= -1;
      pair.fundamental.col(1) *= -1;
    }
  return pairs;
}

// The median of what the pairs state as principal distance.
double focal_of(const std::vector<PairFundamental>& pairs, double otherwise) {
  std::vector<double> focals;
  for (const PairFundamental& pair : pairs)
    if (pair.focal) focals.push_back(*pair.focal);
  return focals.empty() ? otherwise : median(std::move(focals));
}

Matrix3d calibration_by(double focal, const Vector2d& principal_point) {
  Matrix3d k = Matrix3d::Identity();
  k(0, 0) = k(1, 1) = focal;
  k.topRightCorner<2, 1>() = principal_point;
  return k;
}

Result<FactorisationReport> report_of(const ImageMarks& table, const Common& common, const PhotoFrame& frame,
                                      const FactoriseOptions& options) {
  FactorisationReport report;
  report.unit = frame.unit();
  report.y_up = frame.y_up;
  report.images = table.images;
  report.points = common.names;
  report.left_out = common.left_out;
  COLLINEA_TRY(const ProjectiveModel model, factorised(common.measured));
  report.projective = in_table(model, frame.y_up);
  report.projective_variance = {model.sigma0, model.redundancy, table.sigmas_are_stated, options.alpha};
  const ImageFrame image = image_frame(common.measured, frame);
  const auto pairs = fundamentals_of_pairs(common.measured, image.principal_point);
  report.pairs = in_table(pairs, frame.y_up);
  const Matrix3d start = calibration_by(focal_of(pairs, 2 * image.size), image.principal_point);
  if (const auto k = calibration_from_fundamentals(pairs, start, options.calibration))
    report.from_fundamentals = interior_estimates(*k, {}, frame.y_up, report.unit);
  std::optional<AdjustedBundles> self;
  if (options.calibration != CalibrationUnknowns::kNone) {
    const auto upgrades = euclidean_upgrades(model, image.principal_point, image.size, options.calibration);
    if (!upgrades.empty()) {
      report.unit_base = farthest_from_first(upgrades[0].bundles);
      report.upgrade_misfit = upgrades[0].misfit;
    }
    const auto found = self_calibrated(model, common.measured, upgrades, options.calibration, report.unit_base);
    if (found) {
      self = *found;
      report.self_calibrated = euclidean_of(*found, report, table.sigmas_are_stated, options.alpha);
    } else {
      report.why_not_euclidean = found.error().message;
    }
  }
  if (!options.photo.principal_distance) return report;
  const auto by_camera =
      calibrated(common.measured, calibration_by(*options.photo.principal_distance, image.principal_point),
                 report.unit_base, options.seed);
  if (!by_camera) {
    report.why_not_calibrated = by_camera.error().message;
    return report;
  }
  report.calibrated = euclidean_of(*by_camera, report, table.sigmas_are_stated, options.alpha);
  if (self) report.differences = differences_of(*self, *by_camera, report.self_calibrated->variance.factor());
  return report;
}

// Points with a test beyond the limit and beyond half of the largest one: a large error makes others look wrong.
std::set<std::string> contradicting_points(const FactorisationReport& report) {
  std::set<std::string> out;
  const auto& euclidean = report.self_calibrated ? report.self_calibrated : report.calibrated;
  if (!euclidean || euclidean->variance.redundancy <= 1) return out;
  double largest = 0;
  for (const BundleMarkTest& mark : euclidean->marks) largest = std::max(largest, mark.w.cwiseAbs().maxCoeff());
  const double limit = std::max(euclidean->variance.limit(), largest / 2);
  for (std::size_t k = 0; k < euclidean->marks.size(); ++k)
    if (euclidean->marks[k].w.cwiseAbs().maxCoeff() > limit) out.insert(report.points[k / report.images.size()]);
  return out;
}

ImageMarks without_points(const ImageMarks& table, const std::set<std::string>& names) {
  ImageMarks out;
  out.images = table.images;
  out.points = table.points;
  out.sigmas_are_stated = table.sigmas_are_stated;
  for (const BundleMark& mark : table.marks)
    if (!names.contains(table.points[mark.point])) out.marks.push_back(mark);
  return out;
}

}  // namespace

Result<FactorisationReport> factorise_table(const std::filesystem::path& measurements,
                                            const FactoriseOptions& options) {
  COLLINEA_TRY(validate(options));
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  const std::string stated = table.unit_of("x");
  PhotoOptions photo = options.photo;
  if (!photo.principal_distance) photo.principal_distance = 1;  // nothing here is computed with it
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(photo, stated.empty() || stated == "px" ? "px" : "mm"));
  COLLINEA_TRY(const ImageMarks marks, read_image_marks(table, frame, options.sigma).map_error(in_file));
  std::set<std::string> rejected;
  while (true) {
    Common common = common_points(without_points(marks, rejected));
    std::erase_if(common.left_out, [&](const std::string& name) { return rejected.contains(name); });
    COLLINEA_TRY(FactorisationReport report, report_of(marks, common, frame, options).map_error(in_file));
    report.rejected.assign(rejected.begin(), rejected.end());
    const std::set<std::string> contradicting = options.reject ? contradicting_points(report) : std::set<std::string>();
    if (contradicting.empty()) {
      report.findings = factorisation_findings(report);
      return report;
    }
    rejected.insert(contradicting.begin(), contradicting.end());
  }
}

}  // namespace collinea
