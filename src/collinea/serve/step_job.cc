// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/step_job.h"

#include <fmt/chrono.h>

#include <ctime>
#include <fstream>
#include <mutex>

#include "collinea/project/settings_change.h"
#include "collinea/report/error_text.h"
#include "collinea/serve/project_json.h"
#include "collinea/steps/flow.h"

namespace collinea {

Result<std::string> run_step_job(const JobRequest& request, const Run& run) {
  const std::filesystem::path& folder = request.project.folder;
  COLLINEA_TRY(const Settings before, read_settings(folder));
  COLLINEA_TRY(const Settings settings, changed_settings(before, request.options));
  std::mutex mutex;
  std::ofstream file;
  Run logged = run;
  logged.log = [&](std::string_view line) {
    run.say(line);
    const std::lock_guard lock(mutex);
    if (file.is_open())
      file << fmt::format("{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(std::time(nullptr)), line) << std::flush;
  };
  COLLINEA_TRY(Project project, create_project(folder, settings, logged));
  file.open(folder / "log.txt", std::ios::app);
  const Result<> done = bring_up_to(project, request.step);
  if (!done && file.is_open()) file << "error: " << text_of(done.error(), run.spelling) << "\n";
  COLLINEA_TRY(done);
  return project_findings(project.store);
}

}  // namespace collinea
