// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
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
  auto asked = std::make_shared<Asked>();
  return {"plan", "what precision a flight and its control would give, before anybody goes out",
          [asked](Flags& flags) {
            flags.positional("folder", asked->folder, "where report, tables and maps go; made when missing");
            flags.add_all(asked->options, "plan");
            flags.add_all(asked->flight, "flight");
            flags.add_all(asked->layout, "control");
            flags.add_all(asked->measurements, "measurements");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto text = plan_survey(asked->flight, asked->layout, asked->measurements, asked->options,
                                          asked->folder, console->run());
            if (!text) return console->complain(text.error());
            std::fputs(text->c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
