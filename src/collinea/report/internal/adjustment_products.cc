// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/adjustment_products.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/block/world_frame.h"
#include "collinea/io/opk.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/json_values.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using json = nlohmann::ordered_json;

constexpr double kDegrees = 180 / std::numbers::pi;

Matrix3d unknown() { return Matrix3d::Constant(std::nan("")); }
Vector3d sigma(const Matrix3d& covariance) { return covariance.diagonal().cwiseSqrt(); }

// Standard deviations of the angles as they are written, from those of small turns about the axes of the map.
Vector3d sigma_of_angles(const OmegaPhiKappa& angles, const Matrix3d& rotations_in_map) {
  const Matrix3d by_rotation = angles_by_rotation_of_camera(angles);
  return kDegrees * sigma(by_rotation * rotations_in_map * by_rotation.transpose());
}

std::vector<ProductImage> images_of(const AdjustmentReport& report, const std::vector<ExteriorOrientation>& rows) {
  const double scale = std::pow(sigma_scale(report.adjusted), 2);
  std::vector<ProductImage> images;
  auto row = rows.begin();
  for (const auto& [id, pose] : oriented_images(report.block)) {
    ProductImage image{id, row->centre_in_map, row->angles, cam_from_world(row->angles).normalized(), unknown(), {},
                       {}};
    if (image.cam_from_map.w() < 0) image.cam_from_map.coeffs() *= -1;
    image.sigma_rotation_deg = image.sigma_angles_deg = Vector3d::Constant(std::nan(""));
    if (const auto known = report.adjusted.pose_covariance.find(id); known != report.adjusted.pose_covariance.end()) {
      const Matrix3d map_from_world = (image.cam_from_map.conjugate() * pose.rotation).toRotationMatrix();
      const auto in_map = [&](const Matrix3d& covariance) {
        return Matrix3d(scale * map_from_world * covariance * map_from_world.transpose());
      };
      const Matrix3d rotations = known->second.topLeftCorner<3, 3>();
      image.covariance_m2 = in_map(known->second.bottomRightCorner<3, 3>());
      image.sigma_rotation_deg = kDegrees * std::sqrt(scale) * sigma(rotations);
      image.sigma_angles_deg = sigma_of_angles(image.angles, in_map(rotations));
    }
    images.push_back(image);
    ++row;
  }
  return images;
}

// One turn for the whole block: its axes differ by the convergence of meridians, too little to matter for a sigma.
Matrix3d rotation_of(const std::optional<LocalFrame>& frame, const std::vector<Vector3d>& positions) {
  if (!frame || positions.empty()) return Matrix3d::Identity();
  return map_from_local_rotation(*frame, positions[positions.size() / 2]).toRotationMatrix();
}

std::vector<ProductPoint> points_of(const AdjustmentReport& report, const std::optional<LocalFrame>& frame) {
  const Examined& adjusted = report.adjusted;
  const double scale = std::pow(sigma_scale(adjusted), 2);
  std::map<PointId, int> images;
  for (const std::uint32_t seen : adjusted.observations) ++images[report.block.observations[seen].point];
  std::vector<Vector3d> positions;
  for (const auto& [id, position] : adjusted.points) positions.push_back(position);
  const Matrix3d rotation = rotation_of(frame, positions);
  if (frame) frame->map_from_local(positions);
  std::vector<ProductPoint> points;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    ProductPoint point{adjusted.points[i].first,        positions[i], adjusted.points[i].second, unknown(), {},
                       images[adjusted.points[i].first]};
    point.sigma_in_world_m = Vector3d::Constant(std::nan(""));
    if (i < adjusted.point_covariance.size()) {
      point.covariance_m2 = scale * rotation * adjusted.point_covariance[i] * rotation.transpose();
      point.sigma_in_world_m = std::sqrt(scale) * sigma(adjusted.point_covariance[i]);
    }
    points.push_back(point);
  }
  return points;
}

std::vector<ProductControl> control_of(const AdjustmentReport& report, const std::optional<LocalFrame>& frame) {
  const double scale = std::pow(sigma_scale(report.adjusted), 2);
  std::vector<Vector3d> positions;
  for (const ControlDifference& one : report.adjusted.control)
    positions.push_back(one.position_in_world.value_or(Vector3d::Constant(std::nan(""))));
  Matrix3d rotation = Matrix3d::Identity();
  if (const auto met = std::find_if(positions.begin(), positions.end(), [](const auto& p) { return p.allFinite(); });
      met != positions.end())
    rotation = rotation_of(frame, {*met});
  std::vector<ProductControl> control;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const ControlDifference& one = report.adjusted.control[i];
    ProductControl& point = control.emplace_back(ProductControl{&one, positions[i], unknown()});
    if (frame && positions[i].allFinite()) point.position_m = frame->map_from_local(positions[i]);
    if (one.covariance_m2) point.covariance_m2 = scale * rotation * *one.covariance_m2 * rotation.transpose();
  }
  return control;
}

