// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/photomodeler.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/millimetre_camera.h"
#include "collinea/io/internal/observation_order.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

std::optional<std::vector<double>> numbers_of(std::string_view line) {
  std::vector<double> values;
  for (const std::string_view word : words_of(line)) {
    const auto value = finite_number(word);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

bool is_whole(double value, double most) { return value >= 0 && value < most && value == std::floor(value); }

class Parser {
 public:
  explicit Parser(std::string_view text) : lines_(lines_of(text)) {}

  Result<AdjustmentFile> parse() {
    for (const auto part :
         {&Parser::take_camera, &Parser::take_images, &Parser::take_control, &Parser::take_points, &Parser::take_marks})
      if (Result<> taken = (this->*part)(); !taken) return tl::unexpected(taken.error());
    sort_by_point_and_image(file_.block.observations);
    return std::move(file_);
  }

 private:
  tl::unexpected<Error> bad(const std::string& what) const {
    return fail(Errc::kBadFormat, "line " + std::to_string(at_ + 1) + ": " + what);
  }

  [[nodiscard]] bool at_end() const { return at_ >= lines_.size(); }
  [[nodiscard]] bool at_blank() const { return at_end() || words_of(lines_[at_]).empty(); }

  // The next line, which must hold at least so many numbers.
  Result<std::vector<double>> row(std::size_t least, const char* what) {
    if (at_end()) return bad(std::string("the file ends before ") + what + "; is it complete?");
    auto values = numbers_of(lines_[at_]);
    if (!values || values->size() < least)
      return bad(std::string("not ") + what + ": " + std::to_string(least) + " numbers are expected");
    ++at_;
    return *std::move(values);
  }

  // Old exports lack width and height of the images, without which a millimetre is no number of pixels: refused.
  Result<> take_camera() {
    ++at_;  // the title
    COLLINEA_TRY(const auto head, row(2, "tolerance, iterations, width and height of the images"));
    if (head.size() < 4 || !is_whole(head[2], 1e6) || !is_whole(head[3], 1e6) || head[2] < 1 || head[3] < 1)
      return bad(
          "the line above lacks width and height of the images [px]: export again with a newer PhotoModeler, "
          "or add them behind the number of iterations");
    COLLINEA_TRY(const auto defaults, row(9, "standard deviations"));
    if (defaults[0] > 0) default_sigma_px_ = defaults[0];
    COLLINEA_TRY(const auto v, row(10, "the camera: focal length, principal point, format, K1 K2 K3 P1 P2 [mm]"));
    if (!(v[0] > 0) || !(v[3] > 0) || !(v[4] > 0)) return bad("focal length and format above are not above 0 [mm]");
    COLLINEA_TRY(const auto deviations, row(10, "the standard deviations of the camera"));
    MillimetreCamera mm{.width_px = int(head[2]), .height_px = int(head[3])};
    mm.pixel_height_mm = v[4] / head[3];
    mm.off_aspect = v[3] / head[2] / mm.pixel_height_mm - 1;
    if (std::abs(mm.off_aspect) < 1e-9) mm.off_aspect = 0;  // the same in as many digits as are written
    mm.focal_mm = v[0];
    mm.principal_mm = {v[1], v[2]};
    mm.k = {v[5], v[6], v[7]};
    mm.p = {v[8], v[9]};
    Camera camera = camera_of(mm);
    camera.name = "camera";
    camera.prior.source = Provenance::kGiven;
    file_.block.cameras[{0}] = file_.given_cameras[{0}] = camera;
    file_.camera_sigmas[{0}].fill(0);
    file_.corrected_cameras.insert({0});
    return {};
  }

  // "3 images/IMG_3.JPG", the pose, its standard deviations, and after a blank line the camera once more.
  Result<> take_images() {
    while (!at_blank()) {
      const auto words = words_of(lines_[at_]);
      const auto id = integer(words[0]);
      if (!id || *id < 0 || words.size() < 2) return bad("not the number and the file of an image");
      const std::string_view path = trimmed(lines_[at_]).substr(words[0].size());
      const auto slash = path.find_last_of("/\\");
      Image image{.file = std::string(trimmed(slash == std::string_view::npos ? path : path.substr(slash + 1))),
                  .camera = {0}};
      ++at_;
      COLLINEA_TRY(const auto v, row(7, "number, projection centre, kappa, phi and omega of an image"));
      COLLINEA_TRY(const auto sigmas, row(7, "their standard deviations"));
      const Eigen::Vector3d centre(v[1], v[2], v[3]);
      const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{v[6], v[5], v[4]});
      const ImageId image_id{std::uint32_t(*id)};
      if (!file_.block.images.emplace(image_id, std::move(image)).second)
        return bad("image " + std::to_string(*id) + " comes twice");
      set_pose(file_.block, image_id, {rotation, -(rotation * centre)});
      if (!at_blank()) return bad("a blank line is expected between the pose of an image and its camera");
      ++at_;
      COLLINEA_TRY(const auto camera, row(11, "the camera of an image"));
      COLLINEA_TRY(const auto deviations, row(11, "the standard deviations of the camera of an image"));
    }
    if (file_.block.images.empty()) return bad("there is no image");
    ++at_;
    return {};
  }

  Result<> take_control() {
    for (; !at_blank();) {
      COLLINEA_TRY(const auto v, row(7, "a control point: number, X, Y, Z and their standard deviations"));
      if (!is_whole(v[0], 4e9)) return bad("the number of a point is expected first in the line above");
      const Eigen::Vector3d position(v[1], v[2], v[3]);
      const ControlId id{std::uint32_t(v[0])};
      if (file_.block.control.contains(id)) return bad("control point " + std::to_string(id.value) + " comes twice");
      file_.block.control[id] = {.name = std::to_string(id.value),
                                 .role = ControlRole::kControl,
                                 .position_in_map = position,
                                 .position_in_world = position,
                                 .sigma_m = Eigen::Vector3d(v[4], v[5], v[6]).cwiseMax(0)};
    }
    ++at_;
    return {};
  }

  Result<> take_points() {
    for (; !at_blank();) {
      COLLINEA_TRY(const auto v, row(4, "an object point: number, X, Y, Z"));
      if (!is_whole(v[0], 4e9)) return bad("the number of a point is expected first in the line above");
      const std::uint32_t id = std::uint32_t(v[0]);
      if (file_.block.control.contains({id})) continue;
      if (!file_.block.points.emplace(PointId{id}, TiePoint{{v[1], v[2], v[3]}, {}}).second)
        return bad("object point " + std::to_string(id) + " comes twice");
    }
    ++at_;
    return {};
  }

  Result<> take_marks() {
    for (; !at_blank();) {
      COLLINEA_TRY(const auto v, row(6, "a mark: image, point, x, y and their standard deviations [px]"));
      if (!is_whole(v[0], 4e9) || !is_whole(v[1], 4e9) || !file_.block.images.contains({std::uint32_t(v[0])}))
        return bad("the line above marks a point in an image that was not listed");
      if (!(v[4] >= 0) || v[4] != v[5])
        return bad("the standard deviations of the mark above are not the same number from 0 in x and y");
      const double sigma_px = v[4] > 0 ? v[4] : default_sigma_px_;
      const ImageId image{std::uint32_t(v[0])};
      const std::uint32_t point = std::uint32_t(v[1]);
      if (!marked_.emplace(image.value, point).second)
        return bad("point " + std::to_string(point) + " is marked twice in image " + std::to_string(image.value));
      if (file_.block.control.contains({point}))
        file_.block.control_observations.push_back({{point}, image, {v[2], v[3]}, sigma_px});
      else
        file_.block.observations.push_back({image, {point}, 0, {v[2], v[3]}, sigma_px});
    }
    if (file_.block.observations.empty() && file_.block.control_observations.empty())
      return bad("the file ends before the first mark; is it complete?");
    return {};
  }

  std::vector<std::string_view> lines_;
  std::size_t at_ = 0;
  double default_sigma_px_ = 1;
  std::set<std::pair<std::uint32_t, std::uint32_t>> marked_;  // image, point
  AdjustmentFile file_;
};

}  // namespace

Result<AdjustmentFile> parse_photomodeler(std::string_view bytes) {
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
  return Parser(converted ? *converted : bytes).parse();
}

bool is_photomodeler(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 4096);
  const auto converted = converted_to_utf8(head);
  const std::vector<std::string_view> lines = lines_of(converted && *converted ? **converted : head);
  constexpr std::size_t kNumbers[] = {2, 9, 10, 10};
  if (lines.size() < 6) return false;
  for (std::size_t i = 0; i < std::size(kNumbers); ++i) {
    const auto values = numbers_of(lines[i + 1]);
    if (!values || values->size() < kNumbers[i]) return false;
  }
  return true;
}

}  // namespace collinea
