// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/pair.h"

namespace collinea {

Command pair_command() {
  struct Asked {
    std::string left, right, folder;
    PairChainOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "pair",
      "two photographs to a surface: points, relative orientation, epipolar images, cloud, absolute orientation",
      [](Flags& flags, Asked& asked) {
        flags.positional("left", asked.left, "the left photograph");
        flags.positional("right", asked.right, "the right one");
        flags.required("-o", "out", asked.folder, "folder for everything that is made; made when missing");
        flags.add_all(asked.options, "pair");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return orient_and_match(asked.left, asked.right, asked.folder, asked.options, console.run()).map(pair_text);
      });
}

}  // namespace collinea
