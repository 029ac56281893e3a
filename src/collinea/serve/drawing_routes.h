// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/serve/message.h"
#include "collinea/serve/project_views.h"

namespace collinea {

struct Target;

/// The answer to what is asked below /api/projects/ID of drawing and measuring; nothing when it is none of these:
///
///     GET .../drawing?image=3    POST .../vertices    POST .../figures    POST .../volume    POST .../profile
[[nodiscard]] std::optional<HttpResponse> drawing_response(const HttpRequest& request, const Target& target,
                                                           const ServedProject& project, ProjectViews& views);

}  // namespace collinea
