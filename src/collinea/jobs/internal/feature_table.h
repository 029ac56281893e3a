// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/io/text_table.h"
#include "collinea/restitution/plotted_vertex.h"

namespace collinea {

/// A feature of a table, not plotted yet.
struct AskedFeature {
  std::string id, layer, code;  ///< code: empty, none
  VectorKind kind = VectorKind::kLine;
  std::vector<AskedVertex> vertices;
};

/// Columns feature, image, x, y, sigma (of a mark); E, N, H, sigma_m (of coordinates; without H on the surface); vertex
/// (rows of one are marks of one), code, layer, kind, of the first row of a feature that states it. Errors: with their
/// row.
[[nodiscard]] Result<std::vector<AskedFeature>> features_in(const TextTable& table, const Block& block,
                                                            std::span<const DrawingCode> codes, double sigma_px,
                                                            const std::string& layer);

}  // namespace collinea
