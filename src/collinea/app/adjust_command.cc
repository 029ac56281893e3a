// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/pipeline/adjust_project.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  std::optional<std::string> import_file, export_file, output;
  AdjustProjectOptions options;
  ConsoleOptions console;
};

Result<std::string> adjust_as(const Asked& asked, const Run& run) {
  if (asked.import_file.has_value() != asked.project.empty())
    return fail(Errc::kBadInput, "adjust what? Give a project folder, or a file by --import");
  if (asked.import_file) {
    if (asked.export_file) {
      if (auto done = convert_adjustment(*asked.import_file, *asked.export_file); !done)
        return tl::unexpected(done.error());
      return *asked.export_file;
    }
    if (!asked.output) return fail(Errc::kBadInput, "--import needs --output, the folder for what comes of it");
    return adjust_file(*asked.import_file, *asked.output, asked.options, run);
  }
  if (asked.output) return fail(Errc::kBadInput, "--output belongs to --import; a project has its own folder");
  COLLINEA_TRY(const Project project, open_project(asked.project, run));
  if (!asked.export_file) return adjust_project(project, asked.options);
  if (auto done = export_adjustment(project, asked.options, *asked.export_file); !done)
    return tl::unexpected(done.error());
  return *asked.export_file;
}

}  // namespace

Command adjust_command() {
  auto asked = std::make_shared<Asked>();
  return {"adjust", "the bundle of an oriented project again: standard deviations, tests for blunders, reliability",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder", false);
            flags.add("import", asked->import_file, "",
                      "adjust the measurements of this file instead: no project, no images (see adjustment-file)");
            flags.add("output", asked->output, "", "with --import: folder for report and tables");
            flags.add("export", asked->export_file, "",
                      "adjust nothing; write to this file what would be adjusted, as text for --import");
            flags.add_all(asked->console, "run");
            flags.add_all(asked->options, "adjust");
          },
          [asked] {
            auto console = Console::create(asked->console);
            if (!console) return complain(console.error());
            const auto done = adjust_as(*asked, console->run());
            if (!done) return console->complain(done.error());
            fmt::print("{}\n", *done);
            return 0;
          }};
}

}  // namespace collinea
