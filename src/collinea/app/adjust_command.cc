// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/pipeline/adjust_project.h"

namespace collinea {

Command adjust_command() {
  struct Asked {
    std::string project;
    AdjustProjectOptions options;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"adjust", "the bundle of an oriented project again: standard deviations, tests for blunders, reliability",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.add_all(asked->console, "run");
            flags.add_all(asked->options, "adjust");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            auto project = open_project(asked->project, console->run());
            if (!project) return console->complain(project.error());
            const auto done = adjust_project(*project, asked->options);
            if (!done) return console->complain(done.error());
            fmt::print("{}\n", *done);
            return 0;
          }};
}

}  // namespace collinea
