// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/rotation.h"

namespace collinea {

Command rotation_command() {
  struct Asked {
    std::string numbers;
    ConvertRotationOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "rotation", "one rotation as Cardan, Euler, topographic and geodetic angles, Rodrigues, quaternion and matrix",
      [](Flags& flags, Asked& asked) {
        flags.positional("numbers", asked.numbers, "with commas between; behind -- where the first is negative");
        flags.add_all(asked.options, "rotation");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) { return convert_rotation(asked.numbers, asked.options).map(rotation_text); });
}

}  // namespace collinea
