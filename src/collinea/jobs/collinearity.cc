// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/collinearity.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "collinea/base/word_or.h"
#include "collinea/geodesy/geodetic_collinearity.h"
#include "collinea/io/text_table.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kRadians = std::numbers::pi / 180;

// A row of a table of geodetic positions.
struct GeodeticRow {
  std::string name;
  GeodeticPosition position;
  double undulation_m = 0;
  double sigma_plan_m = 0, sigma_height_m = 0;

  [[nodiscard]] double above_sea_m() const { return position.height_m - undulation_m; }
};

Result<std::vector<GeodeticRow>> read_positions(const TextTable& table, const char* name, const HeightsFrom& heights) {
  COLLINEA_TRY(const auto names, table.words(name));
  COLLINEA_TRY(const auto latitudes, table.numbers("latitude", "rad"));
  COLLINEA_TRY(const auto longitudes, table.numbers("longitude", "rad"));
  const bool is_ellipsoidal = table.has("h");
  if (is_ellipsoidal && table.has("H"))
    return fail(Errc::kBadFormat, "the table has h and H: give one of them, ellipsoidal or above the sea");
  COLLINEA_TRY(const auto values, table.numbers(is_ellipsoidal ? "h" : "H", "m"));
  const bool has_undulation = table.has("N");
  COLLINEA_TRY(const auto undulations, table.numbers_or("N", "m", std::nan("")));
  COLLINEA_TRY(const auto plan, table.numbers_or("sigma_plan", "m", 0));
  COLLINEA_TRY(const auto height, table.numbers_or("sigma_h", "m", 0));
  const bool in_degrees = table.unit_of("latitude").empty();
  if (!is_ellipsoidal && !has_undulation && heights.word() == HeightSurface::kEllipsoid)
    return fail(Errc::kBadInput, "heights H above the sea need a geoid: a column N, or what they count from",
                {"heights"_option});
  std::vector<GeodeticRow> out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    GeodeticRow row{names[i], {latitudes[i], longitudes[i], values[i]}, 0, plan[i], height[i]};
    if (in_degrees) {
      row.position.latitude_rad *= kRadians;
      row.position.longitude_rad *= kRadians;
    }
    if (std::abs(row.position.latitude_rad) > std::numbers::pi / 2 || plan[i] < 0 || height[i] < 0)
      return fail(Errc::kBadFormat, names[i] + ": a latitude beyond a pole, or a negative sigma");
    if (std::isfinite(undulations[i])) {
      row.undulation_m = undulations[i];
    } else {
      COLLINEA_TRY(row.undulation_m,
                   undulation_m(heights, row.position.latitude_rad / kRadians, row.position.longitude_rad / kRadians));
    }
    if (!is_ellipsoidal) row.position.height_m = ellipsoidal_height_m(values[i], row.undulation_m);
    out.push_back(std::move(row));
  }
  return out;
}

// An image: its position, angles against east, north and up, and their standard deviations.
struct GeodeticImage {
  GeodeticRow at;
  CardanAngles angles;
  Vector3d sigma_angles_rad = Vector3d::Zero();
};

Result<std::vector<GeodeticImage>> read_images(const TextTable& table, const HeightsFrom& heights) {
  COLLINEA_TRY(const auto rows, read_positions(table, "image", heights));
  std::vector<GeodeticImage> out;
  for (const GeodeticRow& row : rows) out.push_back({row, {}});
  constexpr std::array<const char*, 3> kNames{"omega", "phi", "kappa"};
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::string name = kNames[static_cast<std::size_t>(k)];
    COLLINEA_TRY(const auto values, table.numbers(name, "rad"));
    COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma_" + name, "rad", 0));
    const double unit = table.unit_of(name).empty() ? kRadians : 1;
    const double unit_of_sigma = table.unit_of("sigma_" + name).empty() ? kRadians : 1;
    for (std::size_t i = 0; i < out.size(); ++i) {
      (k == 0 ? out[i].angles.omega_rad : k == 1 ? out[i].angles.phi_rad : out[i].angles.kappa_rad) = unit * values[i];
      out[i].sigma_angles_rad[k] = unit_of_sigma * sigmas[i];
    }
  }
  return out;
}

