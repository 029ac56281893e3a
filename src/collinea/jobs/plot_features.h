// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/plot_report.h"

namespace collinea {

struct PlotOptions {
  double sigma_px = 0.5;
  std::string layer = "drawing";
  std::optional<std::filesystem::path> codes;
  std::string figures;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PlotOptions;
    visit(Field{"sigma_px", &O::sigma_px, "px", "standard deviation of a mark that states none", 1e-3, 1000});
    visit(Field{"layer", &O::layer, "", "layer of features that state neither layer nor code"});
    visit(
        Field{"codes", &O::codes, "",
              "code list that the project keeps from now on (code, layer, kind, colour, meaning); nothing: the one it "
              "has, or that of the program"}
            .leads_to(PathKind::kFile));
    visit(Field{"figures", &O::figures, "",
                "what is measured of features, a word and their names, or those of vertices: \"area roof; distance "
                "roof.1 roof.2\", or a file with one in each line"}
              .leads_to(PathKind::kFileOrWord));
  }
};

/// Draws the features of a table into a project, as edits, and writes all that is drawn, with vertices that have marks
/// computed anew by the adjustment in force (DrawingNow): write_drawing(). Without a table nothing is drawn. A row is a
/// mark of a vertex, or a vertex by coordinates (docs/manual/plot.md). A feature of which a vertex cannot be plotted is
/// not drawn. Errors: not oriented, table, code list, images and codes that there are not; those of make_edits();
/// files.
[[nodiscard]] Result<PlotReport> plot_features(const std::filesystem::path& project,
                                               const std::optional<std::filesystem::path>& table,
                                               const PlotOptions& options, const Run& run);

}  // namespace collinea
