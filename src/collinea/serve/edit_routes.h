// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/serve/edit_journals.h"
#include "collinea/serve/internal/target.h"
#include "collinea/serve/message.h"

namespace collinea {

/// GET and POST of /api/projects/ID/edits:
///
///     GET  ?since=N           as edits_json() has it
///     POST {"command": [...]} -> {"number": 18}
[[nodiscard]] HttpResponse edits_response(const HttpRequest& request, const Target& target,
                                          const ServedProject& project, EditJournals& journals);

/// GET of /api/projects/ID/cloud, as cloud_json() has it.
[[nodiscard]] HttpResponse cloud_response(const ServedProject& project, EditJournals& journals);

}  // namespace collinea
