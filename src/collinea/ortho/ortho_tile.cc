// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/ortho_tile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/ortho/internal/seam_plan.h"

namespace collinea {
namespace {

// A multiple of the block, larger than what labels and weights look at around a cell.
constexpr int kMargin = kOrthoTileReach;
static_assert(kMargin % OrthoPatch::kBlock == 0 && kMargin > kSeamReach);

CellArea patch_area(int column, int row, int width, int height) {
  constexpr int kBlock = OrthoPatch::kBlock;
  const auto whole = [](int cells) { return (cells + kBlock - 1) / kBlock * kBlock; };
  return {column - kMargin, row - kMargin, whole(width) + 2 * kMargin, whole(height) + 2 * kMargin};
}

// What the plan says, in indices of the views over the patch.
WantedViews wanted_views(const OrthoScene& scene, const CellArea& area, const std::vector<std::size_t>& over) {
  if (!scene.seams) return {};
  std::vector<std::int16_t> label_of(scene.views.size() + 1, kNoView);
  for (std::size_t i = 0; i < over.size(); ++i) label_of[over[i] + 1] = std::int16_t(i);
  const SeamPlan::Part part = scene.seams->part(scene.grid, area);
  WantedViews wanted{Labels(area.width, area.height), Labels(area.width, area.height)};
  for (std::size_t i = 0; i < part.source.data.size(); ++i) {
    wanted.first.data[i] = label_of[part.source.data[i]];
    wanted.next.data[i] = label_of[part.below.data[i]];
  }
  return wanted;
}

// The colours mixed so far, of the cells of the tile.
struct Mixture {
  CellArea cells;     // in the patch
  FloatImage colour;  // 3 channels, times weight
  FloatImage weight;
};

struct Source {
  const ColourBalance& balance;
  std::size_t index;
  const View& view;
  const ColourImage& image;
};

bool colour_at(const OrthoPatch& patch, const Source& source, int x, int y, float colour[3]) {
  const Eigen::Vector3d position = patch.world_at(x, y);
  const auto pixel = pixel_of(source.view, position);
  if (!pixel) return false;
  bicubic(source.image, pixel->x() * source.image.width / source.view.camera.width_px,
          pixel->y() * source.image.height / source.view.camera.height_px, colour);
  const auto factor = source.balance.factor(source.index, source.view, position, *pixel);
  for (std::size_t c = 0; c < 3; ++c) colour[c] *= factor[c];
  return true;
}

void add_cell(const OrthoPatch& patch, const Source& source, int x, int y, float weight, Mixture& mixture) {
  float colour[3];
  if (!colour_at(patch, source, x, y, colour)) return;
  const int u = x - mixture.cells.column, v = y - mixture.cells.row;
  float* sum = mixture.colour.row(v) + 3 * u;
  for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * colour[c];
  mixture.weight.at(u, v) += weight;
}

// A side between two cells of different views, and what each of the views shows in the two, summed.
struct SeamSide {
  int x, y, u, v;
  std::int16_t view[2];
  float colour[2][3] = {{0, 0, 0}, {0, 0, 0}};
  bool known[2] = {false, false};
};

// Only those that both views see: elsewhere they show different things.
std::vector<SeamSide> seam_sides(const Labels& labels, const CellArea& wanted, Visibility& visibility) {
  std::vector<SeamSide> sides;
  for (int y = wanted.row; y < wanted.row + wanted.height; ++y) {
    for (int x = wanted.column; x < wanted.column + wanted.width; ++x) {
      const std::int16_t own = labels.at(x, y);
      if (own == kNoView) continue;
      for (const auto& [u, v] : {std::pair(x + 1, y), std::pair(x, y + 1)}) {
        const std::int16_t other = labels.at(u, v);
        if (other == kNoView || other == own) continue;
        if (!visibility.sees(own, u, v) || !visibility.sees(other, x, y) || !visibility.sees(own, x, y) ||
            !visibility.sees(other, u, v))
          continue;
        sides.push_back({x, y, u, v, {std::min(own, other), std::max(own, other)}});
      }
    }
  }
  return sides;
}

void look_along_seams(const OrthoPatch& patch, const Source& source, std::int16_t view, std::vector<SeamSide>& sides) {
  for (SeamSide& side : sides) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (side.view[k] != view) continue;
      float here[3], there[3];
      side.known[k] = colour_at(patch, source, side.x, side.y, here) && colour_at(patch, source, side.u, side.v, there);
      if (!side.known[k]) continue;
      for (std::size_t c = 0; c < 3; ++c) side.colour[k][c] = (here[c] + there[c]) / 2;
    }
  }
}

SeamAgreement agreement_of(const std::vector<SeamSide>& sides, const std::vector<std::size_t>& views) {
  SeamAgreement agreement;
  for (const SeamSide& side : sides) {
    if (!side.known[0] || !side.known[1]) continue;
    double apart = 0, step = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = double(side.colour[1][c]) - double(side.colour[0][c]);
      apart += std::abs(difference) / 3, step += difference / 3;
    }
    ++agreement.sides;
    agreement.difference_grey += apart;
    auto& pair = agreement.steps[{views[std::size_t(side.view[0])], views[std::size_t(side.view[1])]}];
    ++pair.sides;
    pair.grey_levels += step;
  }
  return agreement;
}

