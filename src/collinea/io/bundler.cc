// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/bundler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr const char* kBundleFile = "bundle.out";
constexpr const char* kListFile = "list.txt";

// Bundler's camera axes, seen from ours: y and z turned round.
const Eigen::DiagonalMatrix<double, 3> kFlip(1, -1, -1);

// --- to Bundler ------------------------------------------------------------------------------------------------------

// What is left of a camera in Bundler: f, k1, k2 about the middle of the image.
Camera bundler_camera(const Camera& camera) {
  Camera plain = ideal_camera(camera.focal_px(), camera.width_px, camera.height_px);
  plain.params[Camera::kK1] = camera.params[Camera::kK1];
  plain.params[Camera::kK2] = camera.params[Camera::kK2];
  return plain;
}

// From the middle of the image, y up.
Eigen::Vector2d from_middle(const Camera& camera, const Eigen::Vector2d& pixel) {
  return {pixel.x() - 0.5 * camera.width_px, 0.5 * camera.height_px - pixel.y()};
}

struct View {
  std::size_t camera;
  std::uint32_t feature;
  Eigen::Vector2d pixel;
};

std::string camera_text(const Camera& camera, const Rigid3& pose) {
  std::string text = exact(camera.focal_px()) + " " + exact(camera.params[Camera::kK1]) + " " +
                     exact(camera.params[Camera::kK2]) + "\n";
  const Eigen::Matrix3d rotation = kFlip * pose.rotation.toRotationMatrix();
  const Eigen::Vector3d translation = kFlip * pose.translation;
  for (int row = 0; row < 3; ++row)
    text += exact(rotation(row, 0)) + " " + exact(rotation(row, 1)) + " " + exact(rotation(row, 2)) + "\n";
  return text + exact(translation[0]) + " " + exact(translation[1]) + " " + exact(translation[2]) + "\n";
}

std::string point_text(const TiePoint& point, const std::vector<View>& views) {
  const Eigen::Vector3d& p = point.position_in_world;
  std::string text = exact(p[0]) + " " + exact(p[1]) + " " + exact(p[2]) + "\n" + std::to_string(point.colour[0]) +
                     " " + std::to_string(point.colour[1]) + " " + std::to_string(point.colour[2]) + "\n" +
                     std::to_string(views.size());
  for (const View& view : views)
    text += " " + std::to_string(view.camera) + " " + std::to_string(view.feature) + " " + exact(view.pixel.x()) + " " +
            exact(view.pixel.y());
  return text + "\n";
}

// The line of an image in list.txt. What follows a name there are a zero and the focal length: a name that ends like
// that gets them.
std::string list_line(const std::string& name, const Camera& camera) {
  const auto words = words_of(name);
  const bool ends_in_numbers = words.size() > 2 && number(words[words.size() - 1]) && number(words[words.size() - 2]);
  return name + (ends_in_numbers ? " 0 " + exact(camera.focal_px()) : "") + "\n";
}

// The views of each point, as Bundler's cameras would have measured them: the residual stays.
std::map<PointId, std::vector<View>> views_of(const Block& block, const std::map<ImageId, std::size_t>& row_of,
                                              double& largest_change_px) {
  std::map<PointId, std::vector<View>> views;
  for (const Observation& o : block.observations) {
    const auto row = row_of.find(o.image);
    const auto point = block.points.find(o.point);
    if (row == row_of.end() || point == block.points.end()) continue;
    const Camera &camera = block.camera_of(o.image), plain = bundler_camera(camera);
    const Eigen::Vector3d in_cam = pose_of(block, o.image) * point->second.position_in_world;
    const auto ours = project(camera, in_cam), theirs = project(plain, in_cam);
    if (!ours || !theirs) continue;
    const Eigen::Vector2d change = *theirs - *ours;
    largest_change_px = std::max(largest_change_px, change.norm());
    views[o.point].push_back({row->second, o.feature, from_middle(plain, o.pixel + change)});
  }
  return views;
}

// --- from Bundler ----------------------------------------------------------------------------------------------------

// The numbers of a file one after the other, whatever the line ends; knows the line it is at.
class Numbers {
 public:
  Numbers(std::string_view text, std::string file) : lines_(lines_of(text)), file_(std::move(file)) {}

  template <class Values>
  Result<> take(Values& values, const char* what) {
    for (double& value : values) {
      while (word_ == words_.size() && line_ < lines_.size()) {
        words_ = trimmed(lines_[line_]).starts_with('#') ? std::vector<std::string_view>{} : words_of(lines_[line_]);
        word_ = 0;
        ++line_;
      }
      if (word_ == words_.size()) return fail(Errc::kBadFormat, file_ + " ends before " + what);
      const auto number_here = finite_number(words_[word_++]);
      if (!number_here) return error(std::string(what) + " is not a number");
      value = *number_here;
    }
    return {};
  }
  /// A whole number in [0, below).
  Result<std::size_t> count(double below, const char* what) {
    std::array<double, 1> value{};
    COLLINEA_TRY(take(value, what));
    if (!(value[0] >= 0 && value[0] < below) || value[0] != std::floor(value[0]))
      return error(std::string(what) + " is out of range");
    return static_cast<std::size_t>(value[0]);
  }
  [[nodiscard]] tl::unexpected<Error> error(const std::string& what) const {
    return fail(Errc::kBadFormat, file_ + ": line " + std::to_string(line_) + ": " + what);
  }

 private:
  std::vector<std::string_view> lines_, words_;
  std::string file_;
  std::size_t line_ = 0, word_ = 0;
};

