// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/measure_points.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command measure_command() {
  struct Asked {
    std::string project, marks;
    std::optional<std::string> out;
    MeasurePointsOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "measure", "points marked in the images of a project, and distances, angles and areas of them, with sigmas",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder, oriented");
        flags.positional("marks", asked.marks, "table with image, point, x, y, sigma");
        flags.add("out", asked.out, "", "folder for the tables of points, marks and figures");
        flags.add_all(asked.options, "measure");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const MeasuredReport report,
                     measure_points(asked.project, asked.marks, asked.options, console.run()));
        if (asked.out) COLLINEA_TRY(write_result_tables(measured_tables(report), *asked.out));
        return measured_text(report);
      });
}

}  // namespace collinea
