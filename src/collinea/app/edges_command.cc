// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/find_edges.h"

namespace collinea {

Command edges_command() {
  struct Asked {
    std::string image, out;
    FindEdgesOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "edges", "edges of an image, lines, circles, ellipses, targets and curves, to a fraction of a pixel",
      [](Flags& flags, Asked& asked) {
        flags.positional("image", asked.image, "photograph (JPEG, PNG, TIFF)");
        flags.required("-o", "out", asked.out, "folder for tables, vectors and the image with what was found");
        flags.add_all(asked.options, "edges");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return find_edges(asked.image, asked.out, asked.options, console.run()).map(edges_text);
      });
}

}  // namespace collinea
