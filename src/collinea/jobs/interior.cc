// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/interior.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/io/film_calibration_file.h"
#include "collinea/io/number_rows.h"
#include "collinea/jobs/internal/image_findings.h"
#include "collinea/jobs/internal/out_folder.h"
#include "collinea/report/film_marks_drawing.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

// Readings of the marks of one image.
struct ImageReadings {
  std::string image;
  std::vector<MarkReading> readings;
};

// A table of positions in an image, whatever they are of.
struct Positions {
  std::vector<std::string> images, names;
  std::vector<Vector2d> at;  // y down
  std::vector<double> sigmas;
  bool has_sigmas = false;
  std::string unit;  // px or mm
};

Result<Positions> read_positions(const fs::path& path, std::string_view name, double sigma) {
  const auto in_file = [&](Error e) { return std::move(e).within(path.string()); };
  COLLINEA_TRY(const TextTable table, read_text_table(path));
  Positions out;
  const std::string stated = table.unit_of("x");
  out.unit = stated.empty() || stated == "px" ? "px" : "mm";
  COLLINEA_TRY(out.names, table.words(name).map_error(in_file));
  COLLINEA_TRY(const auto x, table.numbers("x", out.unit).map_error(in_file));
  COLLINEA_TRY(const auto y, table.numbers("y", out.unit).map_error(in_file));
  COLLINEA_TRY(out.sigmas, table.numbers_or("sigma", out.unit, sigma).map_error(in_file));
  out.images.assign(out.names.size(), "");
  if (table.has("image")) {
    COLLINEA_TRY(out.images, table.words("image").map_error(in_file));
  }
  out.has_sigmas = table.has("sigma");
  for (std::size_t i = 0; i < x.size(); ++i) out.at.emplace_back(x[i], out.unit == "px" ? y[i] : -y[i]);
  for (const double one : out.sigmas)
    if (!(one >= 0)) return fail(Errc::kBadInput, path.string() + ": a sigma below zero");
  return out;
}

std::vector<ImageReadings> by_image(const Positions& positions) {
  std::vector<ImageReadings> out;
  for (std::size_t i = 0; i < positions.names.size(); ++i) {
    const auto same = [&](const ImageReadings& one) { return one.image == positions.images[i]; };
    auto found = std::find_if(out.begin(), out.end(), same);
    if (found == out.end()) found = out.insert(out.end(), {positions.images[i], {}});
    found->readings.push_back({positions.names[i], positions.at[i], positions.sigmas[i]});
  }
  return out;
}

Result<std::optional<double>> pixel_mm_of(const InteriorOptions& options) {
  if (options.pixel_um && options.dpi)
    return fail(Errc::kBadInput, "the size of a pixel stands there twice", {"pixel_um"_option, "dpi"_option});
  if (options.pixel_um) return *options.pixel_um / 1000;
  if (options.dpi) return 25.4 / *options.dpi;
  return std::optional<double>();
}

// Calibrated and measured marks, brought together by name.
std::vector<FilmMark> matched(const FilmCalibration& calibration, InteriorReport::Image& image) {
  std::vector<FilmMark> marks;
  for (const ReadMark& read : image.readings.marks) {
    const auto& all = calibration.marks;
    const auto known = std::find_if(all.begin(), all.end(), [&](const auto& mark) { return mark.name == read.mark; });
    if (known == all.end()) {
      image.unknown.push_back(read.mark);
      continue;
    }
    marks.push_back({read.mark, known->film_mm, read.position, read.sigma * read.sigma * Eigen::Matrix2d::Identity(),
                     known->sigma_mm, known->coordinates});
  }
  for (const CalibratedMark& mark : calibration.marks)
    if (std::none_of(marks.begin(), marks.end(), [&](const FilmMark& one) { return one.name == mark.name; }))
      image.missing.push_back(mark.name);
  return marks;
}

