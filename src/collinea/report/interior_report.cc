// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/interior_report.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "collinea/io/text.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

using Image = InteriorReport::Image;

std::string joined(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

// A parameter as people read it: the rotation in degrees, the rest in its own unit.
struct Shown {
  std::string_view name, unit;
  double value, sigma;
  int decimals;
};

Shown shown(const FilmTransformation& t, int i, const std::string& unit) {
  const double sigma = std::sqrt(t.covariance(i, i)), value = t.parameters[i];
  if (i == 2) return {"rotation", "deg", value * 180 / std::numbers::pi, sigma * 180 / std::numbers::pi, 6};
  if (i < 2) return {film_parameter_name(i), unit, value, sigma, unit == "px" ? 3 : 5};
  if (i < 5) {
    const bool is_one = t.model == FilmModel::kSimilarity;
    return {is_one ? "scale" : film_parameter_name(i), unit == "px" ? "px/mm" : "1", value, sigma, 6};
  }
  return {film_parameter_name(i), film_parameter_unit(i), value, sigma, 9};
}

std::string reading_lines(const Image& image, const std::string& unit) {
  std::string text;
  const ReadMarks& read = image.readings;
  if (read.degrees > 0)
    text += fmt::format(
        "  readings: standard deviation of one {:.2f} {}; farther than {:.1f} {} from the others is gross\n",
        read.sigma, unit, read.limit, unit);
  for (const ReadMark& mark : read.marks) {
    for (const int number : mark.gross)
      text += fmt::format("  mark {}: reading {} is gross and left out\n", mark.mark, number);
    if (mark.is_contested)
      text +=
          fmt::format("  mark {}: its readings differ by more, and none is outvoted: measure it again\n", mark.mark);
  }
  return text;
}

std::string parameter_lines(const Image& image, const std::string& unit) {
  std::string text;
  const FilmTransformation& t = image.orientation.fit.transformation;
  for (int i = 0; i < t.parameters.size(); ++i) {
    const Shown s = shown(t, i, unit);
    text += fmt::format("  {:<14}{:>16.{}f} {:<6}", s.name, s.value, s.decimals, s.unit);
    text += image.has_marks || s.sigma > 0 ? fmt::format(" +- {:.{}f}\n", s.sigma, s.decimals) : std::string("\n");
  }
  return text;
}

std::string residual_lines(const Image& image, const std::string& unit) {
  const int decimals = unit == "px" ? 2 : 4;
  std::string text =
      fmt::format("  mark         residual x        y [{}]      w x     w y   redundancy x    y   chance\n", unit);
  for (const FilmMarkResidual& mark : image.orientation.fit.marks) {
    text += fmt::format("  {:<10}{:>12.{}f}{:>12.{}f}", mark.name, mark.residual_px.x(), decimals, mark.residual_px.y(),
                        decimals);
    text += mark.is_used ? fmt::format("{:>9.2f}{:>8.2f}{:>11.2f}{:>9.2f}{:>9.4f}\n", mark.w.x(), mark.w.y(),
                                       mark.redundancy.x(), mark.redundancy.y(), mark.misread_chance)
                         : std::string("   misread: left out\n");
  }
  return text;
}

std::string test_lines(const Image& image, bool known) {
  std::string text;
  for (const FilmModelTest& test : image.orientation.tests)
    text += fmt::format("  {:<11} against {:<11}{} {:>10.3f}  chance {:.4f}\n", word_of(test.smaller),
                        word_of(test.larger), known ? "chi2/degrees" : "F", test.statistic, test.chance);
  if (!text.empty())
    text += fmt::format("  so {} is the smallest that no larger one rejects (5 % in all)\n",
                        word_of(image.orientation.fit.transformation.model));
  return text;
}

std::string deformation_lines(const FilmDeformation& d, bool in_pixels) {
  std::string text;
  if (in_pixels)
    text += fmt::format("  pixel {:.5f} um +- {:.5f} in x, {:.5f} um +- {:.5f} in y\n", d.pixel_x_um.value,
                        d.pixel_x_um.sigma, d.pixel_y_um.value, d.pixel_y_um.sigma);
  if (d.x_ppm && d.y_ppm)
    text += fmt::format("  film longer than calibrated by {:.0f} ppm +- {:.0f} in x, {:.0f} ppm +- {:.0f} in y\n",
                        d.x_ppm->value, d.x_ppm->sigma, d.y_ppm->value, d.y_ppm->sigma);
  text += fmt::format("  deformation: x longer than y by {:.0f} ppm +- {:.0f} ({}), shear {:.0f} ppm +- {:.0f} ({})\n",
                      d.difference_ppm.value, d.difference_ppm.sigma, d.differs ? "significant" : "not significant",
                      d.shear_ppm.value, d.shear_ppm.sigma, d.is_sheared ? "significant" : "not significant");
  return text;
}

std::string image_text(const Image& image, const InteriorReport& report) {
  const FilmFit& fit = image.orientation.fit;
  const FilmTransformation& t = fit.transformation;
  std::string text = image.name.empty() ? std::string() : fmt::format("image {}\n", image.name);
  if (!image.has_marks)
    return text + "  by principal point and size of a pixel, without marks\n" + parameter_lines(image, report.unit);
  text += reading_lines(image, report.unit);
  if (image.least_correlation)
    text += fmt::format("  {} marks found in the scan, with correlations of {:.2f} and more\n",
                        image.readings.marks.size(), *image.least_correlation);
  if (!image.unknown.empty()) text += fmt::format("  not in the calibration, not used: {}\n", joined(image.unknown));
  if (!image.missing.empty()) text += fmt::format("  not measured: {}\n", joined(image.missing));
  text += fmt::format("  {}, {} parameters from {} marks, redundancy {}", word_of(t.model), t.parameters.size(),
                      fit.marks.size(), fit.redundancy);
  if (fit.redundancy > 0)
    text += report.sigmas_are_known
                ? fmt::format(", sigma0 {:.2f} times the sigmas given", fit.sigma0)
                : fmt::format(", sigma0 {:.3f} {} ({:.1f} um on the film)", fit.sigma0, report.unit,
                              1e3 * fit.sigma0 / std::sqrt(std::abs(t.by_film({0, 0}).determinant())));
  text += fit.redundancy > 0 ? "\n" : ": nothing checks them\n";
  if (t.is_mirrored)
    text += "  seen as in a mirror: rows are counted from below, or the film was scanned from its back\n";
  return text + parameter_lines(image, report.unit) + residual_lines(image, report.unit) +
         test_lines(image, report.sigmas_are_known) +
         (image.deformation ? deformation_lines(*image.deformation, report.unit == "px") : std::string());
}

}  // namespace

