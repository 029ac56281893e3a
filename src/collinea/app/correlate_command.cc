// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/correlate.h"

namespace collinea {

Command correlate_command() {
  struct Asked {
    std::string left, right, out;
    CorrelateOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "correlate", "find points of one image in another by area matching (NCC, SSD, SAD, rank, census)",
      [](Flags& flags, Asked& asked) {
        flags.positional("left", asked.left, "image whose points are looked for (JPEG, PNG, TIFF)");
        flags.positional("right", asked.right, "image in which they are looked for");
        flags.required("-o", "out", asked.out, "folder for correlated.txt, left.png, right.png; made when missing");
        flags.add_all(asked.options, "correlate");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return correlate_points(asked.left, asked.right, asked.out, asked.options, console.run()).map(correlate_text);
      });
}

}  // namespace collinea
