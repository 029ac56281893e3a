// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "collinea/math/median.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/page_parts.h"
#include "collinea/report/internal/svg.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

std::string area_text(double area, const std::string& unit) {
  if (unit != "m") return fmt::format("{:.4g} square units", area);
  if (area >= 1e6) return fmt::format("{:.2f} km\xc2\xb2", area / 1e6);
  if (area >= 1e4) return fmt::format("{:.2f} ha", area / 1e4);
  return fmt::format("{:.0f} m\xc2\xb2", area);
}

std::string pixel_size_text(double size, const std::string& unit) {
  return unit == "m" && size < 1 ? fmt::format("{:.2f} cm", 100 * size) : fmt::format("{:.3g} {}", size, unit);
}

// Wrong before weak before noteworthy; in each what moves points by a share of their sigmas behind the rest, the
// largest share first.
std::vector<Finding> by_weight(std::vector<Finding> findings) {
  const auto is_systematic = [](const Finding& one) {
    return one.code == FindingCode::kSystematic || one.code == FindingCode::kSystematicTakenUp;
  };
  const auto share = [&](const Finding& one) {
    return is_systematic(one) ? one.figure(FigureName::kRatio).value_or(0) : std::numeric_limits<double>::infinity();
  };
  std::ranges::stable_sort(findings, [&](const Finding& a, const Finding& b) {
    return a.severity != b.severity ? a.severity > b.severity : share(a) > share(b);
  });
  return findings;
}

// The findings among the cautions stand on the page in their own order.
std::vector<std::string> cautions_of_no_finding(const ReportInput& input, const ReportSummary& s) {
  std::set<std::string> of_findings;
  for (const Finding& finding : input.findings) of_findings.insert(sentence_of(finding, input.block));
  std::vector<std::string> cautions;
  for (const std::string& one : s.cautions)
    if (!of_findings.contains(one)) cautions.push_back(one);
  return cautions;
}

std::string statement_section(const ReportInput& input, const ReportSummary& s) {
  const bool checked = s.check.points > 0;
  const AxisRms& rms = checked ? s.check : s.control.points ? s.control : s.position;
  std::string html =
      fmt::format("<section class=\"statement{}\">\n<p>{}</p>\n", checked ? "" : " unverified", escaped(s.statement));
  if (rms.points > 0) {
    constexpr std::array<const char*, 3> kNames = {"east", "north", "height"};
    const char* kind = checked ? "check points" : s.control.points ? "control points" : "image positions";
    html += fmt::format("<p class=\"kind\">Root mean square differences at {}</p><div class=\"axes\">", kind);
    for (std::size_t i = 0; i < 3; ++i)
      html += fmt::format("<div><span>{}</span><b>{}</b></div>", kNames[i], length_text(rms.axis_m[i], s.unit));
    html += fmt::format("<div><span>in space</span><b>{}</b></div></div>\n", length_text(rms.spatial_m, s.unit));
  }
  html += "</section>\n";
  std::vector<std::string> cautions = cautions_of_no_finding(input, s);
  for (const Finding& finding : by_weight(input.findings))
    cautions.push_back(sentence_of(finding, input.block, input.spelling));
  if (!cautions.empty()) {
    html += "<ul class=\"cautions\">\n";
    for (const std::string& caution : cautions) html += "<li>" + escaped(caution) + "</li>\n";
    html += "</ul>\n";
  }
  return html;
}

// "2024-05-01 10:12 to 10:40": the first and the last of the images that say so.
std::string dates_text(const Block& block) {
  std::string first, last;
  for (const auto& [id, image] : block.images) {
    if (image.taken.size() < 16) continue;
    if (first.empty() || image.taken < first) first = image.taken;
    if (image.taken > last) last = image.taken;
  }
  if (first.empty()) return "";
  const auto readable = [](std::string time) {  // EXIF writes 2024:05:01 10:12:33.25
    time.resize(16);
    time[4] = time[7] = '-';
    return time;
  };
  first = readable(first), last = readable(last);
  if (first == last) return first;
  return first + " to " + (first.substr(0, 10) == last.substr(0, 10) ? last.substr(11) : last);
}

