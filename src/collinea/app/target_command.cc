// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/io/text.h"
#include "collinea/jobs/predict_marks.h"

namespace collinea {

Command target_command() {
  struct Asked {
    std::string image, column_px, row_px;
    TargetOptions options;
    ConsoleOptions console;
  };
  return console_command<Asked>(
      "target", "the centre of a target near a position of an image, with standard deviations",
      [](Flags& flags, Asked& asked) {
        flags.positional("image", asked.image, "image file (JPEG, PNG, TIFF)");
        flags.positional("column", asked.column_px, "where about the target lies [px]; the first pixel's centre is 0.5");
        flags.positional("row", asked.row_px, "the same, from above");
        flags.add_all(asked.options, "target");
        flags.add_all(asked.console, "run");
      },
      [](Asked& asked, Console&) -> Result<std::string> {
        const auto column_px = finite_number(asked.column_px), row_px = finite_number(asked.row_px);
        if (!column_px || !row_px) return fail(Errc::kBadInput, "the position is two numbers: column and row [px]");
        COLLINEA_TRY(const RefinedMark mark, target_in_file(asked.image, {*column_px, *row_px}, asked.options));
        return refined_mark_text(mark);
      });
}

}  // namespace collinea