Result<InteriorReport::Image> orient_image(const FilmCalibration& calibration, const ImageReadings& read,
                                           const InteriorOptions& options, const FilmFitOptions& fitting,
                                           double least_sigma) {
  InteriorReport::Image image{.name = read.image};
  image.readings = mean_of_readings(read.readings, least_sigma);
  std::vector<FilmMark> marks = matched(calibration, image);
  // Without known sigmas marks weigh alike: what several readings share is no smaller for their number.
  if (!fitting.sigmas_are_known)
    for (FilmMark& mark : marks) mark.covariance.setIdentity(), mark.calibration_sigma_mm = 0;
  std::optional<FilmChoice> choice;
  if (options.model) {
    if (auto fit = fit_film(marks, *options.model, fitting)) choice = FilmChoice{*std::move(fit), {}};
  } else {
    choice = choose_film_model(marks, fitting);
  }
  const std::string name = read.image.empty() ? "the image" : "image " + read.image;
  if (!choice && options.model == FilmModel::kRigid && !fitting.pixel_mm)
    return fail(Errc::kBadInput, "a rigid transformation needs the size of a pixel", {"pixel_um"_option, "dpi"_option});
  if (!choice)
    return fail(Errc::kIllPosed, fmt::format("{}: {} of its marks are in the calibration, and their positions do not "
                                             "determine the transformation",
                                             name, marks.size()));
  image.orientation = *std::move(choice);
  image.deformation = film_deformation(marks, fitting);
  return image;
}

// The image of a point of a table; the only one where neither names any.
Result<const InteriorReport::Image*> image_of(const InteriorReport& report, const Positions& points, std::size_t i,
                                              const fs::path& table) {
  for (const auto& image : report.images)
    if (image.name == points.images[i]) return &image;
  if (report.images.size() == 1 && (points.images[i].empty() || report.images[0].name.empty()))
    return &report.images.front();
  return fail(Errc::kBadInput, fmt::format("{}: point {} is of image \"{}\", whose marks are not there", table.string(),
                                           points.names[i], points.images[i]));
}

// Points in mm of scans in pixels lie on the film, with y up: they are brought to the scan. Their own standard
// deviations are in mm; without a column of them points of the film are exact.
Result<> add_points(InteriorReport& report, const InteriorOptions& options) {
  COLLINEA_TRY(const Positions points, read_positions(*options.points, "point", options.point_sigma));
  const bool to_scan = report.unit == "px" && points.unit == "mm";
  if (points.unit != report.unit && !to_scan)
    return fail(Errc::kBadInput, fmt::format("marks are in {}, points in {}", report.unit, points.unit),
                {"points"_option});
  for (std::size_t i = 0; i < points.names.size(); ++i) {
    COLLINEA_TRY(const InteriorReport::Image* const image, image_of(report, points, i, *options.points));
    const FilmTransformation& scan_from_film = image->orientation.fit.transformation;
    const std::string name = points.images[i].empty() ? image->name : points.images[i];
    const double variance = points.sigmas[i] * points.sigmas[i];
    if (to_scan) {
      const Vector2d film(points.at[i].x(), -points.at[i].y());
      const Position2 seen = scan_from_film.pixel_with_covariance(film);
      const Eigen::Matrix2d by_film = scan_from_film.by_film(film);
      const Eigen::Matrix2d own = (points.has_sigmas ? variance : 0) * by_film * by_film.transpose();
      report.scan_points.push_back({name, points.names[i], film, seen.position, seen.covariance + own});
      continue;
    }
    const auto film = scan_from_film.film_with_covariance(points.at[i], variance * Eigen::Matrix2d::Identity());
    if (!film) return fail(Errc::kBadInput, fmt::format("point {} lies beyond the film", points.names[i]));
    report.points.push_back(
        {name, points.names[i], film->position, corrected_mm(report.calibration, film->position), film->covariance});
  }
  return {};
}

