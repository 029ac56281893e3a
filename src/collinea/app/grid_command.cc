// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/grid_points.h"

namespace collinea {

Command grid_command() {
  struct Asked {
    std::string points, out;
    GridPointsOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "grid", "a raster of heights from points: collocation, splines, triangles or planes, with standard deviations",
      [](Flags& flags, Asked& asked) {
        flags.positional("points", asked.points, "text table with X Y Z [m] and, where known, sigma_Z");
        flags.required("-o", "out", asked.out, "GeoTIFF of heights; standard deviations go to NAME_sigma.tif");
        flags.add_all(asked.options, "grid");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return grid_points(asked.points, asked.out, asked.options, console.run()).map(gridded_text);
      });
}

}  // namespace collinea
