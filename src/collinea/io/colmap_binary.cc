// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/packed.h"
#include "collinea/io/internal/colmap_model.h"

namespace collinea::colmap {
namespace {

void put(Packer& packer, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) packer.put(v[i]);
}

void get(Unpacker& unpacker, Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) unpacker.get(v[i]);
}

tl::unexpected<Error> truncated() { return fail(Errc::kBadFormat, "truncated or damaged"); }

std::string text_until_zero(Unpacker& unpacker) {
  std::string text;
  while (unpacker.ok()) {
    const char c = char(unpacker.get<std::uint8_t>());
    if (c == '\0') break;
    text += c;
  }
  return text;
}

// A count that the bytes left could really hold, each item taking at least `item_bytes`.
std::optional<std::size_t> count_of(Unpacker& unpacker, std::size_t item_bytes) {
  const auto count = unpacker.get<std::uint64_t>();
  if (!unpacker.ok() || count > unpacker.left() / item_bytes) return std::nullopt;
  return std::size_t(count);
}

}  // namespace

std::string cameras_binary(const Model& model) {
  Packer packer;
  packer.put(std::uint64_t(model.cameras.size()));
  for (const CameraRow& camera : model.cameras) {
    packer.put(std::uint32_t(camera.id));
    packer.put(std::int32_t(camera.model));
    packer.put(camera.width_px);
    packer.put(camera.height_px);
    for (const double value : camera.params) packer.put(value);
  }
  return packer.bytes();
}

std::string images_binary(const Model& model) {
  Packer packer;
  packer.put(std::uint64_t(model.images.size()));
  for (const ImageRow& image : model.images) {
    const auto& q = image.cam_from_world.rotation;
    packer.put(std::uint32_t(image.id));
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) packer.put(value);
    put(packer, image.cam_from_world.translation);
    packer.put(std::uint32_t(image.camera));
    packer.put_text(image.name, image.name.size() + 1);
    packer.put(std::uint64_t(image.seen.size()));
    for (const SeenPoint& seen : image.seen) {
      packer.put(seen.pixel.x());
      packer.put(seen.pixel.y());
      packer.put(seen.point);
    }
  }
  return packer.bytes();
}

std::string points_binary(const Model& model) {
  Packer packer;
  packer.put(std::uint64_t(model.points.size()));
  for (const PointRow& point : model.points) {
    packer.put(point.id);
    put(packer, point.position);
    for (const std::uint8_t channel : point.colour) packer.put(channel);
    packer.put(point.error_px);
    packer.put(std::uint64_t(point.track.size()));
    for (const TrackElement& element : point.track) {
      packer.put(std::uint32_t(element.image));
      packer.put(std::uint32_t(element.index));
    }
  }
  return packer.bytes();
}

Result<std::vector<CameraRow>> parse_cameras_binary(std::string_view bytes) {
  Unpacker unpacker(bytes);
  const auto count = count_of(unpacker, 4 + 4 + 8 + 8 + 3 * 8);
  if (!count) return truncated();
  std::vector<CameraRow> cameras(*count);
  for (CameraRow& camera : cameras) {
    camera.id = unpacker.get<std::uint32_t>();
    camera.model = unpacker.get<std::int32_t>();
    unpacker.get(camera.width_px);
    unpacker.get(camera.height_px);
    if (!unpacker.ok()) return truncated();
    if (camera.model < 0 || std::size_t(camera.model) >= kModels.size())
      return fail(Errc::kUnsupported, "camera model number " + std::to_string(camera.model) + " is not supported");
    camera.params.resize(kModels[std::size_t(camera.model)].params);
    for (double& value : camera.params) unpacker.get(value);
  }
  if (!unpacker.ok()) return truncated();
  return cameras;
}

Result<std::vector<ImageRow>> parse_images_binary(std::string_view bytes) {
  Unpacker unpacker(bytes);
  const auto count = count_of(unpacker, 4 + 7 * 8 + 4 + 1 + 8);
  if (!count) return truncated();
  std::vector<ImageRow> images(*count);
  for (ImageRow& image : images) {
    auto& q = image.cam_from_world.rotation;
    image.id = unpacker.get<std::uint32_t>();
    for (double* value : {&q.w(), &q.x(), &q.y(), &q.z()}) unpacker.get(*value);
    get(unpacker, image.cam_from_world.translation);
    image.camera = unpacker.get<std::uint32_t>();
    image.name = text_until_zero(unpacker);
    const auto seen = count_of(unpacker, 24);
    if (!seen) return truncated();
    image.seen.resize(*seen);
    for (SeenPoint& point : image.seen) {
      unpacker.get(point.pixel.x());
      unpacker.get(point.pixel.y());
      unpacker.get(point.point);
    }
  }
  if (!unpacker.ok()) return truncated();
  return images;
}

Result<std::vector<PointRow>> parse_points_binary(std::string_view bytes) {
  Unpacker unpacker(bytes);
  const auto count = count_of(unpacker, 8 + 24 + 3 + 8 + 8);
  if (!count) return truncated();
  std::vector<PointRow> points(*count);
  for (PointRow& point : points) {
    unpacker.get(point.id);
    get(unpacker, point.position);
    for (std::uint8_t& channel : point.colour) unpacker.get(channel);
    unpacker.get(point.error_px);
    const auto track = count_of(unpacker, 8);
    if (!track) return truncated();
    point.track.resize(*track);
    for (TrackElement& element : point.track) {
      element.image = unpacker.get<std::uint32_t>();
      element.index = unpacker.get<std::uint32_t>();
    }
  }
  if (!unpacker.ok()) return truncated();
  return points;
}

}  // namespace collinea::colmap
