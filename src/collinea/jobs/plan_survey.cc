// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/plan_survey.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/raster/band_descriptions.h"
#include "collinea/raster/geotiff.h"
#include "collinea/report/plan_report.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kNoData = -9999;
// Second line of a control file that is planned.
constexpr FileText kPlannedRemark =
    "\n# planned: put the surveyed coordinates in place of these; heights count from the ground\n";

Result<MapArea> read_area(const PlanOptions& options) {
  if (!options.area) return MapArea{};
  COLLINEA_TRY(const std::string text, read_file(*options.area));
  return parse_area(text).map_error([&](Error e) { return std::move(e).within(options.area->string()); });
}

Result<std::vector<PlannedPoint>> points_of(const LayoutOptions& layout, const FlightPlan& plan) {
  const auto* path = layout.control.get<std::filesystem::path>();
  if (!path || !is_there(*path))
    return lay_out(layout, plan);  // of what is no file either: it says which words there are
  COLLINEA_TRY(const ControlFile file, read_control(*path, {.sigma_plan_m = layout.control_sigma_plan_m,
                                                            .sigma_height_m = layout.control_sigma_height_m}));
  return planned_points(file);
}

struct Crs {
  std::string wkt, name;
};

// A CRS must fit the site: a corner of it is tried.
Result<Crs> crs_of(const std::optional<std::string>& crs, const FlightPlan& plan) {
  if (!crs) return Crs{};
  const Eigen::Vector2d position = plan.area[0];
  COLLINEA_TRY(const Eigen::Vector3d geographic, geographic_from_map(*crs, {position.x(), position.y(), 0}));
  COLLINEA_TRY(const LocalFrame frame, LocalFrame::create(*crs, geographic[0], geographic[1], 0));
  return Crs{frame.wkt1(), frame.crs_name()};
}

// One more strip across, measured as the others; nothing where there cannot be one more.
Result<std::optional<Gain>> one_more_cross_strip(FlightOptions flight, const MapArea& area,
                                                 const std::vector<PlannedPoint>& points,
                                                 const MeasurementOptions& measurements, const Run& run) {
  ++flight.cross_strips;
  const auto plan = plan_flight(flight, area);
  if (!plan) {
    run.say("what one more cross strip would gain is not reported: " + plan.error().message);
    return std::nullopt;
  }
  COLLINEA_TRY(PlannedBlock planned, planned_block(*plan, points, measurements));
  COLLINEA_TRY(const Precision with, predicted(std::move(planned), run));
  return Gain{.by = GainBy::kCrossStrip, .area = with.area};
}

// Projection centres as a receiver with corrections measures them, where none are planned.
Result<Gain> with_positions(const FlightPlan& plan, const std::vector<PlannedPoint>& points,
                            MeasurementOptions measurements, const Run& run) {
  constexpr double kPlan_m = 0.02, kHeight_m = 0.03;
  measurements.position_sigma_plan_m = kPlan_m;
  measurements.position_sigma_height_m = kHeight_m;
  COLLINEA_TRY(PlannedBlock planned, planned_block(plan, points, measurements));
  COLLINEA_TRY(const Precision with, predicted(std::move(planned), run));
  return Gain{.by = GainBy::kPositions, .sigma_m = {kPlan_m, kPlan_m, kHeight_m}, .area = with.area};
}

std::string stations_csv(const FlightPlan& plan) {
  std::string text = "image,strip,cross,x_m,y_m,height_above_ground_m,heading_deg,tilt_deg\n";
  for (std::size_t i = 0; i < plan.images.size(); ++i) {
    const PlannedImage& image = plan.images[i];
    const double heading = std::fmod(image.heading_rad * kDegrees + 720, 360);
    text += fmt::format("{},{},{},{:.3f},{:.3f},{:.3f},{:.2f},{:.2f}\n", i + 1, image.strip + 1, image.cross ? 1 : 0,
                        image.centre.x(), image.centre.y(), image.centre.z(), heading, plan.tilt_rad * kDegrees);
  }
  return text;
}

