// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/resection.h"

namespace collinea {

Command resection_command() {
  struct Asked {
    std::string measurements, ground;
    ResectOneOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "resection",
      "exterior orientation of single images from control points: collinearity, P3P, linear, DLT, plane, station",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table with image, point, x, y, sigma");
        flags.positional("ground", asked.ground, "table with point, X, Y, Z and sigmas");
        flags.add_all(asked.options, "resection");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) {
        return resect_from_tables(asked.measurements, asked.ground, asked.options).map(resection_text);
      });
}

}  // namespace collinea
