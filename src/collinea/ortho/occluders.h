// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collinea/surface/height_field.h"

namespace collinea {

/// Blocks of HeightOverview::kBlock cells of a surface.
struct SurfaceBlocks {
  int column = 0, row = 0;      ///< of the first [blocks]
  Raster<std::uint8_t> wanted;  ///< one for each block; not 0: it is meant
};

/// What may hide points of an area from cameras: the surface around, no higher than it certainly is. Positions are
/// continuous cells of the window that is held in full: the centre of its upper-left cell is (0.5, 0.5).
///
/// Around a point (kNear cells) lines of sight are followed in cells of the surface, beyond in cells kCoarse times as
/// large, fixed to its raster, that are as high as the highest within. What hides from there rises by more than a line
/// of sight does on kNear cells: mountains and towers, which get wider by less than kCoarse cells, a hundredth of their
/// distance. So memory stays small however far one must look. The answers depend on the point and the surface only, not
/// on the window, as long as this reaches far enough (occluders_of).
class Occluders {
 public:
  Occluders() = default;
  /// Nothing but a window, in full. `column`, `row`: of the upper-left cell of `heights_m` in the field. `sigma_m`: of
  /// the heights, or empty.
  Occluders(FloatImage heights_m, int column, int row, double cell_m, const FloatImage& sigma_m = {});

  [[nodiscard]] int column() const { return column_; }
  [[nodiscard]] int row() const { return row_; }

  /// True when the surface rises above the straight line from the point at height_m (on it or above) towards a camera
  /// at (camera_x, camera_y, camera_height_m), also when it is three of its sigmas lower (but no more than ten cells).
  /// One cell of height is granted to roughness. Cells without height hide nothing.
  [[nodiscard]] bool hide(double x, double y, double height_m, double camera_x, double camera_y,
                          double camera_height_m) const {
    return hide<false>(x, y, height_m, camera_x, camera_y, camera_height_m);
  }

  /// The same, but only what is more than 2 kThin cells wide both ways hides: not the twigs of a tree, nor single
  /// high cells.
  [[nodiscard]] bool wide_ones_hide(double x, double y, double height_m, double camera_x, double camera_y,
                                    double camera_height_m) const {
    return hide<true>(x, y, height_m, camera_x, camera_y, camera_height_m);
  }
  static constexpr int kThin = 2;

  /// The greatest height at which any cell no further than kCeilingReach cells from the point hides something, or more.
  [[nodiscard]] float ceiling_m(double x, double y) const;
  static constexpr int kCeilingReach = 16;
  /// The greatest of all.
  [[nodiscard]] float highest_m() const { return highest_m_; }

  static constexpr int kNear = 256, kCoarse = 4;  ///< [surface cells]

 private:
  // Made in this order: the window is held, what is further away looked up, ceilings over both finished.
  friend Result<Occluders> occluders_of(const HeightField& field, FloatImage near_heights_m, const CellArea& near,
                                        const SurfaceBlocks& far);
  void hold(FloatImage near_m, const CellArea& near, double cell_m);
  Result<> look_further(const HeightField& field, const SurfaceBlocks& far);
  Result<> add_far_blocks(const HeightField& field, const CellArea& blocks, const SurfaceBlocks& far);
  void add_ceilings(const FloatImage& occluders_m, int column, int row);
  void finish_ceilings();
  [[nodiscard]] float far_at(const std::vector<float>& far_m, unsigned column, unsigned row) const;
  // Whether all up to kThin rows and columns from a cell of the window is higher than that.
  [[nodiscard]] bool all_around_above(int column, int row, double line_m) const;
  template <bool wide_ones>
  [[nodiscard]] bool hide(double x, double y, double height_m, double camera_x, double camera_y,
                          double camera_height_m) const;

  FloatImage near_m_;  // no higher than the surface certainly is; minus infinity where nothing is
  CellArea all_{};     // all that is known of, in the field; begins with whole blocks
  // Numbers of the blocks in it that are known in coarse cells, or -1, and their cells block by block.
  Raster<std::int32_t> far_block_;
  std::vector<float> far_m_, far_wide_m_;
  FloatImage ceiling_m_;  // of all, per kCeilingReach cells
  int column_ = 0, row_ = 0;
  double cell_m_ = 1;
  float highest_m_ = -std::numeric_limits<float>::infinity();
};

/// Those around an area. `near`: a window of the field that begins at multiples of Occluders::kCeilingReach and reaches
/// kNear cells beyond the area, or as far as anything hides, and kBesides more; `near_heights_m`: its heights. `far`:
/// where else there may be things that hide a point of the area more than kNear cells away, the window included. Reads
/// the surface piece by piece. Error: it cannot be read.
[[nodiscard]] Result<Occluders> occluders_of(const HeightField& field, FloatImage near_heights_m, const CellArea& near,
                                             const SurfaceBlocks& far);
/// How far aside lines of sight are looked along, with the surroundings that tell a wide thing [surface cells].
constexpr int kBesides = 3 * Occluders::kThin + 2;

}  // namespace collinea
