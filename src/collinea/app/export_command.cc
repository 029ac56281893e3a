// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/export.h"

namespace collinea {

Command export_command() {
  struct Asked {
    std::string project, folder, format = "colmap";
    std::optional<double> tile_m;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"export", "the oriented block for other programs",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.positional("folder", asked->folder, "where the files go; made when missing");
            flags.add("format", asked->format, "",
                      "colmap (text and binary model), bundler, opk (omega, phi, kappa), ply (tie points), las, laz or "
                      "copc (dense cloud)");
            flags.add("tile_m", asked->tile_m, "m",
                      "of a cloud: cut it into squares of the map so large, a file each; nothing: one file");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            auto project = open_project(asked->project, console->run());
            if (!project) return console->complain(project.error());
            if (auto done = export_block(*project, asked->folder, asked->format, asked->tile_m); !done)
              return console->complain(done.error());
            fmt::print("{}\n", asked->folder);
            return 0;
          }};
}

}  // namespace collinea
