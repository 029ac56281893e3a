// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/rectify_plane.h"

namespace collinea {

Command rectify_command() {
  struct Asked {
    std::string source, out;
    RectifyOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "rectify", "a plane (a façade) at a metric scale, from a photograph or an oriented project",
      [](Flags& flags, Asked& asked) {
        flags.positional("source", asked.source, "photograph, or folder of an oriented project");
        flags.required("-o", "out", asked.out, "picture to be written: .tif (GeoTIFF) or .png (and .pgw)");
        flags.add_all(asked.options, "rectify");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return rectify_plane(asked.source, asked.out, asked.options, console.run());
      });
}

}  // namespace collinea