void add_view(const OrthoPatch& patch, const Source& source, const ViewWeights& weights, Mixture& mixture) {
  const CellArea& wanted = mixture.cells;
  const int left = std::max(weights.column, wanted.column), top = std::max(weights.row, wanted.row);
  const int right = std::min(weights.column + weights.weight.width, wanted.column + wanted.width);
  const int bottom = std::min(weights.row + weights.weight.height, wanted.row + wanted.height);
  for (int y = top; y < bottom; ++y) {
    const float* weight = weights.weight.row(y - weights.row) - weights.column;
    for (int x = left; x < right; ++x)
      if (weight[x] > 0 && !std::isnan(patch.heights_m.at(x, y))) add_cell(patch, source, x, y, weight[x], mixture);
  }
}

std::vector<std::int16_t> used_labels(const Labels& labels, const CellArea& wanted, int around) {
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

// The cells that could not be taken from the view they were to be taken from, by views.
std::map<std::size_t, std::uint64_t> not_followed(const OrthoScene& scene, const CellArea& tile,
                                                  const Raster<std::uint16_t>& made) {
  std::map<std::size_t, std::uint64_t> cells;
  if (!scene.seams) return cells;
  const Raster<std::uint16_t> asked = scene.seams->part(scene.grid, tile).source;
  for (std::size_t i = 0; i < made.data.size(); ++i)
    if (made.data[i] != 0 && asked.data[i] != 0 && asked.data[i] != made.data[i]) ++cells[asked.data[i] - 1u];
  return cells;
}

OrthoTile finished(const Mixture& mixture, const Labels& labels, const std::vector<std::size_t>& views) {
  const CellArea& wanted = mixture.cells;
  OrthoTile tile{
      Raster<std::uint8_t>(wanted.width, wanted.height, 4), Raster<std::uint16_t>(wanted.width, wanted.height), {}};
  for (int y = 0; y < wanted.height; ++y) {
    for (int x = 0; x < wanted.width; ++x) {
      const int u = wanted.column + x, v = wanted.row + y;
      const float weight = mixture.weight.at(x, y);
      const std::int16_t label = labels.at(u, v);
      if (label == kNoView || !(weight > 0)) continue;
      for (int c = 0; c < 3; ++c)
        tile.rgba.at(x, y, c) =
            std::uint8_t(std::lround(std::clamp(mixture.colour.at(x, y, c) / weight, 0.0f, 255.0f)));
      tile.rgba.at(x, y, 3) = 255;
      tile.source.at(x, y) = std::uint16_t(views[std::size_t(label)] + 1);
    }
  }
  return tile;
}

}  // namespace

void SeamAgreement::add(const SeamAgreement& other) {
  sides += other.sides;
  difference_grey += other.difference_grey;
  for (const auto& [views, step] : other.steps) {
    auto& sum = steps[views];
    sum.sides += step.sides;
    sum.grey_levels += step.grey_levels;
  }
}

void bicubic(const ColourImage& image, double x, double y, float colour[3]) {
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
  for (int i = 0; i < 4; ++i) offset[i] = 3 * std::clamp(left + i, 0, image.width - 1);
  colour[0] = colour[1] = colour[2] = 0;
  for (int j = 0; j < 4; ++j) {
    const std::uint8_t* row = image.row(std::clamp(top + j, 0, image.height - 1));
    float sum[3] = {0, 0, 0};
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c) sum[c] += across[i] * float(row[offset[i] + c]);
    for (int c = 0; c < 3; ++c) colour[c] += down[j] * sum[c];
  }
}

Result<OrthoTile> make_ortho_tile(const OrthoScene& scene, int column, int row, int width, int height, const Run& run) {
  COLLINEA_CHECK(column % OrthoPatch::kBlock == 0 && row % OrthoPatch::kBlock == 0);
  const CellArea area = patch_area(column, row, width, height), wanted{kMargin, kMargin, width, height};
  std::vector<std::size_t> over;
  COLLINEA_TRY(const std::optional<OrthoPatch> patch, make_patch(scene, area, over));
  if (!patch) return OrthoTile{Raster<std::uint8_t>(width, height, 4), Raster<std::uint16_t>(width, height), {}, {}};
  std::vector<const View*> views;
  for (const std::size_t v : over) views.push_back(&scene.views[v]);
  Visibility visibility(*patch, views, int(std::lround(rim_m(*scene.surface, scene.grid.cell_m) / scene.grid.cell_m)));
  const Labels labels = choose_views(*patch, views, wanted_views(scene, area, over), visibility);
  std::vector<SeamSide> sides = seam_sides(labels, wanted, visibility);
  Mixture mixture{wanted, FloatImage(width, height, 3), FloatImage(width, height)};
  for (const std::int16_t label : used_labels(labels, wanted, scene.feather_cells)) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const std::size_t v = over[std::size_t(label)];
    const ViewWeights weights = weights_of(labels, label, scene.feather_cells, visibility);
    COLLINEA_TRY(const auto image, scene.images->image_of(scene.views[v].image, scene.shrink[v]));
    const Source source{scene.balance, v, scene.views[v], *image};
    add_view(*patch, source, weights, mixture);
    look_along_seams(*patch, source, label, sides);
  }
  OrthoTile tile = finished(mixture, labels, over);
  tile.seams = agreement_of(sides, over);
  tile.not_followed = not_followed(scene, {column, row, width, height}, tile.source);
  return tile;
}

}  // namespace collinea
