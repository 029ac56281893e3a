// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/photo_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/internal/observation_order.h"
#include "collinea/io/text.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr std::string_view kEnd = "-99";
constexpr double kLargest = 1e9;  // of image coordinates and of what they are divided by, in any unit

tl::unexpected<Error> bad_line(std::size_t line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

bool is_remark(std::string_view word) { return word.starts_with('#') || word.starts_with('*'); }

class ListParser {
 public:
  explicit ListParser(std::string_view text) : lines_(lines_of(text)) {}

  Result<std::vector<PhotoList>> parse() {
    for (at_ = 1; at_ <= lines_.size(); ++at_)
      if (Result<> taken = take(words_of(lines_[at_ - 1])); !taken) return tl::unexpected(taken.error());
    if (photos_.empty()) return fail(Errc::kBadFormat, "no image in it");
    return std::move(photos_);
  }

 private:
  Result<> take(const std::vector<std::string_view>& words) {
    if (words.empty()) {
      may_end_ = in_list_ && !photos_.back().points.empty();
      return {};
    }
    if (is_remark(words[0])) return {};
    if (words[0] == kEnd) {
      in_list_ = may_end_ = false;
      return {};
    }
    if (may_end_ && words.size() == 2) in_list_ = false;
    may_end_ = false;
    return in_list_ ? take_point(words) : take_head(words);
  }

  Result<> take_head(const std::vector<std::string_view>& words) {
    if (words.size() < 2)
      return bad_line(at_, "the head of an image is expected: its number and its focal length or camera");
    PhotoList photo{std::string(words[0]), std::string(words[1]), at_, {}};
    if (!names_.insert(photo.name).second) return bad_line(at_, "image " + photo.name + " is there twice");
    photos_.push_back(std::move(photo));
    in_list_ = true;
    of_image_.clear();
    return {};
  }

  Result<> take_point(const std::vector<std::string_view>& words) {
    PhotoPoint point{.name = std::string(words[0]), .xy = {0, 0}, .line = at_};
    const auto x = words.size() > 2 ? finite_number(words[1]) : std::nullopt,
               y = words.size() > 2 ? finite_number(words[2]) : std::nullopt;
    if (!x || !y || !(std::abs(*x) < kLargest) || !(std::abs(*y) < kLargest))
      return bad_line(at_, "a measured point is expected: its number, x and y, or -99 behind the last of an image");
    point.xy = {*x, *y};
    if (!of_image_.insert(point.name).second)
      return bad_line(at_, "point " + point.name + " is there twice in image " + photos_.back().name);
    photos_.back().points.push_back(std::move(point));
    return {};
  }

  std::vector<std::string_view> lines_;
  std::size_t at_ = 0;
  bool in_list_ = false, may_end_ = false;
  std::set<std::string> names_, of_image_;
  std::vector<PhotoList> photos_;
};

// The text behind the first `count` words of a line.
std::string rest_of(std::string_view line, const std::vector<std::string_view>& words, std::size_t count) {
  if (words.size() <= count) return {};
  return std::string(trimmed(line.substr(std::size_t(words[count].data() - line.data()))));
}

Result<> take_control_name(std::string_view line, const std::vector<std::string_view>& words, PhotoNames& names) {
  const bool is_control = words.size() > 2 && words[2] == "control";
  if (words.size() < 7 || (!is_control && words[2] != "check"))
    return fail(Errc::kBadFormat, "expected: control NUMBER control|check SIGMA_E SIGMA_N SIGMA_H NAME");
  Eigen::Vector3d sigma;
  for (int axis = 0; axis < 3; ++axis) {
    const auto value = number(words[std::size_t(axis) + 3]);
    if (!value || !(*value >= 0)) return fail(Errc::kBadFormat, "a standard deviation is not a number from 0 on");
    sigma[axis] = *value;
  }
  const std::string key(words[1]);
  names.control[key] = rest_of(line, words, 6);
  names.sigma_m[key] = sigma;
  names.role[key] = is_control ? ControlRole::kControl : ControlRole::kCheck;
  return {};
}

Result<> take_name_line(std::string_view line, const std::vector<std::string_view>& words, PhotoNames& names) {
  if (words[0] == "control") return take_control_name(line, words, names);
  if (words[0] == "image") {
    if (words.size() < 3) return fail(Errc::kBadFormat, "expected: image NUMBER FILE");
    names.image[std::string(words[1])] = rest_of(line, words, 2);
    return {};
  }
  const auto value = words.size() == 2 ? finite_number(words[1]) : std::nullopt;
  if ((words[0] != "unit" && words[0] != "sigma") || !value || !(*value > 1 / kLargest) || !(*value < kLargest))
    return fail(Errc::kBadFormat, "expected a line unit, sigma, image or control");
  (words[0] == "unit" ? names.unit_per_px : names.sigma) = *value;
  return {};
}

// Numbers of things by their names, from 0 on in the order in which they come.
template <class Id>
class Ids {
 public:
  Id of(const std::string& name) {
    return Id{ids_.try_emplace(name, static_cast<std::uint32_t>(ids_.size())).first->second};
  }

 private:
  std::map<std::string, std::uint32_t> ids_;
};

std::string or_own(const std::map<std::string, std::string>& names, const std::string& key) {
  const auto found = names.find(key);
  return found == names.end() || found->second.empty() ? key : found->second;
}

Camera camera_of(const PhotoCamera& given, double unit_per_px, double half_px, const std::string& name) {
  const int side = 2 * int(std::ceil(std::min(half_px, 1e8)) + 1);
  Camera camera = ideal_camera(given.focal / unit_per_px, side, side);
  camera.params[Camera::kCx] += given.principal.x() / unit_per_px;
  camera.params[Camera::kCy] -= given.principal.y() / unit_per_px;
  camera.name = name;
  camera.prior.calibrate = false;
  camera.prior.source = Provenance::kGiven;
  return camera;
}

std::map<std::string, double> halves_of(const std::vector<PhotoList>& photos) {
  std::map<std::string, double> halves;  // largest coordinate in the images of a camera
  for (const PhotoList& photo : photos) {
    double& half = halves[photo.camera];
    for (const PhotoPoint& point : photo.points) half = std::max(half, point.xy.cwiseAbs().maxCoeff());
  }
  return halves;
}

void add_control(const std::map<std::string, PhotoControl>& control, const PhotoNames& names, Ids<ControlId>& ids,
                 Block& block) {
  for (const auto& [name, point] : control) {
    const auto sigma = names.sigma_m.find(name);
    const auto role = names.role.find(name);
    Eigen::Vector3d sigma_m = point.sigma_m;
    if (sigma != names.sigma_m.end())
      for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(sigma_m[axis])) sigma_m[axis] = sigma->second[axis];
    block.control[ids.of(name)] = {.name = or_own(names.control, name),
                                   .role = role == names.role.end() ? point.role : role->second,
                                   .position_in_map = point.position,
                                   .position_in_world = point.position,
                                   .sigma_m = sigma_m};
  }
}

