// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/resection_tables.h"

#include <fmt/format.h>

#include <numbers>

#include "collinea/io/text_table.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

std::string unit_of(const TextTable& table, const ResectOneOptions& options) {
  if (options.method == ResectionMethod::kStation) return "rad";
  const std::string unit = table.unit_of("x");
  return unit.empty() || unit == "px" ? "px" : "mm";
}

// What a measurement has as its sigma where nothing states one, in the unit that it is kept in.
double default_sigma(const ResectOneOptions& options, const TextTable& table, const std::string& unit) {
  if (options.method != ResectionMethod::kStation) {
    if (!options.sigma) return unit == "mm" ? 0.01 : 1;
    const std::string given = table.unit_of("x");
    return *options.sigma * (unit == "mm" ? unit_factor(given, "mm").value_or(1) : 1);
  }
  const std::string given = table.unit_of("direction");
  return options.sigma.value_or(0.001) * unit_factor(given.empty() ? "deg" : given, "rad").value_or(1 / kDegrees);
}

}  // namespace

Result<ResectionTables> read_resection_tables(const std::filesystem::path& measurements,
                                              const std::filesystem::path& ground, const ResectOneOptions& options) {
  const auto in_file = [&](Error e) { return std::move(e).within(measurements.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(measurements));
  const bool is_station = options.method == ResectionMethod::kStation;
  ResectionTables tables;
  tables.unit = unit_of(table, options);
  tables.sigmas_are_stated = table.has("sigma") || options.sigma.has_value();
  COLLINEA_TRY(const auto points, table.words("point").map_error(in_file));
  const char* image_column = is_station ? "station" : "image";
  std::vector<std::string> images(points.size(), is_station ? "station" : "1");
  if (table.has(image_column)) {
    COLLINEA_TRY(images, table.words(image_column).map_error(in_file));
  }
  const bool in_degrees = is_station && table.unit_of("direction").empty();
  COLLINEA_TRY(auto x, table.numbers(is_station ? "direction" : "x", tables.unit).map_error(in_file));
  std::vector<double> y(x.size(), 0);
  if (!is_station) {
    COLLINEA_TRY(y, table.numbers("y", tables.unit).map_error(in_file));
  }
  COLLINEA_TRY(const auto sigmas,
               table.numbers_or("sigma", tables.unit, default_sigma(options, table, tables.unit)).map_error(in_file));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (in_degrees) x[i] /= kDegrees;
    if (!(sigmas[i] > 0))
      return fail(Errc::kBadFormat, fmt::format("{}: row {}: sigma is not above 0", measurements.string(), i + 1));
    for (const ResectionRow& other : tables.marks)
      if (other.image == images[i] && other.point == points[i])
        return fail(Errc::kBadFormat,
                    fmt::format("{}: point {} is measured twice in {}", measurements.string(), points[i], images[i]));
    tables.marks.push_back({images[i], points[i], {x[i], y[i]}, sigmas[i]});
    if (std::find(tables.images.begin(), tables.images.end(), images[i]) == tables.images.end())
      tables.images.push_back(images[i]);
  }
  const bool needs_height = options.method != ResectionMethod::kPlane && !is_station;
  COLLINEA_TRY(tables.ground, read_ground_table(ground, options.sigma_ground.value_or(0), needs_height));
  if (tables.marks.empty()) return fail(Errc::kBadInput, measurements.string() + " has no measurements");
  return tables;
}

Result<> check_one_image(const ResectionTables& tables) {
  if (tables.images.size() > 1)
    return fail(Errc::kBadInput, fmt::format("the table has {} images: this method is of one", tables.images.size()),
                {"method"_option});
  return {};
}

}  // namespace collinea
