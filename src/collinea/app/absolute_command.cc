// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/absolute.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command absolute_command() {
  struct Asked {
    std::string model, ground;
    std::optional<std::string> out;
    OrientAbsoluteOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "absolute", "a model on the ground by control points: similarity with 7 (or 4) parameters and their covariance",
      [](Flags& flags, Asked& asked) {
        flags.positional("model", asked.model, "table with point, U, V, W and sigmas of a model");
        flags.positional("ground", asked.ground, "table with point, X, Y, Z and sigmas; - where one is not known");
        flags.add("out", asked.out, "", "folder for the tables of parameters, residuals and ground points");
        flags.add_all(asked.options, "absolute");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        COLLINEA_TRY(const AbsoluteReport report, orient_absolutely(asked.model, asked.ground, asked.options));
        if (asked.out) COLLINEA_TRY(write_result_tables(absolute_tables(report), report.findings, *asked.out));
        return absolute_text(report);
      });
}

}  // namespace collinea