// Height of the middle projection centre over the middle tie point; nothing when the images do not look down.
std::optional<double> flying_height(const Block& block, const Coverage& coverage) {
  std::vector<double> heights;
  for (const auto& [id, pose] : oriented_images(block)) {
    if ((pose.rotation.conjugate() * Eigen::Vector3d::UnitZ()).z() > -0.7) continue;
    heights.push_back(centre_of(pose).z() - coverage.ground_height);
  }
  if (2 * heights.size() <= count_oriented(block)) return std::nullopt;
  return median(heights);
}

std::string facts_section(const ReportInput& input, const ReportSummary& s) {
  const Block& block = input.block;
  std::string html = "<dl class=\"facts\">\n";
  html += fact("images oriented", fmt::format("{} of {}", count_oriented(block), block.images.size()));
  html += fact("tie points", count_text(block.points.size()));
  html += fact("measured image points", count_text(s.residuals.observations));
  html += fact("mean residual", fmt::format("{:.2f} px", s.residuals.mean_px));
  if (std::isfinite(input.sigma0))
    html += fact("sigma 0 (1: as assumed)", fmt::format("{:.2f}, redundancy {}", input.sigma0,
                                                        count_text(std::size_t(std::max(0L, input.redundancy)))));
  if (input.gsd_m) html += fact("ground size of a pixel", pixel_size_text(*input.gsd_m, s.unit));
  if (const auto height = flying_height(block, s.coverage))
    html += fact("height above ground", fmt::format("{:.{}f} {}", *height, *height < 20 ? 1 : 0, s.unit));
  if (const double area = s.overlap.area(3); area > 0)
    html += fact("area seen by 3 images or more", area_text(area, s.unit));
  html += fact("control / check points", fmt::format("{} / {}", s.control_points, s.check_points));
  if (const std::string dates = dates_text(block); !dates.empty())
    html += fact("photographs taken, by the camera's clock", dates);
  const auto& g = block.georeference;
  if (input.georeferenced && g)
    html +=
        fact("coordinate system",
             input.crs_name.empty() || input.crs_name == g->crs ? g->crs : input.crs_name + " (" + g->crs + ")", true);
  else
    html += fact("coordinate system",
                 input.metric ? "none: a local frame in metres" : "none: a local frame in units of the model", true);
  if (input.georeferenced && input.height_reference)
    html += fact("heights", std::string(words_of(*input.height_reference)), true);
  if (input.gauge) html += fact("position, attitude and scale", words_of(*input.gauge), true);
  return html + "</dl>\n";
}

std::string images_of(const ProductPreviews& shown, const std::string& unit, const char* of_heights) {
  std::string html = "<div class=\"pair\">\n";
  if (shown.ortho)
    html += "<figure>" + image_element(*shown.ortho, "Orthophoto") +
            "<figcaption>Orthophoto, reduced.</figcaption></figure>\n";
  if (shown.heights)
    html += "<figure>" + image_element(*shown.heights, "Surface model") + height_scale(*shown.heights, unit) +
            "<figcaption>" + of_heights + "</figcaption></figure>\n";
  return html + "</div>";
}

std::string products_images(const ProductPreviews& map, const std::string& unit) {
  if (!map.heights && !map.ortho) return "";
  return "<section><h2>Products</h2>\n" +
         images_of(map, unit,
                   "Surface model, reduced; heights in colour, light from the north-west. White: no height.") +
         "</section>\n";
}