Result<> write_tables(const InteriorReport& report, const fs::path& folder) {
  COLLINEA_TRY(make_out_folder(folder));
  COLLINEA_TRY(write_file(folder / "interior.txt", text_of(parameter_table(report))));
  COLLINEA_TRY(write_file(folder / "residuals.txt", text_of(residual_table(report))));
  COLLINEA_TRY(write_file(folder / "covariance.txt", text_of(covariance_table(report))));
  COLLINEA_TRY(write_file(folder / "model_tests.txt", text_of(model_test_table(report))));
  COLLINEA_TRY(write_file(folder / "deformation.txt", text_of(deformation_table(report))));
  if (!report.points.empty()) COLLINEA_TRY(write_file(folder / "points.txt", text_of(point_table(report))));
  if (!report.scan_points.empty())
    COLLINEA_TRY(write_file(folder / "scan_points.txt", text_of(scan_point_table(report))));
  return write_file(folder / "findings.json", findings_json_text(report.findings));
}

// By principal point and size of a pixel: where its pixel says the principal point is, the calibration has it.
Result<InteriorReport::Image> orient_without_marks(const FilmCalibration& calibration, const InteriorOptions& options,
                                                   std::optional<double> pixel_mm) {
  if (!pixel_mm)
    return fail(Errc::kBadInput, "without marks the size of a pixel is needed", {"pixel_um"_option, "dpi"_option});
  const auto at = parse_numbers(*options.principal_point_px);
  if (!at || at->size() != 2)
    return fail(Errc::kBadInput, "the principal point is not two numbers with a comma between",
                {"principal_point_px"_option});
  InteriorReport::Image image{.has_marks = false};
  FilmTransformation& t = image.orientation.fit.transformation;
  t = without_marks({(*at)[0], (*at)[1]}, *pixel_mm);
  t = without_marks(2 * Vector2d((*at)[0], (*at)[1]) - t.pixel_of(calibration.principal_point_mm), *pixel_mm);
  // The size of a pixel is taken as exact; the rotation of the film is part of kappa.
  if (options.sigma) t.covariance.topLeftCorner<2, 2>().diagonal().setConstant(*options.sigma * *options.sigma);
  return image;
}

// By marks that are found in scans. What the pixels say of their precision is the least of it: film moves by more.
Result<> orient_scans(InteriorReport& report, const fs::path& scans, const InteriorOptions& options,
                      std::optional<double> pixel_mm, const Run& run) {
  COLLINEA_TRY(auto found, find_scan_marks(scans, report.calibration, pixel_mm, options.scans, run));
  report.sigmas_are_known = options.sigma.has_value();
  const FilmFitOptions fitting{
      .sigmas_are_known = report.sigmas_are_known, .reject_misread = !options.keep_misread, .pixel_mm = pixel_mm};
  for (ScanMarks& scan : found) {
    if (options.sigma)
      for (MarkReading& mark : scan.marks) mark.sigma = *options.sigma;
    COLLINEA_TRY(auto image, orient_image(report.calibration, {scan.image, scan.marks}, options, fitting, 0.5));
    image.least_correlation = scan.least_correlation;
    report.images.push_back(std::move(image));
  }
  return {};
}

Result<> orient_table(InteriorReport& report, const fs::path& measurements, const InteriorOptions& options,
                      std::optional<double> pixel_mm) {
  COLLINEA_TRY(const Positions positions, read_positions(measurements, "mark", options.sigma.value_or(1)));
  report.unit = positions.unit;
  const bool in_pixels = report.unit == "px";
  if (!in_pixels && pixel_mm)
    return fail(Errc::kBadInput, "the marks are in mm: their scale is 1, not the size of a pixel",
                {"pixel_um"_option, "dpi"_option});
  for (const double sigma : positions.sigmas)
    if (!(sigma > 0)) return fail(Errc::kBadInput, measurements.string() + ": a mark without noise: sigma is zero");
  report.sigmas_are_known = positions.has_sigmas || options.sigma;
  const FilmFitOptions fitting{.sigmas_are_known = report.sigmas_are_known,
                               .reject_misread = !options.keep_misread,
                               .pixel_mm = in_pixels ? pixel_mm : std::optional<double>(1)};
  for (const ImageReadings& read : by_image(positions)) {
    COLLINEA_TRY(auto image, orient_image(report.calibration, read, options, fitting, in_pixels ? 0.5 : 0.005));
    report.images.push_back(std::move(image));
  }
  if (report.images.empty()) return fail(Errc::kBadInput, measurements.string() + ": the table has no rows");
  return {};
}

