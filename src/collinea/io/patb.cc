// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/patb.h"

#include <limits>
#include <optional>

#include "collinea/base/file.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/internal/photo_points.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr PhotoDefaults kDefaults_um{.unit_per_px = 1, .sigma = 3};
constexpr double kControlSigma_m = 0.05;
constexpr double kUnknown = std::numeric_limits<double>::infinity();

std::filesystem::path beside(std::filesystem::path path, const char* extension) {
  return path.replace_extension(extension);
}

// The horizontal list is closed by -99, then comes the vertical one.
class ControlParser {
 public:
  explicit ControlParser(std::string_view text) : lines_(lines_of(text)) {}

  Result<std::map<std::string, PhotoControl>> parse() {
    for (at_ = 1; at_ <= lines_.size(); ++at_) {
      const auto words = words_of(lines_[at_ - 1]);
      if (words.empty() || words[0].starts_with('#')) continue;
      if (words[0] == "-99") {
        ++list_;
        continue;
      }
      if (Result<> taken = take(words); !taken) return tl::unexpected(taken.error());
    }
    return std::move(control_);
  }

 private:
  Result<> take(const std::vector<std::string_view>& words) {
    const std::size_t count = list_ == 0 ? 2 : 1;
    if (list_ > 1) return bad_line("nothing is expected behind the -99 of vertical control");
    if (words.size() < count + 1)
      return bad_line(list_ == 0 ? "horizontal control is expected: number, X and Y, or -99"
                                 : "vertical control is expected: number and Z, or -99");
    const auto [found, is_new] =
        control_.try_emplace(std::string(words[0]), PhotoControl{{0, 0, 0}, Eigen::Vector3d::Constant(kUnknown)});
    for (std::size_t i = 0; i < count; ++i) {
      const int axis = list_ == 0 ? int(i) : 2;
      const auto value = finite_number(words[i + 1]);
      if (!value) return bad_line("\"" + std::string(words[i + 1]) + "\" is not a coordinate");
      if (std::isfinite(found->second.sigma_m[axis])) return bad_line("point " + found->first + " is there twice");
      found->second.position[axis] = *value;
      found->second.sigma_m[axis] = kControlSigma_m;
    }
    return {};
  }

  tl::unexpected<Error> bad_line(const std::string& what) const {
    return fail(Errc::kBadFormat, "line " + std::to_string(at_) + ": " + what);
  }

  std::vector<std::string_view> lines_;
  std::size_t at_ = 0;
  int list_ = 0;
  std::map<std::string, PhotoControl> control_;
};

Result<std::map<std::string, PhotoControl>> read_control_lists(const std::filesystem::path& path) {
  if (!is_there(path)) return std::map<std::string, PhotoControl>{};
  COLLINEA_TRY(const std::string text, read_file(path));
  return ControlParser(text).parse().map_error([&](Error error) { return std::move(error).within(path.string()); });
}

std::string control_text(const std::map<std::uint64_t, PhotoControl>& control) {
  std::string horizontal, vertical;
  for (const auto& [number, point] : control) {
    const std::string name = std::to_string(number);
    if (point.sigma_m.head<2>().allFinite())
      horizontal += name + " " + fixed(point.position.x(), 4) + " " + fixed(point.position.y(), 4) + "\n";
    if (std::isfinite(point.sigma_m.z())) vertical += name + " " + fixed(point.position.z(), 4) + "\n";
  }
  return horizontal + "-99\n" + vertical + "-99\n";
}

Result<std::map<std::string, PhotoCamera>> cameras_of(const std::vector<PhotoList>& photos) {
  std::map<std::string, PhotoCamera> cameras;
  for (const PhotoList& photo : photos) {
    const auto focal = finite_number(photo.camera);
    if (!focal || !(*focal > 1e-9) || !(*focal < 1e9))
      return fail(Errc::kBadFormat, "line " + std::to_string(photo.line) + ": the focal length of image " + photo.name +
                                        " is not a number above 0: \"" + photo.camera + "\"");
    cameras[photo.camera] = {*focal, {0, 0}};
  }
  return cameras;
}

}  // namespace

Result<> write_patb(const std::filesystem::path& path, const Block& block, double pixel_um) {
  COLLINEA_TRY(check_photo_cameras(block, "PATB"));
  COLLINEA_TRY(check_image_names(block, "a list of names"));
  const PhotoNumbers numbers = numbers_of(block);
  COLLINEA_TRY(const auto control, control_of(block, numbers));
  std::map<CameraId, std::string> focal;
  for (const auto& [id, camera] : block.cameras) focal[id] = fixed(camera.focal_px() * pixel_um, 4);
  COLLINEA_TRY(write_file(path, photo_lists_text(block, numbers, pixel_um, 4, focal)));
  COLLINEA_TRY(write_file(beside(path, ".con"), control_text(control)));
  return write_file(beside(path, ".names"), photo_names_text(block, numbers, pixel_um));
}

Result<AdjustmentFile> read_patb(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  COLLINEA_TRY(const auto control, read_control_lists(beside(path, ".con")));
  COLLINEA_TRY(const PhotoNames names, read_photo_names(beside(path, ".names")));
  const auto read = [&]() -> Result<AdjustmentFile> {
    COLLINEA_TRY(const auto photos, parse_photo_lists(text));
    COLLINEA_TRY(const auto cameras, cameras_of(photos));
    return adjustment_of(photos, cameras, control, names, kDefaults_um);
  };
  return read().map_error([&](Error error) { return std::move(error).within(path.string()); });
}

bool is_patb(std::string_view text) {
  std::vector<std::vector<std::string_view>> first;
  bool has_end = false;
  for (const std::string_view line : lines_of(text)) {
    auto words = words_of(line);
    if (words.empty() || words[0].starts_with('#') || words[0].starts_with('*')) continue;
    has_end |= words[0] == "-99";
    if (first.size() < 2) first.push_back(std::move(words));
    if (has_end) break;
  }
  if (!has_end || first.size() < 2 || first[0].size() < 2 || first[0].size() > 3 || first[1].size() < 3) return false;
  const auto focal = finite_number(first[0][1]);
  return focal && *focal > 0 && finite_number(first[1][1]) && finite_number(first[1][2]);
}

}  // namespace collinea
