// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/drawing_now.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/restitution/drawn_vertex.h"

namespace collinea {
namespace {

bool is_by_marks(const DrawnVertex& vertex) {
  return !vertex.marks.empty() && (vertex.source == VertexSource::kStereo || vertex.source == VertexSource::kMono);
}

Result<DrawnVertex> computed(const DrawnVertex& drawn, VertexPlotter& plotter, const ImagesByFile& images) {
  MarkedVertex marked;
  for (const VertexMark& mark : drawn.marks) {
    const auto image = images.find(mark.image);
    if (image == images.end()) return fail(Errc::kNotFound, "there is no image " + mark.image);
    marked.marks.push_back({image->second, mark.pixel, mark.sigma_px});
  }
  COLLINEA_TRY(const PlottedVertex plotted, plotter.plot(marked));
  return DrawnVertex{plotted.position, plotter.covariance_in_map(plotted), plotted.source, drawn.marks};
}

void add_move(const DrawnVertex& before, const DrawnVertex& after, FeatureNow& now) {
  const Eigen::Vector3d moved = after.position - before.position;
  now.moved_m = std::max(now.moved_m, moved.norm());
  const auto sigma = before.covariance_m2 ? before.sigma_m() : after.sigma_m();
  if (!sigma) return;
  for (int axis = 0; axis < 3; ++axis)
    if ((*sigma)[axis] > 0) now.moved_sigmas = std::max(now.moved_sigmas, std::abs(moved[axis]) / (*sigma)[axis]);
}

}  // namespace

ImagesByFile images_by_file(const Block& block) {
  ImagesByFile images;
  for (const auto& [id, image] : block.images) images[image.file] = id;
  return images;
}

FeatureNow feature_now(const DrawnFeature& drawn, VertexPlotter& plotter, const ImagesByFile& images) {
  FeatureNow now{.vertices = drawn.vertices, .kept = {}};
  for (std::size_t i = 0; i < drawn.vertices.size(); ++i) {
    if (!is_by_marks(drawn.vertices[i])) continue;
    auto vertex = computed(drawn.vertices[i], plotter, images);
    if (!vertex) {
      now.kept.push_back({i, vertex.error().message});
      continue;
    }
    ++now.computed;
    add_move(drawn.vertices[i], *vertex, now);
    now.vertices[i] = *std::move(vertex);
  }
  return now;
}

Result<DrawingNow> DrawingComputer::drawing_now(const Drawing& drawn, const MakePlotter& make_plotter,
                                                const ImagesByFile& images) {
  DrawingNow now{drawn, {}};
  VertexPlotter* plotter = nullptr;
  std::map<std::string, Known> known;
  for (const DrawnFeature& feature : drawn.features) {
    if (std::ranges::none_of(feature.vertices, is_by_marks)) continue;
    auto its = known_.extract(feature.id);
    if (its.empty() || its.mapped().drawn != feature.vertices) {
      if (!plotter) {
        COLLINEA_TRY(plotter, make_plotter());
      }
      known.emplace(feature.id, Known{feature.vertices, feature_now(feature, *plotter, images)});
    } else {
      known.insert(std::move(its));
    }
    const FeatureNow& computed_now = known.at(feature.id).now;
    now.drawing.features.find(feature.id)->vertices = computed_now.vertices;
    now.features.emplace(feature.id, computed_now);
  }
  known_ = std::move(known);
  return now;
}

}  // namespace collinea
