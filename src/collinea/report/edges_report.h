// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/feature/edge_map.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// What can be made of the edges of an image.
enum class EdgeFind : std::uint8_t { kChains, kLines, kCorners, kCircles, kEllipses, kTargets, kShapes };
inline constexpr Word<EdgeFind> kEdgeFindWords[] = {
    {EdgeFind::kChains, "chains", "linked edges, their polygons, chain codes, curvatures and descriptors"},
    {EdgeFind::kLines, "lines", "straight lines (Hough)"},
    {EdgeFind::kCorners, "corners", "intersections of straight lines"},
    {EdgeFind::kCircles, "circles", "circles (Hough)"},
    {EdgeFind::kEllipses, "ellipses", "linked edges that are ellipses"},
    {EdgeFind::kTargets, "targets", "centres of targets, by least squares of grey values"},
    {EdgeFind::kShapes, "shapes", "a given shape (generalised Hough)"}};
[[nodiscard]] constexpr std::span<const Word<EdgeFind>> words(EdgeFind) { return kEdgeFindWords; }

/// Edges of an image and what was made of them.
struct EdgesReport {
  std::filesystem::path image;
  int width = 0, height = 0;
  EdgeOperator edge_operator = EdgeOperator::kSobel;
  double noise_grey = 0, high = 0, low = 0, along_px = 0;
  std::size_t points = 0, chains = 0;
  EdgeFind find = EdgeFind::kChains;
  TextTable found;               ///< a row each
  std::size_t scaled = 0;        ///< of them with residuals larger than their standard deviations
  std::size_t not_measured = 0;  ///< given points without a target
  std::vector<std::filesystem::path> files;
};

/// For a terminal: the edges, the first rows of what was found, findings, files.
[[nodiscard]] std::string edges_text(const EdgesReport& report);

}  // namespace collinea
