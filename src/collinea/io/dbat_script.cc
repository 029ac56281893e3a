// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/dbat_script.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/internal/dbat_operations.h"
#include "collinea/io/internal/millimetre_camera.h"
#include "collinea/io/internal/observation_order.h"
#include "collinea/io/internal/xml.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

/// One row of a table whose columns are named by its format.
struct Row {
  std::size_t line;
  std::map<std::string, std::string> text;

  [[nodiscard]] bool has(const std::string& column) const { return text.contains(column); }
};

class Reader {
 public:
  Result<AdjustmentFile> read(const std::filesystem::path& path) {
    COLLINEA_TRY(const XmlElement script, read_xml(path));
    const XmlElement* input = script.child("input");
    if (!input) return fail(Errc::kBadFormat, path.string() + ": there is no element input: not a script of DBAT");
    here_ = base_ = path.parent_path();
    if (!input->attribute("base_dir").empty()) base_ = path_of(input->attribute("base_dir"));
    COLLINEA_TRY(const double pixel_height_mm, take_cameras(*input, path));
    COLLINEA_TRY(take_tables(*input));
    const XmlElement* operations = script.child("operations");
    if (operations)
      for (const XmlElement& operation : operations->children)
        COLLINEA_TRY(apply_dbat_operation(operation, pixel_height_mm, path, file_));
    return std::move(file_);
  }

 private:
  static Result<XmlElement> read_xml(const std::filesystem::path& path) {
    COLLINEA_TRY(const std::string text, read_file(path));
    return parse_xml(text).map_error([&](Error e) { return std::move(e).within(path.string()); });
  }

  static tl::unexpected<Error> bad(const std::filesystem::path& path, std::size_t line, const std::string& what) {
    return fail(Errc::kBadFormat, path.string() + ": line " + std::to_string(line) + ": " + what);
  }

  // $HERE is the folder of the script; other names are relative to its base_dir.
  [[nodiscard]] std::filesystem::path path_of(std::string_view name) const {
    constexpr std::string_view kHere = "$HERE";
    name = trimmed(name);
    if (name.starts_with(kHere)) {
      name.remove_prefix(kHere.size());
      while (name.starts_with('/') || name.starts_with('\\')) name.remove_prefix(1);
      return here_ / name;
    }
    const std::filesystem::path path(name);
    return path.is_absolute() ? path : base_ / path;
  }

  static Result<std::vector<double>> numbers(const XmlElement& e, std::size_t count,
                                             const std::filesystem::path& path) {
    std::vector<double> values;
    for (const std::string_view field : fields_of(e.text, ',')) {
      const auto value = finite_number(field);
      if (!value) return bad(path, e.line, e.name + ": \"" + std::string(field) + "\" is no number");
      values.push_back(*value);
    }
    if (values.size() != count)
      return bad(path, e.line,
                 e.name + " has " + std::to_string(values.size()) + " numbers; " + std::to_string(count) +
                     (count == 1 ? " is" : " are") + " expected");
    return values;
  }

  // Answers the height of a pixel.
  Result<double> take_cameras(const XmlElement& input, const std::filesystem::path& script) {
    const XmlElement* cameras = input.child("cameras");
    if (!cameras) return bad(script, input.line, "there is no element cameras");
    if (const XmlElement* file = cameras->child("file")) {
      const std::filesystem::path path = path_of(file->text);
      COLLINEA_TRY(const XmlElement document, read_xml(path));
      const XmlElement* inner = document.child("cameras");
      if (!inner) return bad(path, document.line, "there is no element cameras");
      return take_camera(*inner, path);
    }
    return take_camera(*cameras, script);
  }

