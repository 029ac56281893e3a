// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/rectify_plane.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/base/file.h"
#include "collinea/import/image_names.h"
#include "collinea/io/colmap.h"
#include "collinea/io/number_rows.h"
#include "collinea/io/text.h"
#include "collinea/jobs/internal/project_plane.h"
#include "collinea/ortho/plane_homography.h"
#include "collinea/ortho/rectify.h"
#include "collinea/project/fitted_camera.h"
#include "collinea/project/json_text.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWider = 0.1;  // of the points' extent, on each side

Result<std::vector<double>> numbers_of(const std::string& text, const OptionName& option) {
  return parse_numbers(text).map_error([&](Error e) { return std::move(e).about(option); });
}

// --- what is reported of the result ----------------------------------------------------------------------------------

template <class Measure>
Spread spread_of(const PlaneExtent& extent, const Measure& measure) {
  Spread spread{measure(extent.at(0.5, 0.5)), 0};
  for (int corner = 0; corner < 4; ++corner)
    spread.worst = std::max(spread.worst, measure(extent.at(corner & 1, corner >> 1)));
  return spread;
}

Result<PlaneExtent> extent_of(const RectifyOptions& options, const std::vector<Vector2d>& around) {
  if (options.extent) {
    COLLINEA_TRY(const auto n, numbers_of(*options.extent, "extent"_option));
    if (n.size() != 4 || !(n[2] > n[0] && n[3] > n[1]))
      return fail(Errc::kBadInput, "\"" + *options.extent + "\" is no extent: left,bottom,right,top are wanted",
                  {"extent"_option});
    return PlaneExtent{{n[0], n[1]}, {n[2], n[3]}};
  }
  PlaneExtent extent{around[0], around[0]};
  for (const Vector2d& p : around) {
    extent.lowest = extent.lowest.cwiseMin(p);
    extent.highest = extent.highest.cwiseMax(p);
  }
  const Vector2d more = kWider * extent.size();
  return PlaneExtent{extent.lowest - more, extent.highest + more};
}

// Two digits: what is reported is what is used.
Result<double> cell_of(const RectifyOptions& options, const std::vector<PlaneView>& views, const PlaneExtent& extent) {
  if (options.cell_m) return *options.cell_m;
  double pixel_m = pixel_size_m(views[0], extent.at(0.5, 0.5));
  if (!std::isfinite(pixel_m))  // the best view shows another part
    for (int i = 0; i < 81; ++i)
      pixel_m = std::min(pixel_m, pixel_size_m(views[0], extent.at(i % 9 / 8.0, i / 9 / 8.0)));
  if (!std::isfinite(pixel_m)) return fail(Errc::kIllPosed, "no photograph shows the area to be rectified");
  const double unit = std::pow(10.0, std::floor(std::log10(pixel_m)) - 1);
  return std::max(1.0, std::floor(pixel_m / unit)) * unit;
}

Result<RectifiedReport> paint(const fs::path& out, const PlaneExtent& extent, const std::vector<PlaneView>& views,
                              const std::vector<std::string>& names, const PixelSource& pixels,
                              const RectifyOptions& options, const Run& run) {
  COLLINEA_TRY(const double cell_m, cell_of(options, views, extent));
  COLLINEA_TRY(const MapGrid grid, plane_grid(extent, cell_m));
  COLLINEA_TRY(const RectifiedSummary summary, write_rectified(out, grid, views, pixels, run));
  RectifiedReport report{.file = out,
                         .cell_m = cell_m,
                         .width = grid.width,
                         .height = grid.height,
                         .left_m = grid.west_m,
                         .top_m = grid.north_m};
  report.painted_share = double(summary.painted_cells) / double(summary.painted_cells + summary.empty_cells);
  for (std::size_t v = 0; v < views.size(); ++v)
    if (summary.cells_of[v] > 0) report.sources.push_back({names[v], summary.cells_of[v], views[v].centre_over_plane});
  if (views[0].centre_over_plane)
    report.shift_per_depth =
        spread_of(extent, [&](const Vector2d& p) { return shift_per_depth(views[0], p).value_or(0); });
  return report;
}

Result<RectifiedReport> finished(RectifiedReport report) {
  fs::path json = report.file;
  COLLINEA_TRY(write_file(json.replace_extension(".json"), rectified_json(report)));
  return report;
}

// --- from an image -----------------------------------------------------------------------------------------------

struct CameraOfImage {
  Camera camera;
  bool known = false;  // its focal length and lens
};

