// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/colmap.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "collinea/io/colmap_model.h"
#include "collinea/io/file.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using namespace colmap;

// --- to COLMAP -------------------------------------------------------------------------------------------------------

CameraRow row_of(CameraId id, const Camera& camera) {
  const auto& p = camera.params;
  const double f = p[Camera::kF];
  return {id.value + std::uint64_t{1},
          kFullOpencv,
          std::uint64_t(camera.width_px),
          std::uint64_t(camera.height_px),
          // OpenCV's tangential terms are named the other way round: its p1 is the one that grows with 2 x y in x
          {f + p[Camera::kB1], f, p[Camera::kCx], p[Camera::kCy], p[Camera::kK1], p[Camera::kK2], p[Camera::kP2],
           p[Camera::kP1], p[Camera::kK3], 0, 0, 0}};
}

std::vector<std::string> remarks_on(const Block& block, const std::map<CameraId, Camera>& used) {
  std::vector<std::string> remarks;
  for (const auto& [id, camera] : used) {
    const double f = camera.params[Camera::kF], b2 = camera.params[Camera::kB2];
    const double worst = std::abs(b2) / f * camera.height_px / 2;
    if (worst > 1e-6)
      remarks.push_back("camera " + camera.name + ": its shear b2 = " + fixed(b2, 3) + " px is left out, up to " +
                        fixed(worst, 3) + " px at the picture's edge");
  }
  if (block.cam_from_world.size() < block.images.size())
    remarks.push_back(std::to_string(block.images.size() - block.cam_from_world.size()) +
                      " images without orientation are left out");
  return remarks;
}

Model model_of(const Block& block, const std::map<CameraId, Camera>& used) {
  Model model;
  for (const auto& [id, camera] : used) model.cameras.push_back(row_of(id, camera));
  std::map<ImageId, std::size_t> rows;
  for (const auto& [id, pose] : block.cam_from_world) {
    const Image& image = block.images.at(id);
    rows[id] = model.images.size();
    model.images.push_back({id.value + std::uint64_t{1}, image.camera.value + std::uint64_t{1}, pose, image.file, {}});
  }
  std::map<PointId, std::pair<PointRow, double>> points;  // with the sum of residual lengths
  for (const auto& [id, point] : block.points)
    points[id] = {{id.value + std::uint64_t{1}, point.position_in_world, point.colour, 0, {}}, 0};
  for (const Observation& o : block.observations) {
    const auto row = rows.find(o.image);
    const auto point = points.find(o.point);
    if (row == rows.end() || point == points.end()) continue;
    ImageRow& image = model.images[row->second];
    auto& [point_row, residuals] = point->second;
    point_row.track.push_back({image.id, image.seen.size()});
    image.seen.push_back({o.pixel, point_row.id});
    const auto pixel = project(block.camera_of(o.image), image.cam_from_world * point_row.position);
    if (pixel) residuals += (*pixel - o.pixel).norm();
  }
  for (auto& [id, entry] : points) {
    if (entry.first.track.empty()) continue;
    entry.first.error_px = entry.second / double(entry.first.track.size());
    model.points.push_back(std::move(entry.first));
  }
  return model;
}

// --- from COLMAP -----------------------------------------------------------------------------------------------------

Result<Camera> camera_of(const CameraRow& row) {
  const auto& v = row.params;
  if (row.width_px > 1'000'000 || row.height_px > 1'000'000)
    return fail(Errc::kBadFormat, "a camera without sensible size");
  Camera camera;
  camera.width_px = int(row.width_px);
  camera.height_px = int(row.height_px);
  camera.name = "COLMAP camera " + std::to_string(row.id);
  camera.source = "given";
  auto& p = camera.params;
  const std::string_view model = kModels[std::size_t(row.model)].name;
  const bool two_focals = model == "PINHOLE" || model == "OPENCV" || model == "FULL_OPENCV";
  const std::size_t centre = two_focals ? 2 : 1, distortion = centre + 2;
  p[Camera::kF] = v[two_focals ? 1 : 0];
  p[Camera::kB1] = two_focals ? v[0] - v[1] : 0;
  p[Camera::kCx] = v[centre];
  p[Camera::kCy] = v[centre + 1];
  if (model == "SIMPLE_RADIAL" || model == "RADIAL" || model == "OPENCV" || model == "FULL_OPENCV")
    p[Camera::kK1] = v[distortion];
  if (model == "RADIAL" || model == "OPENCV" || model == "FULL_OPENCV") p[Camera::kK2] = v[distortion + 1];
  if (model == "OPENCV" || model == "FULL_OPENCV") {
    p[Camera::kP2] = v[distortion + 2];
    p[Camera::kP1] = v[distortion + 3];
  }
  if (model == "FULL_OPENCV") {
    p[Camera::kK3] = v[8];
    if (v[9] != 0 || v[10] != 0 || v[11] != 0)
      return fail(Errc::kUnsupported, "a FULL_OPENCV camera with k4, k5 or k6 has no counterpart here");
  } else if (model.find("FISHEYE") != std::string_view::npos || model == "FOV") {
    return fail(Errc::kUnsupported, "camera model " + std::string(model) + " is not supported");
  }
  if (!(p[Camera::kF] > 0)) return fail(Errc::kBadFormat, "a camera without focal length");
  return camera;
}

