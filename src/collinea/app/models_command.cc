// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/join_models.h"

namespace collinea {

Command models_command() {
  struct Asked {
    std::string source;
    JoinModelsOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "models", "block of independent models: joined spatially at once, or by cycles of plan and height",
      [](Flags& flags, Asked& asked) {
        flags.positional("source", asked.source,
                         "table of models (model point U V W), or an adjustment file or project whose pairs of images "
                         "make them");
        flags.add_all(asked.options, "models");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return join_models_of(asked.source, asked.options, console.run()).map(models_text);
      });
}

}  // namespace collinea
