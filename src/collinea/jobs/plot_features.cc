// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/plot_features.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>

#include "collinea/base/file.h"
#include "collinea/edit/make_edits.h"
#include "collinea/edit/read_work.h"
#include "collinea/io/code_list.h"
#include "collinea/jobs/drawing_files.h"
#include "collinea/jobs/internal/asked_figures.h"
#include "collinea/jobs/internal/feature_table.h"
#include "collinea/jobs/marking_project.h"
#include "collinea/project/project.h"
#include "collinea/restitution/drawing_now.h"
#include "collinea/restitution/drawn_vertex.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

/// What vertices of a project are plotted in.
struct Plotting {
  MarkingProject oriented;
  std::optional<PlottingSurface> surface;

  static Result<Plotting> of(const Project& project) {
    Plotting all;
    COLLINEA_TRY(all.oriented, MarkingProject::read_with_precision(project));
    if (const fs::path dsm = project.folder / "products" / "dsm.tif"; is_there(dsm)) {
      COLLINEA_TRY(all.surface, PlottingSurface::open(dsm));
    }
    return all;
  }
  [[nodiscard]] VertexPlotter plotter() {
    return {oriented.marking(), oriented.frame_or_null(), surface ? &*surface : nullptr};
  }
};

/// Features as they were plotted.
struct Plotted {
  std::vector<Edit> edits;
  std::map<std::string, std::vector<PlottedVertex>> vertices;  // of features that are drawn, by their ids
};

void plot_feature(const AskedFeature& asked, VertexPlotter& plotter, const Block& block, PlotReport& report,
                  Plotted& all) {
  PlotReport::Feature& feature = report.features.emplace_back();
  feature.id = asked.id;
  feature.layer = asked.layer;
  feature.kind = asked.kind;
  DrawFeature draw{asked.id, asked.layer, asked.kind, {}};
  std::vector<PlottedVertex> vertices;
  for (const AskedVertex& one : asked.vertices) {
    PlotReport::Vertex& vertex = feature.vertices.emplace_back();
    const auto plotted = plotter.plot(one);
    if (!plotted) {
      vertex.refused = plotted.error().message;
      continue;
    }
    vertex.drawn = drawn_vertex(plotter, one, *plotted, block);
    vertex.residuals_px = plotted->residuals_px;
    draw.vertices.push_back(*vertex.drawn);
    vertices.push_back(*plotted);
  }
  if (vertices.size() != asked.vertices.size()) return;
  all.vertices[asked.id] = std::move(vertices);
  if (!asked.code.empty()) draw.attributes["code"] = asked.code;
  all.edits.emplace_back(std::move(draw));
}

// "roof": all vertices of a feature; "roof.2": one of them.
std::vector<PlottedVertex> vertices_named(const std::string& name,
                                          const std::map<std::string, std::vector<PlottedVertex>>& all) {
  if (const auto whole = all.find(name); whole != all.end()) return whole->second;
  const auto point = name.rfind('.');
  if (point == std::string::npos) return {};
  const auto of = all.find(name.substr(0, point));
  std::size_t number = 0;
  const char* end = name.data() + name.size();
  const bool is_number = std::from_chars(name.data() + point + 1, end, number).ptr == end;
  if (of == all.end() || !is_number || number == 0 || number > of->second.size()) return {};
  return {of->second[number - 1]};
}

using Vertices = std::map<std::string, std::vector<PlottedVertex>>;

// A feature that was drawn before, when a figure names it or a vertex of it.
Result<> add_drawn(const std::string& name, const Drawing& drawing, VertexPlotter& plotter, const Block& block,
                   Vertices& all) {
  const DrawnFeature* feature = drawing.features.find(name);
  if (!feature) feature = drawing.features.find(name.substr(0, name.rfind('.')));
  if (!feature || all.contains(feature->id)) return {};
  std::vector<PlottedVertex> vertices;
  for (const DrawnVertex& vertex : feature->vertices) {
    COLLINEA_TRY(PlottedVertex plotted, plotter.plot(repeated_vertex(vertex, block)));
    vertices.push_back(std::move(plotted));
  }
  all.emplace(feature->id, std::move(vertices));
  return {};
}

Result<FigureOfVertices> measured(const MeasuredReport::Figure& figure, const Drawing& drawing, VertexPlotter& plotter,
                                  const Block& block, Vertices& all) {
  std::vector<PlottedVertex> vertices;
  for (const std::string& name : figure.points) {
    COLLINEA_TRY(add_drawn(name, drawing, plotter, block, all));
    const auto named = vertices_named(name, all);
    if (named.empty()) return fail(Errc::kBadInput, "no vertex is called \"" + name + "\"");
    vertices.insert(vertices.end(), named.begin(), named.end());
  }
  return VertexFigures(plotter, std::move(vertices)).measure(figure.kind);
}

