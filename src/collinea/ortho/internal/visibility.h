// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collinea/ortho/occluders.h"
#include "collinea/ortho/world_lattice.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A piece of an orthophoto in the making: heights of its cells and how to get from them to the world and to the
/// surface.
struct OrthoPatch {
  static constexpr int kBlock = 16;  ///< the patch starts at a multiple of it and is a whole number of blocks

  MapGrid grid;             ///< of the whole orthophoto
  int column = 0, row = 0;  ///< of the patch in the grid; may be negative
  FloatImage heights_m;     ///< NaN: no height
  WorldLattice lattice;
  Occluders occluders;
  MapGrid surface_grid;

  [[nodiscard]] int blocks_across() const { return heights_m.width / kBlock; }
  [[nodiscard]] int blocks_down() const { return heights_m.height / kBlock; }
  /// Continuous cells of the window of the occluders, of a map position.
  [[nodiscard]] double surface_x(double east_m) const { return surface_grid.column_of(east_m) - occluders.column(); }
  [[nodiscard]] double surface_y(double north_m) const { return surface_grid.row_of(north_m) - occluders.row(); }
  [[nodiscard]] Eigen::Vector3d world_at(int x, int y) const {
    return lattice.at(x + 0.5, y + 0.5, double(heights_m.at(x, y)));
  }
};

/// How far from hidden areas an orthophoto of such cells counts as hidden, too: roof edges of a surface model are good
/// to about a cell; one cell of the orthophoto more for the reach of the interpolation in the image.
[[nodiscard]] double rim_m(const HeightField& surface, double cell_m);

/// Which cells of a patch are on which images, and not hidden by the surface. Worked out block by block when asked
/// for; a block that certainly is seen as a whole costs next to nothing.
class Visibility {
 public:
  /// A cell counts as hidden when any cell within `edge_cells` of it is: the surface model is not exact at the edges of
  /// roofs.
  Visibility(const OrthoPatch& patch, std::vector<const View*> views, int edge_cells);

  /// `view`: index into the views. Cells without height are seen by nobody.
  [[nodiscard]] bool sees(int view, int x, int y);
  /// As sees(), but a few hidden cells along the border do not count (artefacts of an edge), as long as the next
  /// neighbours are seen: better than nothing where no view sees a cell well. Along the border of a larger hidden area
  /// it is no help.
  [[nodiscard]] bool sees_barely(int view, int x, int y);
  /// True when only small things stand between the view and a cell (Occluders::wide_ones_hide), and its line
  /// of sight passes wide ones at two cells or more. Points beside walls are not seen by this rule either.
  [[nodiscard]] bool sees_past_small_things(int view, int x, int y) const;
  /// True when the view sees all cells of a block that have a height.
  [[nodiscard]] bool sees_block(int view, int block_x, int block_y) {
    return final_state(std::size_t(view), block_x, block_y) == State::kAll;
  }

 private:
  enum class State : std::uint8_t { kUnknown, kAll, kMask };
  /// A bit for each cell of a patch, in those of its blocks in which any was set: dozens of views may need some.
  class Mask {
   public:
    Mask() = default;
    Mask(int blocks_across, int blocks_down)
        : across_(blocks_across), first_row_(std::size_t(blocks_across * blocks_down), kNone) {}
    [[nodiscard]] bool empty() const { return first_row_.empty(); }
    /// Whether a cell is set, of a block in which any is.
    [[nodiscard]] bool at(int x, int y) const {
      return rows_[first_row_[block_of(x, y)] + std::uint32_t(y % OrthoPatch::kBlock)] >> (x % OrthoPatch::kBlock) & 1;
    }
    void set(int x, int y, bool value) {
      std::uint32_t& first = first_row_[block_of(x, y)];
      if (first == kNone) {
        first = std::uint32_t(rows_.size());
        rows_.resize(rows_.size() + OrthoPatch::kBlock);
      }
      std::uint16_t& row = rows_[first + std::uint32_t(y % OrthoPatch::kBlock)];
      const auto bit = std::uint16_t(1 << (x % OrthoPatch::kBlock));
      row = std::uint16_t(value ? row | bit : row & ~bit);
    }

   private:
    static_assert(OrthoPatch::kBlock == 16);
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    [[nodiscard]] std::size_t block_of(int x, int y) const {
      return std::size_t(y / OrthoPatch::kBlock * across_ + x / OrthoPatch::kBlock);
    }
    int across_ = 0;
    std::vector<std::uint32_t> first_row_;
    std::vector<std::uint16_t> rows_;  // 16 bits each
  };
  struct Layer {
    std::vector<State> raw, final;  // per block
    std::vector<State> imaged;      // per block: kAll where it is on the image as a whole
    Mask raw_mask, final_mask;
  };

  [[nodiscard]] bool on_image(std::size_t view, int x, int y) const;
  [[nodiscard]] bool hidden(const View& view, int x, int y) const;
  [[nodiscard]] bool whole_block_on_image(const View& view, int block_x, int block_y) const;
  [[nodiscard]] bool clear_towards(const View& view, int block_x, int block_y, float low_m, float high_m) const;
  int hidden_around(std::size_t view, int x, int y, int radius);
  State raw_state(std::size_t view, int block_x, int block_y);
  State final_state(std::size_t view, int block_x, int block_y);
  void make_final_mask(Layer& layer, int block_x, int block_y) const;

  const OrthoPatch& patch_;
  std::vector<const View*> views_;
  int edge_cells_;
  std::vector<Layer> layers_;
  FloatImage block_low_, block_high_;  // NaN: no heights
};

}  // namespace collinea
