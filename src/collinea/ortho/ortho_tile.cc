// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/ortho_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace collinea {
namespace {

// A multiple of the block, larger than what labels and weights look at around a cell.
constexpr int kMargin = 3 * OrthoPatch::kBlock;
static_assert(kMargin > kSeamReach);
constexpr int kFarthestOccluder = 2048;  // [surface cells]

struct Area {
  int column, row, width, height;  // cells of a grid
};

struct HeightRange {
  float low_m = std::numeric_limits<float>::infinity(), high_m = -std::numeric_limits<float>::infinity();
  [[nodiscard]] bool empty() const { return !(low_m <= high_m); }
};

Area patch_area(int column, int row, int width, int height) {
  constexpr int kBlock = OrthoPatch::kBlock;
  const auto whole = [](int cells) { return (cells + kBlock - 1) / kBlock * kBlock; };
  return {column - kMargin, row - kMargin, whole(width) + 2 * kMargin, whole(height) + 2 * kMargin};
}

// The part of the surface under an area of the orthophoto, with a margin, cut at the border of the raster.
Area surface_area(const OrthoScene& scene, const Area& area, int margin) {
  const MapGrid &from = scene.grid, &to = scene.surface->grid;
  const auto column = [&](double c) { return (from.east_of(c) - to.west_m) / to.cell_m; };
  const auto row = [&](double r) { return (to.north_m - from.north_of(r)) / to.cell_m; };
  const int left = std::clamp(int(std::floor(column(area.column))) - margin, 0, to.width);
  const int right = std::clamp(int(std::ceil(column(area.column + area.width))) + margin, 0, to.width);
  const int top = std::clamp(int(std::floor(row(area.row))) - margin, 0, to.height);
  const int bottom = std::clamp(int(std::ceil(row(area.row + area.height))) + margin, 0, to.height);
  return {left, top, right - left, bottom - top};
}

template <class Visit>
void each_block(const HeightOverview& overview, const Area& surface, Visit&& visit) {
  constexpr int kBlock = HeightOverview::kBlock;
  if (surface.width <= 0 || surface.height <= 0) return;
  for (int y = surface.row / kBlock; y <= (surface.row + surface.height - 1) / kBlock; ++y)
    for (int x = surface.column / kBlock; x <= (surface.column + surface.width - 1) / kBlock; ++x)
      if (!std::isnan(overview.highest_m.at(x, y))) visit(x, y);
}

HeightRange heights_under(const HeightOverview& overview, const Area& surface) {
  HeightRange range;
  each_block(overview, surface, [&](int x, int y) {
    range.low_m = std::min(range.low_m, overview.lowest_m.at(x, y));
    range.high_m = std::max(range.high_m, overview.highest_m.at(x, y));
  });
  return range;
}

// Views that show something of the patch, by a coarse look at 5 x 5 places, lowest and highest.
std::vector<std::size_t> views_over(const OrthoScene& scene, const WorldLattice& lattice, const Area& area,
                                    const HeightRange& range) {
  std::vector<std::size_t> found;
  const double stride_cells = std::max(area.width, area.height) / 4.0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    bool shows = false;
    for (int place = 0; place < 50 && !shows; ++place) {
      const double x = area.width * (place % 5) / 4.0, y = area.height * (place / 5 % 5) / 4.0;
      const Eigen::Vector3d at = lattice.at(x, y, double(place < 25 ? range.low_m : range.high_m));
      const auto pixel = pixel_of(view, at);
      if (!pixel) continue;
      const double distance_m = (view.centre_in_world - at).norm();
      const double slack_px = stride_cells * scene.grid.cell_m / distance_m * view.camera.focal_px();
      shows = pixel->x() > -slack_px && pixel->y() > -slack_px && pixel->x() < view.camera.width_px + slack_px &&
              pixel->y() < view.camera.height_px + slack_px;
    }
    if (shows) found.push_back(v);
  }
  return found;
}

