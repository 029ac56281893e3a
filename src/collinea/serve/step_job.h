// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/serve/job_board.h"

namespace collinea {

/// The work of jobs: changes the options of the project, brings it up to the step, as the command of that name does,
/// and adds to its log.txt. The findings of its steps as a JSON array.
[[nodiscard]] Result<std::string> run_step_job(const JobRequest& request, const Run& run);

}  // namespace collinea
