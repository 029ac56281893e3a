// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "collinea/serve/access.h"
#include "collinea/serve/edit_journals.h"
#include "collinea/serve/job_board.h"
#include "collinea/serve/message.h"
#include "collinea/serve/project_views.h"

namespace collinea {

/// What is served, to whom.
struct Site {
  std::vector<std::filesystem::path> roots;
  Access& access;
  JobBoard& board;
  std::function<void()> link_used = {};  ///< called when a link was exchanged: there is a new one
  std::shared_ptr<EditJournals> journals = std::make_shared<EditJournals>();
  std::shared_ptr<ProjectViews> views = std::make_shared<ProjectViews>();  ///< what is remembered of projects
};

/// The answer to any request but that for a WebSocket:
///
///     GET  /, /page.js, /page.css
///     GET  /api/projects                              POST /api/projects/ID/jobs
///     GET  /api/projects/ID                           POST /api/jobs/N/stop
///     GET  /api/projects/ID/settings                  GET  /api/jobs
///     GET  /api/projects/ID/files/products/dsm.tif    GET  /api/options
///     GET  /api/projects/ID/edits                     POST /api/projects/ID/edits
///     GET  /api/projects/ID/images, images/3/tiles/0/0/0.jpg, images/3/residuals
///     GET  /api/projects/ID/map, ties, control
///     GET  /api/projects/ID/drawing                   POST /api/projects/ID/vertices, figures, volume, profile
///
/// HEAD is answered as GET; the server leaves the body out.
[[nodiscard]] HttpResponse answer(const HttpRequest& request, Site& site);

/// Where the WebSocket is.
inline constexpr std::string_view kEventsPath = "/api/events";

/// The number behind which a client wants changes: "/api/events?since=12"; 0 where it says nothing.
[[nodiscard]] std::uint64_t asked_since(std::string_view target);

/// Headers that every answer has: what pages may load, and that nobody guesses types.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> guarding_headers(bool is_project_file);

}  // namespace collinea
