// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/bingo.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/internal/photo_points.h"
#include "collinea/io/opk.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr PhotoDefaults kDefaults_mm{.unit_per_px = 0.001, .sigma = 0.003};
constexpr double kControlSigma_m = 0.05;
constexpr double kLargest = 1e9;  // of any number
constexpr double kRadiansPerGon = std::numbers::pi / 200;

using Words = std::vector<std::string_view>;

struct PhiOmegaKappa {
  double phi_gon = 0, omega_gon = 0, kappa_gon = 0;
};

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double angle_gon) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_gon * kRadiansPerGon, axis));
}

const Eigen::Quaterniond kCamFromImage(0, 1, 0, 0);  // x right, y up, z backward

Eigen::Quaterniond cam_from_ground(const PhiOmegaKappa& angles) {
  const Eigen::Quaterniond ground_from_image = about(Eigen::Vector3d::UnitY(), angles.phi_gon) *
                                               about(Eigen::Vector3d::UnitX(), angles.omega_gon) *
                                               about(Eigen::Vector3d::UnitZ(), angles.kappa_gon);
  return (kCamFromImage * ground_from_image.conjugate()).normalized();
}

// m = Ry(phi) Rx(omega) Rz(kappa): m02 = sin(phi) cos(omega), m12 = -sin(omega), m22 = cos(phi) cos(omega),
// m10 = cos(omega) sin(kappa), m11 = cos(omega) cos(kappa).
PhiOmegaKappa phi_omega_kappa(const Eigen::Quaterniond& cam_from_ground) {
  const Eigen::Matrix3d m = (cam_from_ground.conjugate() * kCamFromImage).toRotationMatrix();
  return {std::atan2(m(0, 2), m(2, 2)) / kRadiansPerGon,
          std::atan2(-m(1, 2), std::hypot(m(1, 0), m(1, 1))) / kRadiansPerGon,
          std::atan2(m(1, 0), m(1, 1)) / kRadiansPerGon};
}

bool is_remark(std::string_view word) { return word.starts_with('*') || word.starts_with('#') || word == "C"; }

// So many numbers of a line from a word on.
template <std::size_t kCount>
std::optional<std::array<double, kCount>> numbers_from(const Words& words, std::size_t first) {
  std::array<double, kCount> values{};
  if (words.size() < first + kCount) return std::nullopt;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto value = finite_number(words[first + i]);
    if (!value || !(std::abs(*value) < kLargest)) return std::nullopt;
    values[i] = *value;
  }
  return values;
}

// What geoin.dat says.
struct Given {
  std::map<std::string, PhotoCamera> cameras;
  std::map<std::string, PhotoControl> control;
};

template <class Take>
Result<> for_each_line(const std::filesystem::path& path, Take&& take) {
  COLLINEA_TRY(const std::string text, read_file(path));
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Words words = words_of(lines[i]);
    if (words.empty() || is_remark(words[0])) continue;
    if (Result<> taken = take(words); !taken)
      return fail(Errc::kBadFormat, path.string() + ": line " + std::to_string(i + 1) + ": " + taken.error().message);
  }
  return {};
}

Result<> take_given(const Words& words, Given& given) {
  if (words[0] == "CAPA") {
    const auto v = numbers_from<3>(words, 3);
    if (!v || !((*v)[0] > 1 / kLargest))
      return fail(Errc::kBadFormat, "expected: CAPA camera 0 focal x0 y0, in millimetres");
    if (!given.cameras.emplace(words[1], PhotoCamera{(*v)[0], {(*v)[1], (*v)[2]}}).second)
      return fail(Errc::kBadFormat, "camera " + std::string(words[1]) + " is there twice");
  } else if (words[0] == "CONT" || words[0] == "CHCK") {
    const auto v = numbers_from<3>(words, 2);
    if (!v) return fail(Errc::kBadFormat, "expected: " + std::string(words[0]) + " number E N H");
    const ControlRole role = words[0] == "CONT" ? ControlRole::kControl : ControlRole::kCheck;
    if (!given.control
             .emplace(words[1],
                      PhotoControl{{(*v)[0], (*v)[1], (*v)[2]}, Eigen::Vector3d::Constant(kControlSigma_m), role})
             .second)
      return fail(Errc::kBadFormat, "point " + std::string(words[1]) + " is there twice");
  }
  return {};
}

Result<> add_poses(const std::filesystem::path& path, const PhotoNames& names, Block& block) {
  if (!is_there(path)) return {};
  std::map<std::string, ImageId> by_name;
  for (const auto& [id, image] : block.images) by_name[image.file] = id;
  return for_each_line(path, [&](const Words& words) -> Result<> {
    if (words[0] != "ORIA") return {};
    const auto v = numbers_from<6>(words, 2);
    if (!v) return fail(Errc::kBadFormat, "expected: ORIA image X Y Z phi omega kappa, in metres and gons");
    const auto named = names.image.find(std::string(words[1]));
    const auto image = by_name.find(named == names.image.end() ? std::string(words[1]) : named->second);
    if (image == by_name.end()) return {};  // of an image without measurements
    const Eigen::Quaterniond rotation = cam_from_ground({(*v)[3], (*v)[4], (*v)[5]});
    set_pose(block, image->second, {rotation, -(rotation * Eigen::Vector3d((*v)[0], (*v)[1], (*v)[2]))});
    return {};
  });
}