Result<std::vector<std::string>> names_of(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  std::vector<std::string> names;
  for (const std::string_view line : lines_of(text)) {
    const auto words = words_of(line);  // name [0 focal_px]
    if (words.empty()) continue;
    const bool has_focal = words.size() >= 3 && number(words[words.size() - 1]) && number(words[words.size() - 2]);
    const std::string_view last = has_focal ? words[words.size() - 3] : words.back();
    names.emplace_back(line.substr(std::size_t(words.front().data() - line.data()),
                                   std::size_t(last.data() + last.size() - words.front().data())));
  }
  return names;
}

Result<> take_camera(Numbers& numbers, const std::string& name, ImageSize size, ImageId id, Block& block) {
  std::array<double, 15> v{};
  COLLINEA_TRY(numbers.take(v, "a camera"));
  Camera camera = ideal_camera(v[0], size.width_px, size.height_px);
  camera.params[Camera::kK1] = v[1];
  camera.params[Camera::kK2] = v[2];
  camera.name = "Bundler camera " + std::to_string(id.value);
  camera.prior.source = Provenance::kGiven;
  block.cameras[{id.value}] = camera;
  Image& image = block.images[id];
  image.file = name;
  image.camera = {id.value};
  if (v[0] == 0) return {};
  if (v[0] < 0) return numbers.error("the focal length of " + name + " is negative");
  const Eigen::Matrix3d rotation =
      kFlip * Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&v[3]));
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3) || rotation.determinant() < 0)
    return numbers.error("the rotation of " + name + " is none");
  set_pose(block, id, {Eigen::Quaterniond(rotation).normalized(), kFlip * Eigen::Vector3d(v[12], v[13], v[14])});
  return {};
}

Result<> take_point(Numbers& numbers, PointId id, Block& block) {
  std::array<double, 6> v{};
  COLLINEA_TRY(numbers.take(v, "a point"));
  TiePoint& point = block.points[id];
  point.position_in_world = {v[0], v[1], v[2]};
  for (std::size_t i = 0; i < 3; ++i) point.colour[i] = std::uint8_t(std::clamp(v[3 + i], 0.0, 255.0));
  COLLINEA_TRY(const std::size_t views, numbers.count(1e6, "the number of views"));
  for (std::size_t i = 0; i < views; ++i) {
    COLLINEA_TRY(const std::size_t image, numbers.count(double(block.images.size()), "the camera of a view"));
    COLLINEA_TRY(const std::size_t feature, numbers.count(0xffffffffu, "the feature of a view"));
    std::array<double, 2> pixel{};
    COLLINEA_TRY(numbers.take(pixel, "a view"));
    Observation o;
    o.image = {std::uint32_t(image)};
    o.point = id;
    o.feature = std::uint32_t(feature);
    const Camera& camera = block.camera_of(o.image);
    o.pixel = {0.5 * camera.width_px + pixel[0], 0.5 * camera.height_px - pixel[1]};
    if (is_oriented(block, o.image)) block.observations.push_back(o);
  }
  return {};
}

}  // namespace

Result<std::vector<Finding>> write_bundler(const std::filesystem::path& folder, const Block& block) {
  COLLINEA_TRY(check_image_names(block, "Bundler's list"));
  std::map<ImageId, std::size_t> row_of;
  std::string cameras, names, points;
  for (const auto& [id, pose] : oriented_images(block)) {
    if (const Camera& camera = block.camera_of(id); is_fisheye(camera.model))
      return fail(Errc::kUnsupported,
                  "camera " + camera.name + " is a fisheye (" + std::string(name_of(camera.model)) +
                      "), which Bundler does not know; a COLMAP model does",
                  {"format"_option});
    const std::size_t row = row_of.size();
    row_of[id] = row;
    cameras += camera_text(block.camera_of(id), pose);
    names += list_line(block.images.at(id).file, block.camera_of(id));
  }
  double largest_change_px = 0;
  const auto views = views_of(block, row_of, largest_change_px);
  for (const auto& [id, seen] : views) points += point_text(block.points.at(id), seen);
  const std::string head =
      "# Bundle file v0.3\n" + std::to_string(row_of.size()) + " " + std::to_string(views.size()) + "\n";
  COLLINEA_TRY(write_file(folder / kListFile, names));
  COLLINEA_TRY(write_file(folder / kBundleFile, head + cameras + points));
  std::vector<Finding> findings;
  if (largest_change_px > 1e-3)
    findings.push_back(finding_of(FindingCode::kDistortionFitted, {}, {{FigureName::kOffsetPx, largest_change_px}}));
  return findings;
}

Result<Block> read_bundler(const std::filesystem::path& folder,
                           const std::function<Result<ImageSize>(const std::string&)>& size_of) {
  const std::filesystem::path path = folder / kBundleFile;
  COLLINEA_TRY(const std::vector<std::string> names, names_of(folder / kListFile));
  COLLINEA_TRY(const std::string text, read_file(path));
  Numbers numbers(text, path.string());
  COLLINEA_TRY(const std::size_t cameras, numbers.count(1e7, "the number of cameras"));
  COLLINEA_TRY(const std::size_t points, numbers.count(4e9, "the number of points"));
  if (cameras != names.size())
    return numbers.error(std::to_string(cameras) + " cameras, but " + (folder / kListFile).string() + " names " +
                         std::to_string(names.size()) + " images");
  Block block;
  for (std::uint32_t i = 0; i < cameras; ++i) {
    COLLINEA_TRY(const ImageSize size, size_of(names[i]));
    COLLINEA_TRY(take_camera(numbers, names[i], size, {i}, block));
  }
  for (std::uint32_t i = 0; i < points; ++i) COLLINEA_TRY(take_point(numbers, {i}, block));
  const auto key = [](const Observation& o) { return std::tuple(o.point, o.image, o.feature); };
  std::ranges::sort(block.observations, {}, key);
  return block;
}

}  // namespace collinea