// Standard deviations of latitude, longitude (rad) and height (m) at a position.
Vector3d sigmas_of(const GeodeticRow& row) {
  const Eigen::Matrix3d by = geocentric(row.position).by_geodetic;
  return {row.sigma_plan_m / by.col(0).norm(), row.sigma_plan_m / std::max(1e-3, by.col(1).norm()), row.sigma_height_m};
}

// Derivatives by the angles against east, north and up: those of the angles against geocentric axes by differences.
Eigen::Matrix<double, 2, 3> by_level_angles(double c, const GeodeticImage& image, const GeodeticPosition& point) {
  constexpr double kStep = 1e-6;
  const auto seen = [&](Eigen::Index axis, double by) {
    CardanAngles angles = image.angles;
    (axis == 0 ? angles.omega_rad : axis == 1 ? angles.phi_rad : angles.kappa_rad) += by;
    return collinearity(c, image.at.position, geocentric_angles(angles, image.at.position), point).xy;
  };
  Eigen::Matrix<double, 2, 3> out;
  for (Eigen::Index axis = 0; axis < 3; ++axis) out.col(axis) = (seen(axis, kStep) - seen(axis, -kStep)) / (2 * kStep);
  return out;
}

CollinearityReport::Row row_of(double c, const GeodeticImage& image, const GeodeticRow& point,
                               const GeodeticCollinearity& at, const CollinearityReport& report,
                               const CollinearityOptions& options) {
  CollinearityReport::Row row;
  row.image = image.at.name;
  row.point = point.name;
  row.latitude_deg = point.position.latitude_rad / kRadians;
  row.longitude_deg = point.position.longitude_rad / kRadians;
  row.ellipsoidal_m = point.position.height_m;
  row.undulation_m = point.undulation_m;
  row.distance_m = (geocentric(point.position).position - geocentric(image.at.position).position).norm();
  row.xy = at.xy;
  row.by << at.by_centre, by_level_angles(c, image, point.position), at.by_point;
  Eigen::Matrix<double, 9, 1> sigmas;
  sigmas << sigmas_of(image.at), image.sigma_angles_rad, sigmas_of(point);
  row.sigma = (row.by * sigmas.asDiagonal()).rowwise().norm();
  if (report.refraction)
    row.refraction =
        refraction_in_image(row.xy, c, image.angles,
                            {image.at.above_sea_m(), point.above_sea_m(), options.sigma_height_m}, *report.refraction);
  return row;
}

std::optional<RefractionModel> model_of(RefractionBy by, double coefficient) {
  if (by == RefractionBy::kNone) return std::nullopt;
  return RefractionModel{by == RefractionBy::kAtmosphere, coefficient};
}

}  // namespace

Result<CollinearityReport> collinearity_of_tables(const std::filesystem::path& points,
                                                  const std::filesystem::path& orientation,
                                                  const CollinearityOptions& options) {
  COLLINEA_TRY(validate(options));
  if (!options.principal_distance_mm)
    return fail(Errc::kBadInput, "nothing says the principal distance of the photographs",
                {"principal_distance_mm"_option});
  const double c = *options.principal_distance_mm;
  const auto in_file = [](const std::filesystem::path& path) {
    return [&path](Error e) { return std::move(e).within(path.string()); };
  };
  COLLINEA_TRY(const TextTable point_table, read_text_table(points));
  COLLINEA_TRY(const TextTable image_table, read_text_table(orientation));
  COLLINEA_TRY(const auto rows, read_positions(point_table, "point", options.heights).map_error(in_file(points)));
  COLLINEA_TRY(const auto images, read_images(image_table, options.heights).map_error(in_file(orientation)));
  CollinearityReport report;
  report.refraction = model_of(options.refraction, options.refraction_coefficient);
  for (const GeodeticImage& image : images)
    for (const GeodeticRow& point : rows) {
      const GeodeticCollinearity at =
          collinearity(c, image.at.position, geocentric_angles(image.angles, image.at.position), point.position);
      if (!(at.denominator < 0))
        report.behind.emplace_back(image.at.name, point.name);
      else
        report.rows.push_back(row_of(c, image, point, at, report, options));
    }
  return report;
}

