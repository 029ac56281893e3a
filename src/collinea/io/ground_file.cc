// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/ground_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "collinea/io/file.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Fields = std::vector<std::string_view>;

constexpr double kDegree = std::numbers::pi / 180, kGon = std::numbers::pi / 200;
constexpr double kArcsecond = kDegree / 3600, kMilligon = kGon / 1000;

struct Unit {
  std::string_view column;
  double factor;
};

/// A column that may be measured, and those that may hold its sigma.
struct Measured {
  GroundKind kind;
  std::vector<Unit> values, sigmas;
};

/// A column that names the shape on which a point lies.
struct Shape {
  GroundKind kind;
  const char *column, *sigma;
};
constexpr Shape kShapes[] = {{GroundKind::kOnPlane, "plane", "sigma_plane_m"},
                             {GroundKind::kOnLine, "line", "sigma_line_m"},
                             {GroundKind::kAtHeight, "level", "sigma_level_m"}};

const std::vector<Measured>& all_measured() {
  static const std::vector<Measured> all = {
      {GroundKind::kDistance, {{"distance_m", 1}}, {{"sigma_distance_m", 1}, {"sigma_m", 1}}},
      {GroundKind::kHeightDifference, {{"height_difference_m", 1}}, {{"sigma_height_difference_m", 1}, {"sigma_m", 1}}},
      {GroundKind::kDirection,
       {{"direction_deg", kDegree}, {"direction_gon", kGon}},
       {{"sigma_direction_arcsec", kArcsecond}, {"sigma_direction_mgon", kMilligon}}},
      {GroundKind::kZenithAngle,
       {{"zenith_deg", kDegree}, {"zenith_gon", kGon}},
       {{"sigma_zenith_arcsec", kArcsecond}, {"sigma_zenith_mgon", kMilligon}}}};
  return all;
}

tl::unexpected<Error> bad_line(int line, const std::string& what) {
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": " + what);
}

class Reader {
 public:
  Result<> take_title(int line, const Fields& titles) {
    for (std::size_t i = 0; i < titles.size(); ++i) {
      const std::string name = lower(titles[i]);
      if (!is_known(name)) return bad_line(line, "there is no column \"" + name + "\"");
      if (!column_.emplace(name, i).second) return bad_line(line, "column " + name + " is there twice");
    }
    if (!has("from")) return bad_line(line, "the first row must name a column from");
    for (const Shape& shape : kShapes) {
      if (!has(shape.column)) continue;
      if (!has(shape.sigma) && !has("sigma_m"))
        return bad_line(line, std::string("column ") + shape.column + " needs a column " + shape.sigma);
      ++shapes_;
    }
    for (const Measured& measured : all_measured())
      for (const Unit& value : measured.values) {
        if (!has(value.column)) continue;
        if (std::none_of(measured.sigmas.begin(), measured.sigmas.end(), [&](auto& s) { return has(s.column); }))
          return bad_line(line, "column " + std::string(value.column) + " needs a column " +
                                    std::string(measured.sigmas.front().column));
        ++measured_;
      }
    if (measured_ + shapes_ == 0)
      return bad_line(line,
                      "no column holds a measurement: distance_m, height_difference_m, direction_deg, zenith_deg, "
                      "plane, line, level");
    if (measured_ > 0 && !has("to")) return bad_line(line, "the first row must name a column to");
    if (has("sigma_m") && has("distance_m") && has("height_difference_m"))
      return bad_line(line,
                      "sigma_m is of distances or of height differences? Call the columns sigma_distance_m and "
                      "sigma_height_difference_m");
    return {};
  }

  Result<> take_row(int line, const Fields& fields) {
    if (fields.size() > column_.size()) return bad_line(line, "too many fields (decimal commas?)");
    fields_ = &fields;
    GroundFileRow row{.from = std::string(field("from")), .to = std::string(field("to"))};
    row.name = field("name");
    row.setup = field("setup");
    row.line = line;
    if (row.from.empty()) return bad_line(line, "a row needs the name of a point");
    if (row.from == row.to) return bad_line(line, "from and to are both " + row.from);
    const std::string role = lower(field("role"));
    if (role != "" && role != "control" && role != "check")
      return bad_line(line, "role \"" + role + "\" is neither control nor check");
    if (role == "check") row.role = ControlRole::kCheck;
    const std::pair<const char*, double*> heights[] = {{"instrument_height_m", &row.instrument_height_m},
                                                       {"target_height_m", &row.target_height_m}};
    for (const auto& [name, height] : heights)
      if (!field(name).empty()) {
        COLLINEA_TRY(*height, number_in(line, name));
      }
    const std::size_t before = rows.size();
    if (Result<> taken = take_shapes(row); !taken) return taken;
    for (const Measured& measured : all_measured())
      for (const Unit& value : measured.values) {
        if (field(value.column).empty()) continue;
        if (row.to.empty()) return bad_line(line, "a measurement needs the names of two points");
        row.kind = measured.kind;
        COLLINEA_TRY(const double number, number_in(line, value.column));
        row.value = number * value.factor;
        COLLINEA_TRY(row.sigma, sigma_of(line, measured));
        if (row.kind == GroundKind::kDistance && !(row.value > 0))
          return bad_line(line, "the distance " + row.from + " - " + row.to + " is not above 0");
        rows.push_back(row);
        if (row.kind == GroundKind::kHeightDifference)
          rows.back().instrument_height_m = rows.back().target_height_m = 0;
      }
    if (rows.size() == before) return bad_line(line, "nothing is measured from " + row.from + " to " + row.to);
    return {};
  }

