// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/opk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>

#include "collinea/base/file.h"
#include "collinea/base/file_text.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr FileText kSigmaTitles = "sigma_x_m\tsigma_y_m\tsigma_z_m\tsigma_omega_deg\tsigma_phi_deg\tsigma_kappa_deg";

// Six standard deviations [m, deg]; those of an image that has none are nan.
std::optional<Eigen::Matrix<double, 6, 6>> covariance_of(std::span<const std::string_view> words) {
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  for (int i = 0; i < 6; ++i) {
    const auto sigma = finite_number(words[std::size_t(i)]);
    if (!sigma) return std::nullopt;
    covariance(i, i) = std::pow(*sigma * (i < 3 ? 1 : kRadians), 2);
  }
  return covariance;
}

bool are_sigmas(std::span<const std::string_view> words) {
  return std::ranges::all_of(words, [](std::string_view word) {
    const auto value = number(word);
    return value && !(*value < 0) && !std::isinf(*value);
  });
}

// The numbers are the last six words, or the six before their standard deviations; file names may hold blanks.
std::optional<ExteriorOrientation> row_of(std::span<const std::string_view> words, bool with_sigmas) {
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
  if (with_sigmas) {
    if (words.size() < 13 || !are_sigmas(words.last(6))) return std::nullopt;
    covariance = covariance_of(words.last(6));
    words = words.first(words.size() - 6);
  }
  if (words.size() < 7) return std::nullopt;
  std::array<double, 6> v{};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = finite_number(words[words.size() - 6 + i]);
    if (!value) return std::nullopt;
    v[i] = *value;
  }
  const std::string_view last = words[words.size() - 7];
  const std::string file(words[0].data(), last.data() + last.size());
  return ExteriorOrientation{file, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}, covariance};
}

// The derivative of map coordinates by those of the world, by central differences of a metre.
Eigen::Matrix3d map_by_local(const LocalFrame& frame, const Eigen::Vector3d& local) {
  Eigen::Matrix3d derivative;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d half = 0.5 * Eigen::Vector3d::Unit(axis);
    derivative.col(axis) = frame.map_from_local(local + half) - frame.map_from_local(local - half);
  }
  return derivative;
}

// `map_rotation`: the map's axes from those of the world; `map_position`: coordinates of the map by those of the world.
Eigen::Matrix<double, 6, 6> in_map(const PoseCovariance& in_world, const OmegaPhiKappa& angles,
                                   const Eigen::Matrix3d& map_rotation, const Eigen::Matrix3d& map_position) {
  Eigen::Matrix<double, 6, 6> derivative = Eigen::Matrix<double, 6, 6>::Zero();
  derivative.topRightCorner<3, 3>() = map_position;
  derivative.bottomLeftCorner<3, 3>() = angles_by_rotation(angles) * map_rotation;
  return derivative * in_world * derivative.transpose();
}

}  // namespace

Eigen::Matrix3d angles_by_rotation(const OmegaPhiKappa& angles) {
  const double omega = angles.omega_deg * kRadians, phi = angles.phi_deg * kRadians;
  const double so = std::sin(omega), co = std::cos(omega), sp = std::sin(phi), cp = std::cos(phi);
  const Eigen::RowVector3d kappa(0, -so / cp, co / cp), by_phi(0, co, so);
  Eigen::Matrix3d by_minus_e;
  by_minus_e << Eigen::RowVector3d::UnitX() - sp * kappa, by_phi, kappa;
  return -by_minus_e;
}

Result<std::vector<ExteriorOrientation>> exterior_orientations(
    const Block& block, const std::map<ImageId, PoseCovariance>& pose_covariance) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  std::vector<ExteriorOrientation> rows;
  for (const auto& [id, cam_from_world] : oriented_images(block)) {
    const Eigen::Vector3d centre = centre_of(cam_from_world);
    ExteriorOrientation row{block.images.at(id).file, centre, {}};
    Eigen::Quaterniond map_from_world = Eigen::Quaterniond::Identity();
    if (frame) {
      row.centre_in_map = frame->map_from_local(centre);
      map_from_world = map_from_local_rotation(*frame, centre);
    }
    row.angles =
        omega_phi_kappa(frame ? cam_from_world.rotation * map_from_world.conjugate() : cam_from_world.rotation);
    if (const auto its = pose_covariance.find(id); its != pose_covariance.end())
      row.covariance = in_map(its->second, row.angles, map_from_world.toRotationMatrix(),
                              frame ? map_by_local(*frame, centre) : Eigen::Matrix3d::Identity());
    rows.push_back(std::move(row));
  }
  return rows;
}

