// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/serve/project_views.h"

namespace collinea {

/// {"masks": [{"name", "image": id or null (all photographs), "ring": [[x, y], ..]}], "patches": [{"name", "image",
/// "file", "ring": [[e, n], ..]}]}: masks of photographs [px] and patches of the orthophoto [m in the map] that are in
/// force, in the order in which they were made.
[[nodiscard]] std::string work_json(const ProjectView& view);

}  // namespace collinea