std::string frames_section(const ReportInput& input, const ReportSummary& s,
                           const std::vector<ProductPreviews>& previews) {
  const std::vector<FrameRecord> frames = outcome_in<FramesRecord>(input.steps).frames;
  if (frames.empty()) return "";
  std::string html =
      "<section><h2>Planes of the object</h2>\n<p>Surface and orthophoto on each plane as on the ground, in "
      "products/frames. Sigma: of a distance from the plane, and of one against those around it.</p>\n"
      "<table><thead><tr><th class=\"l\">plane</th><th>width [" +
      s.unit + "]</th><th>height [" + s.unit + "]</th><th>photographs</th><th>RMS of its points [" + s.unit +
      "]</th><th>cell [" + s.unit + "]</th><th>sigma [" + s.unit + "]</th><th>relative [" + s.unit +
      "]</th><th>interpolated [%]</th></tr></thead><tbody>\n";
  for (const FrameRecord& frame : frames) {
    const double seen = double(frame.surface.measured_cells + frame.surface.interpolated_cells);
    html += "<tr>" + text_cell(frame.name) +
            fmt::format(
                "<td>{:.2f}</td><td>{:.2f}</td><td>{}</td><td>{:.3g}</td><td>{:.3g}</td><td>{:.3g}</td><td>{:.3g}"
                "</td><td>{:.1f}</td></tr>\n",
                frame.width_m, frame.height_m, frame.images.size(), frame.rms_m, frame.surface.cell_m,
                frame.surface.mean_sigma_m, frame.surface.mean_sigma_relative_m,
                seen > 0 ? 100 * double(frame.surface.interpolated_cells) / seen : 0.0);
  }
  html += "</tbody></table>\n";
  for (std::size_t i = 0; i < frames.size() && i < previews.size(); ++i)
    html += "<h3>" + escaped(frames[i].name) + "</h3>\n" +
            images_of(previews[i], s.unit,
                      "Distance from the plane in colour, positive towards the viewer, light from the upper left. "
                      "White: nothing measured.") +
            "\n";
  return html + "</section>\n";
}

std::string geometry_section(const ReportInput& input, const ReportSummary& s) {
  if (oriented_images(input.block).empty()) return "";
  const char* lost = s.not_oriented.empty() ? "" : ", red circles: images not oriented, where they say they were";
  std::string html = fmt::format(
      "<section><h2>The block from above</h2>\n<figure class=\"map\">{}<figcaption>Dots: projection centres; outlines: "
      "what they see at the median height of the tie points{}. Triangles: control points; circles: check points; "
      "arrows: estimated minus surveyed, exaggerated.</figcaption></figure>\n",
      block_map(input, s.coverage, s.unit), lost);
  html += "<div class=\"pair\">\n";
  if (s.overlap.columns > 0)
    html += "<figure class=\"map\">" + overlap_map(s.overlap, s.unit) +
            "<figcaption>Images that see each point of the ground. Below 3 a point is hardly checked by others; 5 and "
            "more are good.</figcaption></figure>\n";
  html += "<figure>" + rays_chart(s.residuals) +
          "<figcaption>Tie points by the number of images that see them.</figcaption></figure>\n";
  return html + "</div></section>\n";
}

std::string residual_section(const ReportSummary& s) {
  if (s.residuals.observations == 0) return "";
  return fmt::format(
      "<section><h2>Image residuals</h2>\n<div class=\"pair\"><figure>{}<figcaption>Residual coordinates of all tie "
      "points; dashed: the normal "
      "distribution of the same standard deviation.</figcaption></figure>\n<div><table><tbody>"
      "<tr><td class=\"l\">residuals</td><td>{}</td></tr><tr><td class=\"l\">mean length</td><td>{:.3f} px</td></tr>"
      "<tr><td class=\"l\">RMS of a coordinate</td><td>{:.3f} px</td></tr><tr><td class=\"l\">largest "
      "length</td><td>{:.2f} px</td></tr>"
      "</tbody></table></div></div></section>\n",
      residual_histogram(s.residuals), count_text(s.residuals.observations), s.residuals.mean_px, s.residuals.rms_px,
      s.residuals.largest_px);
}

}  // namespace

std::string report_page(const ReportInput& input, const ReportSummary& s, const ProductPreviews& map,
                        const std::vector<ProductPreviews>& frames) {
  std::string html = statement_section(input, s);
  html += facts_section(input, s);
  html += products_images(map, s.unit);
  html += frames_section(input, s, frames);
  html += geometry_section(input, s);
  html += control_section(input, s);
  html += geodetic_section(input);
  html += position_section(input, s);
  html += film_section(input);
  html += camera_section(input, s);
  html += residual_section(s);
  html += image_section(input, s);
  html += left_out_section(input, s);
  html += process_section(input);
  html += signature_section(input);
  html += "<footer>All figures are also in report.json.</footer>\n";
  return whole_page({input.title.empty() ? "Project" : input.title, "quality report", "Quality report", input.date},
                    html);
}

}  // namespace collinea
