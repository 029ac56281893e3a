// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/dbat_tables.h"

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>

#include "collinea/base/file.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/observation_order.h"
#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using Names = std::initializer_list<std::string_view>;

/// One row of a table whose columns are named by its format.
struct Row {
  std::map<std::string, std::string> text;

  [[nodiscard]] bool has(const std::string& column) const { return text.contains(column); }
  [[nodiscard]] std::optional<double> value(const char* column) const {
    const auto its = text.find(column);
    return its == text.end() ? std::nullopt : finite_number(its->second);
  }
  [[nodiscard]] std::optional<std::uint32_t> id(const char* column) const {
    const auto its = text.find(column);
    const auto found = its == text.end() ? std::nullopt : integer(its->second);
    return found && *found >= 0 && *found < std::int64_t(PointId::kNone) ? std::optional(std::uint32_t(*found))
                                                                         : std::nullopt;
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> three(const char* a, const char* b, const char* c) const {
    const auto x = value(a), y = value(b), z = value(c);
    return x && y && z ? std::optional(Eigen::Vector3d(*x, *y, *z)) : std::nullopt;
  }
};

/// What is wrong with a row; empty: nothing.
using Take = std::function<std::string(const Row&, const XmlElement& file)>;

Result<std::vector<std::string>> columns_of(const XmlElement& file, Names known, const std::filesystem::path& script) {
  std::vector<std::string> columns;
  for (const std::string_view name : fields_of(file.attribute("format"), ',')) {
    columns.push_back(lower(name));
    const std::string& column = columns.back();
    if (column != "ignored" && column != "dummy" && std::find(known.begin(), known.end(), column) == known.end())
      return bad_dbat(script, file.line, "format: \"" + column + "\" is no column of this table");
    const bool twice = std::find(columns.begin(), columns.end() - 1, column) != columns.end() - 1;
    if (twice && column != "ignored" && column != "dummy")
      return bad_dbat(script, file.line, "format: column " + column + " is there twice");
  }
  return columns;
}

Result<> read_rows(const std::filesystem::path& path, const std::vector<std::string>& columns,
                   const std::string& format, const std::function<std::string(const Row&)>& take) {
  COLLINEA_TRY(const std::string bytes, read_file(path));
  COLLINEA_TRY(const auto converted,
               converted_to_utf8(bytes).map_error([&](Error e) { return std::move(e).within(path.string()); }));
  const std::vector<std::string_view> lines = lines_of(converted ? *converted : bytes);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = trimmed(lines[i]);
    if (line.empty() || line.starts_with('#')) continue;
    const std::vector<std::string_view> fields = fields_of(line, ',');
    if (fields.size() != columns.size())
      return bad_dbat(
          path, i + 1,
          std::to_string(fields.size()) + " fields; the script says there are " + format + separator_hint(line, ','));
    Row row;
    for (std::size_t k = 0; k < columns.size(); ++k) row.text[columns[k]] = fields[k];
    if (const std::string wrong = take(row); !wrong.empty()) return bad_dbat(path, i + 1, wrong);
  }
  return {};
}

// Standard deviations of coordinates: what names more axes is read first. Below 0: one that is no number.
Eigen::Vector3d sigma_of_point(const Row& row) {
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
  if (row.has("sxyz")) sigma.setConstant(row.value("sxyz").value_or(-1));
  if (row.has("sxy")) sigma.head<2>().setConstant(row.value("sxy").value_or(-1));
  const char* names[] = {"sx", "sy", "sz"};
  for (int axis = 0; axis < 3; ++axis)
    if (row.has(names[axis])) sigma[axis] = row.value(names[axis]).value_or(-1);
  return sigma;
}

std::optional<double> degrees_of_unit(const std::string& unit) {
  if (unit == "degrees" || unit == "degree") return 1;
  if (unit == "radian" || unit == "radians") return 180 / std::numbers::pi;
  return unit == "gon" ? std::optional(0.9) : std::nullopt;
}

class Tables {
 public:
  explicit Tables(DbatProject& project) : project_(project), block_(project.file.block) {}

