// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/geodetic_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/io/internal/titled_table.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

constexpr double kDegree = std::numbers::pi / 180, kGon = std::numbers::pi / 200;
constexpr double kArcsecond = kDegree / 3600, kMilligon = kGon / 1000;

struct Unit {
  std::string_view column;
  double factor;
};

/// A column that may be measured, and those that may hold its sigma.
struct Measured {
  GeodeticKind kind;
  std::vector<Unit> values, sigmas;
};

/// A column that names the shape on which a point lies.
struct Shape {
  GeodeticKind kind;
  const char *column, *sigma;
};
constexpr Shape kShapes[] = {{GeodeticKind::kOnPlane, "plane", "sigma_plane_m"},
                             {GeodeticKind::kOnLine, "line", "sigma_line_m"},
                             {GeodeticKind::kAtHeight, "level", "sigma_level_m"}};

/// Columns of a GNSS vector and of its covariance, by rows from the diagonal on.
struct VectorColumns {
  bool is_geocentric;
  const char* vector[3];
  const char* covariance[6];
};
constexpr VectorColumns kVectors[] = {
    {true, {"dx_m", "dy_m", "dz_m"}, {"xx_m2", "xy_m2", "xz_m2", "yy_m2", "yz_m2", "zz_m2"}},
    {false, {"de_m", "dn_m", "du_m"}, {"ee_m2", "en_m2", "eu_m2", "nn_m2", "nu_m2", "uu_m2"}}};

const std::vector<Measured>& all_measured() {
  static const std::vector<Measured> all = {
      {GeodeticKind::kDistance, {{"distance_m", 1}}, {{"sigma_distance_m", 1}, {"sigma_m", 1}}},
      {GeodeticKind::kHeightDifference,
       {{"height_difference_m", 1}},
       {{"sigma_height_difference_m", 1}, {"sigma_m", 1}}},
      {GeodeticKind::kDirection,
       {{"direction_deg", kDegree}, {"direction_gon", kGon}},
       {{"sigma_direction_arcsec", kArcsecond}, {"sigma_direction_mgon", kMilligon}}},
      {GeodeticKind::kZenithAngle,
       {{"zenith_deg", kDegree}, {"zenith_gon", kGon}},
       {{"sigma_zenith_arcsec", kArcsecond}, {"sigma_zenith_mgon", kMilligon}}},
      {GeodeticKind::kAzimuth,
       {{"azimuth_deg", kDegree}, {"azimuth_gon", kGon}},
       {{"sigma_azimuth_arcsec", kArcsecond}, {"sigma_azimuth_mgon", kMilligon}}}};
  return all;
}

