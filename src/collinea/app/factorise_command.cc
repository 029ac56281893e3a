// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/factorise.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command factorise_command() {
  struct Asked {
    std::string measurements;
    std::optional<std::string> out;
    FactoriseOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "factorise", "cameras and points from measurements alone: projective factorisation, self-calibration, upgrade",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table of points: image point x y");
        flags.add("out", asked.out, "", "folder for the tables of cameras, points, residuals, pairs and orientation");
        flags.add_all(asked.options, "factorise");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        COLLINEA_TRY(const FactorisationReport report, factorise_table(asked.measurements, asked.options));
        if (asked.out) COLLINEA_TRY(write_result_tables(factorisation_tables(report), report.findings, *asked.out));
        return factorisation_text(report);
      });
}

}  // namespace collinea
