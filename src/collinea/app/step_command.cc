// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/app/settings_flags.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  SettingsFlags flags;
  ConsoleOptions console;
};

void declare(const std::string& step, Flags& flags, Asked& asked) {
  flags.positional("project", asked.project, "project folder");
  declare_seed(flags, asked.flags);
  flags.add_all(asked.console, "run");
  declare_options(flags, step, asked.flags);
}

Result<std::string> run_step(Asked& asked, Step step, Console& console) {
  COLLINEA_TRY(Settings settings, read_settings(asked.project));
  apply_flags(asked.flags, settings);
  COLLINEA_TRY(Project project, create_project(asked.project, settings, console.run()));
  console.log_to(project.folder / "log.txt");
  COLLINEA_TRY(bring_up_to(project, step));
  return std::string();
}

}  // namespace

Command step_command(Step step, const std::string& summary) {
  return console_command<Asked>(
      std::string(word_of(step)), summary + "; earlier steps are done first where they are missing",
      [step](Flags& flags, Asked& asked) { declare(std::string(word_of(step)), flags, asked); },
      [step](Asked& asked, Console& console) { return run_step(asked, step, console); });
}

}  // namespace collinea
