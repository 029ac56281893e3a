// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/app/settings_flags.h"
#include "collinea/jobs/adjust_project.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/step_words.h"
#include "collinea/steps/flow.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  std::optional<std::string> import_file, export_file, output;
  SettingsFlags flags;
  ConsoleOptions console;
};

// One line for the user.
std::string outcome_text(const AdjustmentReport& report, const std::filesystem::path& folder) {
  const Examined& adjusted = report.adjusted;
  std::string text = fmt::format("sigma0 {:.3f}, redundancy {}, datum: {}", adjusted.sigma0, adjusted.redundancy,
                                 words_of(adjusted.datum, adjusted.rank_defect));
  if (const auto& tests = adjusted.reliability; !tests) {
    text += "; no standard deviations" +
            (adjusted.undetermined ? ": " + sentence_of(*adjusted.undetermined, report.block, report.spelling) : "");
  } else {
    text += fmt::format("; {} of {} observations suspected", tests->rejected, tests->tested);
    if (tests->unseen > 0)
      text += fmt::format(", and {} more whose point lies where their image does not see it", tests->unseen);
  }
  for (const AdditionalTest& test : report.additional) {
    const std::string dropped = dropped_names(test);
    text += fmt::format("; {} of {} additional parameters to keep", test.kept, test.parameters.size());
    if (!dropped.empty() && test.kept > 0) text += " (--additional-fixed " + dropped + ")";
  }
  for (const Finding& pair : adjusted.inseparable) text += "; " + sentence_of(pair, report.block, report.spelling);
  return text + "; " + (folder / "adjustment.html").string();
}

// The measurements of a file, with the options that it states and those that were given, which go before.
Result<FileAdjustment> file_as_asked(Asked& asked) {
  COLLINEA_TRY(FileAdjustment given, read_adjustment(*asked.import_file));
  Settings settings;
  settings.adjust = given.options;
  apply_flags(asked.flags, settings);
  given.options = settings.adjust;
  return given;
}

Result<std::string> adjust_of_file(Asked& asked, const Run& run) {
  if (asked.export_file && asked.output)
    return fail(Errc::kBadInput, "adjust the file, or convert it", {"output"_option, "export"_option});
  if (!asked.export_file && !asked.output)
    return fail(Errc::kBadInput, "a file needs a folder for what comes of it", {"output"_option});
  COLLINEA_TRY(FileAdjustment given, file_as_asked(asked));
  if (asked.export_file) {
    COLLINEA_TRY(convert_adjustment(given, *asked.export_file));
    return *asked.export_file;
  }
  COLLINEA_TRY(const AdjustmentReport report, adjust_file(std::move(given), *asked.output, run));
  return outcome_text(report, *asked.output);
}

// With the options of the project and those that were given; the project stays as it is.
Result<std::string> look_only(Asked& asked, const Run& run) {
  if (asked.output && asked.export_file)
    return fail(Errc::kBadInput, "adjust the project, or write what would be adjusted",
                {"output"_option, "export"_option});
  COLLINEA_TRY(Project project, open_project(asked.project, run));
  apply_flags(asked.flags, project.settings);
  if (asked.export_file) {
    COLLINEA_TRY(export_adjustment(project, project.settings.adjust, *asked.export_file));
    return *asked.export_file;
  }
  COLLINEA_TRY(const AdjustmentReport report, try_adjustment(project, project.settings.adjust, *asked.output));
  return outcome_text(report, *asked.output);
}

Result<std::string> adjust_as(Asked& asked, Console& console) {
  if (asked.import_file.has_value() != asked.project.empty())
    return fail(Errc::kBadInput, "adjust what? Give a project folder, or a file", {"import"_option});
  if (asked.import_file) return adjust_of_file(asked, console.run());
  if (asked.output || asked.export_file) return look_only(asked, console.run());
  COLLINEA_TRY(Settings settings, read_settings(asked.project));
  apply_flags(asked.flags, settings);
  COLLINEA_TRY(Project project, create_project(asked.project, settings, console.run()));
  console.log_to(project.folder / "log.txt");
  COLLINEA_TRY(bring_up_to(project, Step::kAdjust));
  COLLINEA_TRY(const auto record, project.store.read_outcome<AdjustmentRecord>());
  return summary_of(record) + "; " + (project.folder / "adjustment" / "adjustment.html").string();
}

void declare(Flags& flags, Asked& asked) {
  flags.positional("project", asked.project, "project folder", false);
  flags.add("import", asked.import_file, "",
            "adjust the measurements of this file instead: no project, no images (see adjustment-file)");
  flags.add("output", asked.output, "",
            "folder for report and tables: of a file; or of a trial, which leaves the project as it is");
  flags.add("export", asked.export_file, "",
            "adjust nothing; write to this file what would be adjusted, and by which options, as text for --import");
  declare_seed(flags, asked.flags);
  flags.add_all(asked.console, "run");
  declare_options(flags, "adjust", asked.flags);
}

}  // namespace

Command adjust_command() {
  return console_command<Asked>(
      "adjust",
      "adjust the oriented block with the full model: standard deviations, tests for gross errors, reliability; "
      "earlier steps are done first where they are missing",
      declare, [](Asked& asked, Console& console) -> Result<std::string> {
        COLLINEA_TRY(const std::string text, adjust_as(asked, console));
        return text + "\n";
      });
}

}  // namespace collinea
