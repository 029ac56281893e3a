// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/serve/message.h"
#include "collinea/serve/project_views.h"

namespace collinea {

struct Target;

/// The answer to what is asked below /api/projects/ID of the ground and the control of a project; nothing when it is
/// none of these:
///
///     GET .../map    GET .../ties?most=20000    GET .../control    GET .../control/NAME/places    POST .../refine
[[nodiscard]] std::optional<HttpResponse> control_response(const HttpRequest& request, const Target& target,
                                                           const ServedProject& project, ProjectViews& views);

}  // namespace collinea
