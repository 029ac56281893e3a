// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "collinea/edit/draw_feature.h"
#include "collinea/restitution/drawn_vertex.h"

namespace collinea {

inline constexpr std::size_t kMostAskedVertices = DrawFeature::kMostVertices, kMostAskedMarks = DrawFeature::kMostMarks;

/// The object of a request. Errors: no JSON, no object, nested too deep.
[[nodiscard]] Result<nlohmann::ordered_json> asked_object(std::string_view body);

/// Its "vertices": {"marks": [{"image", "pixel", "sigma_px"}]}, {"surface": [E, N]}, {"at": [E, N, H], "sigma_m",
/// "source"}, {"feature", "vertex"}. Errors: none, or more than kMostAskedVertices; one that is written otherwise;
/// kNotFound, a feature or vertex that there is not.
[[nodiscard]] Result<std::vector<AskedVertex>> asked_vertices(const nlohmann::ordered_json& asked,
                                                              const Drawing& drawing, const Block& block);

/// A list of positions in plan, named so. Errors: fewer than `least`, or too many; not finite.
[[nodiscard]] Result<std::vector<Eigen::Vector2d>> asked_positions(const nlohmann::ordered_json& asked,
                                                                   const char* name, std::size_t least);

}  // namespace collinea