bool contradicts_itself(const InteriorReport& report, const Image& image) {
  constexpr double kMostOnFilm_mm = 0.1, kMostTimesGiven = 3;
  const FilmFit& fit = image.orientation.fit;
  if (!image.has_marks || fit.redundancy <= 0) return false;
  if (report.sigmas_are_known) return fit.sigma0 > kMostTimesGiven;
  return fit.sigma0 > kMostOnFilm_mm * std::sqrt(std::abs(fit.transformation.by_film({0, 0}).determinant()));
}

std::string interior_text(const InteriorReport& report) {
  const bool is_nominal = !(report.calibration.principal_distance_mm > 0);
  std::string text =
      is_nominal
          ? fmt::format("{}: {} marks, no calibration\n", report.calibration.camera, report.calibration.marks.size())
          : fmt::format("{}: principal distance {} mm, principal point {} {} mm, {} marks\n",
                        report.calibration.camera.empty() ? "camera" : report.calibration.camera,
                        exact(report.calibration.principal_distance_mm),
                        exact(report.calibration.principal_point_mm.x()),
                        exact(report.calibration.principal_point_mm.y()), report.calibration.marks.size());
  if (report.calibration.radial_rms_mm > 0)
    text += fmt::format("the polynomial differs from the table of the distortion by {:.2f} um (RMS)\n",
                        1e3 * report.calibration.radial_rms_mm);
  for (const Image& image : report.images) text += image_text(image, report);
  if (!report.points.empty()) text += fmt::format("{} points brought to the film\n", report.points.size());
  if (!report.scan_points.empty())
    text += fmt::format("{} points of the film brought to the scans\n", report.scan_points.size());
  return text + findings_text(report.findings);
}

TextTable parameter_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"model", ""}, {"parameter", ""}, {"value", ""}, {"sigma", ""}, {"unit", ""}};
  for (const Image& image : report.images) {
    const FilmTransformation& t = image.orientation.fit.transformation;
    const std::string model(word_of(t.model));
    const auto row = [&](std::string_view name, double value, std::string sigma, std::string_view unit) {
      table.rows.push_back({image.name, model, std::string(name), exact(value), std::move(sigma), std::string(unit)});
    };
    for (int i = 0; i < t.parameters.size(); ++i) {
      const Shown s = shown(t, i, report.unit);
      row(s.name, s.value, image.has_marks || s.sigma > 0 ? exact(s.sigma) : "", s.unit);
    }
    if (t.model == FilmModel::kRigid) row("scale", t.scale_px_per_mm, "", report.unit == "px" ? "px/mm" : "1");
    if (t.is_mirrored) row("mirrored", 1, "", "1");
    if (image.has_marks) row("sigma0", image.orientation.fit.sigma0, "", report.sigmas_are_known ? "1" : report.unit);
  }
  return table;
}

