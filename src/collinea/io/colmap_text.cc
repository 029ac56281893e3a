// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/colmap_model.h"
#include "collinea/io/text.h"

namespace collinea::colmap {
namespace {

using Words = std::vector<std::string_view>;

tl::unexpected<Error> bad_line(std::size_t line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line + 1) + ": " + what);
}

bool is_comment(std::string_view line) { return trimmed(line).starts_with('#'); }

std::optional<std::uint64_t> id_of(std::string_view word) {
  const auto value = integer(word);
  if (!value || *value < 0) return std::nullopt;
  return std::uint64_t(*value);
}

// words[first + i] into values[i]; false when one is missing or no number.
template <class Values>
bool numbers_of(const Words& words, std::size_t first, std::size_t count, Values&& put) {
  if (words.size() < first + count) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = number(words[first + i]);
    if (!value) return false;
    put(i, *value);
  }
  return true;
}

std::optional<ImageRow> image_row(std::string_view line, const Words& words) {
  if (words.size() < 10) return std::nullopt;
  const auto id = id_of(words[0]), camera = id_of(words[8]);
  std::array<double, 7> v{};
  if (!id || !camera || !numbers_of(words, 1, 7, [&](std::size_t i, double x) { v[i] = x; })) return std::nullopt;
  ImageRow image;
  image.id = *id;
  image.camera = *camera;
  image.cam_from_world.rotation = Eigen::Quaterniond(v[0], v[1], v[2], v[3]);
  image.cam_from_world.translation = {v[4], v[5], v[6]};
  image.name = trimmed(line.substr(std::size_t(words[9].data() - line.data())));  // names may hold blanks
  return image;
}

bool read_seen(const Words& words, std::vector<SeenPoint>& seen) {
  if (words.size() % 3 != 0) return false;
  for (std::size_t i = 0; i < words.size(); i += 3) {
    SeenPoint point;
    if (!numbers_of(words, i, 2, [&](std::size_t k, double x) { point.pixel[Eigen::Index(k)] = x; })) return false;
    const auto id = integer(words[i + 2]);
    if (!id) return false;
    point.point = *id < 0 ? kNoPoint : std::uint64_t(*id);
    seen.push_back(point);
  }
  return true;
}

std::optional<PointRow> point_row(const Words& words) {
  if (words.size() < 8 || words.size() % 2 != 0) return std::nullopt;
  PointRow point;
  const auto id = id_of(words[0]);
  bool ok = id && numbers_of(words, 1, 3, [&](std::size_t i, double x) { point.position[Eigen::Index(i)] = x; });
  ok = ok && numbers_of(words, 4, 3, [&](std::size_t i, double x) {
         point.colour[i] = x >= 0 && x <= 255 ? std::uint8_t(x) : std::uint8_t{0};
       });
  ok = ok && numbers_of(words, 7, 1, [&](std::size_t, double x) { point.error_px = x; });
  if (!ok) return std::nullopt;
  point.id = *id;
  for (std::size_t i = 8; i < words.size(); i += 2) {
    const auto image = id_of(words[i]), index = id_of(words[i + 1]);
    if (!image || !index) return std::nullopt;
    point.track.push_back({*image, *index});
  }
  return point;
}

void append(std::string& text, const Eigen::Vector3d& v) {
  for (int i = 0; i < 3; ++i) text += " " + exact(v[i]);
}

}  // namespace

std::string cameras_text(const Model& model) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (const CameraRow& camera : model.cameras) {
    text += std::to_string(camera.id) + " " + std::string(kModels[std::size_t(camera.model)].name) + " " +
            std::to_string(camera.width_px) + " " + std::to_string(camera.height_px);
    for (const double value : camera.params) text += " " + exact(value);
    text += "\n";
  }
  return text;
}

std::string images_text(const Model& model) {
  std::string text =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  for (const ImageRow& image : model.images) {
    const auto& q = image.cam_from_world.rotation;
    text += std::to_string(image.id);
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) text += " " + exact(value);
    append(text, image.cam_from_world.translation);
    text += " " + std::to_string(image.camera) + " " + image.name + "\n";
    for (std::size_t i = 0; i < image.seen.size(); ++i) {
      const SeenPoint& seen = image.seen[i];
      text += (i ? " " : "") + exact(seen.pixel.x()) + " " + exact(seen.pixel.y()) + " " +
              (seen.point == kNoPoint ? "-1" : std::to_string(seen.point));
    }
    text += "\n";
  }
  return text;
}

std::string points_text(const Model& model) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (const PointRow& point : model.points) {
    text += std::to_string(point.id);
    append(text, point.position);
    for (const std::uint8_t channel : point.colour) text += " " + std::to_string(channel);
    text += " " + exact(point.error_px);
    for (const TrackElement& e : point.track) text += " " + std::to_string(e.image) + " " + std::to_string(e.index);
    text += "\n";
  }
  return text;
}

Result<std::vector<CameraRow>> parse_cameras_text(std::string_view text) {
  std::vector<CameraRow> cameras;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Words words = words_of(lines[i]);
    if (words.empty() || is_comment(lines[i])) continue;
    if (words.size() < 5) return bad_line(i, "not a camera");
    CameraRow camera{.id = 0, .model = -1, .width_px = 0, .height_px = 0, .params = {}};
    for (std::size_t m = 0; m < kModels.size(); ++m)
      if (words[1] == kModels[m].name) camera.model = int(m);
    if (camera.model < 0)
      return fail(Errc::kUnsupported, "camera model " + std::string(words[1]) + " is not supported");
    const auto id = id_of(words[0]), width = id_of(words[2]), height = id_of(words[3]);
    const std::size_t count = kModels[std::size_t(camera.model)].params;
    camera.params.resize(count);
    const bool ok = numbers_of(words, 4, count, [&](std::size_t k, double x) { camera.params[k] = x; });
    if (!ok || !id || !width || !height) return bad_line(i, "not a camera");
    camera.id = *id;
    camera.width_px = *width;
    camera.height_px = *height;
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

Result<std::vector<ImageRow>> parse_images_text(std::string_view text) {
  std::vector<ImageRow> images;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Words words = words_of(lines[i]);
    if (words.empty() || is_comment(lines[i])) continue;
    auto image = image_row(lines[i], words);
    if (!image) return bad_line(i, "not an image");
    ++i;  // its points follow on a line of their own, which may be empty
    if (i < lines.size() && !read_seen(words_of(lines[i]), image->seen)) return bad_line(i, "not a list of points");
    images.push_back(*std::move(image));
  }
  return images;
}

Result<std::vector<PointRow>> parse_points_text(std::string_view text) {
  std::vector<PointRow> points;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Words words = words_of(lines[i]);
    if (words.empty() || is_comment(lines[i])) continue;
    auto point = point_row(words);
    if (!point) return bad_line(i, "not a point");
    points.push_back(*std::move(point));
  }
  return points;
}

}  // namespace collinea::colmap
