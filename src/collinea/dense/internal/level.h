// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/base/shared_budget.h"
#include "collinea/dense/internal/labels.h"
#include "collinea/dense/internal/match_kernels.h"

namespace collinea::dense {

/// One neighbour as the reference image of a level sees it.
struct View {
  Quads quads;
  Transfer transfer;
  Eigen::Vector3f centre_in_cam = Eigen::Vector3f::Zero();  ///< of projection, in the reference camera
};

/// An image and its neighbours at one level of the pyramid. Its views are in one of three states:
/// all have quads: for match_level() and refine();
/// all have empty ones: an outline, for what asks for geometry and step alone (quads take most of a level's memory);
/// there are none any more: a level that has been measured, for what looks at its image and step.
struct Level {
  const GreyImage* image = nullptr;
  std::vector<View> views;
  float focal_px = 1, cx = 0, cy = 0;  ///< of the reference image
  float step = 0;                      ///< inverse depth per label
  float parallax_px = 1;               ///< of one label, in the neighbours that see most of it
};

/// A cell of the reference image and the views that may show it, ready for comparison. Large: keep one per thread.
struct CellScene {
  int left = 0, top = 0;
  alignas(64) std::array<float, kRegion> inverse_depth{};
  std::vector<int> views;  ///< indices into Level::views
  std::vector<Carried> carried;
};

/// Fills in the views that can see the cell somewhere between `low` and `high` beyond scene.inverse_depth.
void locate_views(const Level& level, float low, float high, CellScene& scene);

/// Multi-view matching of the whole image: census costs (Zabih and Woodfill 1994, opposite pixels compared), the
/// better half of the views (Kang et al. 2001), semi-global aggregation in tiles, best label. Inverse depth per pixel;
/// NaN where the image is empty; everything else gets a value, right or wrong. Result is not to be used when
/// run.stopped(). Costs of all labels of a tile are in memory together: what they take is taken from `costs`.
[[nodiscard]] FloatImage match_level(const Level& level, const Labels& labels, SharedBudget& costs, const Run& run);

/// The bytes a tile takes where the coarser level is smooth, as it is of most ground: 39 MB. At most it is twelve times
/// that.
[[nodiscard]] std::size_t usual_bytes_to_match();

/// The surface measured again, pixel by pixel, by correlation of windows that follow it (7 x 7).
struct Refined {
  FloatImage inverse_depth;  ///< NaN where nothing can be measured
  FloatImage sigma;          ///< of the inverse depth, from noise and texture
  FloatImage correlation;    ///< weighted mean over the views that agree
};
/// `surface`: inverse depths without NaN. Searched: half a step before and behind when `near`, else a whole one.
[[nodiscard]] Refined refine(const Level& level, const FloatImage& surface, bool near, const Run& run);

/// Mean over the 5 x 5 pixels whose inverse depth is within `reach` of that in the middle; NaN stay.
[[nodiscard]] FloatImage smoothed_within(const FloatImage& surface, float reach);

/// Empties connected patches of fewer than `min_pixels`. Neighbours belong together when they differ by at most `reach`
/// plus, when `sigma` is given, twice the standard deviations of both.
void remove_speckles(FloatImage& surface, float reach, int min_pixels, const FloatImage* sigma = nullptr);

}  // namespace collinea::dense