  Result<> read(const XmlElement& input) {
    for (const char* needed : {"images", "image_pts"})
      if (!input.child(needed))
        return bad_dbat(project_.script, input.line, std::string("there is no element ") + needed);
    COLLINEA_TRY(each_row(input, "images", {"id", "label", "path"}, {"format"},
                          [&](auto& row, auto&) { return take_image(row); }));
    COLLINEA_TRY(take_points(input, "ctrl_pts", ControlRole::kControl));
    COLLINEA_TRY(take_points(input, "check_pts", ControlRole::kCheck));
    COLLINEA_TRY(
        each_row(input, "prior_eo",
                 {"id", "x", "y", "z", "sx", "sy", "sz", "sxy", "sxyz", "omega", "phi", "kappa", "so", "sp", "sk"},
                 {"format", "units"}, [&](auto& row, auto& file) { return take_orientation(row, file); }));
    COLLINEA_TRY(each_row(input, "image_pts", {"id", "im", "x", "y", "sx", "sy", "sxy"}, {"format", "sxy", "sx", "sy"},
                          [&](auto& row, auto& file) { return take_mark(row, file); }));
    sort_by_point_and_image(block_.observations);
    return {};
  }

 private:
  // Rows of all files of an element; an element may be missing.
  Result<> each_row(const XmlElement& input, const char* table, Names columns, Names attributes, const Take& take) {
    const auto elements = children_named(input, table);
    if (elements.empty()) return {};
    const XmlElement& element = *elements[0];
    if (elements.size() > 1)
      return bad_dbat(project_.script, elements[1]->line, std::string("a second element ") + table);
    const bool of_points = std::string_view(table) == "ctrl_pts" || std::string_view(table) == "check_pts";
    COLLINEA_TRY(check_children(element, of_points ? Names{"file", "filter"} : Names{"file"}, project_.script));
    COLLINEA_TRY(check_attributes(element, {"image_base_dir"}, project_.script));
    if (!element.child("file")) return bad_dbat(project_.script, element.line, std::string(table) + " names no file");
    for (const XmlElement* file : children_named(element, "file")) {
      COLLINEA_TRY(check_attributes(*file, attributes, project_.script));
      COLLINEA_TRY(const std::vector<std::string> names, columns_of(*file, columns, project_.script));
      COLLINEA_TRY(const std::filesystem::path path, project_.path_of(*file, file->text));
      COLLINEA_TRY(read_rows(path, names, file->attribute("format"), [&](const Row& row) { return take(row, *file); }));
    }
    return {};
  }

  std::string take_image(const Row& row) {
    const auto image = row.id("id");
    const auto path = row.text.find("path");
    if (!image || path == row.text.end()) return "an image needs a number (id) and a file (path)";
    if (block_.images.contains({*image})) return "a second image " + std::to_string(*image);
    const auto slash = path->second.find_last_of("/\\");
    block_.images[{*image}] = {.file = path->second.substr(slash == std::string::npos ? 0 : slash + 1), .camera = {0}};
    return {};
  }

  Result<> take_points(const XmlElement& input, const char* table, ControlRole role) {
    std::map<std::uint32_t, ControlPoint> points;
    COLLINEA_TRY(each_row(input, table, {"id", "label", "x", "y", "z", "sx", "sy", "sz", "sxy", "sxyz"}, {"format"},
                          [&](auto& row, auto&) { return take_point(row, role, points); }));
    if (const XmlElement* element = input.child(table))
      for (const XmlElement* filter : children_named(*element, "filter")) COLLINEA_TRY(apply(*filter, points));
    for (auto& [id, point] : points)
      if (!block_.control.emplace(ControlId{id}, std::move(point)).second)
        return bad_dbat(project_.script, input.child(table)->line,
                        "point " + std::to_string(id) + " is a control point and a check point");
    return {};
  }

  static std::string take_point(const Row& row, ControlRole role, std::map<std::uint32_t, ControlPoint>& points) {
    const auto id = row.id("id");
    const auto coordinates = row.three("x", "y", "z");
    if (!id || !coordinates) return "a point needs id, x, y and z";
    const Eigen::Vector3d sigma = sigma_of_point(row);
    if (!(sigma.minCoeff() >= 0)) return "a standard deviation is a number from 0";
    const auto label = row.text.find("label");
    const bool has_name = label != row.text.end() && !label->second.empty();
    const bool is_new = points
                            .emplace(*id, ControlPoint{.name = has_name ? label->second : std::to_string(*id),
                                                       .role = role,
                                                       .position_in_map = *coordinates,
                                                       .position_in_world = *coordinates,
                                                       .sigma_m = sigma})
                            .second;
    return is_new ? std::string{} : "a second point " + std::to_string(*id);
  }

