// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/plan_survey.h"

namespace collinea {

Command plan_command() {
  struct Asked {
    std::string folder;
    PlanOptions options;
    FlightOptions flight;
    LayoutOptions layout;
    MeasurementOptions measurements;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "plan", "what precision a flight and its control would give, before anybody goes out",
      [](Flags& flags, Asked& asked) {
        flags.positional("folder", asked.folder, "where report, tables and maps go; made when missing");
        flags.add_all(asked.options, "plan");
        flags.add_all(asked.flight, "flight");
        flags.add_all(asked.layout, "control");
        flags.add_all(asked.measurements, "measurements");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const PlanReport report, plan_survey(asked.flight, asked.layout, asked.measurements, asked.options,
                                                          asked.folder, console.run()));
        return plan_text(report) + (std::filesystem::path(asked.folder) / "plan.html").string() + "\n";
      });
}

}  // namespace collinea