// As import reads it, once heights and pixels are measured.
std::string control_csv(const PlanReport& report, const std::optional<std::string>& crs) {
  std::string text = "# collinea control" + (crs ? ", " + *crs : "") + kPlannedRemark + kControlPointColumns + "\n";
  const auto sigma = [](double value) { return std::isfinite(value) ? fmt::format("{:g}", value) : "inf"; };
  for (const PlannedPoint& point : report.points)
    text += fmt::format("point, {}, {:.3f}, {:.3f}, 0, {}, {}, {}, {}\n", point.name, point.position.x(),
                        point.position.y(), sigma(point.sigma_m.x()), sigma(point.sigma_m.y()),
                        sigma(point.sigma_m.z()), point.role == ControlRole::kControl ? "control" : "check");
  return text;
}

Result<> write_raster(const Precision& precision, const std::string& wkt, const std::filesystem::path& path) {
  const PrecisionGrid& its = precision.planned.grid;
  const MapGrid grid{its.west_m, its.north_m, its.cell_m, its.width, its.height, wkt};
  Raster<float> raster(its.width, its.height, 4, float(kNoData));
  for (const CellPrecision& cell : precision.cells) {
    const int x = int(cell.cell % std::size_t(its.width)), y = int(cell.cell / std::size_t(its.width));
    for (int i = 0; i < 3; ++i) raster.at(x, y, i) = float(cell.sigma_m()[i]);
    raster.at(x, y, 3) = float(cell.images);
  }
  COLLINEA_TRY(auto writer,
               GeoTiffWriter<float>::create(path, grid, 4, {.nodata = kNoData, .description = band::kPlannedSigma}));
  COLLINEA_TRY(writer.write(0, 0, raster));
  return writer.finish();
}

Eigen::Vector3d on_ground(const Eigen::Vector2d& position) { return {position.x(), position.y(), 0}; }

std::vector<VectorLayer> layers_of(const PlanReport& report) {
  VectorLayer site{"site", VectorKind::kPolygon, {{"area_m2"}}, {}};
  VectorRow outline{{}, {size_m2(report.plan.area)}};
  for (const Eigen::Vector2d& corner : report.plan.area) outline.positions.push_back(on_ground(corner));
  site.rows.push_back(std::move(outline));

  VectorLayer images{"images",
                     VectorKind::kPoint,
                     {{"image", VectorType::kInteger},
                      {"strip", VectorType::kInteger},
                      {"heading_deg"},
                      {"sigma_e_m"},
                      {"sigma_n_m"},
                      {"sigma_h_m"}},
                     {}};
  for (std::size_t i = 0; i < report.plan.images.size(); ++i) {
    const PlannedImage& image = report.plan.images[i];
    const auto known = report.precision.adjusted.pose_covariance.find(ImageId{std::uint32_t(i)});
    Eigen::Vector3d sigma = Eigen::Vector3d::Constant(std::nan(""));
    if (known != report.precision.adjusted.pose_covariance.end())
      sigma = known->second.diagonal().tail<3>().cwiseSqrt();
    images.rows.push_back({{image.centre},
                           {std::int64_t(i + 1), std::int64_t(image.strip + 1),
                            std::fmod(image.heading_rad * kDegrees + 720, 360), sigma.x(), sigma.y(), sigma.z()}});
  }

  VectorLayer points{"control",
                     VectorKind::kPoint,
                     {{"name", VectorType::kText},
                      {"role", VectorType::kText},
                      {"sigma_e_m"},
                      {"sigma_n_m"},
                      {"sigma_h_m"},
                      {"survey_sigma_e_m"},
                      {"survey_sigma_n_m"},
                      {"survey_sigma_h_m"}},
                     {}};
  VectorLayer cells{
      "sigma", VectorKind::kPoint, {{"sigma_e_m"}, {"sigma_n_m"}, {"sigma_h_m"}, {"images", VectorType::kInteger}}, {}};
  for (const ControlDifference& one : report.precision.adjusted.control) {
    const ControlPoint& point = report.precision.planned.block.control.at(one.point);
    Eigen::Vector3d sigma = Eigen::Vector3d::Constant(std::nan(""));
    if (one.covariance_m2) sigma = one.covariance_m2->diagonal().cwiseSqrt();
    if (report.precision.planned.cells.contains(one.point))
      cells.rows.push_back({{point.position_in_map}, {sigma.x(), sigma.y(), sigma.z(), std::int64_t(one.rays)}});
    else
      points.rows.push_back({{point.position_in_map},
                             {point.name, std::string(one.used ? "control" : "check"), sigma.x(), sigma.y(), sigma.z(),
                              point.sigma_m.x(), point.sigma_m.y(), point.sigma_m.z()}});
  }
  return {site, images, points, cells};
}

