// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/plot_features.h"
#include "collinea/jobs/result_tables.h"

namespace collinea {

Command plot_command() {
  struct Asked {
    std::string project, table;
    std::optional<std::string> out;
    PlotOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "plot", "points, lines and polygons drawn into a project by marks in images, on the surface or by coordinates",
      [](Flags& flags, Asked& asked) {
        flags.positional("project", asked.project, "project folder");
        flags.positional(
            "features", asked.table,
            "table with feature, vertex, layer, image, x, y, sigma or E, N, H, sigma_m; none: only the files of the "
            "drawing are written",
            false);
        flags.add("out", asked.out, "", "folder for the tables of vertices and figures");
        flags.add_all(asked.options, "plot");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) -> Result<std::string> {
        const auto table = asked.table.empty() ? std::nullopt : std::optional<std::filesystem::path>(asked.table);
        COLLINEA_TRY(const PlotReport report, plot_features(asked.project, table, asked.options, console.run()));
        if (asked.out) COLLINEA_TRY(write_result_tables(plot_tables(report), *asked.out));
        return plot_text(report);
      });
}

}  // namespace collinea
