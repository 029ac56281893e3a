// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/write.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/io/control_file.h"
#include "collinea/io/text.h"
#include "collinea/math/random.h"
#include "collinea/raster/image_file.h"
#include "collinea/synthetic/render.h"

namespace collinea {
namespace {

constexpr int kJpegQuality = 92;
constexpr std::uint64_t kBarometerStream = 6000;
// Receivers that are this good say so in the header; others say nothing of their accuracy.
constexpr double kRtkSigma_m = 0.2;
// Titles of the columns of the true poses and marks.
constexpr FileText kPoseColumns = "# file, x, y, z, qw, qx, qy, qz, easting, northing, height\n";
constexpr FileText kMarkColumns = "# id, role, x, y, z, easting, northing, height\n";

ImageHeader header_of(const Truth& truth, ImageId id) {
  const Image& image = truth.block.images.at(id);
  const Camera& camera = truth.block.camera_of(id);
  ImageHeader header;
  header.width_px = camera.width_px;
  header.height_px = camera.height_px;
  header.maker = "Collinea";
  header.model = fmt::format("Synthetic {:.0f}MP", double(camera.width_px) * camera.height_px / 1e6);
  header.focal_mm = truth.lens_mm;
  // The equivalent for film of 36 x 24 mm compares diagonals and is a whole number, as cameras write it.
  header.focal_35mm_mm =
      std::round(truth.nominal_focal_px * std::hypot(36, 24) / std::hypot(camera.width_px, camera.height_px));
  header.taken = image.taken;
  if (image.position) {
    header.latitude_deg = image.position->latitude_deg;
    header.longitude_deg = image.position->longitude_deg;
    header.height_m = image.position->height_m;
    if (image.position->sigma_m.maxCoeff() <= kRtkSigma_m) {
      header.sigma_east_m = image.position->sigma_m.x();
      header.sigma_north_m = image.position->sigma_m.y();
      header.sigma_height_m = image.position->sigma_m.z();
    }
  }
  if (image.attitude) {
    Random random(truth.seed, (kBarometerStream << 32) + id.value);
    header.relative_height_m = centre_of(pose_of(truth.block, id)).z() + 0.3 * random.normal();
    header.heading_deg = image.attitude->heading_deg;
    header.pitch_deg = image.attitude->pitch_deg;
    header.roll_deg = image.attitude->roll_deg;
  }
  return header;
}

std::string xyz(const Eigen::Vector3d& p, int decimals) {
  return fixed(p.x(), decimals) + ", " + fixed(p.y(), decimals) + ", " + fixed(p.z(), decimals);
}

std::string role_of(const ControlPoint& point) { return point.role == ControlRole::kControl ? "control" : "check"; }

std::string control_text(const Truth& truth) {
  std::string text = "# collinea control, " + truth.block.georeference->crs + "\n# " + kControlPointColumns + "\n# " +
                     kControlImageColumns + "\n";
  for (const auto& [id, point] : truth.block.control)
    text += "point, " + point.name + ", " + xyz(point.position_in_map, 4) + ", " + xyz(point.sigma_m, 4) + ", " +
            role_of(point) + "\n";
  for (const ControlObservation& seen : truth.block.control_observations)
    text += "image, " + truth.block.control.at(seen.point).name + ", " + truth.block.images.at(seen.image).file + ", " +
            fixed(seen.pixel.x(), 3) + ", " + fixed(seen.pixel.y(), 3) + ", " + fixed(seen.sigma_px, 3) + "\n";
  return text;
}

std::string camera_text(const Camera& camera) {
  std::string text = "# name, value\n";
  text += fmt::format("width_px, {}\nheight_px, {}\n", camera.width_px, camera.height_px);
  if (!is<Brown>(camera.model)) text += "model, " + std::string(name_of(camera.model)) + "\n";
  if (camera.additional != AdditionalSet::kNone)
    text += "additional, " + std::string(kAdditionalNames[std::size_t(camera.additional)]) + "\n";
  for (const int k : params_of(camera)) text += param_name(k) + ", " + exact(camera.params[std::size_t(k)]) + "\n";
  return text;
}

std::string poses_text(const Truth& truth) {
  std::string text = kPoseColumns;
  for (const auto& [id, pose] : oriented_images(truth.block)) {
    const Eigen::Vector3d centre = centre_of(pose);
    const auto& q = pose.rotation;
    text += truth.block.images.at(id).file + ", " + exact(centre.x()) + ", " + exact(centre.y()) + ", " +
            exact(centre.z()) + ", " + exact(q.w()) + ", " + exact(q.x()) + ", " + exact(q.y()) + ", " + exact(q.z()) +
            ", " + xyz(truth.frame.map_from_local(centre), 6) + "\n";
  }
  return text;
}

std::string marks_text(const Truth& truth) {
  std::string text = kMarkColumns;
  for (const auto& [id, position] : truth.marks_in_world) {
    const ControlPoint& point = truth.block.control.at(id);
    text += point.name + ", " + role_of(point) + ", " + xyz(position, 6) + ", " +
            xyz(truth.frame.map_from_local(position), 6) + "\n";
  }
  return text;
}

std::string frame_text(const Georeference& g) {
  return "# name, value\ncrs, " + g.crs + "\nlatitude_deg, " + exact(g.origin_latitude_deg) + "\nlongitude_deg, " +
         exact(g.origin_longitude_deg) + "\nheight_m, " + exact(g.origin_height_m) + "\n";
}

Result<> write_all(const Truth& truth, const std::filesystem::path& folder, const Run& run) {
  std::error_code error;
  std::filesystem::create_directories(folder / "images", error);
  std::filesystem::create_directories(folder / "truth", error);
  if (error) return fail(Errc::kNotFound, folder.string() + ": cannot be made: " + error.message());
  COLLINEA_TRY(write_tables(truth, folder));
  COLLINEA_TRY(write_images(truth, folder / "images", run));
  return write_products(truth, folder / "truth", truth.gsd_m, run);
}

}  // namespace

Result<> write_images(const Truth& truth, const std::filesystem::path& images, const Run& run) {
  std::optional<RayTable> rays;
  CameraId camera;
  std::size_t done = 0;
  for (const auto& [id, image] : truth.block.images) {
    if (!rays || camera != image.camera) {
      camera = image.camera;
      rays.emplace(truth.block.cameras.at(camera), run);
    }
    COLLINEA_TRY(const ColourImage raster, render(truth, id, *rays, run));
    const ImageHeader header = header_of(truth, id);
    COLLINEA_TRY(write_jpeg(images / image.file, raster, kJpegQuality, &header));
    run.report("photographs", double(++done) / double(truth.block.images.size()));
  }
  return {};
}

namespace {

// What an earlier simulation left and this one does not write: rasters, and images that its own truth names.
Result<> remove_earlier(const Truth& truth, const std::filesystem::path& folder) {
  if (!is_there(folder / "truth/poses.csv")) return {};
  for (const char* raster : {"truth/dsm.tif", "truth/dtm.tif", "truth/ortho.tif"})
    COLLINEA_TRY(remove_file(folder / raster));
  const auto earlier = read_truth(folder);
  if (!earlier) return {};  // damaged: nothing is known to be ours
  std::set<std::string> files;
  for (const auto& [id, image] : truth.block.images) files.insert(image.file);
  for (const auto& [file, pose] : earlier->cam_from_world)
    if (!files.contains(file)) COLLINEA_TRY(remove_file(folder / "images" / file));
  return {};
}

}  // namespace

Result<> write_tables(const Truth& truth, const std::filesystem::path& folder) {
  COLLINEA_TRY(remove_earlier(truth, folder));
  const std::filesystem::path inner = folder / "truth";
  const std::pair<std::filesystem::path, std::string> files[] = {
      {folder / "control.csv", control_text(truth)},
      {inner / "camera.csv", camera_text(truth.block.cameras.begin()->second)},
      {inner / "poses.csv", poses_text(truth)},
      {inner / "marks.csv", marks_text(truth)},
      {inner / "frame.csv", frame_text(*truth.block.georeference)},
  };
  for (const auto& [path, text] : files) COLLINEA_TRY(write_file(path, text));
  return {};
}

Result<> simulate(const SurveyOptions& options, const std::filesystem::path& folder, const Run& run) {
  COLLINEA_TRY(const Truth truth, make_survey(options, run));
  return write_all(truth, folder, run);
}

Result<> simulate(const FacadeOptions& options, const std::filesystem::path& folder, const Run& run) {
  COLLINEA_TRY(const Truth truth, make_facade(options, run));
  return write_all(truth, folder, run);
}

}  // namespace collinea