TextTable covariance_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"parameter_1", ""}, {"parameter_2", ""}, {"covariance", ""}};
  for (const Image& image : report.images) {
    const FilmTransformation& t = image.orientation.fit.transformation;
    const auto name = [&](int i) { return std::string(shown(t, i, report.unit).name); };
    for (int i = 0; i < t.parameters.size(); ++i)
      for (int j = i; j < t.parameters.size(); ++j)
        table.rows.push_back({image.name, name(i), name(j), exact(t.covariance(i, j))});
  }
  return table;
}

TextTable model_test_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"smaller", ""}, {"larger", ""}, {"statistic", ""}, {"chance", ""}};
  for (const Image& image : report.images)
    for (const FilmModelTest& test : image.orientation.tests)
      table.rows.push_back({image.name, std::string(word_of(test.smaller)), std::string(word_of(test.larger)),
                            exact(test.statistic), exact(test.chance)});
  return table;
}

TextTable deformation_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""}, {"quantity", ""}, {"value", ""}, {"sigma", ""}, {"unit", ""}};
  for (const Image& image : report.images) {
    if (!image.deformation) continue;
    const auto row = [&](const char* name, const auto& is, const char* unit) {
      table.rows.push_back({image.name, name, exact(is.value), exact(is.sigma), unit});
    };
    const FilmDeformation& d = *image.deformation;
    if (report.unit == "px") {
      row("pixel_x", d.pixel_x_um, "um");
      row("pixel_y", d.pixel_y_um, "um");
    }
    if (d.x_ppm) row("longer_x", *d.x_ppm, "ppm");
    if (d.y_ppm) row("longer_y", *d.y_ppm, "ppm");
    row("difference", d.difference_ppm, "ppm");
    row("shear", d.shear_ppm, "ppm");
    row("rotation", d.rotation_rad, "rad");
  }
  return table;
}

TextTable scan_point_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""},     {"point", ""},       {"x", "px"},      {"y", "px"},     {"sigma_x", "px"},
                   {"sigma_y", "px"}, {"correlation", ""}, {"x_film", "mm"}, {"y_film", "mm"}};
  for (const InteriorReport::ScanPoint& point : report.scan_points) {
    const double sx = std::sqrt(point.covariance(0, 0)), sy = std::sqrt(point.covariance(1, 1));
    table.rows.push_back({point.image, point.point, fixed(point.pixel.x(), 4), fixed(point.pixel.y(), 4), fixed(sx, 4),
                          fixed(sy, 4), fixed(sx * sy > 0 ? point.covariance(0, 1) / (sx * sy) : 0, 4),
                          fixed(point.film_mm.x(), 5), fixed(point.film_mm.y(), 5)});
  }
  return table;
}

TextTable residual_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""},        {"mark", ""},         {"x", report.unit}, {"y", report.unit},
                   {"v_x", report.unit}, {"v_y", report.unit}, {"w_x", ""},        {"w_y", ""},
                   {"chance", ""},       {"used", ""},         {"coordinates", ""}};
  for (const Image& image : report.images)
    for (const FilmMarkResidual& mark : image.orientation.fit.marks) {
      Eigen::Vector2d at = Eigen::Vector2d::Zero();
      for (const ReadMark& read : image.readings.marks)
        if (read.mark == mark.name) at = read.position;
      table.rows.push_back({image.name, mark.name, fixed(at.x(), 4), fixed(at.y(), 4), fixed(mark.residual_px.x(), 4),
                            fixed(mark.residual_px.y(), 4), fixed(mark.w.x(), 3), fixed(mark.w.y(), 3),
                            fixed(mark.misread_chance, 6), mark.is_used ? "yes" : "no",
                            mark.coordinates == MarkCoordinates::kBoth ? "xy"
                            : mark.coordinates == MarkCoordinates::kX  ? "x"
                                                                       : "y"});
    }
  return table;
}

TextTable point_table(const InteriorReport& report) {
  TextTable table;
  table.columns = {{"image", ""},     {"point", ""},       {"x", "mm"},      {"y", "mm"},     {"sigma_x", "mm"},
                   {"sigma_y", "mm"}, {"correlation", ""}, {"x_film", "mm"}, {"y_film", "mm"}};
  for (const InteriorReport::Point& point : report.points) {
    const double sx = std::sqrt(point.covariance(0, 0)), sy = std::sqrt(point.covariance(1, 1));
    table.rows.push_back({point.image, point.point, fixed(point.corrected_mm.x(), 5), fixed(point.corrected_mm.y(), 5),
                          fixed(sx, 5), fixed(sy, 5), fixed(sx * sy > 0 ? point.covariance(0, 1) / (sx * sy) : 0, 4),
                          fixed(point.film_mm.x(), 5), fixed(point.film_mm.y(), 5)});
  }
  return table;
}

}  // namespace collinea
