// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/assess.h"

namespace collinea {

Command assess_command() {
  struct Asked {
    std::string project, truth;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"assess", "how far the products of a simulated block are from the truth",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.positional("truth", asked->truth, "folder truth/ beside the simulated photographs");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto project = open_project(asked->project, console->run());
            if (!project) return console->complain(project.error());
            const auto text = assess_project(*project, asked->truth);
            if (!text) return console->complain(text.error());
            std::fputs(text->c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
