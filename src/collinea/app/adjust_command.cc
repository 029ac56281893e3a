// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/jobs/adjust_project.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  std::optional<std::string> import_file, export_file, output;
  AdjustProjectOptions options;
  InstrumentOptions instruments;  ///< holds what the flags say; only those given change what orient did
  std::vector<std::function<void(InstrumentOptions&)>> changes;
  std::vector<std::pair<std::string, Given>> given;  ///< options of the adjustment
  ConsoleOptions console;
};

Result<std::string> adjust_as(const Asked& asked, const Run& run) {
  if (asked.import_file.has_value() != asked.project.empty())
    return fail(Errc::kBadInput, "adjust what? Give a project folder, or a file by --import");
  if (asked.import_file) {
    if (asked.export_file) {
      for (const auto& [name, given] : asked.given)
        if (given())
          return fail(Errc::kBadInput, name +
                                           ": with --import and --export the file is only converted, and nothing of "
                                           "how it will be adjusted is kept in it");
      if (asked.output) return fail(Errc::kBadInput, "--output and --export: adjust the file, or convert it");
      COLLINEA_TRY(convert_adjustment(*asked.import_file, *asked.export_file));
      return *asked.export_file;
    }
    if (!asked.output) return fail(Errc::kBadInput, "--import needs --output, the folder for what comes of it");
    return adjust_file(*asked.import_file, *asked.output, asked.options, run);
  }
  if (asked.output) return fail(Errc::kBadInput, "--output belongs to --import; a project has its own folder");
  COLLINEA_TRY(const Project project, open_project(asked.project, run));
  if (!asked.export_file) return adjust_project(project, asked.options);
  COLLINEA_TRY(export_adjustment(project, asked.options, *asked.export_file));
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
            const auto note = [asked](const auto& field, const Given& given) {
              std::string name = "--" + std::string(field.name);
              std::replace(name.begin(), name.end(), '_', '-');
              asked->given.emplace_back(name, given);
            };
            flags.add_all(asked->options, "adjust", note);
            flags.add_all(asked->instruments, "instruments", [&](const auto& field, const Given& given) {
              note(field, given);
              asked->changes.push_back([given, member = field.member, asked = asked.get()](InstrumentOptions& options) {
                if (given()) options.*member = asked->instruments.*member;
              });
            });
            asked->options.instruments = [asked = asked.get()](InstrumentOptions& options) {
              for (const auto& change : asked->changes) change(options);
            };
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
