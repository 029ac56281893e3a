// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/opk.h"

#include <array>
#include <map>
#include <optional>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/io/internal/line_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

// The numbers are the last six words; file names may hold blanks.
std::optional<ExteriorOrientation> row_of(const std::vector<std::string_view>& words) {
  if (words.size() < 7) return std::nullopt;
  std::array<double, 6> v{};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = finite_number(words[words.size() - 6 + i]);
    if (!value) return std::nullopt;
    v[i] = *value;
  }
  const std::string_view last = words[words.size() - 7];
  const std::string file(words[0].data(), last.data() + last.size());
  return ExteriorOrientation{file, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
}

}  // namespace

Result<std::vector<ExteriorOrientation>> exterior_orientations(const Block& block) {
  COLLINEA_TRY(const std::optional<LocalFrame> frame, world_frame(block));
  std::vector<ExteriorOrientation> rows;
  for (const auto& [id, cam_from_world] : oriented_images(block)) {
    const Eigen::Vector3d centre = centre_of(cam_from_world);
    ExteriorOrientation row{block.images.at(id).file, centre, {}};
    Eigen::Quaterniond cam_from_map = cam_from_world.rotation;
    if (frame) {
      row.centre_in_map = frame->map_from_local(centre);
      cam_from_map = cam_from_map * map_from_local_rotation(*frame, centre).conjugate();
    }
    row.angles = omega_phi_kappa(cam_from_map);
    rows.push_back(std::move(row));
  }
  return rows;
}

Result<std::vector<ExteriorOrientation>> read_opk(const std::filesystem::path& path) {
  COLLINEA_TRY(const std::string text, read_file(path));
  std::vector<ExteriorOrientation> rows;
  std::map<std::string, std::size_t> line_of;
  const auto lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto words = words_of(lines[i]);
    if (words.empty() || words[0].starts_with('#')) continue;
    auto row = row_of(words);
    const std::string where = path.string() + ": line " + std::to_string(i + 1) + ": ";
    if (!row)
      return fail(Errc::kBadFormat, where + "not an orientation: image X Y Z omega phi kappa, in metres and degrees");
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

Result<> write_opk(const std::filesystem::path& path, const Block& block) {
  COLLINEA_TRY(check_image_names(block, "a table of orientations", /*hash_begins_remark=*/true));
  COLLINEA_TRY(const auto rows, exterior_orientations(block));
  std::string text = block.georeference ? "# Exterior orientations in " + block.georeference->crs +
                                              "; angles to the axes of its grid at each projection centre\n"
                                        : "# Exterior orientations in a local frame without place on Earth, z up\n";
  text +=
      "# ground = Rx(omega) Ry(phi) Rz(kappa) image, image frame x right, y up, z backward\n"
      "# image\tx_m\ty_m\tz_m\tomega_deg\tphi_deg\tkappa_deg\n";
  for (const ExteriorOrientation& row : rows) {
    text += row.file;
    for (int i = 0; i < 3; ++i) text += "\t" + fixed(row.centre_in_map[i], 4);
    for (const double angle : {row.angles.omega_deg, row.angles.phi_deg, row.angles.kappa_deg})
      text += "\t" + fixed(angle, 7);
    text += "\n";
  }
  return write_file(path, text);
}

}  // namespace collinea
