// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/evaluate.h"

namespace collinea {

Command evaluate_command() {
  struct Asked {
    std::string surface, reference;
    EvaluateOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "evaluate", "how far a surface model is from a reference: shift, RMS, robust figures, shares of the tolerance",
      [](Flags& flags, Asked& asked) {
        flags.positional("surface", asked.surface, "GeoTIFF of heights, such as PROJECT/products/dsm.tif");
        flags.positional("reference", asked.reference,
                         "GeoTIFF of heights, cloud (.las, .laz, .ply) or text table with X Y Z [m]");
        flags.add_all(asked.options, "evaluate");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return evaluate_surface(asked.surface, asked.reference, asked.options, console.run()).map(evaluation_text);
      });
}

}  // namespace collinea