// COLMAP's ids as ours.
struct IdRule {
  std::uint64_t first;  // the id that becomes 0
  [[nodiscard]] bool fits(std::uint64_t id) const { return id >= first && id - first < 0xffffffffu; }
  [[nodiscard]] std::uint32_t operator()(std::uint64_t id) const { return std::uint32_t(id - first); }
};

template <class Rows>
Result<IdRule> rule_of(const Rows& rows, const char* what) {
  IdRule rule{1};
  for (const auto& row : rows)
    if (row.id == 0) rule.first = 0;
  for (const auto& row : rows)
    if (!rule.fits(row.id)) return fail(Errc::kUnsupported, std::string(what) + " with an id beyond 32 bits");
  return rule;
}

Result<> take_images(const std::vector<ImageRow>& rows, IdRule image_id, IdRule camera_id, Block& block) {
  for (const ImageRow& row : rows) {
    Image image;
    image.file = row.name;
    if (!camera_id.fits(row.camera) || !block.cameras.contains({camera_id(row.camera)}))
      return fail(Errc::kBadFormat, "image " + row.name + " has no camera");
    image.camera = {camera_id(row.camera)};
    const auto& q = row.cam_from_world.rotation;
    if (!(q.norm() > 1e-6) || !q.coeffs().allFinite() || !row.cam_from_world.translation.allFinite())
      return fail(Errc::kBadFormat, "image " + row.name + " has no sensible pose");
    Rigid3 pose = row.cam_from_world;
    if (std::abs(q.squaredNorm() - 1) > 1e-12) pose.rotation.normalize();
    block.cam_from_world[{image_id(row.id)}] = pose;
    block.images[{image_id(row.id)}] = std::move(image);
  }
  return {};
}

Result<> take_points(const Model& model, IdRule image_id, IdRule point_id, Block& block) {
  std::map<std::uint64_t, const ImageRow*> images;
  for (const ImageRow& row : model.images) images[row.id] = &row;
  for (const PointRow& row : model.points) {
    const PointId point{point_id(row.id)};
    block.points[point] = {row.position, row.colour};
    for (const TrackElement& element : row.track) {
      const auto image = images.find(element.image);
      if (image == images.end() || element.index >= image->second->seen.size())
        return fail(Errc::kBadFormat, "point " + std::to_string(row.id) + " is seen in an image that is not there");
      Observation o;
      o.image = {image_id(element.image)};
      o.point = point;
      o.feature = std::uint32_t(element.index);
      o.pixel = image->second->seen[element.index].pixel;
      block.observations.push_back(o);
    }
  }
  const auto key = [](const Observation& o) { return std::tuple(o.point, o.image, o.feature); };
  std::sort(block.observations.begin(), block.observations.end(),
            [&](const Observation& a, const Observation& b) { return key(a) < key(b); });
  return {};
}

Result<Block> block_of(const Model& model) {
  Block block;
  COLLINEA_TRY(const IdRule camera_id, rule_of(model.cameras, "a camera"));
  COLLINEA_TRY(const IdRule image_id, rule_of(model.images, "an image"));
  COLLINEA_TRY(const IdRule point_id, rule_of(model.points, "a point"));
  for (const CameraRow& row : model.cameras) {
    COLLINEA_TRY(block.cameras[{camera_id(row.id)}], camera_of(row));
  }
  if (auto taken = take_images(model.images, image_id, camera_id, block); !taken) return tl::unexpected(taken.error());
  if (auto taken = take_points(model, image_id, point_id, block); !taken) return tl::unexpected(taken.error());
  return block;
}

template <class Rows>
Result<Rows> parsed_file(const std::filesystem::path& path, Result<Rows> (*parse)(std::string_view)) {
  COLLINEA_TRY(const std::string bytes, read_file(path));
  return parse(bytes).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace

Result<std::vector<std::string>> write_colmap(const std::filesystem::path& folder, const Block& block,
                                              ColmapEncoding encoding) {
  std::map<CameraId, Camera> used;
  for (const auto& [id, pose] : block.cam_from_world) used[block.images.at(id).camera] = block.camera_of(id);
  const Model model = model_of(block, used);
  const bool text = encoding == ColmapEncoding::kText;
  const std::string end = text ? ".txt" : ".bin";
  const std::array<std::pair<std::string, std::string>, 3> files = {
      {{"cameras", text ? cameras_text(model) : cameras_binary(model)},
       {"images", text ? images_text(model) : images_binary(model)},
       {"points3D", text ? points_text(model) : points_binary(model)}}};
  for (const auto& [name, bytes] : files)
    if (auto written = write_file(folder / (name + end), bytes); !written) return tl::unexpected(written.error());
  return remarks_on(block, used);
}

Result<Block> read_colmap(const std::filesystem::path& folder) {
  const bool binary = is_there(folder / "cameras.bin");
  const std::string end = binary ? ".bin" : ".txt";
  Model model;
  COLLINEA_TRY(model.cameras,
               parsed_file(folder / ("cameras" + end), binary ? parse_cameras_binary : parse_cameras_text));
  COLLINEA_TRY(model.images, parsed_file(folder / ("images" + end), binary ? parse_images_binary : parse_images_text));
  const auto points = folder / ("points3D" + end);
  if (is_there(points)) {
    COLLINEA_TRY(model.points, parsed_file(points, binary ? parse_points_binary : parse_points_text));
  }
  return block_of(model).map_error([&](Error e) { return std::move(e).within(folder.string()); });
}

}  // namespace collinea