// That of the file, with the nominal marks where it has none; without a file, those alone.
Result<FilmCalibration> calibration_of(const InteriorOptions& options) {
  if (!options.calibration) {
    if (options.points)
      return fail(Errc::kBadInput,
                  "points are brought to the principal point and freed from the lens: that needs a calibration",
                  {"calibration"_option});
    return nominal_calibration(*options.gallery);
  }
  COLLINEA_TRY(FilmCalibration calibration, read_film_calibration(*options.calibration));
  if (options.gallery) {
    if (!calibration.marks.empty())
      return fail(Errc::kBadInput, "the calibration has marks of its own", {"gallery"_option});
    calibration.marks = nominal_calibration(*options.gallery).marks;
  }
  return calibration;
}

// The marks of the calibration; of no calibration and no type those of all types.
Result<> draw_marks(const InteriorOptions& options, const FilmCalibration* calibration) {
  std::vector<FilmCalibration> cameras;
  if (calibration)
    cameras.push_back(*calibration);
  else
    for (const auto& type : kFilmCameraTypeWords) cameras.push_back(nominal_calibration(type.value));
  return write_file(*options.drawing, film_marks_svg(cameras, options.scans.mark_kind));
}

}  // namespace

Result<InteriorReport> interior_orientation(const fs::path& measurements, const InteriorOptions& options,
                                            const Run& run) {
  COLLINEA_TRY(validate(options));
  InteriorReport report;
  const bool is_drawing_alone = options.drawing && measurements.empty() && !options.principal_point_px;
  if (is_drawing_alone && !options.calibration && !options.gallery) {
    COLLINEA_TRY(draw_marks(options, nullptr));
    return report;
  }
  if (!options.calibration && !options.gallery)
    return fail(Errc::kBadInput, "nothing says what the camera is: give its calibration, or its type",
                {"calibration"_option, "gallery"_option});
  if (measurements.empty() == !options.principal_point_px && !is_drawing_alone)
    return fail(Errc::kBadInput, "an orientation is made from measured marks or from the principal point, one of both",
                {"principal_point_px"_option});
  COLLINEA_TRY(report.calibration, calibration_of(options));
  if (options.drawing) COLLINEA_TRY(draw_marks(options, &report.calibration));
  if (is_drawing_alone) return report;
  COLLINEA_TRY(const auto pixel_mm, pixel_mm_of(options));
  if (measurements.empty()) {
    COLLINEA_TRY(auto image, orient_without_marks(report.calibration, options, pixel_mm));
    report.images.push_back(std::move(image));
  } else if (report.calibration.marks.empty()) {
    return fail(Errc::kBadInput, "the calibration has no marks: lines mark NAME X Y, or its type",
                {"calibration"_option, "gallery"_option});
  } else if (is_scan(measurements)) {
    COLLINEA_TRY(orient_scans(report, measurements, options, pixel_mm, run));
  } else {
    COLLINEA_TRY(orient_table(report, measurements, options, pixel_mm));
  }
  if (options.points) {
    COLLINEA_TRY(add_points(report, options));
  }
  report.findings = interior_findings(report);
  if (options.out) {
    COLLINEA_TRY(write_tables(report, *options.out));
  }
  return report;
}

}  // namespace collinea
