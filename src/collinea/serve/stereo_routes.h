// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/serve/message.h"
#include "collinea/serve/project_views.h"

namespace collinea {

struct Target;

/// The answer to what is asked below /api/projects/ID of the stereoplotter; nothing when it is none of these:
///
///     GET .../stereo?at=E,N    GET .../stereo?images=3,4    POST .../ground
[[nodiscard]] std::optional<HttpResponse> stereo_response(const HttpRequest& request, const Target& target,
                                                          const ServedProject& project, ProjectViews& views);

}  // namespace collinea
