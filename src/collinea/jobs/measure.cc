// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/measure.h"

#include <fmt/format.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/io/text.h"
#include "collinea/report/profile_page.h"
#include "collinea/report/volume_report.h"

namespace collinea {
namespace {

Result<std::optional<MapArea>> area_of(const std::optional<std::filesystem::path>& file) {
  if (!file) return std::nullopt;
  COLLINEA_TRY(const std::string text, read_file(*file));
  return parse_area(text).map([](MapArea area) { return std::optional(std::move(area)); }).map_error([&](Error e) {
    return std::move(e).within(file->string());
  });
}

Result<Volume> volume_of(const SurfaceFiles& surface, const decltype(MeasureVolumeOptions::base)& base,
                         const std::optional<MapArea>& area, const VolumeOptions& options, const Run& run) {
  if (base.word() == VolumeBase::kRim) {
    if (!area)
      return fail(Errc::kBadInput, "volume over which area? Give its corners, or as base a height or another surface",
                  {"area"_option, "base"_option});
    return volume_over_rim(surface, *area, options, run);
  }
  if (const double* level_m = base.get<double>()) return volume_over_level(surface, *level_m, area, options, run);
  return volume_over_surface(surface, with_sigmas_beside(*base.get<std::filesystem::path>()), area, options, run);
}

// Numbers as they are written, or a file of them.
Result<std::vector<Eigen::Vector2d>> line_of(const std::string& line) {
  if (line.empty())
    return fail(Errc::kBadInput, "a profile along what? Give a line, east,north,east,north, or a file of it",
                {"line"_option});
  std::vector<double> numbers;
  for (const std::string_view field : fields_of(line, ',')) {
    const auto value = finite_number(field);
    if (!value) {
      COLLINEA_TRY(const std::string text, read_file(line));
      return parse_map_points(text).map_error([&](Error e) { return std::move(e).within(line); });
    }
    numbers.push_back(*value);
  }
  if (numbers.size() < 4 || numbers.size() % 2)
    return fail(Errc::kBadInput, "\"" + line + "\" is no line: give east,north of two points or more", {"line"_option});
  std::vector<Eigen::Vector2d> positions;
  for (std::size_t i = 0; i < numbers.size(); i += 2) positions.emplace_back(numbers[i], numbers[i + 1]);
  return positions;
}

// A field of a table as RFC 4180 has it: text with commas, quotes or line breaks stands in quotes.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string profile_csv(const Profile& profile, const std::vector<std::string>& names) {
  std::string text = "distance_m,east_m,north_m";
  for (const std::string& name : names)
    text += "," + csv_field(name + "_height_m") + "," + csv_field(name + "_sigma_m");
  text += "\n";
  const auto field = [](double value) { return std::isfinite(value) ? fmt::format(",{:.4f}", value) : ","; };
  for (std::size_t i = 0; i < profile.distance_m.size(); ++i) {
    text +=
        fmt::format("{:.4f},{:.4f},{:.4f}", profile.distance_m[i], profile.positions[i].x(), profile.positions[i].y());
    for (const auto& surface : profile.of) text += field(surface[i].height_m) + field(surface[i].sigma_m);
    text += "\n";
  }
  return text;
}

}  // namespace

Result<MeasuredVolume> measure_volume(const std::filesystem::path& surface, const MeasureVolumeOptions& asked,
                                      const VolumeOptions& options, const Run& run) {
  COLLINEA_TRY(const std::optional<MapArea> area, area_of(asked.area));
  const SurfaceFiles files = with_sigmas_beside(surface);
  COLLINEA_TRY(const Volume volume, volume_of(files, asked.base, area, options, run));
  if (asked.output) COLLINEA_TRY(write_file(*asked.output, volume_json(volume)));
  return MeasuredVolume{volume, !files.sigma.has_value()};
}

Result<Profile> draw_profile(const std::filesystem::path& surface, const ProfileOptions& options,
                             const std::filesystem::path& folder, const Run&) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(const std::vector<Eigen::Vector2d> line, line_of(options.line));
  std::vector<std::filesystem::path> files = {surface};
  for (const std::string_view other : fields_of(options.others, ','))
    if (!other.empty()) files.emplace_back(other);
  std::vector<HeightSamples> surfaces;
  std::vector<std::string> names;
  for (const auto& file : files) {
    COLLINEA_TRY(HeightSamples samples, HeightSamples::open(with_sigmas_beside(file), options.sigma_m));
    surfaces.push_back(std::move(samples));
    names.push_back(file.stem().string());
  }
  COLLINEA_TRY(Profile profile, profile_along(line, options.step_m.value_or(surfaces[0].grid().cell_m), surfaces));
  COLLINEA_TRY(write_file(folder / "profile.csv", profile_csv(profile, names)));
  COLLINEA_TRY(write_file(folder / "profile.html", profile_page(profile, names)));
  return profile;
}

}  // namespace collinea
