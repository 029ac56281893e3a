// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/plot_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kWideResidual_px = 3;

TextTable vertices_table(const PlotReport& report, bool in_full) {
  TextTable table;
  table.columns = {{"feature", ""}, {"vertex", ""}, {"layer", ""},    {"source", ""},   {"E", "m"},
                   {"N", "m"},      {"H", "m"},     {"sigma_E", "m"}, {"sigma_N", "m"}, {"sigma_H", "m"}};
  if (in_full)
    for (const char* pair : {"EN", "EH", "NH"}) table.columns.push_back({std::string("correlation_") + pair, ""});
  for (const PlotReport::Feature& feature : report.features)
    for (std::size_t i = 0; i < feature.vertices.size(); ++i) {
      const auto& drawn = feature.vertices[i].drawn;
      std::vector<std::string> row{feature.id, std::to_string(i + 1), feature.layer,
                                   drawn ? std::string(word_of(drawn->source)) : "-"};
      if (drawn) {
        for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text(drawn->position[axis], in_full ? 6 : 4));
        if (const auto sigma = drawn->sigma_m()) {
          for (int axis = 0; axis < 3; ++axis) row.push_back(decimal_text((*sigma)[axis], in_full ? 6 : 4));
          const Eigen::Matrix3d& c = *drawn->covariance_m2;
          if (in_full)
            for (const auto& [a, b] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
              row.push_back(decimal_text(c(a, b) / ((*sigma)[a] * (*sigma)[b]), 6));
        }
      }
      row.resize(table.columns.size(), "-");
      table.rows.push_back(std::move(row));
    }
  return table;
}

std::string remarks_of(const PlotReport::Feature& feature) {
  std::string text;
  for (std::size_t i = 0; i < feature.vertices.size(); ++i) {
    const PlotReport::Vertex& vertex = feature.vertices[i];
    if (!vertex.drawn)
      text += fmt::format("feature {} is not drawn: vertex {}: {}\n", feature.id, i + 1, vertex.refused);
    else if (!vertex.drawn->covariance_m2)
      text += fmt::format("feature {}: vertex {}: its standard deviation is not known\n", feature.id, i + 1);
    double largest = 0;
    for (const Eigen::Vector2d& residual : vertex.residuals_px) largest = std::max(largest, residual.norm());
    if (largest > kWideResidual_px)
      text += fmt::format("feature {}: vertex {}: its marks miss each other: residual {:.1f} px\n", feature.id, i + 1,
                          largest);
  }
  return text;
}

// What the adjustment in force makes of what was drawn in another.
std::string changes_text(const PlotReport& report) {
  constexpr std::size_t kMostLines = 20;
  std::string text;
  if (!report.not_recomputed.empty())
    text += fmt::format("vertices are where they were drawn: {}\n", report.not_recomputed);
  const auto more = [&](std::size_t count) {
    if (count > kMostLines) text += fmt::format("and {} more\n", count - kMostLines);
  };
  for (std::size_t i = 0; i < std::min(kMostLines, report.moved.size()); ++i)
    text += fmt::format("feature {}: computed anew, it moved by {:.3f} m, {:.1f} standard deviations\n",
                        report.moved[i].id, report.moved[i].moved_m, report.moved[i].moved_sigmas);
  more(report.moved.size());
  for (std::size_t i = 0; i < std::min(kMostLines, report.as_drawn.size()); ++i) {
    const FeatureNow::Kept& first = report.as_drawn[i].kept.front();
    text += fmt::format("feature {}: {} of its vertices cannot be computed anew and stay as drawn: vertex {}: {}\n",
                        report.as_drawn[i].id, report.as_drawn[i].kept.size(), first.vertex + 1, first.why);
  }
  more(report.as_drawn.size());
  return text;
}

}  // namespace

std::string plot_text(const PlotReport& report) {
  std::string text;
  if (!report.features.empty()) {
    text += indented_rows(vertices_table(report, false));
    for (const PlotReport::Feature& feature : report.features) text += remarks_of(feature);
  }
  if (!report.figures.empty()) text += figures_text(report.figures);
  text += changes_text(report);
  text +=
      fmt::format("{} drawn, {}: {}\n", counted_text(report.features_in_force, "feature"),
                  report.crs.empty() ? "in the frame of the block" : "in " + report.crs, fmt::join(report.files, ", "));
  return text;
}

std::vector<NamedTable> plot_tables(const PlotReport& report) {
  std::vector<NamedTable> tables{{"vertices.txt", vertices_table(report, true)}};
  for (NamedTable& figures : figure_tables(report.figures)) tables.push_back(std::move(figures));
  return tables;
}

}  // namespace collinea