// Pixels to the right and down from the upper-left corner, without distortion.
Eigen::Vector2d metric_xy(const Camera& camera, const Eigen::Vector2d& pixel, double unit_per_px) {
  const Eigen::Vector2d xy = normalized(camera, pixel) * camera.focal_px() * unit_per_px;
  return {xy.x(), -xy.y()};
}

double sigma_px_of(const Block& block) {
  std::vector<double> sigmas;
  for (const Observation& seen : block.observations) sigmas.push_back(seen.sigma_px);
  for (const ControlObservation& seen : block.control_observations) sigmas.push_back(seen.sigma_px);
  return sigmas.empty() ? 1 : median(std::move(sigmas));
}

}  // namespace

Result<std::vector<PhotoList>> parse_photo_lists(std::string_view text) { return ListParser(text).parse(); }

Result<PhotoNames> parse_photo_names(std::string_view text) {
  PhotoNames names;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto words = words_of(lines[i]);
    if (words.empty() || words[0].starts_with('#')) continue;
    if (Result<> taken = take_name_line(lines[i], words, names); !taken) return bad_line(i + 1, taken.error().message);
  }
  return names;
}

Result<PhotoNames> read_photo_names(const std::filesystem::path& path) {
  if (!is_there(path)) return PhotoNames{};
  COLLINEA_TRY(const std::string text, read_file(path));
  return parse_photo_names(text).map_error([&](Error error) { return std::move(error).within(path.string()); });
}