// How far away something could stand that hides a cell of the area from one of the views [surface cells].
int occluder_reach(const OrthoScene& scene, const std::vector<std::size_t>& views, const WorldLattice& lattice,
                   const Area& area, const HeightRange& range) {
  double flattest = 0;  // largest run per rise
  for (const std::size_t v : views) {
    for (int corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3d at =
          lattice.at(corner & 1 ? area.width : 0, corner & 2 ? area.height : 0, double(range.low_m));
      const Eigen::Vector3d up = scene.views[v].centre_in_world - at;
      flattest = std::max(flattest, up.z() > 0 ? std::min(std::hypot(up.x(), up.y()) / up.z(), 10.0) : 0.0);
    }
  }
  const double cell_m = scene.surface->grid.cell_m;
  const Area near = surface_area(scene, area, 0), far = surface_area(scene, area, kFarthestOccluder);
  constexpr int kBlock = HeightOverview::kBlock;
  int reach = 0;
  each_block(*scene.surface_overview, far, [&](int x, int y) {
    const int dx = std::max({0, near.column - (x + 1) * kBlock, x * kBlock - near.column - near.width});
    const int dy = std::max({0, near.row - (y + 1) * kBlock, y * kBlock - near.row - near.height});
    const int distance = std::max(dx, dy);
    const double casts = double(scene.surface_overview->highest_m.at(x, y) - range.low_m) * flattest / cell_m;
    if (distance < casts) reach = std::max(reach, std::min(distance + kBlock, int(casts) + 1));
  });
  return reach + 2;
}

FloatImage heights_of(const OrthoPatch& patch, const Area& area) {
  FloatImage heights_m(area.width, area.height);
  for (int y = 0; y < area.height; ++y) {
    const double v = patch.surface_y(patch.grid.north_of(area.row + y + 0.5));
    for (int x = 0; x < area.width; ++x)
      heights_m.at(x, y) = patch.surface.at(patch.surface_x(patch.grid.east_of(area.column + x + 0.5)), v);
  }
  return heights_m;
}

struct Mixture {
  FloatImage colour;  // 3 channels, times weight
  FloatImage weight;
};

struct Source {
  const View& view;
  const Exposure& exposure;
  const ColourImage& picture;
};

void add_cell(const OrthoPatch& patch, const Source& source, int x, int y, float weight, Mixture& mixture) {
  const auto pixel = pixel_of(source.view, patch.world_at(x, y));
  if (!pixel) return;
  float colour[3];
  bicubic(source.picture, pixel->x() * source.picture.width / source.view.camera.width_px,
          pixel->y() * source.picture.height / source.view.camera.height_px, colour);
  const auto r2 = float(relative_radius2(source.view.camera, *pixel));
  float* sum = mixture.colour.row(y) + 3 * x;
  for (std::size_t c = 0; c < 3; ++c) {
    const float falloff = source.exposure.falloff[c];
    sum[c] += weight * colour[c] * source.exposure.gain[c] * (falloff == 0 ? 1 : std::exp(falloff * r2));
  }
  mixture.weight.at(x, y) += weight;
}

void add_view(const OrthoPatch& patch, const Source& source, const ViewWeights& weights, const Area& wanted,
              Mixture& mixture) {
  const int left = std::max(weights.column, wanted.column), top = std::max(weights.row, wanted.row);
  const int right = std::min(weights.column + weights.weight.width, wanted.column + wanted.width);
  const int bottom = std::min(weights.row + weights.weight.height, wanted.row + wanted.height);
  for (int y = top; y < bottom; ++y) {
    const float* weight = weights.weight.row(y - weights.row) - weights.column;
    for (int x = left; x < right; ++x)
      if (weight[x] > 0 && !std::isnan(patch.heights_m.at(x, y))) add_cell(patch, source, x, y, weight[x], mixture);
  }
}

std::vector<std::int16_t> used_labels(const Labels& labels, const Area& wanted, int around) {
  std::vector<std::int16_t> used;
  for (int y = std::max(0, wanted.row - around); y < std::min(labels.height, wanted.row + wanted.height + around);
       ++y) {
    std::int16_t last = kNoView;
    for (int x = std::max(0, wanted.column - around); x < std::min(labels.width, wanted.column + wanted.width + around);
         ++x) {
      const std::int16_t label = labels.at(x, y);
      if (label == last || label == kNoView) continue;
      last = label;
      if (std::find(used.begin(), used.end(), label) == used.end()) used.push_back(label);
    }
  }
  std::sort(used.begin(), used.end());
  return used;
}

OrthoTile finished(const Mixture& mixture, const Labels& labels, const std::vector<std::size_t>& views,
                   const Area& wanted) {
  OrthoTile tile{Raster<std::uint8_t>(wanted.width, wanted.height, 4),
                 Raster<std::uint16_t>(wanted.width, wanted.height)};
  for (int y = 0; y < wanted.height; ++y) {
    for (int x = 0; x < wanted.width; ++x) {
      const int u = wanted.column + x, v = wanted.row + y;
      const float weight = mixture.weight.at(u, v);
      const std::int16_t label = labels.at(u, v);
      if (label == kNoView || !(weight > 0)) continue;
      for (int c = 0; c < 3; ++c)
        tile.rgba.at(x, y, c) =
            std::uint8_t(std::lround(std::clamp(mixture.colour.at(u, v, c) / weight, 0.0f, 255.0f)));
      tile.rgba.at(x, y, 3) = 255;
      tile.source.at(x, y) = std::uint16_t(views[std::size_t(label)] + 1);
    }
  }
  return tile;
}

