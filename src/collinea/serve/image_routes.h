// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/serve/message.h"
#include "collinea/serve/project_views.h"

namespace collinea {

/// The answer to a request below /api/projects/ID/images; `path`: its parts behind that.
///
///     GET ...                      the list of them
///     GET .../3/residuals          of tie points
///     GET .../3/tags               coded tags
///     GET .../3/tiles/Z/X/Y.jpg    a tile of an image (raster/image_tiles.h)
///
/// Tiles are kept in PROJECT/cache/tiles, at most TileCache::kMostBytes of them.
[[nodiscard]] HttpResponse image_response(const HttpRequest& request, const ServedProject& project,
                                          std::span<const std::string> path, ProjectViews& views);

}  // namespace collinea
