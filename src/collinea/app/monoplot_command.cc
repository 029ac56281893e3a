// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/monoplot.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command monoplot_command() {
  struct Asked {
    std::string measurements, orientation, surface;
    std::optional<std::string> out;
    MonoplotTableOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "monoplot", "ground points from single oriented images and a surface model, with covariances",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table with image, point, x, y, sigma");
        flags.positional("orientation", asked.orientation,
                         "table with image, X, Y, Z, omega, phi, kappa and their sigmas");
        flags.positional("surface", asked.surface,
                         "raster of heights (GeoTIFF), in the coordinates of the orientation");
        flags.add("out", asked.out, "", "folder for the table of points");
        flags.add_all(asked.options, "monoplot");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const MonoplotReport report, monoplot_from_tables(asked.measurements, asked.orientation,
                                                                       asked.surface, asked.options, console.run()));
        if (asked.out) COLLINEA_TRY(write_result_tables(monoplot_tables(report), *asked.out));
        return monoplot_text(report);
      });
}

}  // namespace collinea