  Result<double> take_camera(const XmlElement& cameras, const std::filesystem::path& path) {
    const XmlElement* camera = cameras.child("camera");
    if (!camera) return bad(path, cameras.line, "there is no element camera");
    if (std::count_if(cameras.children.begin(), cameras.children.end(), [](auto& e) { return e.name == "camera"; }) > 1)
      return bad(path, cameras.line, "several cameras: this reader knows one");
    for (const char* needed : {"image", "sensor", "model"})
      if (!camera->child(needed)) return bad(path, camera->line, std::string("the camera has no element ") + needed);
    MillimetreCamera mm;
    COLLINEA_TRY(const auto size, numbers(*camera->child("image"), 2, path));
    if (!(size[0] >= 1 && size[1] >= 1 && size[0] < 1e6 && size[1] < 1e6))
      return bad(path, camera->child("image")->line, "width and height of an image are numbers of pixels above 0");
    mm.width_px = int(size[0]);
    mm.height_px = int(size[1]);
    XmlElement sensor = *camera->child("sensor");
    const bool automatic = sensor.text.starts_with("auto,");
    if (automatic) sensor.text = sensor.text.substr(5);
    COLLINEA_TRY(const auto extent, numbers(sensor, automatic ? 1 : 2, path));
    mm.pixel_height_mm = extent.back() / mm.height_px;
    if (!(mm.pixel_height_mm > 0)) return bad(path, sensor.line, "a sensor has a size above 0 [mm]");
    const auto optional = [&](const char* name, std::size_t count, std::vector<double> otherwise) {
      const XmlElement* e = camera->child(name);
      return e ? numbers(*e, count, path) : Result<std::vector<double>>(std::move(otherwise));
    };
    COLLINEA_TRY(const auto aspect, optional("aspect", 1, {1}));
    COLLINEA_TRY(const auto skew, optional("skew", 1, {0}));
    COLLINEA_TRY(const auto focal, optional("focal", 1, {0}));
    COLLINEA_TRY(const auto constant, optional("cc", 1, focal));
    COLLINEA_TRY(const auto principal,
                 optional("pp", 2, {mm.pixel_height_mm * mm.width_px / 2, mm.pixel_height_mm * mm.height_px / 2}));
    COLLINEA_TRY(const auto k, optional("K", 3, {0, 0, 0}));
    COLLINEA_TRY(const auto p, optional("P", 2, {0, 0}));
    COLLINEA_TRY(const auto model, numbers(*camera->child("model"), 1, path));
    if (skew[0] != 0) return bad(path, camera->line, "a skew that is not 0: this reader does not know it");
    if (model[0] != 1 && model[0] != 3 && model[0] != -1)
      return bad(path, camera->child("model")->line,
                 "lens model " + exact(model[0]) + ": this reader knows 1 and 3 (corrections) and -1 (distortion)");
    mm.off_aspect = 1 - aspect[0];
    mm.focal_mm = constant[0] > 0 ? constant[0] : focal[0];
    if (!(mm.focal_mm > 0)) return bad(path, camera->line, "the camera has no focal length: add an element focal [mm]");
    mm.principal_mm = {principal[0], principal[1]};
    mm.k = {k[0], k[1], k[2]};
    mm.p = {p[0], p[1]};
    mm.forward = model[0] < 0;
    Camera read = camera_of(mm);
    read.name = camera->child("name") ? camera->child("name")->text : "camera";
    read.prior.source = Provenance::kGiven;
    file_.block.cameras[{0}] = file_.given_cameras[{0}] = read;
    file_.camera_sigmas[{0}].fill(0);
    if (!mm.forward) file_.corrected_cameras.insert({0});
    return mm.pixel_height_mm;
  }

  // Every row of the table that an element names, to `take`.
  Result<> each_row(const XmlElement& input, const char* table, bool needed,
                    const std::function<std::string(const Row&, const XmlElement&)>& take) {
    const XmlElement* element = input.child(table);
    const XmlElement* file = element ? element->child("file") : nullptr;
    if (!file)
      return needed ? Result<>(fail(Errc::kBadFormat, std::string("the script names no file for ") + table))
                    : Result<>{};
    const std::filesystem::path path = path_of(file->text);
    COLLINEA_TRY(const std::string text, read_file(path));
    const std::string format = lower(file->attribute("format"));
    const std::vector<std::string_view> columns = fields_of(format, ',');
    const std::vector<std::string_view> lines = lines_of(text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::string_view line = trimmed(lines[i]);
      if (line.empty() || line.starts_with('#')) continue;
      const std::vector<std::string_view> fields = fields_of(line, ',');
      if (fields.size() < columns.size())
        return bad(path, i + 1, std::to_string(fields.size()) + " fields; the script says there are " + format);
      Row row{i + 1, {}};
      for (std::size_t k = 0; k < columns.size(); ++k) row.text[std::string(columns[k])] = fields[k];
      if (const std::string wrong = take(row, *file); !wrong.empty()) return bad(path, i + 1, wrong);
    }
    return {};
  }

  static std::optional<double> value(const Row& row, const char* column) {
    const auto its = row.text.find(column);
    return its == row.text.end() ? std::nullopt : finite_number(its->second);
  }

  static std::optional<std::uint32_t> id(const Row& row, const char* column) {
    const auto its = row.text.find(column);
    const auto found = its == row.text.end() ? std::nullopt : integer(its->second);
    return found && *found >= 0 && *found < std::int64_t(PointId::kNone) ? std::optional(std::uint32_t(*found))
                                                                         : std::nullopt;
  }

  static std::optional<Eigen::Vector3d> three(const Row& row, const char* a, const char* b, const char* c) {
    const auto x = value(row, a), y = value(row, b), z = value(row, c);
    return x && y && z ? std::optional(Eigen::Vector3d(*x, *y, *z)) : std::nullopt;
  }