Result<> write_plan(const PlanReport& report, const std::optional<std::string>& crs, const std::string& wkt,
                    const std::filesystem::path& folder) {
  const std::pair<const char*, std::string> files[] = {{"stations.csv", stations_csv(report.plan)},
                                                       {"control.csv", control_csv(report, crs)},
                                                       {"plan.json", plan_json(report)},
                                                       {"plan.html", plan_page(report)}};
  for (const auto& [name, text] : files) COLLINEA_TRY(write_file(folder / name, text));
  COLLINEA_TRY(write_raster(report.precision, wkt, folder / "sigma.tif"));
  return write_geopackage(folder / "plan.gpkg", layers_of(report), wkt);
}

}  // namespace

Result<PlanReport> plan_survey(const FlightOptions& flight, const LayoutOptions& layout,
                               const MeasurementOptions& measurements, const PlanOptions& options,
                               const std::filesystem::path& folder, const Run& asked) {
  COLLINEA_TRY(validate(options));
  Run run = asked;
  run.seed = std::uint64_t(options.seed);
  COLLINEA_TRY(const MapArea area, read_area(options));
  PlanReport report;
  report.flight = flight;
  report.measurements = measurements;
  COLLINEA_TRY(report.plan, plan_flight(flight, area));
  COLLINEA_TRY(const Crs crs, crs_of(options.crs, report.plan));
  report.crs_name = crs.name;
  COLLINEA_TRY(report.points, points_of(layout, report.plan));
  COLLINEA_TRY(PlannedBlock planned, planned_block(report.plan, report.points, measurements));
  run.say(fmt::format("adjusting {} images, {} tie points", planned.block.images.size(), planned.block.points.size()));
  COLLINEA_TRY(report.precision, predicted(std::move(planned), run));
  if (options.gains && !report.precision.cells.empty()) {
    const Eigen::Vector3d survey(layout.control_sigma_plan_m, layout.control_sigma_plan_m,
                                 layout.control_sigma_height_m);
    COLLINEA_TRY(const std::optional<Gain> point, one_more_point(report.plan, report.points, survey, measurements,
                                                                 report.precision, options.candidates, run));
    if (point) report.gains.push_back(*point);
    COLLINEA_TRY(const auto strip, one_more_cross_strip(flight, area, report.points, measurements, run));
    if (strip) report.gains.push_back(*strip);
    if (!measurements.position_sigma_plan_m) {
      COLLINEA_TRY(const Gain positions, with_positions(report.plan, report.points, measurements, run));
      report.gains.push_back(positions);
    }
  }
  if (options.trials > 0 &&
      !report.precision.cells.empty()) {  // nothing is predicted of a block that is not determined
    COLLINEA_TRY(report.trials, tried(report.precision, options.trials, run));
  }
  report.rules = rules_of_thumb(report.plan, flight, measurements, report.precision);
  report.customs = customs(report.plan, flight, report.points, report.precision);
  std::error_code error;
  report.title = std::filesystem::absolute(folder, error).lexically_normal().filename().string();
  COLLINEA_TRY(write_plan(report, options.crs, crs.wkt, folder));
  return report;
}

}  // namespace collinea
