// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/image_marks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>

namespace collinea {
namespace {

// Names in order of appearance, with their indices.
class Names {
 public:
  explicit Names(std::vector<std::string>& names) : names_(names) {}
  std::size_t index_of(const std::string& name) {
    const auto [at, is_new] = index_.emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return at->second;
  }

 private:
  std::vector<std::string>& names_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace

const BundleMark* ImageMarks::find(std::size_t image, std::size_t point) const {
  if (point >= marks_of.size()) return nullptr;
  for (const std::size_t k : marks_of[point])
    if (marks[k].image == image) return &marks[k];
  return nullptr;
}

Result<ImageMarks> read_image_marks(const TextTable& table, const PhotoFrame& frame, std::optional<double> sigma) {
  const std::string unit(frame.unit());
  COLLINEA_TRY(const auto images, table.words("image"));
  COLLINEA_TRY(const auto points, table.words("point"));
  COLLINEA_TRY(const auto x, table.numbers("x", unit));
  COLLINEA_TRY(const auto y, table.numbers("y", unit));
  const double stated = sigma.value_or(0) * (frame.y_up ? unit_factor(table.unit_of("x"), unit).value_or(1) : 1);
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", unit, sigma ? stated : frame.y_up ? 0.005 : 0.5));
  ImageMarks out;
  out.sigmas_are_stated = table.has("sigma") || sigma.has_value();
  Names image_names(out.images), point_names(out.points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(sigmas[i] > 0))
      return fail(Errc::kBadInput, fmt::format("point {} in {}: its sigma is not above zero", points[i], images[i]));
    const std::size_t image = image_names.index_of(images[i]), point = point_names.index_of(points[i]);
    if (out.find(image, point))
      return fail(Errc::kBadFormat, fmt::format("point {} is measured twice in image {}", points[i], images[i]));
    out.marks_of.resize(out.points.size());
    out.marks_of[point].push_back(out.marks.size());
    out.marks.push_back({image, point, frame.pixel({x[i], y[i]}), sigmas[i]});
  }
  if (out.marks.empty()) return fail(Errc::kBadInput, "the table has no measurements");
  return out;
}

AdjustedBundles in_photo_axes(const AdjustedBundles& adjusted, double scale) {
  AdjustedBundles out = adjusted;
  const Eigen::Quaterniond photo_from_camera(0, 1, 0, 0);  // half a turn about x, its own inverse
  const Eigen::Matrix3d axes = photo_from_camera.toRotationMatrix();
  for (Rigid3& pose : out.bundles.cam_from_model) {
    pose.rotation = (pose.rotation * photo_from_camera).normalized();
    pose.translation *= scale;
  }
  for (Eigen::Vector3d& point : out.bundles.points) point = scale * (axes * point);
  for (Eigen::Matrix3d& covariance : out.point_covariances)
    covariance = scale * scale * axes * covariance * axes.transpose();
  Eigen::MatrixXd by = Eigen::MatrixXd::Identity(out.covariance.rows(), out.covariance.cols());
  for (std::size_t i = 0; i < out.bundles.cam_from_model.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i);
    by.block<3, 3>(row, row) = axes;
    by.block<3, 3>(row + 3, row + 3) = scale * axes;
  }
  out.covariance = by * out.covariance * by.transpose();
  return out;
}

}  // namespace collinea