  Result<> apply(const XmlElement& filter, std::map<std::uint32_t, ControlPoint>& points) {
    COLLINEA_TRY(check_attributes(filter, {"id"}, project_.script));
    if (filter.text != "keep" && filter.text != "remove")
      return bad_dbat(project_.script, filter.line, "filter " + filter.text + ": keep or remove is expected");
    std::set<std::uint32_t> named;
    for (const std::string_view field : fields_of(filter.attribute("id"), ',')) {
      const auto id = integer(field);
      if (!id || *id < 0 || *id >= std::int64_t(PointId::kNone) || !points.contains(std::uint32_t(*id)))
        return bad_dbat(project_.script, filter.line,
                        "filter: \"" + std::string(field) + "\" is no number of a point in the files above it");
      named.insert(std::uint32_t(*id));
    }
    std::erase_if(points, [&](const auto& one) { return named.contains(one.first) != (filter.text == "keep"); });
    return {};
  }

  std::string take_orientation(const Row& row, const XmlElement& file) {
    const bool has_angles = row.has("omega") || row.has("phi") || row.has("kappa");
    const auto image = row.id("id");
    const auto centre = row.three("x", "y", "z"), angles = row.three("omega", "phi", "kappa");
    if (!image || !centre || (has_angles && !angles)) return "an orientation needs id, x, y, z, omega, phi and kappa";
    if (!block_.images.contains({*image})) return "there is no image " + std::to_string(*image);
    if (!with_orientation_.insert(*image).second) return "a second orientation of image " + std::to_string(*image);
    if (!has_angles) return {};
    const std::string unit = lower(file.attribute("units"));
    const auto degrees = degrees_of_unit(unit);
    if (!degrees)
      return (unit.empty() ? "angles of no unit: write the attribute units" : "angles in " + unit) +
             ": this reader knows degrees, radian and gon";
    const Eigen::Vector3d angles_deg = *angles * *degrees;
    const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{angles_deg[0], angles_deg[1], angles_deg[2]});
    set_pose(block_, {*image}, {rotation, -(rotation * *centre)});
    return {};
  }

  // The last that says something of both axes: sxy, sx and sy, of the columns and then of the file.
  static std::optional<Eigen::Vector2d> sigma_of_mark(const Row& row, const XmlElement& file) {
    Eigen::Vector2d sigma = Eigen::Vector2d::Zero();
    const auto take = [&](const std::optional<double>& value, bool x, bool y) {
      if (x) sigma.x() = value.value_or(-1);
      if (y) sigma.y() = value.value_or(-1);
    };
    for (const auto& [name, x, y] : {std::tuple("sxy", true, true), {"sx", true, false}, {"sy", false, true}})
      if (row.has(name)) take(row.value(name), x, y);
    for (const auto& [name, x, y] : {std::tuple("sxy", true, true), {"sx", true, false}, {"sy", false, true}})
      if (file.attributes.contains(name)) take(finite_number(trimmed(file.attribute(name))), x, y);
    return sigma.minCoeff() > 0 ? std::optional(sigma) : std::nullopt;
  }

  std::string take_mark(const Row& row, const XmlElement& file) {
    const auto image = row.id("im"), point = row.id("id");
    const auto x = row.value("x"), y = row.value("y");
    if (!image || !point || !x || !y) return "a mark needs im, id, x and y";
    const auto sigma = sigma_of_mark(row, file);
    if (!sigma) return "a mark needs a standard deviation above 0 (sxy), in its row or for all";
    if (!block_.images.contains({*image})) return "there is no image " + std::to_string(*image);
    if (!marked_.emplace(*image, *point).second)
      return "point " + std::to_string(*point) + " is marked twice in image " + std::to_string(*image);
    const auto control = block_.control.find({*point});
    const PixelShape shape{.row_over_column = static_cast<float>(sigma->y() / sigma->x())};
    if (control != block_.control.end())
      block_.control_observations.push_back({{*point}, {*image}, {*x, *y}, sigma->x(), shape});
    if (control == block_.control.end() || control->second.role == ControlRole::kCheck)
      block_.observations.push_back({{*image}, {*point}, 0, {*x, *y}, sigma->x(), shape});
    return {};
  }

  DbatProject& project_;
  Block& block_;
  std::set<std::uint32_t> with_orientation_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> marked_;  // image, point
};

}  // namespace

Result<> read_dbat_tables(const XmlElement& input, DbatProject& project) { return Tables(project).read(input); }

}  // namespace collinea