std::string field(double value) { return std::isfinite(value) ? fmt::format(",{:.12g}", value) : ","; }
std::string fields(const Vector3d& values) { return field(values.x()) + field(values.y()) + field(values.z()); }

const char* role_of(const ControlDifference& one) { return one.used ? "control" : "check"; }

json images_json(const AdjustmentReport& report, const AdjustmentProducts& products) {
  json list = json::array();
  for (const ProductImage& image : products.images) {
    const Eigen::Quaterniond& q = image.cam_from_map;
    list.push_back({{"file", report.block.images.at(image.image).file},
                    {"centre_m", vector(image.centre_m)},
                    {"omega_phi_kappa_deg", {image.angles.omega_deg, image.angles.phi_deg, image.angles.kappa_deg}},
                    {"cam_from_map_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                    {"sigma_m", vector(sigma(image.covariance_m2))},
                    {"sigma_omega_phi_kappa_deg", vector(image.sigma_angles_deg)}});
  }
  return list;
}

json cameras_json(const AdjustmentReport& report) {
  json list = json::array();
  for (const auto& [id, camera] : report.block.cameras) {
    json one = {{"name", camera.name},
                {"model", name_of(camera.model)},
                {"width_px", camera.width_px},
                {"height_px", camera.height_px}};
    const auto covariance = report.adjusted.camera_covariance.find(id);
    if (camera.additional != AdditionalSet::kNone) one["additional"] = kAdditionalNames[std::size_t(camera.additional)];
    for (const int k : params_of(camera)) {
      json& parameter = one["parameters"][param_name(k)];
      parameter = {{"value", number(camera.params[std::size_t(k)])}, {"unit", param_unit(k)}};
      if (covariance != report.adjusted.camera_covariance.end())
        parameter["sigma"] = number(std::sqrt(covariance->second(k, k)) * sigma_scale(report.adjusted));
    }
    list.push_back(one);
  }
  return list;
}

void append(std::vector<VectorValue>& values, const Vector3d& v) {
  for (int i = 0; i < 3; ++i) values.emplace_back(v[i]);
}

}  // namespace

Result<AdjustmentProducts> products_of(const AdjustmentReport& report) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(report.block));
  COLLINEA_TRY(const std::vector<ExteriorOrientation> rows, exterior_orientations(report.block));
  AdjustmentProducts products;
  if (frame) {
    products.crs = frame->crs();
    products.wkt = frame->wkt1();
  }
  products.images = images_of(report, rows);
  products.points = points_of(report, frame);
  products.control = control_of(report, frame);
  return products;
}

std::string poses_csv(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::string text =
      "image,x_m,y_m,z_m,omega_deg,phi_deg,kappa_deg,sigma_x_m,sigma_y_m,sigma_z_m,sigma_turn_about_x_deg,"
      "sigma_turn_about_y_deg,sigma_turn_about_z_deg,sigma_omega_deg,sigma_phi_deg,sigma_kappa_deg,cam_from_map_qw,"
      "cam_from_map_qx,cam_from_map_qy,cam_from_map_qz\n";
  for (const ProductImage& image : products.images) {
    const Eigen::Quaterniond& q = image.cam_from_map;
    text += in_quotes(report.block.images.at(image.image).file) + fields(image.centre_m) +
            fields({image.angles.omega_deg, image.angles.phi_deg, image.angles.kappa_deg}) +
            fields(sigma(image.covariance_m2)) + fields(image.sigma_rotation_deg) + fields(image.sigma_angles_deg) +
            field(q.w()) + fields({q.x(), q.y(), q.z()}) + "\n";
  }
  return text;
}

std::string points_csv(const AdjustmentProducts& products) {
  std::string text =
      "point,x_in_world_m,y_in_world_m,z_in_world_m,sigma_x_m,sigma_y_m,sigma_z_m,east_m,north_m,height_m,"
      "sigma_east_m,sigma_north_m,sigma_height_m,images\n";
  for (const ProductPoint& point : products.points)
    text += std::to_string(point.point.value) + fields(point.in_world_m) + fields(point.sigma_in_world_m) +
            fields(point.position_m) + fields(sigma(point.covariance_m2)) + "," + std::to_string(point.images) + "\n";
  return text;
}

std::string control_csv(const AdjustmentReport& report, const AdjustmentProducts& products) {
  std::string text =
      "point,role,images,difference_x_m,difference_y_m,difference_z_m,sigma_x_m,sigma_y_m,sigma_z_m,"
      "left_out_x_m,left_out_y_m,left_out_z_m,left_out_sigma_x_m,left_out_sigma_y_m,left_out_sigma_z_m,"
      "east_m,north_m,height_m,sigma_east_m,sigma_north_m,sigma_height_m\n";
  for (const ProductControl& its : products.control) {
    const ControlDifference& one = *its.difference;
    text += in_quotes(report.block.control.at(one.point).name) + "," + role_of(one) + "," + std::to_string(one.rays) +
            fields(one.difference_m) + fields(one.difference_sigma_m);
    Vector3d left_out = Vector3d::Constant(std::nan("")), left_out_sigma = left_out;
    if (report.adjusted.reliability)
      for (const LeftOutPoint& out : report.adjusted.reliability->left_out)
        if (out.point == one.point) left_out = out.difference_m, left_out_sigma = out.difference_sigma_m;
    text +=
        fields(left_out) + fields(left_out_sigma) + fields(its.position_m) + fields(sigma(its.covariance_m2)) + "\n";
  }
  return text;
}