  std::vector<GroundFileRow> rows;

 private:
  Result<> take_shapes(GroundFileRow row) {
    row.instrument_height_m = row.target_height_m = 0;
    for (const Shape& shape : kShapes) {
      if (field(shape.column).empty()) continue;
      row.kind = shape.kind;
      row.name = row.setup = field(shape.column);
      row.to = row.from;
      const std::string_view column = field(shape.sigma).empty() ? "sigma_m" : shape.sigma;
      if (field(column).empty())
        return bad_line(row.line, row.from + " on " + shape.column + " " + row.name + " has no standard deviation");
      COLLINEA_TRY(row.sigma, number_in(row.line, column));
      if (!(row.sigma > 0)) return bad_line(row.line, std::string(column) + " must be above 0");
      for (row.axis = 0; row.axis < (shape.kind == GroundKind::kOnLine ? 2 : 1); ++row.axis) rows.push_back(row);
      row.axis = 0;
    }
    return {};
  }

  static bool is_known(const std::string& name) {
    for (const Shape& shape : kShapes)
      if (name == shape.column || name == shape.sigma) return true;
    for (const char* other : {"from", "to", "name", "role", "setup", "instrument_height_m", "target_height_m"})
      if (name == other) return true;
    for (const Measured& measured : all_measured()) {
      const auto is_it = [&](const Unit& unit) { return unit.column == name; };
      if (std::any_of(measured.values.begin(), measured.values.end(), is_it) ||
          std::any_of(measured.sigmas.begin(), measured.sigmas.end(), is_it))
        return true;
    }
    return false;
  }
  [[nodiscard]] bool has(std::string_view name) const { return column_.find(name) != column_.end(); }
  [[nodiscard]] std::string_view field(std::string_view name) const {
    const auto its = column_.find(name);
    return its == column_.end() || its->second >= fields_->size() ? std::string_view{} : (*fields_)[its->second];
  }
  [[nodiscard]] Result<double> number_in(int line, std::string_view name) const {
    const auto value = number(field(name));
    if (!value || !std::isfinite(*value))
      return bad_line(line, std::string(name) + " \"" + std::string(field(name)) + "\" is not a number");
    return *value;
  }
  [[nodiscard]] Result<double> sigma_of(int line, const Measured& measured) const {
    for (const Unit& sigma : measured.sigmas) {
      if (field(sigma.column).empty()) continue;
      COLLINEA_TRY(const double value, number_in(line, sigma.column));
      if (!(value > 0)) return bad_line(line, std::string(sigma.column) + " must be above 0");
      return value * sigma.factor;
    }
    return bad_line(line, std::string("the ") + kGroundKindNames[static_cast<std::size_t>(measured.kind)] + " " +
                              std::string(field("from")) + " - " + std::string(field("to")) +
                              " has no standard deviation");
  }

  std::map<std::string, std::size_t, std::less<>> column_;
  const Fields* fields_ = nullptr;
  int measured_ = 0, shapes_ = 0;
};

}  // namespace

Result<std::vector<GroundFileRow>> parse_ground(std::string_view text) {
  Reader reader;
  bool titled = false;
  int line = 0;
  for (const std::string_view raw : lines_of(text)) {
    ++line;
    const std::string_view content = trimmed(raw);
    if (content.empty() || content.starts_with('#')) continue;
    const Fields fields = fields_of(content, ',');
    const Result<> taken = titled ? reader.take_row(line, fields) : reader.take_title(line, fields);
    if (!taken) return tl::unexpected(taken.error());
    titled = true;
  }
  if (reader.rows.empty()) return fail(Errc::kBadFormat, "no measurement found");
  return std::move(reader.rows);
}

Result<std::vector<GroundFileRow>> read_ground(const std::filesystem::path& path) {
  constexpr std::uint64_t kLargest = 64 << 20;
  COLLINEA_TRY(const std::string text, read_file(path, kLargest));
  return parse_ground(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace collinea