// The patch with its heights; nothing where there are none or no view shows anything.
Result<std::optional<OrthoPatch>> make_patch(const OrthoScene& scene, const Area& area,
                                             std::vector<std::size_t>& views) {
  HeightRange range = heights_under(*scene.surface_overview, surface_area(scene, area, 1));
  if (range.empty()) return std::nullopt;
  OrthoPatch patch{scene.grid,
                   area.column,
                   area.row,
                   {},
                   WorldLattice(scene.frame, scene.grid, area.column, area.row, area.width, area.height,
                                double(range.low_m), double(range.high_m)),
                   {},
                   scene.surface->grid};
  views = views_over(scene, patch.lattice, area, range);
  if (views.empty()) return std::nullopt;
  const Area window = surface_area(scene, area, occluder_reach(scene, views, patch.lattice, area, range));
  if (window.width <= 0 || window.height <= 0) return std::nullopt;
  COLLINEA_TRY(FloatImage heights, scene.surface->read(window.column, window.row, window.width, window.height));
  FloatImage sigmas;
  if (scene.surface->read_sigma) {
    COLLINEA_TRY(sigmas, scene.surface->read_sigma(window.column, window.row, window.width, window.height));
  }
  patch.surface = HeightWindow(std::move(heights), window.column, window.row, scene.surface->grid.cell_m, sigmas);
  patch.heights_m = heights_of(patch, area);
  return patch;
}

}  // namespace

void bicubic(const ColourImage& picture, double x, double y, float colour[3]) {
  const double u = std::floor(x - 0.5), v = std::floor(y - 0.5);
  const auto weights = [](float t, float w[4]) {
    w[0] = ((-0.5f * t + 1) * t - 0.5f) * t;
    w[1] = (1.5f * t - 2.5f) * t * t + 1;
    w[2] = ((-1.5f * t + 2) * t + 0.5f) * t;
    w[3] = (0.5f * t - 0.5f) * t * t;
  };
  float across[4], down[4];
  weights(float(x - 0.5 - u), across);
  weights(float(y - 0.5 - v), down);
  const int left = int(u) - 1, top = int(v) - 1;
  int offset[4];
  for (int i = 0; i < 4; ++i) offset[i] = 3 * std::clamp(left + i, 0, picture.width - 1);
  colour[0] = colour[1] = colour[2] = 0;
  for (int j = 0; j < 4; ++j) {
    const std::uint8_t* row = picture.row(std::clamp(top + j, 0, picture.height - 1));
    float sum[3] = {0, 0, 0};
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c) sum[c] += across[i] * float(row[offset[i] + c]);
    for (int c = 0; c < 3; ++c) colour[c] += down[j] * sum[c];
  }
}

Result<OrthoTile> make_ortho_tile(const OrthoScene& scene, int column, int row, int width, int height, const Run& run) {
  COLLINEA_CHECK(column % OrthoPatch::kBlock == 0 && row % OrthoPatch::kBlock == 0);
  const Area area = patch_area(column, row, width, height), wanted{kMargin, kMargin, width, height};
  std::vector<std::size_t> over;
  COLLINEA_TRY(const std::optional<OrthoPatch> patch, make_patch(scene, area, over));
  if (!patch) return OrthoTile{Raster<std::uint8_t>(width, height, 4), Raster<std::uint16_t>(width, height)};
  std::vector<const View*> views;
  for (const std::size_t v : over) views.push_back(&scene.views[v]);
  // Roof edges of the surface model are good to about a cell; one more for the reach of the interpolation in the
  // picture.
  const int rim_cells = 1 + int(std::ceil(1.5 * scene.surface->grid.cell_m / scene.grid.cell_m));
  Visibility visibility(*patch, views, rim_cells);
  const Labels labels = choose_views(*patch, views, visibility);
  Mixture mixture{FloatImage(area.width, area.height, 3), FloatImage(area.width, area.height)};
  for (const std::int16_t label : used_labels(labels, wanted, scene.feather_cells)) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const std::size_t v = over[std::size_t(label)];
    const ViewWeights weights = weights_of(labels, label, scene.feather_cells, visibility);
    COLLINEA_TRY(const auto picture, scene.pictures->picture(scene.views[v].image, scene.shrink[v]));
    add_view(*patch, {scene.views[v], scene.exposures[v], *picture}, weights, wanted, mixture);
  }
  return finished(mixture, labels, over, wanted);
}

}  // namespace collinea