Result<std::vector<ExteriorOrientation>> read_opk(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  std::vector<ExteriorOrientation> rows;
  std::map<std::string, std::size_t> line_of;
  const auto lines = lines_of(text);
  bool with_sigmas = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto words = words_of(lines[i]);
    if (!words.empty() && words[0].starts_with('#'))
      with_sigmas |= lines[i].find("sigma_x_m") != std::string_view::npos;
    if (words.empty() || words[0].starts_with('#')) continue;
    auto row = row_of(words, with_sigmas);
    const std::string where = path.string() + ": line " + std::to_string(i + 1) + ": ";
    if (!row)
      return fail(Errc::kBadFormat, where + "not an orientation: image X Y Z omega phi kappa, in metres and degrees" +
                                        (with_sigmas ? ", and their six standard deviations" : ""));
    const auto [earlier, is_new] = line_of.emplace(row->file, i + 1);
    if (!is_new)
      return fail(Errc::kBadFormat,
                  where + row->file + " is there twice, first in line " + std::to_string(earlier->second));
    rows.push_back(*std::move(row));
  }
  if (rows.empty()) return fail(Errc::kBadFormat, path.string() + ": no orientation in it");
  return rows;
}

Result<std::map<ImageId, Rigid3>> poses_of(const std::vector<ExteriorOrientation>& rows, const Block& block) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  std::map<std::string, const ExteriorOrientation*> by_file;
  for (const ExteriorOrientation& row : rows) by_file[row.file] = &row;
  std::map<ImageId, Rigid3> poses;
  for (const auto& [id, image] : block.images) {
    const auto found = by_file.find(image.file);
    if (found == by_file.end()) continue;
    Eigen::Quaterniond rotation = cam_from_world(found->second->angles);
    Eigen::Vector3d centre = found->second->centre_in_map;
    if (frame) {
      centre = frame->local_from_map(centre);
      if (!centre.allFinite())
        return fail(Errc::kBadInput, image.file + ": its position is outside of " + frame->crs());
      rotation = rotation * map_from_local_rotation(*frame, centre);
    }
    poses[id] = {rotation, -(rotation * centre)};
  }
  return poses;
}

Result<> write_opk(const std::filesystem::path& path, const Block& block,
                   const std::map<ImageId, PoseCovariance>& pose_covariance) {
  COLLINEA_TRY(check_image_names(block, "a table of orientations", /*hash_begins_remark=*/true));
  COLLINEA_TRY(const auto rows, exterior_orientations(block, pose_covariance));
  std::string text = block.georeference ? "# Exterior orientations in " + block.georeference->crs +
                                              "; angles to the axes of its grid at each projection centre\n"
                                        : "# Exterior orientations in a local frame without place on Earth, z up\n";
  text +=
      "# ground = Rx(omega) Ry(phi) Rz(kappa) image, image frame x right, y up, z backward\n"
      "# image\tx_m\ty_m\tz_m\tomega_deg\tphi_deg\tkappa_deg";
  if (!pose_covariance.empty()) text += std::string("\t") + kSigmaTitles;
  text += "\n";
  for (const ExteriorOrientation& row : rows) {
    text += row.file;
    for (int i = 0; i < 3; ++i) text += "\t" + fixed(row.centre_in_map[i], 4);
    for (const double angle : {row.angles.omega_deg, row.angles.phi_deg, row.angles.kappa_deg})
      text += "\t" + fixed(angle, 7);
    for (int i = 0; i < 6 && !pose_covariance.empty(); ++i)
      text += "\t" + (row.covariance ? fixed(std::sqrt((*row.covariance)(i, i)) / (i < 3 ? 1 : kRadians), i < 3 ? 5 : 8)
                                     : std::string("nan"));
    text += "\n";
  }
  return write_file(path, text);
}

}  // namespace collinea
