// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/intersection.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command intersection_command() {
  struct Asked {
    std::string measurements, orientation;
    std::optional<std::string> out;
    IntersectTableOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "intersection", "points in space where rays of oriented images meet, with covariances and tests",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table with image, point, x, y, sigma");
        flags.positional("orientation", asked.orientation,
                         "table with image, X, Y, Z, omega, phi, kappa and their sigmas");
        flags.add("out", asked.out, "", "folder for the tables of points and residuals");
        flags.add_all(asked.options, "intersection");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const IntersectionReport report,
                     intersect_from_tables(asked.measurements, asked.orientation, asked.options, console.run()));
        if (asked.out) COLLINEA_TRY(write_result_tables(intersection_tables(report), report.findings, *asked.out));
        return intersection_text(report);
      });
}

}  // namespace collinea