Result<AdjustmentFile> adjustment_of(const std::vector<PhotoList>& photos,
                                     const std::map<std::string, PhotoCamera>& cameras,
                                     const std::map<std::string, PhotoControl>& control, const PhotoNames& names,
                                     const PhotoDefaults& defaults) {
  AdjustmentFile file;
  Block& block = file.block;
  const double unit = names.unit_per_px > 0 ? names.unit_per_px : defaults.unit_per_px;
  const double sigma_px = (names.sigma > 0 ? names.sigma : defaults.sigma) / unit;
  const std::map<std::string, double> halves = halves_of(photos);
  Ids<CameraId> camera_ids;
  Ids<ControlId> control_ids;
  Ids<PointId> point_ids;
  add_control(control, names, control_ids, block);
  for (const PhotoList& photo : photos) {
    const CameraId camera = camera_ids.of(photo.camera);
    if (!block.cameras.contains(camera)) {
      block.cameras[camera] = file.given_cameras[camera] =
          camera_of(cameras.at(photo.camera), unit, halves.at(photo.camera) / unit, photo.camera);
      file.camera_sigmas[camera].fill(0);
    }
    const ImageId image{static_cast<std::uint32_t>(block.images.size())};
    block.images[image] = {.file = or_own(names.image, photo.name), .camera = camera};
    const Camera& its = block.cameras.at(camera);
    for (const PhotoPoint& point : photo.points) {
      const Eigen::Vector2d pixel(its.width_px / 2.0 + point.xy.x() / unit, its.height_px / 2.0 - point.xy.y() / unit);
      if (control.contains(point.name))
        block.control_observations.push_back({control_ids.of(point.name), image, pixel, sigma_px});
      else
        block.observations.push_back({image, point_ids.of(point.name), 0, pixel, sigma_px});
    }
  }
  if (block.observations.empty() && block.control_observations.empty())
    return fail(Errc::kBadFormat, "no point is measured in any image");
  sort_by_point_and_image(block.observations);
  return file;
}

PhotoNumbers numbers_of(const Block& block) {
  PhotoNumbers numbers;
  std::uint64_t next = 1;
  for (const auto& [id, point] : block.control) numbers.control[id] = next++;
  std::map<PointId, int> rays;
  for (const Observation& seen : block.observations)
    if (is_oriented(block, seen.image)) ++rays[seen.point];
  for (const auto& [id, count] : rays)
    if (count >= 2) numbers.points[id] = next++;
  for (const auto& [id, image] : block.images) numbers.images[id] = id.value + std::uint64_t{1};
  return numbers;
}

std::string photo_names_text(const Block& block, const PhotoNumbers& numbers, double unit_per_px) {
  std::string text = "# What the numbers in the files beside this one stand for\n";
  text += "unit " + exact(unit_per_px) + "\nsigma " + exact(sigma_px_of(block) * unit_per_px) + "\n";
  for (const auto& [id, pose] : oriented_images(block))
    text += "image " + std::to_string(numbers.images.at(id)) + " " + block.images.at(id).file + "\n";
  for (const auto& [id, point] : block.control) {
    text += "control " + std::to_string(numbers.control.at(id));
    text += point.role == ControlRole::kControl ? " control" : " check";
    for (int axis = 0; axis < 3; ++axis) text += " " + exact(point.sigma_m[axis]);
    text += " " + point.name + "\n";
  }
  return text;
}

std::string photo_lists_text(const Block& block, const PhotoNumbers& numbers, double unit_per_px, int decimals,
                             const std::map<CameraId, std::string>& head) {
  std::map<ImageId, std::string> lists;
  const auto add = [&](ImageId image, std::uint64_t number, const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d xy = metric_xy(block.camera_of(image), pixel, unit_per_px);
    lists[image] += std::to_string(number) + " " + fixed(xy.x(), decimals) + " " + fixed(xy.y(), decimals) + "\n";
  };
  for (const ControlObservation& seen : block.control_observations)
    if (is_oriented(block, seen.image)) add(seen.image, numbers.control.at(seen.point), seen.pixel);
  for (const Observation& seen : block.observations)
    if (const auto number = numbers.points.find(seen.point);
        number != numbers.points.end() && is_oriented(block, seen.image))
      add(seen.image, number->second, seen.pixel);
  std::string text;
  for (const auto& [image, list] : lists)
    text += std::to_string(numbers.images.at(image)) + " " + head.at(block.images.at(image).camera) + "\n" + list +
            std::string(kEnd) + "\n";
  return text;
}

Result<std::map<std::uint64_t, PhotoControl>> control_of(const Block& block, const PhotoNumbers& numbers) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  std::map<std::uint64_t, PhotoControl> control;
  for (const auto& [id, point] : block.control)
    if (point.sigma_m.array().isFinite().any())
      control[numbers.control.at(id)] = {
          frame ? frame->map_from_local(point.position_in_world) : point.position_in_world, point.sigma_m, point.role};
  return control;
}

Result<> check_photo_cameras(const Block& block, std::string_view format) {
  for (const auto& [id, camera] : block.cameras)
    if (is_fisheye(camera.model))
      return fail(Errc::kBadInput,
                  "camera " + camera.name + " is a fisheye: " + std::string(format) + " has only central projections");
  return {};
}

}  // namespace collinea
