// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/io/text.h"
#include "collinea/jobs/measure_ground.h"

namespace collinea {

Command ground_command() {
  struct Asked {
    std::string project, east_m, north_m;
    GroundOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "ground", "the ground at a place of the map, measured in the best stereo pair, with standard deviations",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder");
        flags.positional("easting", asked.east_m, "of the place, in the CRS of the project [m]");
        flags.positional("northing", asked.north_m, "the same");
        flags.add_all(asked.options, "ground");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        const auto east_m = finite_number(asked.east_m), north_m = finite_number(asked.north_m);
        if (!east_m || !north_m) return fail(Errc::kBadInput, "the place is two numbers: easting and northing [m]");
        COLLINEA_TRY(const Project project, open_project(asked.project, console.run()));
        COLLINEA_TRY(const GroundReport report, measure_ground(project, {*east_m, *north_m}, asked.options));
        return ground_text(report);
      });
}

}  // namespace collinea
