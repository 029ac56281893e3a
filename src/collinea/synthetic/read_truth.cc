// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <type_traits>

#include "collinea/base/file.h"
#include "collinea/io/text.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

using Fields = std::vector<std::string_view>;

// The numbers of the fields [from, from + N).
template <int N>
Result<Eigen::Matrix<double, N, 1>> numbers(const Fields& fields, std::size_t from) {
  Eigen::Matrix<double, N, 1> values;
  for (int i = 0; i < N; ++i) {
    const std::size_t index = from + std::size_t(i);
    const auto value = index < fields.size() ? number(fields[index]) : std::nullopt;
    if (!value) return fail(Errc::kBadFormat, fmt::format("field {} is not a number", index + 1));
    values[i] = *value;
  }
  return values;
}

// Calls take(fields) for every row of a table that is not a comment.
template <class Take>
Result<> read_table(const std::filesystem::path& path, Take&& take) {
  COLLINEA_TRY(const std::string text, read_file(path));
  int line = 0;
  for (const std::string_view row : lines_of(text)) {
    ++line;
    if (trimmed(row).empty() || trimmed(row).front() == '#') continue;
    if (Result<> taken = take(fields_of(row, ',')); !taken)
      return tl::unexpected(std::move(taken).error().within(fmt::format("{}: line {}", path.string(), line)));
  }
  return {};
}

Result<> take_camera(const Fields& fields, Camera& camera) {
  const auto take_word = [&](const auto& names, auto& value) -> Result<> {
    const auto found = std::find(names.begin(), names.end(), fields.size() > 1 ? std::string_view(fields[1]) : "");
    if (found == names.end()) return fail(Errc::kBadFormat, "no such " + std::string(fields[0]) + " of a camera");
    value = std::remove_reference_t<decltype(value)>(found - names.begin());
    return {};
  };
  if (!fields.empty() && fields[0] == "model") {
    const auto model = model_named(fields.size() > 1 ? std::string_view(fields[1]) : "");
    if (!model) return fail(Errc::kBadFormat, "no such model of a camera");
    camera.model = *model;
    return {};
  }
  if (!fields.empty() && fields[0] == "additional") return take_word(kAdditionalNames, camera.additional);
  COLLINEA_TRY(const auto value, numbers<1>(fields, 1));
  if (fields[0] == "width_px") camera.width_px = int(value[0]);
  if (fields[0] == "height_px") camera.height_px = int(value[0]);
  if (const auto param = param_named(camera, fields[0])) camera.params[std::size_t(*param)] = value[0];
  return {};
}

Result<> take_frame(const Fields& fields, Georeference& georeference) {
  if (fields.size() > 1 && fields[0] == "crs") {
    georeference.crs = fields[1];
    return {};
  }
  COLLINEA_TRY(const auto value, numbers<1>(fields, 1));
  if (fields[0] == "latitude_deg") georeference.origin_latitude_deg = value[0];
  if (fields[0] == "longitude_deg") georeference.origin_longitude_deg = value[0];
  if (fields[0] == "height_m") georeference.origin_height_m = value[0];
  return {};
}

Result<> take_pose(const Fields& fields, TruthFolder& truth) {
  COLLINEA_TRY(const auto v, numbers<10>(fields, 1));
  const std::string file(fields[0]);
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized();
  truth.cam_from_world[file] = {rotation, -(rotation * Eigen::Vector3d(v.head<3>()))};
  truth.centre_in_map[file] = v.tail<3>();
  return {};
}

Result<> take_mark(const Fields& fields, TruthFolder& truth) {
  COLLINEA_TRY(const auto v, numbers<6>(fields, 2));
  truth.marks[std::string(fields[0])] = {fields[1] == "check" ? ControlRole::kCheck : ControlRole::kControl,
                                         v.head<3>(), v.tail<3>()};
  return {};
}

}  // namespace

Result<TruthFolder> read_truth(const std::filesystem::path& path) {
  const std::filesystem::path folder = is_there(path / "truth") ? path / "truth" : path;
  TruthFolder truth;
  truth.camera.prior.source = Provenance::kTrue;
  Result<> read = read_table(folder / "camera.csv", [&](const Fields& f) { return take_camera(f, truth.camera); });
  if (read) read = read_table(folder / "frame.csv", [&](const Fields& f) { return take_frame(f, truth.georeference); });
  if (read) read = read_table(folder / "poses.csv", [&](const Fields& f) { return take_pose(f, truth); });
  if (read) read = read_table(folder / "marks.csv", [&](const Fields& f) { return take_mark(f, truth); });
  if (!read) return tl::unexpected(std::move(read).error());
  if (is_there(folder / "dsm.tif")) truth.dsm = folder / "dsm.tif";
  if (is_there(folder / "dtm.tif")) truth.dtm = folder / "dtm.tif";
  if (is_there(folder / "ortho.tif")) truth.ortho = folder / "ortho.tif";
  return truth;
}

}  // namespace collinea
