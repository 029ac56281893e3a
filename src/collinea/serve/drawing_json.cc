// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/drawing_json.h"

#include <algorithm>

#include "collinea/base/file.h"
#include "collinea/io/code_list.h"
#include "collinea/marking/local_poses.h"
#include "collinea/report/json_values.h"
#include "collinea/serve/internal/asked_vertices.h"
#include "collinea/serve/internal/bounded_json.h"
#include "collinea/surface/volume.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

constexpr std::size_t kMostFigures = 20;

std::string dumped(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

json pixel_json(const Eigen::Vector2d& v) { return {number(v.x()), number(v.y())}; }

json vertex_json(const DrawnVertex& vertex, const ImagesByFile& images) {
  json covariance = nullptr, sigma = nullptr, marks = json::array();
  if (vertex.covariance_m2) {
    const Eigen::Matrix3d& c = *vertex.covariance_m2;
    covariance = {number(c(0, 0)), number(c(0, 1)), number(c(0, 2)), number(c(1, 1)), number(c(1, 2)), number(c(2, 2))};
    sigma = vector(*vertex.sigma_m());
  }
  for (const VertexMark& mark : vertex.marks) {
    const auto image = images.find(mark.image);
    marks.push_back({{"image", image == images.end() ? json(nullptr) : json(image->second.value)},
                     {"file", mark.image},
                     {"pixel", pixel_json(mark.pixel)},
                     {"sigma_px", number(mark.sigma_px)}});
  }
  return {{"position", vector(vertex.position)},
          {"covariance_m2", covariance},
          {"sigma_m", sigma},
          {"source", word_of(vertex.source)},
          {"marks", marks}};
}

/// Where an image shows positions of the map.
class Projection {
 public:
  Projection(const ProjectView& view, std::optional<ImageId> image) : view_(view), image_(image) {
    if (image) pose_ = find_pose(view.block, *image);
  }
  void add_to(json& vertex, const Eigen::Vector3d& on_map) const {
    if (!image_) return;
    vertex["pixel"] = nullptr;
    if (!pose_) return;
    const Camera& camera = view_.block.camera_of(*image_);
    const auto seen = linear_pixel(camera, *pose_, view_.frame ? view_.frame->local_from_map(on_map) : on_map);
    if (seen && inside(camera, seen->pixel)) vertex["pixel"] = pixel_json(seen->pixel);
  }

 private:
  const ProjectView& view_;
  std::optional<ImageId> image_;
  std::optional<Rigid3> pose_;
};

/// What vertices of a project are plotted in.
struct Plotting {
  std::shared_ptr<const TiedBlock> ties;
  std::optional<PlottingSurface> surface;
  std::optional<VertexPlotter> plotter;
};

Result<std::unique_ptr<Plotting>> plotting_of(const ProjectView& view) {
  if (count_oriented(view.block) == 0)
    return fail(Errc::kIllPosed, "the images are not oriented yet: bring the project to the step orient first");
  auto all = std::make_unique<Plotting>();
  COLLINEA_TRY(all->ties, view.ties());
  const std::filesystem::path dsm = view.project.folder / "products" / "dsm.tif";
  if (is_there(dsm)) {
    COLLINEA_TRY(const HeightSpan span, view.span_of_surface(dsm));
    COLLINEA_TRY(all->surface, PlottingSurface::open(dsm, span));
  }
  all->plotter.emplace(view.plotting(*all->ties), view.frame_or_null(), all->surface ? &*all->surface : nullptr);
  return all;
}

Result<FigureKind> kind_in(const json& word) {
  const auto kind = word.is_string() ? from_word<FigureKind>(word.get<std::string>()) : std::nullopt;
  if (kind) return *kind;
  std::string known;
  for (const auto& entry : kFigureKindWords) known += (known.empty() ? "" : ", ") + std::string(entry.word);
  return fail(Errc::kBadInput, "a figure is one of " + known);
}

json figure_json(FigureKind kind, const FigureOfVertices& figure) {
  return {{"kind", word_of(kind)},
          {"value", number(figure.value)},
          {"sigma", figure.sigma ? number(*figure.sigma) : json(nullptr)},
          {"unit", unit_of(kind)}};
}

Result<std::optional<ImageId>> asked_image(const json& asked, const Block& block) {
  const json image = asked.value("image", json());
  if (image.is_null()) return std::optional<ImageId>();
  try {
    if (const ImageId id = image_in(image); block.images.contains(id)) return std::optional(id);
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
  return fail(Errc::kNotFound, "there is no such image");
}

Result<SurfaceFiles> surface_of(const ProjectView& view) {
  const std::filesystem::path dsm = view.project.folder / "products" / "dsm.tif";
  if (!is_there(dsm)) return fail(Errc::kIllPosed, "there is no surface yet: bring the project to the step surface");
  return with_sigmas_beside(dsm);
}

/// The drawing as the adjustment has it, or as it was drawn where nothing can be plotted.
struct DrawingInForce {
  DrawingNow now;
  std::optional<std::string> as_drawn = {};  // why
};

DrawingInForce drawing_of(const ProjectView& view) {
  std::unique_ptr<Plotting> plotting;
  auto now = view.drawing_now([&]() -> Result<VertexPlotter*> {
    COLLINEA_TRY(plotting, plotting_of(view));
    return &*plotting->plotter;
  });
  if (now) return {*std::move(now)};
  return {{view.work.drawing, {}}, now.error().message};
}

// The same where what is asked names vertices of it; else nothing is needed of it.
Drawing drawing_for(const json& asked, const ProjectView& view) {
  const auto list = asked.find("vertices");
  const bool names_some = list != asked.end() && list->is_array() && std::ranges::any_of(*list, [](const json& one) {
                            return one.is_object() && one.contains("feature");
                          });
  return names_some ? drawing_of(view).now.drawing : Drawing();
}

// What computing it anew made of a feature.
void add_change(json& feature, const DrawingNow& drawing, const std::string& id) {
  feature["moved_m"] = feature["moved_sigmas"] = nullptr;
  feature["not_computed"] = json::array();
  const auto its = drawing.features.find(id);
  if (its == drawing.features.end()) return;
  if (its->second.computed > 0) {
    feature["moved_m"] = number(its->second.moved_m);
    feature["moved_sigmas"] = number(its->second.moved_sigmas);
  }
  for (const FeatureNow::Kept& kept : its->second.kept)
    feature["not_computed"].push_back({{"vertex", kept.vertex}, {"error", kept.why}});
}

// What is plotted by several marks has residuals, nothing else.
void add_residuals(json& marks, const AskedVertex& asked, const std::vector<Eigen::Vector2d>& residuals_px) {
  const auto* marked = std::get_if<MarkedVertex>(&asked);
  if (!marked) return;
  for (std::size_t i = 0; i < residuals_px.size() && i < marked->marks.size(); ++i)
    for (json& mark : marks)
      if (mark.at("image") == marked->marks[i].image.value) mark["residual_px"] = pixel_json(residuals_px[i]);
}

}  // namespace

Result<std::string> drawing_json(const ProjectView& view, std::optional<ImageId> image) {
  if (image && !view.block.images.contains(*image)) return fail(Errc::kNotFound, "there is no such image");
  COLLINEA_TRY(const std::vector<DrawingCode> codes, code_list_of(view.project.folder));
  const DrawingInForce in_force = drawing_of(view);
  const Drawing& drawing = in_force.now.drawing;
  const ImagesByFile images = images_by_file(view.block);
  const Projection projection(view, image);
  json all = {{"layers", json::array()}, {"codes", json::array()}, {"features", json::array()}};
  all["as_drawn"] = in_force.as_drawn ? json(*in_force.as_drawn) : json(nullptr);
  for (const DrawingLayer& layer : layers_of(drawing, codes))
    all["layers"].push_back({{"name", layer.name},
                             {"kind", layer.kind ? json(word_of(*layer.kind)) : json(nullptr)},
                             {"colour", collinea::text_of(layer.colour)}});
  for (const DrawingCode& code : codes)
    all["codes"].push_back({{"code", code.code},
                            {"layer", code.layer},
                            {"kind", word_of(code.kind)},
                            {"colour", collinea::text_of(code.colour)},
                            {"meaning", code.meaning}});
  for (const DrawnFeature& feature : drawing.features) {
    json vertices = json::array();
    for (const DrawnVertex& vertex : feature.vertices) {
      json one = vertex_json(vertex, images);
      projection.add_to(one, vertex.position);
      vertices.push_back(std::move(one));
    }
    all["features"].push_back({{"id", feature.id},
                               {"layer", feature.layer},
                               {"kind", word_of(feature.kind)},
                               {"attributes", json(feature.attributes)},
                               {"vertices", std::move(vertices)}});
    add_change(all["features"].back(), in_force.now, feature.id);
  }
  return dumped(all);
}

Result<std::string> vertices_json(const ProjectView& view, std::string_view body) {
  COLLINEA_TRY(const json asked, asked_object(body));
  const Drawing drawing = drawing_for(asked, view);
  COLLINEA_TRY(const auto vertices, asked_vertices(asked, drawing, view.block));
  COLLINEA_TRY(const std::optional<ImageId> image, asked_image(asked, view.block));
  COLLINEA_TRY(const auto plotting, plotting_of(view));
  VertexPlotter& plotter = *plotting->plotter;
  const ImagesByFile images = images_by_file(view.block);
  const Projection projection(view, image);
  json list = json::array();
  for (const AskedVertex& vertex : vertices) {
    const auto plotted = plotter.plot(vertex);
    if (!plotted) {
      list.push_back({{"error", plotted.error().message}});
      continue;
    }
    json one = vertex_json(drawn_vertex(plotter, vertex, *plotted, plotting->ties->block), images);
    add_residuals(one["marks"], vertex, plotted->residuals_px);
    projection.add_to(one, plotted->position);
    list.push_back(std::move(one));
  }
  return dumped({{"vertices", std::move(list)}});
}

Result<std::string> figures_json(const ProjectView& view, std::string_view body) {
  COLLINEA_TRY(const json asked, asked_object(body));
  const bool is_list = asked.contains("figures");
  const json words = is_list ? asked.at("figures") : json::array({asked.value("kind", json())});
  if (!words.is_array() || words.size() > kMostFigures)
    return fail(Errc::kBadInput, "figures: a list of at most " + std::to_string(kMostFigures));
  std::vector<FigureKind> kinds;
  for (const json& word : words) {
    COLLINEA_TRY(const FigureKind kind, kind_in(word));
    kinds.push_back(kind);
  }
  const auto without = [](FigureKind kind, const Error& why) {
    return json{{"kind", word_of(kind)}, {"error", why.message}};
  };
  json list = json::array();
  const Drawing drawing = drawing_for(asked, view);
  const auto vertices = asked_vertices(asked, drawing, view.block);
  // A feature that another edit has just taken away has no figures, and that is no fault of who asks.
  if (!vertices && is_list && vertices.error().code == Errc::kNotFound) {
    for (const FigureKind kind : kinds) list.push_back(without(kind, vertices.error()));
    return dumped({{"figures", std::move(list)}});
  }
  if (!vertices) return tl::unexpected(vertices.error());
  COLLINEA_TRY(const auto plotting, plotting_of(view));
  std::vector<PlottedVertex> plotted;
  for (const AskedVertex& vertex : *vertices) {
    COLLINEA_TRY(PlottedVertex one, plotting->plotter->plot(vertex).map_error([&](Error e) {
      return std::move(e).within("vertex " + std::to_string(plotted.size()));
    }));
    plotted.push_back(std::move(one));
  }
  const VertexFigures figures(*plotting->plotter, std::move(plotted));
  for (const FigureKind kind : kinds) {
    const auto figure = figures.measure(kind);
    if (!figure && !is_list) return tl::unexpected(figure.error());
    list.push_back(figure ? figure_json(kind, *figure) : without(kind, figure.error()));
  }
  return dumped(is_list ? json{{"figures", std::move(list)}} : list.at(0));
}

Result<std::string> volume_over_json(const ProjectView& view, std::string_view body) {
  COLLINEA_TRY(const json asked, asked_object(body));
  COLLINEA_TRY(const MapArea ring, asked_positions(asked, "ring", 3));
  const json base = asked.value("base", json("rim"));
  if (base != "rim" && !base.is_number()) return fail(Errc::kBadInput, "base: it is rim, or a height in metres");
  COLLINEA_TRY(const SurfaceFiles surface, surface_of(view));
  COLLINEA_TRY(const Volume volume, base.is_number() ? volume_over_level(surface, base.get<double>(), ring, {}, {})
                                                     : volume_over_rim(surface, ring, {}, {}));
  return dumped({{"above_m3", number(volume.above_m3)},
                 {"below_m3", number(volume.below_m3)},
                 {"net_m3", number(volume.net_m3())},
                 {"sigma_m3", number(volume.sigma_m3())},
                 {"area_m2", number(volume.area_m2)},
                 {"missing_m2", number(volume.missing_m2)}});
}

Result<std::string> profile_json(const ProjectView& view, std::string_view body) {
  constexpr std::size_t kMostSamples = 20'000;
  COLLINEA_TRY(const json asked, asked_object(body));
  COLLINEA_TRY(const auto line, asked_positions(asked, "line", 2));
  const json step = asked.value("step_m", json());
  if (!step.is_null() && !(step.is_number() && step.get<double>() > 0))
    return fail(Errc::kBadInput, "step_m: a length in metres, or null for a cell of the surface");
  COLLINEA_TRY(const SurfaceFiles files, surface_of(view));
  std::vector<HeightSamples> surfaces;
  COLLINEA_TRY(HeightSamples samples, HeightSamples::open(files, VolumeOptions{}.sigma_m));
  surfaces.push_back(std::move(samples));
  const double step_m = step.is_null() ? surfaces[0].grid().cell_m : step.get<double>();
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  if (!(length / step_m < kMostSamples))
    return fail(Errc::kBadInput, "the profile has more than " + std::to_string(kMostSamples) +
                                     " heights: give a longer step_m or a shorter line");
  COLLINEA_TRY(const Profile profile, profile_along(line, step_m, surfaces));
  json positions = json::array(), heights = json::array(), sigmas = json::array();
  for (const Eigen::Vector2d& position : profile.positions) positions.push_back(pixel_json(position));
  for (const HeightSample& sample : profile.of[0]) {
    heights.push_back(number(sample.height_m));
    sigmas.push_back(number(sample.sigma_m));
  }
  return dumped(
      {{"distance_m", profile.distance_m}, {"positions", positions}, {"height_m", heights}, {"sigma_m", sigmas}});
}

}  // namespace collinea
