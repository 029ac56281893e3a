// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/serve/project_views.h"

namespace collinea {

/// {"layers": [{"name", "kind", "colour"}], "codes": [..], "features": [{"id", "layer", "kind", "attributes",
/// "vertices": [{"position", "covariance_m2", "sigma_m", "source", "marks"}], "moved_m", "moved_sigmas",
/// "not_computed": [{"vertex", "error"}]}], "as_drawn"}: all that is drawn. Vertices that have marks are computed anew
/// by them in the adjustment in force (DrawingNow): how far they moved, null without any; those that cannot be computed
/// are as drawn. "as_drawn": null, or why all are. With an image each vertex has the "pixel" at which that shows it, or
/// null. Errors: the code list; an image that there is not.
[[nodiscard]] Result<std::string> drawing_json(const ProjectView& view, std::optional<ImageId> image);

/// {"vertices": [{"position", ..} | {"error"}]} of {"vertices": [..]} (asked_vertices()), as `collinea plot` plots
/// them; with {"image": 3} each has the "pixel" at which that shows it, or null. Errors: what is asked; no block, or
/// not oriented.
[[nodiscard]] Result<std::string> vertices_json(const ProjectView& view, std::string_view body);

/// {"kind", "value", "sigma", "unit"} of {"kind", "vertices"}, or {"figures": [..]} of {"figures": [kinds],
/// "vertices"}, as `collinea plot --figures` measures them.
[[nodiscard]] Result<std::string> figures_json(const ProjectView& view, std::string_view body);

/// Of {"ring": [[E, N], ..], "base": "rim" | height}, as `collinea volume products/dsm.tif`.
[[nodiscard]] Result<std::string> volume_over_json(const ProjectView& view, std::string_view body);

/// Of {"line": [[E, N], ..], "step_m"}, as `collinea profile products/dsm.tif`.
[[nodiscard]] Result<std::string> profile_json(const ProjectView& view, std::string_view body);

}  // namespace collinea