std::string geoin_text(const Block& block, const std::map<std::uint64_t, PhotoControl>& control, double pixel_mm) {
  std::string text;
  for (const auto& [id, camera] : block.cameras)
    text += "CAPA C" + std::to_string(id.value + 1) + " 0 " + fixed(camera.focal_px() * pixel_mm, 6) + " 0.0 0.0\n";
  for (const auto& [number, point] : control) {
    if (!point.sigma_m.allFinite()) continue;
    text += std::string(point.role == ControlRole::kControl ? "CONT " : "CHCK ") + std::to_string(number);
    for (int axis = 0; axis < 3; ++axis) text += " " + fixed(point.position[axis], 4);
    text += "\n";
  }
  return text;
}

Result<std::string> itera_text(const Block& block, const PhotoNumbers& numbers) {
  COLLINEA_TRY(const std::vector<ExteriorOrientation> rows, exterior_orientations(block));
  std::string text;
  std::size_t row = 0;
  for (const auto& [id, pose] : oriented_images(block)) {
    const ExteriorOrientation& its = rows[row++];
    const PhiOmegaKappa angles = phi_omega_kappa(cam_from_world(its.angles));
    text += "ORIA " + std::to_string(numbers.images.at(id));
    for (int axis = 0; axis < 3; ++axis) text += " " + fixed(its.centre_in_map[axis], 4);
    for (const double angle : {angles.phi_gon, angles.omega_gon, angles.kappa_gon}) text += " " + fixed(angle, 7);
    text += " 0\n";
  }
  return text;
}

}  // namespace

Result<> write_bingo(const std::filesystem::path& path, const Block& block, double pixel_um) {
  COLLINEA_TRY(check_photo_cameras(block, "BINGO"));
  COLLINEA_TRY(check_image_names(block, "a list of names"));
  const double pixel_mm = pixel_um / 1000;
  const PhotoNumbers numbers = numbers_of(block);
  COLLINEA_TRY(const auto control, control_of(block, numbers));
  COLLINEA_TRY(const std::string itera, itera_text(block, numbers));
  std::map<CameraId, std::string> head;
  for (const auto& [id, camera] : block.cameras) head[id] = "C" + std::to_string(id.value + 1);
  const std::filesystem::path folder = path.parent_path();
  COLLINEA_TRY(write_file(path, photo_lists_text(block, numbers, pixel_mm, 7, head)));
  COLLINEA_TRY(write_file(folder / "geoin.dat", geoin_text(block, control, pixel_mm)));
  COLLINEA_TRY(write_file(folder / "itera.dat", itera));
  return write_file(folder / "names.dat", photo_names_text(block, numbers, pixel_mm));
}

Result<AdjustmentFile> read_bingo(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  const std::filesystem::path folder = path.parent_path(), geoin = folder / "geoin.dat";
  if (!is_there(geoin))
    return fail(Errc::kBadFormat, path.string() + ": the cameras of BINGO are in geoin.dat, which is not beside it");
  Given given;
  COLLINEA_TRY(for_each_line(geoin, [&](const Words& words) { return take_given(words, given); }));
  COLLINEA_TRY(const PhotoNames names, read_photo_names(folder / "names.dat"));
  const auto read = [&]() -> Result<AdjustmentFile> {
    COLLINEA_TRY(const auto photos, parse_photo_lists(text));
    for (const PhotoList& photo : photos)
      if (!given.cameras.contains(photo.camera))
        return fail(Errc::kBadFormat, "line " + std::to_string(photo.line) + ": geoin.dat has no camera " +
                                          photo.camera + " (a line CAPA)");
    return adjustment_of(photos, given.cameras, given.control, names, kDefaults_mm);
  };
  COLLINEA_TRY(AdjustmentFile file,
               read().map_error([&](Error error) { return std::move(error).within(path.string()); }));
  COLLINEA_TRY(add_poses(folder / "itera.dat", names, file.block));
  return file;
}

bool is_bingo(std::string_view text, bool has_geoin) {
  std::vector<Words> first;
  for (const std::string_view line : lines_of(text)) {
    Words words = words_of(line);
    if (words.empty() || is_remark(words[0])) continue;
    first.push_back(std::move(words));
    if (first.size() == 2) break;
  }
  if (first.size() < 2 || first[0].size() != 2 || first[1].size() < 3) return false;
  if (finite_number(first[0][1]) && !has_geoin) return false;
  return finite_number(first[1][1]) && finite_number(first[1][2]);
}

}  // namespace collinea
