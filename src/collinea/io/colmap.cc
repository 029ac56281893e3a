// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/colmap.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/io/internal/colmap_camera.h"
#include "collinea/io/internal/colmap_model.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using namespace colmap;

// --- to COLMAP -------------------------------------------------------------------------------------------------------

Result<std::map<CameraId, ExportedCamera>> exported_cameras(const Block& block) {
  std::map<CameraId, ExportedCamera> cameras;
  for (const auto& [id, pose] : oriented_images(block)) {
    const CameraId camera = block.images.at(id).camera;
    if (cameras.contains(camera)) continue;
    COLLINEA_TRY(cameras[camera], exported(camera, block.camera_of(id)));
  }
  return cameras;
}

std::vector<Finding> findings_on(const Block& block, const std::map<CameraId, ExportedCamera>& used) {
  std::vector<Finding> findings;
  for (const auto& [id, camera] : used) findings.insert(findings.end(), camera.findings.begin(), camera.findings.end());
  if (count_oriented(block) < block.images.size())
    findings.push_back(finding_of(FindingCode::kImagesNotExported, {},
                                  {{FigureName::kCount, double(block.images.size() - count_oriented(block))}}));
  return findings;
}

Model model_of(const Block& block, const std::map<CameraId, ExportedCamera>& used) {
  Model model;
  for (const auto& [id, camera] : used) model.cameras.push_back(camera.row);
  std::map<ImageId, std::size_t> rows;
  for (const auto& [id, pose] : oriented_images(block)) {
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
    const Camera& camera = block.camera_of(o.image);
    const Eigen::Vector2d seen =
        camera.additional == AdditionalSet::kNone ? o.pixel : without_additional(camera, o.pixel);
    image.seen.push_back({seen, point_row.id});
    const auto pixel = project(camera, image.cam_from_world * point_row.position);
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
    if (!(q.norm() > 1e-6) || !std::isfinite(q.norm()) || !q.coeffs().allFinite() ||
        !row.cam_from_world.translation.allFinite())
      return fail(Errc::kBadFormat, "image " + row.name + " has no sensible pose");
    Rigid3 pose = row.cam_from_world;
    if (std::abs(q.squaredNorm() - 1) > 1e-12) pose.rotation.normalize();
    set_pose(block, {image_id(row.id)}, pose);
    block.images[{image_id(row.id)}] = std::move(image);
  }
  return {};
}

Result<> take_points(const Model& model, IdRule image_id, IdRule point_id, Block& block) {
  std::map<std::uint64_t, const ImageRow*> images;
  for (const ImageRow& row : model.images) images[row.id] = &row;
  for (const PointRow& row : model.points) {
    const PointId point{point_id(row.id)};
    if (!row.position.allFinite())
      return fail(Errc::kBadFormat, "point " + std::to_string(row.id) + " has no sensible position");
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
      if (!o.pixel.allFinite())
        return fail(Errc::kBadFormat, "point " + std::to_string(row.id) + " is seen nowhere in image " +
                                          escaped_name(image->second->name));
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
    COLLINEA_TRY(block.cameras[{camera_id(row.id)}], imported(row));
  }
  COLLINEA_TRY(take_images(model.images, image_id, camera_id, block));
  COLLINEA_TRY(take_points(model, image_id, point_id, block));
  return block;
}

template <class Rows>
Result<Rows> parsed_file(const std::filesystem::path& path, Result<Rows> (*parse)(std::string_view)) {
  COLLINEA_TRY(const std::string bytes, read_file(path));
  return parse(bytes).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace

Result<std::vector<Finding>> write_colmap(const std::filesystem::path& folder, const Block& block,
                                          ColmapEncoding encoding) {
  COLLINEA_TRY(check_image_names(block, "a COLMAP model"));
  COLLINEA_TRY(const auto used, exported_cameras(block));
  const Model model = model_of(block, used);
  const bool text = encoding == ColmapEncoding::kText;
  const std::string end = text ? ".txt" : ".bin";
  const std::array<std::pair<std::string, std::string>, 3> files = {
      {{"cameras", text ? cameras_text(model) : cameras_binary(model)},
       {"images", text ? images_text(model) : images_binary(model)},
       {"points3D", text ? points_text(model) : points_binary(model)}}};
  for (const auto& [name, bytes] : files) COLLINEA_TRY(write_file(folder / (name + end), bytes));
  return findings_on(block, used);
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

Result<std::vector<Camera>> read_colmap_cameras(const std::filesystem::path& file) {
  COLLINEA_TRY(std::vector<CameraRow> rows, parsed_file(file, parse_cameras_text));
  if (rows.empty()) return fail(Errc::kBadFormat, file.string() + ": no camera");
  std::sort(rows.begin(), rows.end(), [](const CameraRow& a, const CameraRow& b) { return a.id < b.id; });
  std::vector<Camera> cameras(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    COLLINEA_TRY(cameras[i], imported(rows[i]).map_error([&](Error e) { return std::move(e).within(file.string()); }));
  }
  return cameras;
}

}  // namespace collinea
