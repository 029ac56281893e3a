// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/export.h"

namespace collinea {

Command export_command() {
  struct Asked {
    std::string project, folder;
    ExportOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "export", "the oriented block for other programs",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder");
        flags.positional("folder", asked.folder, "where the files go; made when missing");
        flags.add_all(asked.options, "export");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(Project project, open_project(asked.project, console.run()));
        COLLINEA_TRY(export_block(project, asked.folder, asked.options));
        return asked.folder + "\n";
      });
}

}  // namespace collinea
