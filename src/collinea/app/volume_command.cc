// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/measure.h"

namespace collinea {

Command volume_command() {
  struct Asked {
    std::string surface;
    MeasureVolumeOptions measured;
    VolumeOptions options;
    ConsoleOptions console;
  };
  auto asked = std::make_shared<Asked>();
  return {"volume", "what lies between a surface and a plane, a level or another surface, with its standard deviation",
          [asked](Flags& flags) {
            flags.positional("surface", asked->surface, "raster of heights, such as PROJECT/products/dsm.tif");
            flags.add_all(asked->measured, "volume");
            flags.add_all(asked->options, "accuracy");
            flags.add_all(asked->console, "run");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto text = measure_volume(asked->surface, asked->measured, asked->options, console->run());
            if (!text) return console->complain(text.error());
            std::fputs(text->c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
