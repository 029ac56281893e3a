// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/serve/serve.h"

namespace collinea {
namespace {

struct Asked {
  std::vector<std::string> projects;
  ServeOptions options;
  ConsoleOptions console;
};

}  // namespace

Command serve_command() {
  return console_command<Asked>(
      "serve", "projects in a browser: products, findings, steps with their progress",
      [](Flags& flags, Asked& asked) {
        flags.positional("projects", asked.projects,
                         "project folders, or folders of projects; none: the folder that it is started in");
        flags.add_all(asked.options, "serve");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        const Run run = console.run();
        // Without the link nobody comes in, so that it is shown where nothing else is.
        const auto show = [&](std::string_view line) {
          if (asked.console.progress == ProgressForm::kNone)
            fmt::print(stderr, "{}\n", line);
          else
            run.say(line);
        };
        COLLINEA_TRY(serve({asked.projects.begin(), asked.projects.end()}, asked.options, run, show));
        return std::string();
      });
}

}  // namespace collinea
