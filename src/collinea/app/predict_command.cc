// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/predict_marks.h"

namespace collinea {

Command predict_command() {
  struct Asked {
    std::string project, point;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "predict", "where the images of a project show a control point, best to mark first",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder");
        flags.positional("point", asked.point, "name of the control point");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const Project project, open_project(asked.project, console.run()));
        COLLINEA_TRY(const MarksReport report, predict_marks(project, asked.point));
        return predicted_marks_text(report);
      });
}

}  // namespace collinea