bool is_column(const std::string& name) {
  for (const Shape& shape : kShapes)
    if (name == shape.column || name == shape.sigma) return true;
  for (const VectorColumns& vector : kVectors)
    if (std::ranges::find(vector.vector, name) != std::end(vector.vector) ||
        std::ranges::find(vector.covariance, name) != std::end(vector.covariance))
      return true;
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

class Reader {
 public:
  explicit Reader(TitledTable& table) : table_(table) {}

  Result<> check_titles() const {
    if (!table_.has("from")) return table_.bad_row("the first row must name a column from");
    bool measures = false, shapes = false;
    for (const Shape& shape : kShapes) {
      if (!table_.has(shape.column)) continue;
      if (!table_.has(shape.sigma) && !table_.has("sigma_m"))
        return table_.bad_row(std::string("column ") + shape.column + " needs a column " + shape.sigma);
      shapes = true;
    }
    for (const Measured& measured : all_measured())
      for (const Unit& value : measured.values) {
        if (!table_.has(value.column)) continue;
        if (std::none_of(measured.sigmas.begin(), measured.sigmas.end(), [&](auto& s) { return table_.has(s.column); }))
          return table_.bad_row("column " + std::string(value.column) + " needs a column " +
                                std::string(measured.sigmas.front().column));
        measures = true;
      }
    COLLINEA_TRY(const bool vectors, check_titles_of_vectors());
    measures |= vectors;
    if (!measures && !shapes)
      return table_.bad_row(
          "no column holds a measurement: distance_m, height_difference_m, direction_deg, zenith_deg, azimuth_deg, "
          "dx_m, de_m, plane, line, level");
    if (measures && !table_.has("to")) return table_.bad_row("the first row must name a column to");
    return {};
  }

  Result<> take_row() {
    GeodeticFileRow row{.from = std::string(table_.field("from")), .to = std::string(table_.field("to"))};
    row.name = table_.field("name");
    row.setup = table_.field("setup");
    row.line = table_.line();
    if (row.from.empty()) return table_.bad_row("a row needs the name of a point");
    if (row.from == row.to) return table_.bad_row("from and to are both " + row.from);
    const std::string role = lower(table_.field("role"));
    if (role != "" && role != "control" && role != "check")
      return table_.bad_row("role \"" + role + "\" is neither control nor check");
    if (role == "check") row.role = ControlRole::kCheck;
    for (const auto& [name, height] : {std::pair("instrument_height_m", &row.instrument_height_m),
                                       std::pair("target_height_m", &row.target_height_m)})
      if (!table_.field(name).empty()) {
        COLLINEA_TRY(*height, table_.number_in(name));
      }
    const std::size_t before = rows.size();
    users_of_sigma_m_ = 0;
    if (Result<> taken = take_shapes(row); !taken) return taken;
    if (Result<> taken = take_vectors(row); !taken) return taken;
    for (const Measured& measured : all_measured())
      if (Result<> taken = take_measured(measured, row); !taken) return taken;
    if (rows.size() == before) return table_.bad_row("nothing is measured from " + row.from + " to " + row.to);
    if (users_of_sigma_m_ > 1)
      return table_.bad_row("of which measurement of this row is sigma_m? Give each a column of its own: " +
                            std::string("sigma_distance_m, sigma_height_difference_m, sigma_plane_m ..."));
    return {};
  }

  std::vector<GeodeticFileRow> rows;

 private:
  // True when there are columns of a vector.
  [[nodiscard]] Result<bool> check_titles_of_vectors() const {
    bool found = false;
    for (const VectorColumns& columns : kVectors) {
      std::string missing;
      bool any = false;
      const auto look = [&](const auto& names) {
        for (const char* name : names) {
          any |= table_.has(name);
          if (!table_.has(name)) missing += (missing.empty() ? "" : ", ") + std::string(name);
        }
      };
      look(columns.vector);
      look(columns.covariance);
      if (any && !missing.empty())
        return table_.bad_row("a vector has three components and a covariance of six; missing: " + missing);
      found |= any;
    }
    return found;
  }

  Result<> take_vectors(GeodeticFileRow row) {
    for (const VectorColumns& columns : kVectors) {
      const auto is_there = [&](const char* name) { return !table_.field(name).empty(); };
      if (std::ranges::none_of(columns.vector, is_there)) continue;
      if (row.to.empty()) return table_.bad_row("a measurement needs the names of two points");
      row.kind = GeodeticKind::kGnssVector;
      row.is_geocentric = columns.is_geocentric;
      row.vector.is_local = !columns.is_geocentric;
      for (int axis = 0; axis < 3; ++axis) {
        COLLINEA_TRY(row.vector.vector[axis], table_.number_in(columns.vector[axis]));
      }
      if (!row.vector.vector.allFinite())
        return table_.bad_row("the vector " + row.from + " - " + row.to + " lacks a component");
      const char* const* next = columns.covariance;
      for (int r = 0; r < 3; ++r)
        for (int c = r; c < 3; ++c) {
          COLLINEA_TRY(const double value, table_.number_in(*next++));
          row.vector.covariance_m2(r, c) = row.vector.covariance_m2(c, r) = value;
        }
      if (!observations_of(row.vector, {}))
        return table_.bad_row("the covariance of " + row.from + " - " + row.to +
                              " is none: it has to be positive definite");
      rows.push_back(row);
    }
    return {};
  }

  Result<> take_shapes(GeodeticFileRow row) {
    row.instrument_height_m = row.target_height_m = 0;
    for (const Shape& shape : kShapes) {
      if (table_.field(shape.column).empty()) continue;
      row.kind = shape.kind;
      row.name = row.setup = table_.field(shape.column);
      row.to = row.from;
      const std::string_view column = table_.field(shape.sigma).empty() ? "sigma_m" : shape.sigma;
      if (table_.field(column).empty())
        return table_.bad_row(row.from + " on " + shape.column + " " + row.name + " has no standard deviation");
      COLLINEA_TRY(row.sigma, table_.number_in(column));
      if (!(row.sigma > 0)) return table_.bad_row(std::string(column) + " must be above 0");
      if (column == "sigma_m") users_of_sigma_m_ = 1;  // how well the point keeps to all its shapes
      for (row.axis = 0; row.axis < (shape.kind == GeodeticKind::kOnLine ? 2 : 1); ++row.axis) rows.push_back(row);
      row.axis = 0;
    }
    return {};
  }

  Result<> take_measured(const Measured& measured, GeodeticFileRow row) {
    const Unit* in = nullptr;
    for (const Unit& value : measured.values) {
      if (table_.field(value.column).empty()) continue;
      if (in)
        return table_.bad_row(std::string(in->column) + " and " + std::string(value.column) + " tell one thing twice");
      in = &value;
    }
    if (!in) return {};
    if (row.to.empty()) return table_.bad_row("a measurement needs the names of two points");
    row.kind = measured.kind;
    COLLINEA_TRY(const double number, table_.number_in(in->column));
    row.value = number * in->factor;
    COLLINEA_TRY(row.sigma, sigma_of(measured));
    const std::string between = row.from + " - " + row.to;
    if (row.kind == GeodeticKind::kDistance && !(row.value > 0))
      return table_.bad_row("the distance " + between + " is not above 0");
    if ((row.kind == GeodeticKind::kDirection || row.kind == GeodeticKind::kAzimuth) &&
        std::abs(row.value) > 2 * std::numbers::pi * (1 + 1e-12))
      return table_.bad_row("the " + std::string(kGeodeticKindNames[static_cast<std::size_t>(row.kind)]) + " " +
                            between + " is beyond a full circle of 360 degrees, 400 gon");
    if (row.kind == GeodeticKind::kZenithAngle && !(row.value > 0 && row.value < std::numbers::pi))
      return table_.bad_row("the zenith angle " + between +
                            " is not between 0 (up) and 180 degrees, 200 gon (down); of the second face subtract it "
                            "from 360 degrees, 400 gon");
    if (row.kind == GeodeticKind::kHeightDifference) row.instrument_height_m = row.target_height_m = 0;
    rows.push_back(std::move(row));
    return {};
  }

  [[nodiscard]] Result<double> sigma_of(const Measured& measured) {
    for (const Unit& sigma : measured.sigmas) {
      if (table_.field(sigma.column).empty()) continue;
      COLLINEA_TRY(const double value, table_.number_in(sigma.column));
      if (!(value > 0)) return table_.bad_row(std::string(sigma.column) + " must be above 0");
      users_of_sigma_m_ += sigma.column == "sigma_m";
      return value * sigma.factor;
    }
    return table_.bad_row(std::string("the ") + kGeodeticKindNames[static_cast<std::size_t>(measured.kind)] + " " +
                          std::string(table_.field("from")) + " - " + std::string(table_.field("to")) +
                          " has no standard deviation");
  }

  TitledTable& table_;
  int users_of_sigma_m_ = 0;  // of this row
};

}  // namespace

Result<std::vector<GeodeticFileRow>> parse_geodetic(std::string_view bytes) {
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes));
  const std::string_view text = converted ? *converted : bytes;
  COLLINEA_TRY(TitledTable table, TitledTable::parse(text, is_column));
  Reader reader(table);
  if (Result<> checked = reader.check_titles(); !checked) return tl::unexpected(checked.error());
  while (true) {
    COLLINEA_TRY(const bool more, table.next());
    if (!more) break;
    if (Result<> taken = reader.take_row(); !taken) return tl::unexpected(taken.error());
  }
  if (reader.rows.empty()) return fail(Errc::kBadFormat, "no measurement found");
  return std::move(reader.rows);
}

Result<std::vector<GeodeticFileRow>> read_geodetic(const std::filesystem::path& path) {
  constexpr std::uint64_t kLargest = 64 << 20;
  COLLINEA_TRY(const std::string text, read_file(path, kLargest));
  return parse_geodetic(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
}

}  // namespace collinea
