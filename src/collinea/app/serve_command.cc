// SPDX-License-Identifier: Apache-2.0
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
        COLLINEA_TRY(serve({asked.projects.begin(), asked.projects.end()}, asked.options, console.run()));
        return std::string();
      });
}

}  // namespace collinea
