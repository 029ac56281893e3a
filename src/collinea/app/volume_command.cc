// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/measure.h"
#include "collinea/report/volume_report.h"

namespace collinea {

Command volume_command() {
  struct Asked {
    std::string surface;
    MeasureVolumeOptions measured;
    VolumeOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "volume", "what lies between a surface and a plane, a level or another surface, with its standard deviation",
      [](Flags& flags, Asked& asked) {
        flags.positional("surface", asked.surface, "GeoTIFF of heights, such as PROJECT/products/dsm.tif");
        flags.add_all(asked.measured, "volume");
        flags.add_all(asked.options, "accuracy");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console& console) {
        return measure_volume(asked.surface, asked.measured, asked.options, console.run())
            .map([](const MeasuredVolume& done) { return volume_text(done.volume, done.sigmas_assumed); });
      });
}

}  // namespace collinea
