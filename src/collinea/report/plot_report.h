// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/report/measured_report.h"
#include "collinea/restitution/drawing_now.h"
#include "collinea/vector/drawing.h"

namespace collinea {

/// Features that were drawn into a project, and what its drawing holds now.
struct PlotReport {
  struct Vertex {
    std::optional<DrawnVertex> drawn;
    std::string refused;                             ///< why it is not
    std::vector<Eigen::Vector2d> residuals_px = {};  ///< of its marks
  };
  struct Feature {
    std::string id, layer;
    VectorKind kind = VectorKind::kLine;
    std::vector<Vertex> vertices;  ///< it is drawn when all are
  };
  std::string crs;  ///< of the map; empty: positions are in the frame of the block
  std::vector<Feature> features;
  std::vector<MeasuredReport::Figure> figures;
  std::size_t features_in_force = 0;
  std::vector<std::string> files;  ///< that were written, below the project

  /// A feature of the drawing that is not where it was drawn, or not all of it could be computed anew.
  struct Change {
    std::string id;
    double moved_m = 0, moved_sigmas = 0;
    std::vector<FeatureNow::Kept> kept;
  };
  std::size_t recomputed = 0;    ///< vertices of the drawing, by their marks in the adjustment in force
  std::vector<Change> moved;     ///< by more than their standard deviation
  std::vector<Change> as_drawn;  ///< with vertices that can no longer be computed
  std::string not_recomputed;    ///< why none was
};

[[nodiscard]] std::string plot_text(const PlotReport& report);
/// vertices.txt (feature, vertex, layer, source, E, N, H, their sigmas and correlations) and, where there are figures,
/// figures.txt.
[[nodiscard]] std::vector<NamedTable> plot_tables(const PlotReport& report);

}  // namespace collinea
