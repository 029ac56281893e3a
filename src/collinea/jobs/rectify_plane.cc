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
#include "collinea/jobs/project_plane.h"
#include "collinea/ortho/plane_homography.h"
#include "collinea/ortho/rectify.h"
#include "collinea/project/fitted_camera.h"
#include "collinea/project/json_text.h"
#include "collinea/raster/photo.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWider = 0.1;  // of the points' extent, on each side

Result<std::vector<double>> numbers_of(const std::string& text, const char* flag) {
  return parse_numbers(text).map_error([&](Error e) { return std::move(e).within(flag); });
}

// --- what is told of the result --------------------------------------------------------------------------------------

struct Told {
  std::string text;
  nlohmann::json json;
};

// A number at the middle of the extent and the largest at its corners.
struct Spread {
  double middle = 0, worst = 0;
};
template <class Measure>
Spread spread_of(const PlaneExtent& extent, const Measure& measure) {
  Spread spread{measure(extent.at(0.5, 0.5)), 0};
  for (int corner = 0; corner < 4; ++corner)
    spread.worst = std::max(spread.worst, measure(extent.at(corner & 1, corner >> 1)));
  return spread;
}

nlohmann::json json_of(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Result<PlaneExtent> extent_of(const RectifyOptions& options, const std::vector<Vector2d>& around) {
  if (options.extent) {
    COLLINEA_TRY(const auto n, numbers_of(*options.extent, "--extent"));
    if (n.size() != 4 || !(n[2] > n[0] && n[3] > n[1]))
      return fail(Errc::kBadInput, "--extent " + *options.extent + ": left,bottom,right,top are wanted");
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

// Two digits: what is told is what is used.
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

Result<Told> paint(const fs::path& out, const PlaneExtent& extent, const std::vector<PlaneView>& views,
                   const std::vector<std::string>& names, const PixelSource& pixels, const RectifyOptions& options,
                   const Run& run) {
  COLLINEA_TRY(const double cell_m, cell_of(options, views, extent));
  COLLINEA_TRY(const MapGrid grid, plane_grid(extent, cell_m));
  COLLINEA_TRY(const RectifiedSummary summary, write_rectified(out, grid, views, pixels, run));
  Told told;
  const double share = double(summary.painted_cells) / double(summary.painted_cells + summary.empty_cells);
  told.text = fmt::format("{}: {} x {} cells of {}, {:.1f} % painted\n", out.string(), grid.width, grid.height,
                          metres_text(cell_m), 100 * share);
  told.json = {{"cell_m", cell_m},
               {"width", grid.width},
               {"height", grid.height},
               {"left_m", grid.west_m},
               {"top_m", grid.north_m},
               {"painted_share", share},
               {"photographs", nlohmann::json::array()}};
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (summary.cells_of[v] == 0) continue;
    nlohmann::json photo = {{"file", names[v]}, {"cells", summary.cells_of[v]}};
    if (views[v].centre_over_plane) photo["centre_over_plane_m"] = json_of(*views[v].centre_over_plane);
    told.json["photographs"].push_back(photo);
  }
  if (views[0].centre_over_plane) {
    const Spread shift = spread_of(extent, [&](const Vector2d& p) { return shift_per_depth(views[0], p).value_or(0); });
    told.text +=
        fmt::format("off the plane: 10 cm of depth shift a place by {} in the middle, {} in the worst corner\n",
                    metres_text(0.1 * shift.middle), metres_text(0.1 * shift.worst));
    told.json["shift_per_depth"] = {{"middle", shift.middle}, {"worst_corner", shift.worst}};
  } else {
    told.text += "off the plane: not known, the view is too frontal to say where the camera stood (--focal-px)\n";
  }
  return told;
}

Result<std::string> finished(Told told, const fs::path& out) {
  fs::path json = out;
  COLLINEA_TRY(write_file(json.replace_extension(".json"), json_text(told.json, 2) + "\n"));
  return told.text;
}

// --- from a photograph -----------------------------------------------------------------------------------------------

struct PhotoCamera {
  Camera camera;
  bool known = false;  // its focal length and lens
};

Result<PhotoCamera> camera_of(const fs::path& photo, const RectifyOptions& options, const Run& run) {
  COLLINEA_TRY(const PhotoHeader header, read_photo_header(photo));
  if (int(options.project.has_value()) + int(options.orientation.has_value()) + int(options.focal_px.has_value()) > 1)
    return fail(Errc::kBadInput, "one of --project, --orientation and --focal-px says the camera, not several");
  if (!options.project && !options.orientation) {
    const double focal_px = options.focal_px.value_or(std::max(header.width_px, header.height_px));
    return PhotoCamera{ideal_camera(focal_px, header.width_px, header.height_px), options.focal_px.has_value()};
  }
  Block block;
  if (options.project) {
    COLLINEA_TRY(const Project project, open_project(*options.project, run));
    COLLINEA_TRY(block, project.store.read_block());
  } else {
    COLLINEA_TRY(block, read_colmap(*options.orientation));
  }
  COLLINEA_TRY(const ImageId image, ImageNames(block).find_photo(photo));
  COLLINEA_TRY(Camera camera, fitted_to(block.camera_of(image), header.width_px, header.height_px, photo.string()));
  return PhotoCamera{std::move(camera), true};
}

Result<std::vector<PlanePoint>> plane_points(const RectifyOptions& options) {
  if (options.points.has_value() == options.rectangle.has_value())
    return fail(Errc::kBadInput, "which plane? Give --points, or --rectangle with --size");
  if (options.points && options.size) return fail(Errc::kBadInput, "--size belongs to --rectangle, not to --points");
  const double sigma_px = options.sigma_px.value_or(0.5), sigma_m = options.sigma_m.value_or(0);
  std::vector<PlanePoint> points;
  if (options.points) {
    COLLINEA_TRY(const std::string text, read_file(*options.points));
    COLLINEA_TRY(const auto rows, parse_number_rows(text, true, 4, 6).map_error([&](Error e) {
      return std::move(e).within(*options.points);
    }));
    for (const NumberRow& row : rows) {
      const auto& n = row.numbers;
      points.push_back(
          {row.name, {n[0], n[1]}, {n[2], n[3]}, n.size() > 4 ? n[4] : sigma_px, n.size() > 5 ? n[5] : sigma_m});
    }
    return points;
  }
  if (!options.size) return fail(Errc::kBadInput, "--rectangle needs --size width,height in metres");
  COLLINEA_TRY(const auto c, numbers_of(*options.rectangle, "--rectangle"));
  COLLINEA_TRY(const auto s, numbers_of(*options.size, "--size"));
  if (c.size() != 8) return fail(Errc::kBadInput, "--rectangle: column,row of four corners are wanted");
  if (s.size() != 2 || !(s[0] > 0 && s[1] > 0)) return fail(Errc::kBadInput, "--size: width,height are wanted");
  const Vector2d corners[4] = {{0, s[1]}, {s[0], s[1]}, {s[0], 0}, {0, 0}};
  const char* names[4] = {"upper left", "upper right", "lower right", "lower left"};
  for (std::size_t i = 0; i < 4; ++i)
    points.push_back({names[i], {c[2 * i], c[2 * i + 1]}, corners[i], sigma_px, sigma_m});
  return points;
}

// What the homography is worth.
void tell(const PlaneHomography& homography, const std::vector<PlanePoint>& points, const PlaneExtent& extent,
          Told& told) {
  std::size_t worst = 0;
  auto& list = told.json["points"] = nlohmann::json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& r = homography.residuals()[i];
    if (r.in_sigmas > homography.residuals()[worst].in_sigmas) worst = i;
    list.push_back({{"name", points[i].name},
                    {"residual_px", {r.px.x(), r.px.y()}},
                    {"residual_m", {r.m.x(), r.m.y()}},
                    {"in_sigmas", r.in_sigmas}});
  }
  // Residuals larger than stated count; smaller ones may be luck.
  const double scale = std::max(1.0, homography.sigma0());
  const Spread sigma = spread_of(extent, [&](const Vector2d& p) {
    return homography.matrix().row(2).dot(p.homogeneous()) > 0 ? scale * std::sqrt(homography.covariance_at(p).trace())
                                                               : std::numeric_limits<double>::infinity();
  });
  told.json["redundancy"] = homography.redundancy();
  told.json["sigma_position_m"] = {{"middle", sigma.middle}, {"worst_corner", sigma.worst}};
  if (homography.redundancy() > 0) {
    told.json["sigma0"] = homography.sigma0();
    const auto& r = homography.residuals()[worst];
    told.text += fmt::format("{} points, sigma0 {:.2f}; largest residual {:.2f} px, {} at point {}\n", points.size(),
                             homography.sigma0(), r.px.norm(), metres_text(r.m.norm()), points[worst].name);
    if (homography.residuals_too_large())
      told.text +=
          "the residuals are larger than the sigmas stated allow: a point is wrong, does not lie on the plane, "
          "or the lens distorts (--project)\n";
  } else {
    told.text += "four points: nothing checks them\n";
  }
  told.text += fmt::format("standard deviation of a place by them: {} in the middle, {} in the worst corner\n",
                           metres_text(sigma.middle), metres_text(sigma.worst));
}

Result<std::string> rectify_photo(const fs::path& photo, const fs::path& out, const RectifyOptions& options,
                                  const Run& run) {
  if (options.control || options.places || options.region || options.tolerance_m)
    return fail(Errc::kBadInput, "--control, --places, --region and --tolerance-m are for a project, not a photograph");
  COLLINEA_TRY(const auto points, plane_points(options));
  COLLINEA_TRY(const PhotoCamera used, camera_of(photo, options, run));
  COLLINEA_TRY(const PlaneHomography homography, PlaneHomography::fit(used.camera, points));
  std::vector<Vector2d> around;
  for (const PlanePoint& p : points) around.push_back(p.on_plane_m);
  COLLINEA_TRY(const PlaneExtent extent, extent_of(options, around));
  PlaneView view{ImageId{0}, used.camera, homography.matrix(), {}};
  std::string lens;
  if (used.known) {
    view.centre_over_plane = centre_over_plane(homography.matrix());
  } else if (const auto focal = homography.focal()) {
    view.centre_over_plane = centre_over_plane(homography.matrix(), focal->times);
    lens = fmt::format("focal length from the perspective of the points: {:.0f} px, standard deviation {:.0f} px\n",
                       focal->times * used.camera.focal_px(),
                       focal->sigma * std::max(1.0, homography.sigma0()) * used.camera.focal_px());
  }
  if (!options.project && !options.orientation)
    lens += "the lens is not known (--project, --orientation): its distortion stays in the picture\n";
  COLLINEA_TRY(Told told, paint(
                              out, extent, {view}, {photo.filename().string()},
                              [&](ImageId, int shrink) { return read_colour(photo, shrink); }, options, run));
  tell(homography, points, extent, told);
  told.text += lens;
  return finished(std::move(told), out);
}

// --- from a project --------------------------------------------------------------------------------------------------

std::vector<PlaneView> views_of_plane(const Block& block, const FramedPlane& plane) {
  std::vector<PlaneView> views;
  for (const auto& [image, cam_from_world] : oriented_images(block)) {
    const Vector3d centre = plane.in_plane(centre_of(cam_from_world));
    if (!(centre.z() > 0)) continue;  // behind the plane
    const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
    PlaneView view{image, block.camera_of(image), {}, centre};
    view.cam_from_plane << rotation * plane.world_from_plane.leftCols<2>(), cam_from_world * plane.origin_in_world;
    views.push_back(std::move(view));
  }
  return views;
}

Result<std::string> rectify_project(const fs::path& folder, const fs::path& out, const RectifyOptions& options,
                                    const Run& run) {
  if (options.points || options.rectangle || options.size || options.project || options.orientation || options.focal_px)
    return fail(Errc::kBadInput,
                "--points, --rectangle, --size, --project, --orientation and --focal-px are for a "
                "photograph, not a project");
  if (options.sigma_px || options.sigma_m)
    return fail(
        Errc::kBadInput,
        "--sigma-px and --sigma-m are of the points of a photograph; a project's plane is judged by how far its "
        "points lie off it");
  COLLINEA_TRY(const Project project, open_project(folder, run));
  COLLINEA_TRY(const Block block, project.store.read_block());
  if (oriented_images(block).empty())
    return fail(Errc::kNotFound, "the block is not oriented yet: collinea orient " + folder.string());
  COLLINEA_TRY(const Places places, places_of(project, block));
  const AskedPlane asked{options.control, options.places, options.region, options.tolerance_m};
  COLLINEA_TRY(const ProjectPlane plane, plane_of_project(project, block, places, asked));
  COLLINEA_TRY(const PlaneExtent extent, extent_of(options, {Vector2d::Zero(), plane.extent}));
  const auto views = views_for(views_of_plane(block, plane.frame), extent);
  if (views.empty()) return fail(Errc::kIllPosed, "no photograph shows the plane from its front");
  std::vector<std::string> names;
  for (const PlaneView& view : views) names.push_back(block.images.at(view.image).file);
  const auto pixels = [&](ImageId image, int shrink) {
    return read_colour(project.photo(block.images.at(image)), shrink);
  };
  COLLINEA_TRY(Told told, paint(out, extent, views, names, pixels, options, run));
  told.text +=
      fmt::format("plane of {} points of {}, {} off it (RMS)\n", plane.points, plane.of, metres_text(plane.rms_m));
  const Spread shift = spread_of(extent, [&](const Vector2d& p) { return *shift_per_depth(views[0], p); });
  told.text += fmt::format("so places are shifted by {} in the middle, {} in the worst corner (RMS)\n",
                           metres_text(plane.rms_m * shift.middle), metres_text(plane.rms_m * shift.worst));
  if (!places.metric) told.text += "the block has no scale: lengths are in its own unit, not in metres\n";
  const auto on_map = [&](const Vector3d& p) { return places.frame ? places.frame->map_from_local(p) : p; };
  told.json["plane"] = {{"points", plane.points},
                        {"points_looked_at", plane.of},
                        {"rms_m", plane.rms_m},
                        {"origin_on_map", json_of(on_map(plane.frame.origin_in_world))},
                        {"origin_in_world", json_of(plane.frame.origin_in_world)},
                        {"x_axis_in_world", json_of(plane.frame.world_from_plane.col(0))},
                        {"y_axis_in_world", json_of(plane.frame.world_from_plane.col(1))},
                        {"normal_in_world", json_of(plane.frame.world_from_plane.col(2))}};
  return finished(std::move(told), out);
}

}  // namespace

Result<std::string> rectify_plane(const fs::path& source, const fs::path& out, const RectifyOptions& options,
                                  const Run& run) {
  COLLINEA_TRY(validate(options));
  std::string extension = lower(out.extension().string());
  if (extension != ".tif" && extension != ".tiff" && extension != ".png")
    return fail(Errc::kBadInput, out.string() + ": the picture is a .tif or a .png");
  std::error_code error;
  for (const std::optional<std::string>& read : {std::optional(source.string()), options.points, options.places})
    for (const fs::path& made :
         {out, fs::path(out).replace_extension(".json"), fs::path(out).replace_extension(".pgw")})
      if (read && fs::equivalent(*read, made, error))
        return fail(Errc::kBadInput, made.string() + " would be written over what is read from it");
  error.clear();
  if (out.has_parent_path()) fs::create_directories(out.parent_path(), error);
  if (error) return fail(Errc::kBadInput, "cannot make " + out.parent_path().string() + ": " + error.message());
  return fs::is_directory(source, error) ? rectify_project(source, out, options, run)
                                         : rectify_photo(source, out, options, run);
}

}  // namespace collinea
