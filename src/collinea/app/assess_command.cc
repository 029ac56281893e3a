// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/assess.h"
#include "collinea/report/assessment_text.h"

namespace collinea {

Command assess_command() {
  struct Asked {
    std::string project, truth;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "assess", "how far the products of a simulated block are from the truth",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder");
        flags.positional("truth", asked.truth, "folder truth/ beside the simulated photographs");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const Project project, open_project(asked.project, console.run()));
        return assess_project(project, asked.truth).map(assessment_text);
      });
}

}  // namespace collinea
