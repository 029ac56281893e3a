// SPDX-License-Identifier: Apache-2.0
// The tables of the report.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/counted.h"
#include "collinea/report/internal/page.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

constexpr std::size_t kMostImageRows = 100;

std::string optional_cell(const std::optional<double>& value, int decimals) {
  return cell(value.value_or(std::nan("")), decimals);
}

// So many that root mean squares have two digits or more.
int decimals_of(const AxisRms& rms, const std::string& unit) {
  std::vector<double> shown;
  for (const auto& axis : rms.axis_m) shown.push_back(axis.value_or(0));
  return unit == "m" ? decimals_for(shown, 3) : std::min(decimals_for(shown, 2) + 1, 7);
}

std::string control_row(const ReportInput& input, const ControlDifference& control, int decimals, bool with_sigma) {
  const ControlPoint& point = input.block.control.at(control.point);
  const char* role = control.excluded ? "not used" : control.used ? "control" : "check";
  std::string row = control.excluded ? "<tr class=\"out\">" : "<tr>";
  row += text_cell(point.name) + text_cell(role) + fmt::format("<td>{}</td>", control.rays);
  for (int i = 0; i < 3; ++i) row += difference_cell(control.difference_m[i], control.difference_sigma_m[i], decimals);
  row += cell(control.difference_m.norm(), decimals);
  for (int i = 0; with_sigma && i < 3; ++i) row += cell(control.difference_sigma_m[i], decimals);
  return row + cell(control_rms_px(input.block, control), 2) + "</tr>\n";
}

// `what` the mean square is of: "point" or "image".
std::string rms_row(const AxisRms& rms, const char* name, const char* what, int decimals, int columns_before,
                    int columns_after) {
  if (rms.points == 0) return "";
  std::string row = "<tr class=\"total\">" + text_cell(name);
  row += fmt::format("<td class=\"l\" colspan=\"{}\">{} {}{}</td>", columns_before, rms.points, what,
                     rms.points == 1 ? "" : "s");
  for (const auto& axis : rms.axis_m) row += optional_cell(axis, decimals);
  row += optional_cell(rms.spatial_m, decimals);
  for (int i = 0; i < columns_after; ++i) row += "<td></td>";
  return row + "</tr>\n";
}

std::string parameter_row(const ReportInput& input, CameraId id, int param) {
  const auto i = std::size_t(param);
  const Camera& camera = input.block.cameras.at(id);
  const auto first = input.first_cameras.find(id);
  const auto sigmas = input.camera_sigma.find(id);
  const double value = camera.params[i];
  const double before = first == input.first_cameras.end() ? std::nan("") : first->second.params[i];
  const double sigma = sigmas == input.camera_sigma.end() ? std::nan("") : sigmas->second[i];
  const int decimals = param_unit(param) == "px" ? 3 : 7;
  const bool is_fixed = !(sigma > 0);
  return "<tr>" + text_cell(param_name(param)) + text_cell(param_unit(param)) + cell(before, decimals) +
         cell(value, decimals) + cell(value - before, decimals) +
         (is_fixed && std::isfinite(sigma) ? "<td>fixed</td>" : cell(sigma, decimals)) +
         cell(is_fixed || param < Camera::kK1 ? std::nan("") : std::abs(value) / sigma, 1) + "</tr>\n";
}

double field_of_view_deg(const Camera& camera) {
  constexpr double kDegree = std::numbers::pi / 180;
  if (!is_fisheye(camera.model)) return 2 * std::atan(camera.width_px / (2 * camera.focal_px())) / kDegree;
  const double row = camera.params[Camera::kCy];
  const auto angle = [&](double column) {
    return std::acos(std::clamp(ray_in_cam(camera, {column, row}).z(), -1.0, 1.0));
  };
  return (angle(0) + angle(camera.width_px)) / kDegree;
}

