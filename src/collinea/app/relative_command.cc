// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/relative.h"

namespace collinea {

Command relative_command() {
  struct Asked {
    std::string measurements;
    RelativePairOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "relative", "relative orientation of two images, and the coordinates of their model",
      [](Flags& flags, Asked& asked) {
        flags.positional("measurements", asked.measurements, "table of points: point x_left y_left x_right y_right",
                         false);
        flags.add_all(asked.options, "relative");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) { return orient_pair(asked.measurements, asked.options).map(relative_text); });
}

}  // namespace collinea
