// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/result_tables.h"
#include "collinea/jobs/triplet.h"

namespace collinea {

Command triplet_command() {
  struct Asked {
    std::string measurements;
    std::optional<std::string> out;
    TripletOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "triplet", "relative orientation of three images: sixteen combinations of two pairs, and the choice of one",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table of points: image point x y");
        flags.add("out", asked.out, "",
                  "folder for the tables of combinations, exterior orientation, model, residuals");
        flags.add_all(asked.options, "triplet");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        COLLINEA_TRY(const TripletReport report, orient_triplet(asked.measurements, asked.options));
        if (asked.out) COLLINEA_TRY(write_result_tables(triplet_tables(report), report.findings, *asked.out));
        return triplet_text(report);
      });
}

}  // namespace collinea