std::string words_of_model(const Camera& camera) {
  std::string words;
  if (is_fisheye(camera.model)) words = "fisheye (" + std::string(name_of(camera.model)) + "), ";
  if (camera.additional != AdditionalSet::kNone)
    words += fmt::format("{} additional parameters ({}), ", count_of(camera.additional),
                         kAdditionalNames[std::size_t(camera.additional)]);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string words_of_deformation(const Camera& camera) {
  if (!is_deformed_film(camera)) return "";
  const FilmPrior& film = *camera.prior.film;
  return fmt::format(
      "<p>Each scan is the image of its film, which is deformed between the marks as no other is: by {:.3f} px in each "
      "coordinate{}, with a correlation over {:.0f} px{}. Residuals are those of all scans.</p>\n",
      film.sigma_px, film.sigma_is_given ? " (given)" : "", film.correlation_px,
      film.correlation_is_given ? " (given)" : "");
}

std::string one_camera(const ReportInput& input, const ReportSummary& summary, CameraId id) {
  const Camera& camera = input.block.cameras.at(id);
  std::size_t images = 0;
  for (const auto& [image, pose] : oriented_images(input.block))
    images += input.block.common_camera(input.block.images.at(image).camera) == id;
  std::string html =
      fmt::format(
          "<h3>{}</h3><p>{}{} x {} px, {} oriented image{}, horizontal field of view {:.1f}&deg;; first focal length: "
          "{}.{}</p>\n",
          escaped(camera.name.empty() ? fmt::format("Camera {}", id.value) : camera.name), words_of_model(camera),
          camera.width_px, camera.height_px, images, images == 1 ? "" : "s", field_of_view_deg(camera),
          escaped(camera.prior.source == Provenance::kUnknown ? "unknown" : words_of(camera.prior.source)),
          camera.prior.calibrate ? "" : " All parameters were given and fixed.") +
      words_of_deformation(camera);
  html +=
      "<table class=\"whole\"><thead><tr><th class=\"l\">parameter</th><th "
      "class=\"l\">unit</th><th>before</th><th>adjusted</th>"
      "<th>change</th><th>standard deviation</th><th>|value| / st. dev.</th></tr></thead><tbody>\n";
  for (const int param : params_of(camera))
    if (!camera.prior.film || param < Camera::kParams) html += parameter_row(input, id, param);
  html += "</tbody></table>\n<div class=\"pair\">\n";
  const auto first = input.first_cameras.find(id);
  html += "<figure>" + distortion_chart(camera, first == input.first_cameras.end() ? nullptr : &first->second) +
          "<figcaption>Radial distortion, adjusted (solid) and before (dashed), out to the farthest "
          "corner.</figcaption></figure>\n";
  for (const ResidualGrid& grid : summary.residuals.grids)
    if (grid.camera == id)
      html += "<figure>" + residual_pattern(grid, camera) +
              "<figcaption>Mean residual vectors over the image (observed minus computed), exaggerated. Arrows "
              "without order are "
              "noise; a pattern is what the camera model does not explain.</figcaption></figure>\n";
  return html + "</div>\n";
}

// With a space that breaks no line.
std::string bytes_text(double bytes) {
  if (bytes >= 1e9) return fmt::format("{:.2f}\xc2\xa0GB", bytes / 1e9);
  if (bytes >= 1e6) return fmt::format("{:.1f}\xc2\xa0MB", bytes / 1e6);
  return fmt::format("{:.0f}\xc2\xa0kB", bytes / 1e3);
}

std::string name_value_table(const NamedValues& pairs, const char* title) {
  if (pairs.empty()) return "";
  std::string html = fmt::format("<div><h3>{}</h3><table><tbody>\n", title);
  for (const auto& [name, value] : pairs) html += "<tr>" + text_cell(name) + text_cell(value, "l w") + "</tr>\n";
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string control_section(const ReportInput& input, const ReportSummary& summary) {
  if (input.control.empty()) return "";
  int decimals = decimals_of(summary.check.points ? summary.check : summary.control, summary.unit);
  for (const ControlDifference& control : input.control)
    decimals = decimals_for(std::span(control.difference_sigma_m.data(), 3), decimals);
  const bool with_sigma = std::any_of(input.control.begin(), input.control.end(), [](const ControlDifference& control) {
    return control.difference_sigma_m.array().isFinite().any();
  });
  std::string html =
      "<section><h2>Control and check points</h2>\n<p>Differences are estimated minus surveyed. Check points took no "
      "part in the adjustment: they are intersected from the oriented images, and only they show the accuracy of new "
      "points.";
  if (with_sigma) html += " Red: more than three times the predicted standard deviation.";
  html += fmt::format(
      "</p>\n<table><thead><tr><th class=\"l\">point</th><th class=\"l\">role</th><th>images</th>"
      "<th>east [{0}]</th><th>north [{0}]</th><th>height [{0}]</th><th>3D [{0}]</th>{1}<th>image [px]</th></tr></thead>"
      "<tbody>\n",
      summary.unit,
      with_sigma ? fmt::format("<th>&sigma; east [{0}]</th><th>&sigma; north [{0}]</th><th>&sigma; height [{0}]</th>",
                               summary.unit)
                 : "");
  for (const bool used : {false, true})
    for (const ControlDifference& control : input.control)
      if (control.used == used) html += control_row(input, control, decimals, with_sigma);
  html += rms_row(summary.check, "RMS check", "point", decimals, 2, with_sigma ? 4 : 1);
  html += rms_row(summary.control, "RMS control", "point", decimals, 2, with_sigma ? 4 : 1);
  return html + "</tbody></table></section>\n";
}

std::string geodetic_section(const ReportInput& input) {
  if (input.geodetic.empty()) return "";
  std::string html =
      "<section><h2>Measurements on the ground</h2>\n<p>Differences are adjusted minus given. Red: more than three "
      "times the predicted standard deviation.</p>\n<table><thead><tr><th class=\"l\">measurement</th><th "
      "class=\"l\">role</th><th class=\"l\">unit</th><th>given</th><th>&sigma; given</th><th>adjusted</th>"
      "<th>difference</th><th>&sigma; predicted</th></tr></thead><tbody>\n";
  for (const GeodeticDifference& one : input.geodetic) {
    const GeodeticObservation& measured = input.block.geodetic.at(one.observation);
    const double unit = measured.is_angle() ? 180 / std::numbers::pi : 1;
    const int decimals = measured.is_angle() ? 5 : 4;
    html += one.excluded ? "<tr class=\"out\">" : "<tr>";
    html += text_cell(words_of(measured, input.block)) +
            text_cell(one.excluded ? "not used"
                      : one.used   ? "used"
                                   : "check") +
            text_cell(measured.is_angle() ? "deg" : "m") + cell(unit * measured.value, decimals) +
            cell(unit * measured.sigma, decimals) + cell(unit * one.adjusted, decimals) +
            difference_cell(unit * one.difference, unit * one.difference_sigma, decimals) +
            cell(unit * one.difference_sigma, decimals) + "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string position_section(const ReportInput& input, const ReportSummary& summary) {
  if (summary.position.points == 0) return "";
  const auto doubted =
      std::count_if(input.positions.begin(), input.positions.end(), [](const auto& p) { return p.weight < 0.5; });
  const int decimals = decimals_of(summary.position, summary.unit);
  std::string html = fmt::format(
      "<section><h2>Image positions</h2>\n<p>Adjusted projection centres minus the positions that the receivers wrote, "
      "root mean "
      "square of {}.{}</p>\n<table><thead><tr><th class=\"l\"></th><th class=\"l\"></th><th>east "
      "[{}]</th><th>north [{}]</th><th>height [{}]</th>"
      "<th>3D [{}]</th></tr></thead><tbody>\n",
      counted(summary.position.points, "image"),
      doubted ? " " + counted(doubted, "position") +
                    (doubted == 1 ? " disagrees so much that it hardly counts."
                                  : " disagree so much that they hardly count.")
              : "",
      summary.unit, summary.unit, summary.unit, summary.unit);
  html += rms_row(summary.position, "RMS", "image", decimals, 1, 0);
  return html + "</tbody></table></section>\n";
}

std::string camera_section(const ReportInput& input, const ReportSummary& summary) {
  std::string html;
  for (const ResidualGrid& grid : summary.residuals.grids) html += one_camera(input, summary, grid.camera);
  return html.empty() ? "" : "<section><h2>Cameras</h2>\n" + html + "</section>\n";
}

std::string film_section(const ReportInput& input) {
  const std::vector<FilmScanRecord>* film = nullptr;
  for (const StepRecord& step : input.steps)
    if (const auto* import = std::get_if<ImportRecord>(&step.outcome)) film = &import->film;
  if (!film || film->empty()) return "";
  std::string html =
      "<section><h2>Film</h2>\n<p>The photographs are scans of film. Each was brought, once, to the image that its "
      "camera would have taken without distortion on film that did not shrink, by the transformation that its fiducial "
      "marks need. Between the marks film may be deformed by about the residuals.</p>\n"
      "<table><thead><tr><th class=\"l\">scan</th><th class=\"l\">transformation</th><th>marks</th><th>misread</th>"
      "<th>RMS [um]</th><th>pixel [um]</th><th>turned [deg]</th><th>x against y [ppm]</th><th>shear [ppm]</th></tr>"
      "</thead><tbody>\n";
  for (const FilmScanRecord& scan : *film) {
    std::string model = scan.model;
    std::replace(model.begin(), model.end(), '_', ' ');
    html += "<tr>" + text_cell(scan.image, "l w") + text_cell(model) +
            fmt::format("<td>{}</td><td>{}</td>", scan.marks, scan.misread) + cell(scan.rms_um, 1) +
            cell(scan.pixel_um, 3) + cell(scan.rotation_deg, 3) + optional_cell(scan.difference_ppm, 0) +
            optional_cell(scan.shear_ppm, 0) + "</tr>\n";
  }
  return html + "</tbody></table></section>\n";
}

std::string image_section(const ReportInput& input, const ReportSummary& summary) {
  std::vector<ImageResiduals> images = summary.residuals.images;
  if (images.empty()) return "";
  double largest = 0;
  for (const auto& image : images) largest = std::max(largest, image.rms_px);
  std::string note;
  if (images.size() > kMostImageRows) {
    std::stable_sort(images.begin(), images.end(), [](const auto& a, const auto& b) { return a.rms_px > b.rms_px; });
    note = fmt::format("<p>The {} images with the largest residuals of {}; all are in report.json.</p>\n",
                       kMostImageRows, images.size());
    images.resize(kMostImageRows);
  }
  std::map<ImageId, const PositionDifference*> positions;
  for (const PositionDifference& position : input.positions) positions[position.image] = &position;
  const bool with_sigma = !input.centre_sigma_m.empty(), with_positions = !positions.empty();
  std::string html = "<section><h2>Images</h2>\n" + note;
  html += "<table><thead><tr><th class=\"l\">image</th><th>tie points</th><th>RMS [px]</th><th></th>";
  if (with_sigma)
    html += fmt::format("<th>&sigma; E [{0}]</th><th>&sigma; N [{0}]</th><th>&sigma; H [{0}]</th>", summary.unit);
  if (with_positions)
    html += fmt::format("<th>&Delta; E [{0}]</th><th>&Delta; N [{0}]</th><th>&Delta; H [{0}]</th>", summary.unit);
  html += "</tr></thead><tbody>\n";
  for (const ImageResiduals& image : images) {
    html += "<tr>" + text_cell(input.block.images.at(image.image).file, "l w") +
            fmt::format("<td>{}</td>", image.observations) + cell(image.rms_px, 2) +
            fmt::format("<td><span class=\"meter\"><i style=\"width:{:.0f}%\"></i></span></td>",
                        largest > 0 ? 100 * image.rms_px / largest : 0);
    const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(std::nan(""));
    const auto sigma = input.centre_sigma_m.find(image.image);
    for (int i = 0; with_sigma && i < 3; ++i)
      html += cell(sigma == input.centre_sigma_m.end() ? unknown[i] : sigma->second[i], 3);
    const auto position = positions.find(image.image);
    for (int i = 0; with_positions && i < 3; ++i)
      html += difference_cell(position == positions.end() ? unknown[i] : position->second->difference_m[i],
                              std::nan(""), 2);
    html += "</tr>\n";
  }
  html += "</tbody></table>\n";
  if (with_positions)
    html += "<p>&Delta;: adjusted projection centre minus the position written by the receiver.</p>\n";
  return html + "</section>\n";
}

std::string left_out_section(const ReportInput& input, const ReportSummary& summary) {
  if (input.skipped.empty() && summary.not_oriented.empty()) return "";
  std::string html =
      "<section><h2>Images left out</h2>\n<table><thead><tr><th class=\"l\">file</th><th "
      "class=\"l\">why</th></tr></thead><tbody>\n";
  for (const Finding& skipped : input.skipped)
    html += "<tr>" + text_cell(words_of(skipped.subjects.at(0), input.block), "l w") +
            text_cell(reason_of(skipped, input.block), "l w") + "</tr>\n";
  for (const ImageId id : summary.not_oriented)
    html += "<tr>" + text_cell(input.block.images.at(id).file, "l w") +
            text_cell("not oriented: too few points in common with the block", "l w") + "</tr>\n";
  return html + "</tbody></table></section>\n";
}

std::string process_section(const ReportInput& input) {
  std::string html;
  if (!input.products.empty()) {
    html +=
        "<h3>Products</h3><table><thead><tr><th class=\"l\">product</th><th class=\"l\">file</th><th "
        "class=\"l\">content</th><th>size</th></tr></thead><tbody>\n";
    for (const ReportProduct& product : input.products)
      html += "<tr>" + text_cell(name_of(product.file)) + text_cell(path_of(product.file), "l w") +
              text_cell(content_of(product.file, input.steps), "l w") +
              fmt::format("<td>{}</td></tr>\n", bytes_text(double(product.bytes)));
    html += "</tbody></table>\n";
  }
  if (!input.steps.empty()) {
    html +=
        "<h3>Steps</h3><table><thead><tr><th class=\"l\">step</th><th>time [s]</th><th>processor time [s]</th>"
        "<th>processors busy</th><th>peak memory</th></tr></thead><tbody>\n";
    double seconds = 0, cpu = 0, memory = 0;
    const auto row = [&](const std::string& name, double s, double c, double m, const char* style) {
      html += fmt::format("<tr class=\"{}\">{}{}{}", style, text_cell(name), cell(s, 1), cell(c, 1)) +
              cell(s > 0 ? c / s : std::nan(""), 1) + fmt::format("<td>{}</td></tr>\n", bytes_text(m));
    };
    for (const StepRecord& step : input.steps) {
      row(step.name(), step.seconds, step.cpu_seconds, step.peak_memory_bytes, "");
      seconds += step.seconds;
      cpu += step.cpu_seconds;
      memory = std::max(memory, step.peak_memory_bytes);
    }
    row("all", seconds, cpu, memory, "total");
    html += "</tbody></table>\n";
  }
  const std::string options = name_value_table(chosen_options(input), "Options that were chosen"),
                    versions = name_value_table(input.versions, "Versions");
  if (!options.empty() || !versions.empty()) html += "<div class=\"pair\">" + options + versions + "</div>\n";
  return html.empty() ? "" : "<section><h2>Processing</h2>\n" + html + "</section>\n";
}

}  // namespace collinea