Result<RefractionReport> refraction_of_table(const std::filesystem::path& measurements,
                                             const RefractionOptions& options) {
  COLLINEA_TRY(validate(options));
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  const std::string stated = table.unit_of("x"), unit = stated.empty() || stated == "px" ? "px" : "mm";
  COLLINEA_TRY(const PhotoFrame frame, photo_frame(options.photo, unit));
  const auto attitude = three_numbers_in(options.attitude);
  if (!attitude) return fail(Errc::kBadInput, "an attitude is omega,phi,kappa in degrees", {"attitude"_option});
  if (!table.has("camera_height") && !options.camera_height_m)
    return fail(Errc::kBadInput, "nothing says the height of the camera above the sea", {"camera_height_m"_option});
  COLLINEA_TRY(const auto names, table.words("point").map_error(in_file));
  COLLINEA_TRY(const auto x, table.numbers("x", unit).map_error(in_file));
  COLLINEA_TRY(const auto y, table.numbers("y", unit).map_error(in_file));
  const double usual = options.sigma * (unit == "mm" ? unit_factor(stated, "mm").value_or(1) : 1);
  COLLINEA_TRY(const auto sigmas, table.numbers_or("sigma", unit, usual).map_error(in_file));
  COLLINEA_TRY(
      const auto cameras,
      table.numbers_or("camera_height", "m", options.camera_height_m.value_or(std::nan(""))).map_error(in_file));
  COLLINEA_TRY(const auto grounds, table.numbers_or("ground_height", "m", options.ground_height_m).map_error(in_file));
  RefractionReport report;
  report.unit = frame.unit();
  report.model = {options.refraction != RefractionBy::kCoefficient, options.refraction_coefficient};
  const CardanAngles angles{kRadians * (*attitude)[0], kRadians * (*attitude)[1], kRadians * (*attitude)[2]};
  const Vector2d axes(1, frame.y_up ? 1 : -1);  // of the table to those of photographs
  const Vector2d middle = frame.in_table({frame.camera.params[Camera::kCx], frame.camera.params[Camera::kCy]});
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!std::isfinite(cameras[i]))
      return fail(Errc::kBadFormat, measurements.string() + ": point " + names[i] + " has no height of the camera");
    RefractionReport::Row row{names[i], {cameras[i], grounds[i], options.sigma_height_m}, {}, {}, {}, {}};
    const Vector2d measured(x[i], y[i]), xy = (measured - middle).cwiseProduct(axes);
    for (const bool by_atmosphere : {false, true}) {
      ImageRefraction& one = by_atmosphere ? row.by_atmosphere : row.by_coefficient;
      one = refraction_in_image(xy, frame.camera.focal_px(), angles, row.heights,
                                {by_atmosphere, options.refraction_coefficient}, sigmas[i]);
      one.shift = one.shift.cwiseProduct(axes);
    }
    const ImageRefraction none{Vector2d::Zero(), Vector2d::Zero(), 0};
    const ImageRefraction& taken = options.refraction == RefractionBy::kNone ? none
                                   : report.model.by_atmosphere              ? row.by_atmosphere
                                                                             : row.by_coefficient;
    row.corrected = measured - taken.shift;
    // The shift is a few parts in 100,000 of the coordinate: its errors are those of the height.
    row.sigma_corrected = (taken.sigma.array().square() + sigmas[i] * sigmas[i]).sqrt().matrix();
    report.rows.push_back(std::move(row));
  }
  return report;
}

}  // namespace collinea
