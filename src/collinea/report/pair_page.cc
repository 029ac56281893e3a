// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/base/file.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/html_page.h"
#include "collinea/report/internal/page_parts.h"
#include "collinea/report/internal/pair_drawings.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

// The images of the page; those that are missing are left out.
struct Previews {
  std::array<std::optional<Preview>, 2> photos;
  std::optional<Preview> epipolar, heights, sigma, ortho;
};

Previews previews_of(const PairReport& report, const std::filesystem::path& folder, std::vector<Finding>& findings) {
  Previews made;
  for (std::size_t i = 0; i < 2; ++i) made.photos[i] = preview_or_finding(preview_of_file, report.files[i], findings);
  made.epipolar = preview_or_finding(preview_of_file, folder / "epipolar_check.png", findings);
  if (!report.map) return made;
  made.heights = preview_or_finding(preview_of_heights, folder / "dsm.tif", findings);
  made.sigma = preview_or_finding(preview_of_values, folder / "dsm_sigma.tif", findings);
  made.ortho = preview_or_finding(preview_of_image, folder / "ortho.tif", findings);
  return made;
}

std::string figure(const std::string& drawing, std::string_view caption) {
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", drawing, caption);
}

std::string section(std::string_view title, const std::string& body) {
  return fmt::format("<section><h2>{}</h2>\n{}</section>\n", title, body);
}

std::string pair_of(const std::string& left, const std::string& right) {
  return "<div class=\"pair\">\n" + left + right + "</div>\n";
}

std::string statement(const PairReport& report) {
  const PairOrientation& last = report.orientations.back();
  std::string text = fmt::format(
      "Two photographs oriented by {} homologous points ({} rejected) to {:.3f} px; {} "
      "points of the surface.",
      last.orientation.used, last.rejected, last.sigma0_px, count_text(report.surface_points));
  if (report.is_given)
    text += " Their orientation is as given.";
  else if (report.absolute)
    text += fmt::format(" On the ground by {} control points, sigma0 {:.2f}.", report.control_names.size(),
                        report.absolute->sigma0);
  return fmt::format("<section class=\"statement{}\">\n<p>{}</p>\n</section>\n", report.absolute ? "" : " unverified",
                     escaped(text));
}

std::string findings_list(const std::vector<Finding>& findings) {
  if (findings.empty()) return "";
  std::string html = "<ul class=\"cautions\">\n";
  for (const Severity severity : {Severity::kWrong, Severity::kWeak, Severity::kNote})
    for (const Finding& finding : findings)
      if (finding.severity == severity) html += "<li>" + escaped(sentence_of(finding, Block{})) + "</li>\n";
  return html + "</ul>\n";
}

std::string facts(const PairReport& report) {
  std::string html = "<dl class=\"facts\">\n";
  html += fact("left photograph", report.files[0].filename().string());
  html += fact("right photograph", report.files[1].filename().string());
  html +=
      fact("worked on at", fmt::format("1/{}: {} x {} px", report.shrink, report.left_width_px, report.left_height_px));
  html += fact("principal distance", fmt::format("{:.2f} px", report.cameras[0].focal_px()));
  html += fact("y-parallax of the points, RMS", fmt::format("{:.3f} px", report.y_parallax_rms_px));
  html += fact("median sigma of disparities", fmt::format("{:.3f} px", report.median_sigma_px));
  html += fact("median sigma of depths", report.is_metric() ? fmt::format("{:.3f} m", report.median_sigma_z_m())
                                                            : fmt::format("{:.2e} bases", report.median_sigma_z));
  if (report.map)
    html += fact("surface model", fmt::format("{} x {} cells of {:.4g} m, sigma {:.3f} m", report.map->width,
                                              report.map->height, report.map->cell_m, report.map->mean_sigma_m));
  return html + "</dl>\n";
}

std::string products(const PairReport& report, const Previews& previews) {
  if (!report.map)
    return section("Products",
                   "<p>Neither control nor a base in metres, or a pair that does not look down: no surface "
                   "model and no orthophoto. The points are in cloud.ply.</p>\n");
  std::string html;
  const std::string ortho =
      previews.ortho ? figure(image_element(*previews.ortho, "Orthophoto"), "Orthophoto, reduced.") : "";
  const std::string heights =
      previews.heights
          ? figure(image_element(*previews.heights, "Surface model") + height_scale(*previews.heights, "m"),
                   "Surface model, reduced; heights in colour, light from the north-west. White: no "
                   "height.")
          : "";
  html += pair_of(ortho, heights);
  if (previews.sigma)
    html += figure(image_element(*previews.sigma, "Sigma") + height_scale(*previews.sigma, "m", 3),
                   "Standard deviations of its heights by matching and orientation. White: no height, or none is "
                   "stated.");
  return section("Products", html);
}

std::string relative_section(const PairReport& report, const Previews& previews) {
  std::string html = pair_of(figure(epipolar_drawing(report, 0, previews.photos[0]),
                                    "The left photograph: points, and the lines on which the "
                                    "orientation lets them lie by the right one."),
                             figure(epipolar_drawing(report, 1, previews.photos[1]),
                                    "The right photograph: the same points and the lines by "
                                    "the left one."));
  if (previews.epipolar)
    html += figure(image_element(*previews.epipolar, "Epipolar images"),
                   "The epipolar images side by side: homologous points lie on the same red line.");
  html += pair_of(figure(parallax_drawing(report, previews.photos[0]),
                         "What is left of the y-parallaxes, exaggerated; red: rejected."),
                  figure(pair_shape_svg(*report.relative),
                         "The points seen along the base, and along the plane that fits them best."));
  html += "<h3>Elements</h3>\n" + table_element(relative_parameter_table(*report.relative));
  html += "<h3>Correlations</h3>\n" + table_element(relative_correlation_table(*report.relative));
  return section("Relative orientation", html);
}

std::string ground_section(const PairReport& report) {
  std::string html;
  if (report.control)
    for (const NamedTable& table : absolute_tables(*report.control))
      html += fmt::format("<h3>{}</h3>\n", table.name == "parameters.txt"     ? "Seven parameters"
                                           : table.name == "residuals.txt"    ? "Control and check points"
                                           : table.name == "correlations.txt" ? "Correlations"
                                                                              : "Points on the ground by the pair") +
              table_element(table.table);
  const std::array images{report.exterior[0].image, report.exterior[1].image};
  const std::array elements{report.exterior[0].elements, report.exterior[1].elements};
  html += "<h3>Exterior orientations</h3>\n" + table_element(exterior_table(images, elements));
  return section(report.control ? "On the ground" : "In the model", html);
}

std::string pair_page(const PairReport& report, const std::filesystem::path& folder) {
  std::vector<Finding> findings = report.findings;
  const Previews previews = previews_of(report, folder, findings);
  const std::string body = statement(report) + findings_list(findings) + facts(report) + products(report, previews) +
                           relative_section(report, previews) + ground_section(report) +
                           "<footer>All figures are also in pair.json.</footer>\n";
  return whole_page({report.files[0].filename().string() + " and " + report.files[1].filename().string(), "pair report",
                     "Two photographs to a surface", ""},
                    body);
}

}  // namespace

Result<> write_pair_report(const PairReport& report, const std::filesystem::path& folder) {
  COLLINEA_TRY(write_file(folder / "pair.txt", pair_text(report)));
  COLLINEA_TRY(write_file(folder / "pair.json", pair_json(report)));
  return write_file(folder / "pair.html", pair_page(report, folder));
}

}  // namespace collinea
