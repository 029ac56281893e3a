// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/base/result.h"
#include "collinea/serve/edit_journals.h"
#include "collinea/serve/job_board.h"
#include "collinea/serve/project_files.h"
#include "collinea/store/project_store.h"

// JSON of what is served: each a text that a request is answered with.
namespace collinea {

/// [{"id", "name", "folder"}].
[[nodiscard]] std::string projects_json(std::span<const ServedProject> projects);

/// {"id", "name", "folder", "images", "cameras", "oriented", "crs", "steps": [{"name", "done", "seconds", "summary",
/// "figures"}], "findings", "files": [{"path", "bytes"}]}: figures as `collinea info` has them, every step in its
/// order, also those not done. Errors: the database cannot be read.
[[nodiscard]] Result<std::string> project_json(const ServedProject& project);

/// The findings of all steps that are done, as in reports.
[[nodiscard]] Result<std::string> project_findings(const ProjectStore& store);

/// {"board", "number", "jobs": [...], "log": [{"job", "line"}], "edits": [{"project", "number"}]}; "edits" where a
/// journal grew.
[[nodiscard]] std::string changes_json(const JobChanges& changes, std::span<const GrownJournal> grown = {});

/// {"job"}.
[[nodiscard]] std::string job_json(std::uint64_t id);

/// What `POST` of a job holds: {"step", "options": {group: {option: value}}}; of no project yet.
[[nodiscard]] Result<JobRequest> job_request_in(std::string_view body);

}  // namespace collinea
