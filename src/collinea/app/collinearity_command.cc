// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/collinearity.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command collinearity_command() {
  struct Asked {
    std::string points, orientation;
    std::optional<std::string> out;
    CollinearityOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "collinearity", "image coordinates of points in latitude, longitude and height, with refraction and sigmas",
      [](Flags& flags, Asked& asked) {
        flags.positional("points", asked.points, "table with point, latitude, longitude, h or H, sigmas");
        flags.positional("orientation", asked.orientation, "table with image, the same, omega, phi, kappa, sigmas");
        flags.add("out", asked.out, "", "folder for the tables of image points and derivatives");
        flags.add_all(asked.options, "collinearity");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        COLLINEA_TRY(const CollinearityReport report,
                     collinearity_of_tables(asked.points, asked.orientation, asked.options));
        if (asked.out) COLLINEA_TRY(write_result_tables(collinearity_tables(report), *asked.out));
        return collinearity_text(report);
      });
}

}  // namespace collinea