Result<CameraOfImage> camera_of(const fs::path& file, const RectifyOptions& options, const Run& run) {
  COLLINEA_TRY(const ImageHeader header, read_image_header(file));
  if (int(options.project.has_value()) + int(options.orientation.has_value()) + int(options.focal_px.has_value()) > 1)
    return fail(Errc::kBadInput, "one of a project, an orientation and a focal length says the camera, not several",
                {"project"_option, "orientation"_option, "focal_px"_option});
  if (!options.project && !options.orientation) {
    const double focal_px = options.focal_px.value_or(std::max(header.width_px, header.height_px));
    return CameraOfImage{ideal_camera(focal_px, header.width_px, header.height_px), options.focal_px.has_value()};
  }
  Block block;
  if (options.project) {
    COLLINEA_TRY(const Project project, open_project(*options.project, run));
    COLLINEA_TRY(block, project.store.read_block());
  } else {
    COLLINEA_TRY(block, read_colmap(*options.orientation));
  }
  COLLINEA_TRY(const ImageId image, ImageNames(block).find_image(file));
  COLLINEA_TRY(Camera camera, fitted_to(block.camera_of(image), header.width_px, header.height_px, file.string()));
  return CameraOfImage{std::move(camera), true};
}

Result<std::vector<PlanePoint>> plane_points(const RectifyOptions& options) {
  if (options.points.has_value() == options.rectangle.has_value())
    return fail(Errc::kBadInput, "which plane? Give points of it, or a rectangle with its size",
                {"points"_option, "rectangle"_option, "size"_option});
  if (options.points && options.size)
    return fail(Errc::kBadInput, "a size belongs to a rectangle, not to points", {"size"_option});
  const double sigma_px = options.sigma_px.value_or(0.5), sigma_m = options.sigma_m.value_or(0);
  std::vector<PlanePoint> points;
  if (options.points) {
    COLLINEA_TRY(const std::string text, read_file(*options.points));
    COLLINEA_TRY(const auto rows, parse_number_rows(text, true, 4, 6).map_error([&](Error e) {
      return std::move(e).within(options.points->string());
    }));
    for (const NumberRow& row : rows) {
      const auto& n = row.numbers;
      points.push_back(
          {row.name, {n[0], n[1]}, {n[2], n[3]}, n.size() > 4 ? n[4] : sigma_px, n.size() > 5 ? n[5] : sigma_m});
    }
    return points;
  }
  if (!options.size)
    return fail(Errc::kBadInput, "a rectangle needs its size: width,height in metres", {"size"_option});
  COLLINEA_TRY(const auto c, numbers_of(*options.rectangle, "rectangle"_option));
  COLLINEA_TRY(const auto s, numbers_of(*options.size, "size"_option));
  if (c.size() != 8)
    return fail(Errc::kBadInput, "column,row of the four corners of a rectangle are wanted", {"rectangle"_option});
  if (s.size() != 2 || !(s[0] > 0 && s[1] > 0))
    return fail(Errc::kBadInput, "the size of a rectangle is width,height, both positive", {"size"_option});
  const Vector2d corners[4] = {{0, s[1]}, {s[0], s[1]}, {s[0], 0}, {0, 0}};
  const char* names[4] = {"upper left", "upper right", "lower right", "lower left"};
  for (std::size_t i = 0; i < 4; ++i)
    points.push_back({names[i], {c[2 * i], c[2 * i + 1]}, corners[i], sigma_px, sigma_m});
  return points;
}

// What the homography is worth.
RectifiedReport::FromPoints worth_of(const PlaneHomography& homography, const std::vector<PlanePoint>& points,
                                     const PlaneExtent& extent) {
  RectifiedReport::FromPoints out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& r = homography.residuals()[i];
    out.points.push_back({points[i].name, r.px, r.m, r.in_sigmas});
  }
  // Residuals larger than stated count; smaller ones may be luck.
  const double scale = std::max(1.0, homography.sigma0());
  out.sigma_position_m = spread_of(extent, [&](const Vector2d& p) {
    return homography.matrix().row(2).dot(p.homogeneous()) > 0 ? scale * std::sqrt(homography.covariance_at(p).trace())
                                                               : std::numeric_limits<double>::infinity();
  });
  out.redundancy = int(homography.redundancy());
  out.sigma0 = homography.sigma0();
  out.residuals_are_too_large = homography.redundancy() > 0 && homography.residuals_too_large();
  return out;
}

Result<RectifiedReport> rectify_image(const fs::path& image, const fs::path& out, const RectifyOptions& options,
                                      const Run& run) {
  if (options.control || options.map_points || options.region || options.tolerance_m)
    return fail(Errc::kBadInput, "control, map points, a region and its tolerance are for a project, not a photograph",
                {"control"_option, "map_points"_option, "region"_option, "tolerance_m"_option});
  COLLINEA_TRY(const auto points, plane_points(options));
  COLLINEA_TRY(const CameraOfImage used, camera_of(image, options, run));
  COLLINEA_TRY(const PlaneHomography homography, PlaneHomography::fit(used.camera, points));
  std::vector<Vector2d> around;
  for (const PlanePoint& p : points) around.push_back(p.on_plane_m);
  COLLINEA_TRY(const PlaneExtent extent, extent_of(options, around));
  PlaneView view{ImageId{0}, used.camera, homography.matrix(), {}};
  RectifiedReport::FromPoints worth = worth_of(homography, points, extent);
  worth.is_lens_known = options.project || options.orientation;
  if (used.known) {
    view.centre_over_plane = centre_over_plane(homography.matrix());
  } else if (const auto focal = homography.focal()) {
    view.centre_over_plane = centre_over_plane(homography.matrix(), focal->times);
    worth.focal_px = focal->times * used.camera.focal_px();
    worth.focal_sigma_px = focal->sigma * std::max(1.0, homography.sigma0()) * used.camera.focal_px();
  }
  const auto pixels = [&](ImageId, int shrink) { return read_colour(image, shrink); };
  COLLINEA_TRY(RectifiedReport report, paint(out, extent, {view}, {image.filename().string()}, pixels, options, run));
  report.from_points = std::move(worth);
  return finished(std::move(report));
}