std::string products_json(const AdjustmentReport& report, const AdjustmentProducts& products) {
  json control = json::array();
  for (const ProductControl& its : products.control)
    control.push_back({{"name", report.block.control.at(its.difference->point).name},
                       {"role", role_of(*its.difference)},
                       {"images", its.difference->rays},
                       {"position_m", vector(its.position_m)},
                       {"sigma_m", vector(sigma(its.covariance_m2))},
                       {"difference_m", vector(its.difference->difference_m)},
                       {"sigma_difference_m", vector(its.difference->difference_sigma_m)}});
  json rows = json::array();
  for (const ProductPoint& point : products.points) {
    const Vector3d s = sigma(point.covariance_m2);
    rows.push_back({point.point.value, number(point.position_m.x()), number(point.position_m.y()),
                    number(point.position_m.z()), number(s.x()), number(s.y()), number(s.z()), point.images});
  }
  const json j = {
      {"crs", products.crs},
      {"sigma0", number(report.adjusted.sigma0)},
      {"cameras", cameras_json(report)},
      {"images", images_json(report, products)},
      {"control_points", control},
      {"point_columns",
       {"point", "east_m", "north_m", "height_m", "sigma_east_m", "sigma_north_m", "sigma_height_m", "images"}},
      {"points", rows}};
  return j.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<> write_products(const AdjustmentReport& report, const AdjustmentProducts& products,
                        std::vector<VectorLayer> more, const std::filesystem::path& geopackage) {
  VectorLayer images{"images",
                     VectorKind::kPoint,
                     {{"file", VectorType::kText},
                      {"omega_deg"},
                      {"phi_deg"},
                      {"kappa_deg"},
                      {"qw"},
                      {"qx"},
                      {"qy"},
                      {"qz"},
                      {"sigma_east_m"},
                      {"sigma_north_m"},
                      {"sigma_height_m"},
                      {"sigma_omega_deg"},
                      {"sigma_phi_deg"},
                      {"sigma_kappa_deg"}},
                     {}};
  for (const ProductImage& image : products.images) {
    const Eigen::Quaterniond& q = image.cam_from_map;
    VectorRow row{{image.centre_m}, {report.block.images.at(image.image).file}};
    append(row.values, {image.angles.omega_deg, image.angles.phi_deg, image.angles.kappa_deg});
    row.values.emplace_back(q.w());
    append(row.values, {q.x(), q.y(), q.z()});
    append(row.values, sigma(image.covariance_m2));
    append(row.values, image.sigma_angles_deg);
    images.rows.push_back(std::move(row));
  }
  VectorLayer points{"tie_points",
                     VectorKind::kPoint,
                     {{"point", VectorType::kInteger},
                      {"images", VectorType::kInteger},
                      {"sigma_east_m"},
                      {"sigma_north_m"},
                      {"sigma_height_m"}},
                     {}};
  points.indexed = false;  // they are drawn all at once
  for (const ProductPoint& point : products.points) {
    VectorRow row{{point.position_m}, {std::int64_t(point.point.value), std::int64_t(point.images)}};
    append(row.values, sigma(point.covariance_m2));
    points.rows.push_back(std::move(row));
  }
  VectorLayer control{"control",
                      VectorKind::kPoint,
                      {{"name", VectorType::kText},
                       {"role", VectorType::kText},
                       {"images", VectorType::kInteger},
                       {"difference_x_m"},
                       {"difference_y_m"},
                       {"difference_z_m"},
                       {"sigma_difference_x_m"},
                       {"sigma_difference_y_m"},
                       {"sigma_difference_z_m"},
                       {"sigma_east_m"},
                       {"sigma_north_m"},
                       {"sigma_height_m"}},
                      {}};
  for (const ProductControl& its : products.control) {
    if (!its.position_m.allFinite()) continue;
    const ControlDifference& one = *its.difference;
    VectorRow row{{its.position_m},
                  {report.block.control.at(one.point).name, std::string(role_of(one)), std::int64_t(one.rays)}};
    append(row.values, one.difference_m);
    append(row.values, one.difference_sigma_m);
    append(row.values, sigma(its.covariance_m2));
    control.rows.push_back(std::move(row));
  }
  images.style = VectorStyle{{90, 90, 90}, 0.2, 1.5};
  points.style = VectorStyle{{150, 150, 150}, 0.1, 0.6};
  control.style = VectorStyle{{200, 40, 40}, 0.3, 2.5, 0, "name"};
  std::vector<VectorLayer> layers{std::move(images), std::move(points), std::move(control)};
  for (VectorLayer& layer : more) layers.push_back(std::move(layer));
  return write_geopackage(geopackage, layers, products.wkt);
}

}  // namespace collinea
