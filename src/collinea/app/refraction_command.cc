// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/collinearity.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command refraction_command() {
  struct Asked {
    std::string measurements;
    std::optional<std::string> out;
    RefractionOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "refraction", "refraction of image points by coefficient and by standard atmosphere, and corrected coordinates",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table of points: point x y");
        flags.add("out", asked.out, "", "folder for the table of shifts and corrected coordinates");
        flags.add_all(asked.options, "refraction");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        COLLINEA_TRY(const RefractionReport report, refraction_of_table(asked.measurements, asked.options));
        if (asked.out) COLLINEA_TRY(write_result_tables(refraction_tables(report), *asked.out));
        return refraction_text(report);
      });
}

}  // namespace collinea
