// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/drawn_vertex.h"

namespace collinea {

DrawnVertex drawn_vertex(VertexPlotter& plotter, const AskedVertex& asked, const PlottedVertex& plotted,
                         const Block& block) {
  if (const auto* repeated = std::get_if<RepeatedVertex>(&asked)) return repeated->vertex;
  DrawnVertex drawn{
      .position = plotted.position, .covariance_m2 = plotter.covariance_in_map(plotted), .source = plotted.source};
  if (const auto* marked = std::get_if<MarkedVertex>(&asked))
    for (const ImageMark& mark : marked->marks)
      drawn.marks.push_back({block.images.at(mark.image).file, mark.pixel, mark.sigma_px});
  return drawn;
}

RepeatedVertex repeated_vertex(const DrawnVertex& vertex, const Block& block) {
  RepeatedVertex repeated{vertex};
  for (const VertexMark& mark : vertex.marks)
    for (const auto& [id, image] : block.images)
      if (image.file == mark.image) repeated.marks.push_back({id, mark.pixel, mark.sigma_px});
  return repeated;
}

}  // namespace collinea