  std::string take_image(const Row& row) {
    const auto image = id(row, "id");
    const auto path = row.text.find("path");
    if (!image || path == row.text.end()) return "an image needs a number (id) and a file (path)";
    if (file_.block.images.contains({*image})) return "a second image " + std::to_string(*image);
    const auto slash = path->second.find_last_of("/\\");
    file_.block.images[{*image}] = {.file = path->second.substr(slash == std::string::npos ? 0 : slash + 1),
                                    .camera = {0}};
    return {};
  }

  std::string take_control(const Row& row) {
    const auto point = id(row, "id");
    const auto coordinates = three(row, "x", "y", "z");
    if (!point || !coordinates) return "a control point needs id, x, y and z";
    if (file_.block.control.contains({*point})) return "a second control point " + std::to_string(*point);
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
    if (row.has("sxyz")) sigma.setConstant(value(row, "sxyz").value_or(-1));
    if (row.has("sxy")) sigma.head<2>().setConstant(value(row, "sxy").value_or(-1));
    const char* names[] = {"sx", "sy", "sz"};
    for (int axis = 0; axis < 3; ++axis)
      if (row.has(names[axis])) sigma[axis] = value(row, names[axis]).value_or(-1);
    if (!(sigma.minCoeff() >= 0)) return "a standard deviation is a number from 0";
    const auto label = row.text.find("label");
    file_.block.control[{*point}] = {
        .name = label == row.text.end() || label->second.empty() ? std::to_string(*point) : label->second,
        .role = ControlRole::kControl,
        .position_in_map = *coordinates,
        .position_in_world = *coordinates,
        .sigma_m = sigma};
    return {};
  }

  std::string take_orientation(const Row& row, const XmlElement& file) {
    const auto image = id(row, "id");
    const auto centre = three(row, "x", "y", "z"), angles = three(row, "omega", "phi", "kappa");
    if (!image || !centre || !angles) return "an orientation needs id, x, y, z, omega, phi and kappa";
    if (!file_.block.images.contains({*image})) return "there is no image " + std::to_string(*image);
    if (is_oriented(file_.block, {*image})) return "a second orientation of image " + std::to_string(*image);
    const std::string units = lower(file.attribute("units"));
    if (!units.empty() && units != "degrees" && units != "radians")
      return "angles in " + units + ": this reader knows degrees and radians";
    const double degrees = units == "degrees" ? 1 : 180 / std::numbers::pi;
    const Eigen::Quaterniond rotation =
        cam_from_world(OmegaPhiKappa{(*angles)[0] * degrees, (*angles)[1] * degrees, (*angles)[2] * degrees});
    set_pose(file_.block, {*image}, {rotation, -(rotation * *centre)});
    return {};
  }

  std::string take_mark(const Row& row, const XmlElement& file) {
    const auto image = id(row, "im"), point = id(row, "id");
    const auto x = value(row, "x"), y = value(row, "y");
    const auto sigma = row.has("sxy") ? value(row, "sxy") : number(file.attribute("sxy"));
    if (!image || !point || !x || !y) return "a mark needs im, id, x and y";
    if (!sigma || !(*sigma > 0)) return "a mark needs a standard deviation above 0 (sxy), in its row or for all";
    if (!file_.block.images.contains({*image})) return "there is no image " + std::to_string(*image);
    if (!marked_.emplace(*image, *point).second)
      return "point " + std::to_string(*point) + " is marked twice in image " + std::to_string(*image);
    if (file_.block.control.contains({*point}))
      file_.block.control_observations.push_back({{*point}, {*image}, {*x, *y}, *sigma});
    else
      file_.block.observations.push_back({{*image}, {*point}, 0, {*x, *y}, *sigma});
    return {};
  }

  Result<> take_tables(const XmlElement& input) {
    COLLINEA_TRY(each_row(input, "images", true, [&](auto& row, auto&) { return take_image(row); }));
    COLLINEA_TRY(each_row(input, "ctrl_pts", false, [&](auto& row, auto&) { return take_control(row); }));
    COLLINEA_TRY(
        each_row(input, "prior_eo", false, [&](auto& row, auto& file) { return take_orientation(row, file); }));
    COLLINEA_TRY(each_row(input, "image_pts", true, [&](auto& row, auto& file) { return take_mark(row, file); }));
    sort_by_point_and_image(file_.block.observations);
    return {};
  }

  std::filesystem::path here_, base_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> marked_;  // image, point
  AdjustmentFile file_;
};

}  // namespace

Result<AdjustmentFile> read_dbat_script(const std::filesystem::path& path) { return Reader().read(path); }

bool is_dbat_script(std::string_view text) {
  return text.substr(0, 4096).find("dbat_script_version") != std::string_view::npos;
}

}  // namespace collinea
