// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/steps/simulated_project.h"
#include "collinea/synthetic/write.h"

namespace collinea {

Command simulate_command() {
  struct Asked {
    std::string folder, scene = "aerial";
    SurveyOptions aerial;
    FacadeOptions facade;
    bool observations_only = false;
    ObservationOptions observations;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"simulate", "render a survey of a made-up world: photographs, control and the truth beside them",
          [asked](Flags& flags) {
            flags.positional("folder", asked->folder, "where images/, control.csv and truth/ go; made when missing");
            flags.add("scene", asked->scene, "", "aerial (a drone block) or facade (a walk before a wall)");
            flags.add("observations_only", asked->observations_only, "",
                      "no photographs: the folder becomes a project with features and verified pairs, from which "
                      "`collinea orient` goes on (aerial only)");
            flags.add_all(asked->aerial, "aerial");
            flags.add_all(asked->facade, "facade");
            flags.add_all(asked->observations, "observations");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            if (asked->scene != "aerial" && asked->scene != "facade")
              return complain({Errc::kBadInput, "--scene " + asked->scene + ": choose aerial or facade"});
            if (asked->observations_only && asked->scene != "aerial")
              return complain({Errc::kBadInput, "--observations-only is for --scene aerial"});
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const Run run = console->run();
            const auto done = asked->observations_only
                                  ? simulate_project(asked->aerial, asked->observations, asked->folder, run)
                              : asked->scene == "aerial" ? simulate(asked->aerial, asked->folder, run)
                                                         : simulate(asked->facade, asked->folder, run);
            if (!done) return console->complain(done.error());
            run.say("block in " + asked->folder);
            return 0;
          }};
}

}  // namespace collinea