// A figure that cannot be measured says so in its place.
void measure(std::vector<MeasuredReport::Figure>& figures, const Drawing& drawing, VertexPlotter& plotter,
             const Block& block, Vertices& all) {
  for (MeasuredReport::Figure& figure : figures) {
    const auto found = measured(figure, drawing, plotter, block, all);
    if (found)
      figure.measured = {found->value, found->sigma.value_or(std::numeric_limits<double>::quiet_NaN())};
    else
      figure.refused = found.error().message;
  }
}

Result<std::vector<DrawingCode>> codes_of(const fs::path& folder, const std::optional<fs::path>& given) {
  if (!given) return code_list_of(folder);
  return read_code_list(*given);
}

// From now on it is that of the project.
Result<> keep_codes(const fs::path& folder, const fs::path& given) {
  COLLINEA_TRY(const std::string text, read_file(given));
  return write_file(folder / "codes.txt", text);
}

bool has_marks(const Drawing& drawing) {
  return std::ranges::any_of(drawing.features, [](const DrawnFeature& feature) {
    return std::ranges::any_of(feature.vertices, [](const DrawnVertex& one) { return !one.marks.empty(); });
  });
}

// Vertices with marks become what the adjustment in force makes of them.
Result<> compute_anew(Drawing& drawing, VertexPlotter& plotter, const Block& block, PlotReport& report) {
  DrawingComputer computer;
  COLLINEA_TRY(DrawingNow now, computer.drawing_now(
                                   drawing, [&] { return &plotter; }, images_by_file(block)));
  for (const DrawnFeature& feature : drawing.features) {
    const auto its = now.features.find(feature.id);
    if (its == now.features.end()) continue;
    report.recomputed += its->second.computed;
    const PlotReport::Change change{feature.id, its->second.moved_m, its->second.moved_sigmas, its->second.kept};
    if (change.moved_sigmas > 1) report.moved.push_back(change);
    if (!change.kept.empty()) report.as_drawn.push_back(change);
  }
  drawing = std::move(now.drawing);
  return {};
}

}  // namespace

Result<PlotReport> plot_features(const fs::path& folder, const std::optional<fs::path>& table,
                                 const PlotOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  PlotReport report;
  COLLINEA_TRY(report.figures, read_figures(options.figures));
  COLLINEA_TRY(const Project project, open_project(folder, run));
  COLLINEA_TRY(const std::vector<DrawingCode> codes, codes_of(folder, options.codes));
  Plotted all;
  std::optional<Plotting> plotting;
  std::optional<VertexPlotter> plotter;
  const auto begin_plotting = [&]() -> Result<> {
    COLLINEA_TRY(plotting, Plotting::of(project));
    plotter.emplace(plotting->plotter());
    return {};
  };
  if (table || !report.figures.empty()) COLLINEA_TRY(begin_plotting());
  if (table) {
    COLLINEA_TRY(const TextTable text, read_text_table(*table));
    COLLINEA_TRY(const auto asked, features_in(text, plotting->oriented.block, codes, options.sigma_px, options.layer)
                                       .map_error([&](Error e) { return std::move(e).within(table->string()); }));
    for (const AskedFeature& feature : asked) plot_feature(feature, *plotter, plotting->oriented.block, report, all);
    Journal journal(folder);
    if (!all.edits.empty()) {
      COLLINEA_TRY([[maybe_unused]] const EditsMade made, make_edits(folder, journal, all.edits));
    }
  }
  if (options.codes) COLLINEA_TRY(keep_codes(folder, *options.codes));
  COLLINEA_TRY(EditedWork work, read_work(project));
  if (!plotter && has_marks(work.drawing))
    if (const auto begun = begin_plotting(); !begun) report.not_recomputed = begun.error().message;
  if (plotter) COLLINEA_TRY(compute_anew(work.drawing, *plotter, plotting->oriented.block, report));
  if (!report.figures.empty()) measure(report.figures, work.drawing, *plotter, plotting->oriented.block, all.vertices);
  report.features_in_force = work.drawing.features.size();
  COLLINEA_TRY(const DrawingFiles written, write_drawing(project, work.drawing, codes));
  report.crs = written.crs;
  report.files = written.files;
  return report;
}

}  // namespace collinea