// --- from a project --------------------------------------------------------------------------------------------------

std::vector<PlaneView> views_of_plane(const Block& block, const FramedPlane& plane) {
  std::vector<PlaneView> views;
  for (const auto& [image, cam_from_world] : oriented_images(block)) {
    const Vector3d centre = plane.in_plane(centre_of(cam_from_world));
    if (!(centre.z() > 0)) continue;  // behind the plane
    const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
    PlaneView view{image, block.camera_of(image), {}, centre};
    view.bend = block.images.at(image).bend;
    view.cam_from_plane << rotation * plane.world_from_plane.leftCols<2>(), cam_from_world * plane.origin_in_world;
    views.push_back(std::move(view));
  }
  return views;
}

Result<RectifiedReport> rectify_project(const fs::path& folder, const fs::path& out, const RectifyOptions& options,
                                        const Run& run) {
  if (options.points || options.rectangle || options.size || options.project || options.orientation || options.focal_px)
    return fail(Errc::kBadInput,
                "points, a rectangle and its size, a project, an orientation and a focal length are for a photograph, "
                "not a project",
                {"points"_option, "rectangle"_option, "size"_option, "project"_option, "orientation"_option,
                 "focal_px"_option});
  if (options.sigma_px || options.sigma_m)
    return fail(Errc::kBadInput,
                "standard deviations are of the points of a photograph; a project's plane is judged by how far its "
                "points lie off it",
                {"sigma_px"_option, "sigma_m"_option});
  COLLINEA_TRY(const Project project, open_project(folder, run));
  COLLINEA_TRY(const Block block, project.store.read_block());
  if (oriented_images(block).empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + folder.string());
  COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
  const AskedPlane asked{options.control, options.map_points, options.region, options.tolerance_m};
  COLLINEA_TRY(const ProjectPlane plane, plane_of_project(project, block, product_frame, asked));
  COLLINEA_TRY(const PlaneExtent extent, extent_of(options, {Vector2d::Zero(), plane.extent}));
  const auto views = views_for(views_of_plane(block, plane.frame), extent);
  if (views.empty()) return fail(Errc::kIllPosed, "no photograph shows the plane from its front");
  std::vector<std::string> names;
  for (const PlaneView& view : views) names.push_back(block.images.at(view.image).file);
  const auto pixels = [&](ImageId image, int shrink) {
    return read_colour(project.image_file(block.images.at(image)), shrink);
  };
  COLLINEA_TRY(RectifiedReport report, paint(out, extent, views, names, pixels, options, run));
  const auto on_map = [&](const Vector3d& p) {
    return product_frame.frame ? product_frame.frame->map_from_local(p) : p;
  };
  report.is_metric = product_frame.metric;
  report.from_project = {
      .points = plane.points,
      .points_looked_at = plane.of,
      .rms_m = plane.rms_m,
      .origin_on_map = on_map(plane.frame.origin_in_world),
      .origin_in_world = plane.frame.origin_in_world,
      .x_axis_in_world = plane.frame.world_from_plane.col(0),
      .y_axis_in_world = plane.frame.world_from_plane.col(1),
      .normal_in_world = plane.frame.world_from_plane.col(2),
      .shift_by_rms_per_m = spread_of(extent, [&](const Vector2d& p) { return *shift_per_depth(views[0], p); })};
  return finished(std::move(report));
}

}  // namespace

Result<RectifiedReport> rectify_plane(const fs::path& source, const fs::path& out, const RectifyOptions& options,
                                      const Run& run) {
  COLLINEA_TRY(validate(options));
  std::string extension = lower(out.extension().string());
  if (extension != ".tif" && extension != ".tiff" && extension != ".png")
    return fail(Errc::kBadInput, out.string() + ": the image is a .tif or a .png");
  std::error_code error;
  for (const std::optional<fs::path>& read : {std::optional(source), options.points, options.map_points})
    for (const fs::path& made :
         {out, fs::path(out).replace_extension(".json"), fs::path(out).replace_extension(".pgw")})
      if (read && fs::equivalent(*read, made, error))
        return fail(Errc::kBadInput, made.string() + " would be written over what is read from it");
  error.clear();
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), error);
  if (error) return fail(Errc::kBadInput, "cannot make " + out.parent_path().string() + ": " + error.message());
  return fs::is_directory(source, error) ? rectify_project(source, out, options, run)
                                         : rectify_image(source, out, options, run);
}

}  // namespace collinea
