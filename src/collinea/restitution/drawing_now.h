// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "collinea/restitution/plotted_vertex.h"

namespace collinea {

/// Numbers of images by their files.
using ImagesByFile = std::map<std::string, ImageId>;
[[nodiscard]] ImagesByFile images_by_file(const Block& block);

/// A feature whose vertices that have marks were computed anew by them, in the block as it is adjusted now.
struct FeatureNow {
  struct Kept {
    std::size_t vertex = 0;  ///< from 0
    std::string why;
  };
  std::vector<DrawnVertex> vertices;
  std::size_t computed = 0;  ///< vertices
  double moved_m = 0;        ///< the largest distance from where one was drawn
  double moved_sigmas =
      0;                   ///< the largest difference of a coordinate, in its standard deviation as drawn (else as now)
  std::vector<Kept> kept;  ///< that have marks, but can no longer be computed: they are as they were drawn
};
[[nodiscard]] FeatureNow feature_now(const DrawnFeature& drawn, VertexPlotter& plotter, const ImagesByFile& images);

/// A drawing by the adjustment that is in force. What people drew stays in the journal as they did; this follows from
/// it and from the block, and is made anew whenever one of them changes.
struct DrawingNow {
  Drawing drawing;
  std::map<std::string, FeatureNow> features;  ///< those with marks, by their ids; their vertices are in the drawing
};

/// Features that were computed so far in one block and on one surface: those that were not edited since are not
/// computed again.
class DrawingComputer {
 public:
  using MakePlotter = std::function<Result<VertexPlotter*>()>;
  /// `plotter` is asked for when the first feature is to be computed. Errors: those of it.
  [[nodiscard]] Result<DrawingNow> drawing_now(const Drawing& drawn, const MakePlotter& plotter,
                                               const ImagesByFile& images);

 private:
  struct Known {
    std::vector<DrawnVertex> drawn;
    FeatureNow now;
  };
  std::map<std::string, Known> known_;
};

}  // namespace collinea
