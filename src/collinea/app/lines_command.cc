// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/pair_lines.h"

namespace collinea {

Command lines_command() {
  struct Asked {
    std::string left, right, out;
    StereoPairOptions pair;
    PairLinesOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "lines", "straight edges of an oriented pair, matched, as lines in space with covariances",
      [](Flags& flags, Asked& asked) {
        flags.positional("left", asked.left, "left image");
        flags.positional("right", asked.right, "right image");
        flags.required("-o", "out", asked.out, "folder for tables, images and vectors; made when missing");
        flags.add_all(asked.pair, "pair");
        flags.add_all(asked.options, "lines");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return lines_of_pair(asked.left, asked.right, asked.out, asked.pair, asked.options, console.run())
            .map(lines_text);
      });
}

}  // namespace collinea
