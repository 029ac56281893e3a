// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/measure.h"

namespace collinea {

Command profile_command() {
  struct Asked {
    std::string surface, folder;
    ProfileOptions options;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"profile", "heights of surfaces along a line: table and chart",
          [asked](Flags& flags) {
            flags.positional("surface", asked->surface, "raster of heights, such as PROJECT/products/dsm.tif");
            flags.positional("folder", asked->folder, "where profile.csv and profile.html go; made when missing");
            flags.add_all(asked->options, "profile");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto done = draw_profile(asked->surface, asked->options, asked->folder, console->run());
            if (!done) return console->complain(done.error());
            fmt::print("{}\n", *done);
            return 0;
          }};
}

}  // namespace collinea
