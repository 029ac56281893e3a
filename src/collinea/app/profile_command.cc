// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/measure.h"

namespace collinea {

Command profile_command() {
  struct Asked {
    std::string surface, folder;
    ProfileOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "profile", "heights of surfaces along a line: table and chart",
      [](Flags& flags, Asked& asked) {
        flags.positional("surface", asked.surface, "GeoTIFF of heights, such as PROJECT/products/dsm.tif");
        flags.positional("folder", asked.folder, "where profile.csv and profile.html go; made when missing");
        flags.add_all(asked.options, "profile");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const Profile profile, draw_profile(asked.surface, asked.options, asked.folder, console.run()));
        return fmt::format("{} positions over {:.2f} m; {}\n", profile.distance_m.size(), profile.distance_m.back(),
                           (std::filesystem::path(asked.folder) / "profile.html").string());
      });
}

}  // namespace collinea
