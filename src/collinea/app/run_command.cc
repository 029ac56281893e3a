// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/app/settings_paths.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string photos, project, until = "report";
  Settings settings;
  ConsoleOptions console;
};

Result<Step> last_step(const Asked& asked) {
  return step_named(asked.until).map_error([](Error error) { return std::move(error).about("until"_option); });
}

Result<std::string> run_until(Asked& asked, Step last, Console& console) {
  std::error_code error;
  asked.settings.photos = std::filesystem::absolute(asked.photos, error).lexically_normal().string();
  make_paths_absolute(asked.settings);
  COLLINEA_TRY(Project project, create_project(asked.project, asked.settings, console.run()));
  console.log_to(project.folder / "log.txt");
  COLLINEA_TRY(bring_up_to(project, last));
  console.run().say("project in " + asked.project);
  return std::string();
}

}  // namespace

Command run_command() {
  return console_command<Asked>(
      "run", "photographs to oriented images, cloud, surface and terrain model, orthophoto and report",
      [](Flags& flags, Asked& asked) {
        flags.positional("photos", asked.photos, "folder of photographs (searched with its subfolders)");
        flags.required("-o", "project", asked.project, "project folder; made when missing, continued when there");
        flags.add("until", asked.until, "", "last step to do");
        flags.add("seed", asked.settings.seed, "", kSeedHelp);
        flags.add_all(asked.console, "run");
        Settings::each(asked.settings, [&](const char*, const char* group, auto& options) {
          flags.add_group(options, group, [](const char*, const auto&, const Given&) {});
        });
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const Step last, last_step(asked));
        return run_until(asked, last, console);
      });
}

Command import_command() {
  return console_command<Asked>(
      "import", "read headers, cameras, positions and control of a folder of photographs",
      [](Flags& flags, Asked& asked) {
        flags.positional("photos", asked.photos, "folder of photographs (searched with its subfolders)");
        flags.required("-o", "project", asked.project, "project folder; made when missing");
        flags.add("seed", asked.settings.seed, "", kSeedHelp);
        flags.add_all(asked.console, "run");
        flags.add_all(asked.settings.import, "import");
      },
      [](Asked& asked, Console& console) { return run_until(asked, Step::kImport, console); });
}

}  // namespace collinea
