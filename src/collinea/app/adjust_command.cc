// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/app/commands.h"
#include "collinea/app/console_command.h"
#include "collinea/jobs/adjust_project.h"
#include "collinea/report/finding_words.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  std::optional<std::string> import_file, export_file, output;
  AdjustProjectOptions options;
  std::vector<std::pair<std::string_view, Given>> given;  ///< options of the adjustment
  std::vector<std::pair<std::string_view, Given>> given_instruments;
  ConsoleOptions console;
};

// One line for the user.
std::string outcome_text(const AdjustmentReport& report, const std::filesystem::path& folder) {
  const Examined& adjusted = report.adjusted;
  std::string text = fmt::format("sigma0 {:.3f}, redundancy {}, datum: {}", adjusted.sigma0, adjusted.redundancy,
                                 words_of(adjusted.datum, adjusted.rank_defect));
  if (const auto& tests = adjusted.reliability; !tests) {
    text += "; no standard deviations" +
            (adjusted.undetermined ? ": " + sentence_of(*adjusted.undetermined, report.block) : "");
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
  for (const Finding& pair : adjusted.inseparable) text += "; " + sentence_of(pair, report.block);
  return text + "; " + (folder / "adjustment.html").string();
}

Result<std::string> convert(const Asked& asked) {
  for (const auto& given : {asked.given, asked.given_instruments})
    for (const auto& [name, is_given] : given)
      if (is_given())
        return tl::unexpected(Error{Errc::kBadInput,
                                    "the file is only converted, and nothing of how it will be adjusted is kept in it",
                                    {OptionName{std::string(name)}, "import"_option, "export"_option}});
  if (asked.output) return fail(Errc::kBadInput, "adjust the file, or convert it", {"output"_option, "export"_option});
  COLLINEA_TRY(convert_adjustment(*asked.import_file, *asked.export_file));
  return *asked.export_file;
}

Result<std::string> adjust_as(const Asked& asked, const Run& run) {
  if (asked.import_file.has_value() != asked.project.empty())
    return fail(Errc::kBadInput, "adjust what? Give a project folder, or a file", {"import"_option});
  if (asked.import_file) {
    if (asked.export_file) return convert(asked);
    if (!asked.output) return fail(Errc::kBadInput, "a file needs a folder for what comes of it", {"output"_option});
    COLLINEA_TRY(const AdjustmentReport report, adjust_file(*asked.import_file, *asked.output, asked.options, run));
    return outcome_text(report, *asked.output);
  }
  if (asked.output)
    return fail(Errc::kBadInput, "the output of a file needs the file; a project has its own folder",
                {"output"_option, "import"_option});
  COLLINEA_TRY(const Project project, open_project(asked.project, run));
  if (!asked.export_file) {
    COLLINEA_TRY(const AdjustmentReport report, adjust_project(project, asked.options));
    return outcome_text(report, project.folder / "adjustment");
  }
  COLLINEA_TRY(export_adjustment(project, asked.options, *asked.export_file));
  return *asked.export_file;
}

void declare(Flags& flags, Asked& asked) {
  flags.positional("project", asked.project, "project folder", false);
  flags.add("import", asked.import_file, "",
            "adjust the measurements of this file instead: no project, no images (see adjustment-file)");
  flags.add("output", asked.output, "", "with --import: folder for report and tables");
  flags.add("export", asked.export_file, "",
            "adjust nothing; write to this file what would be adjusted, as text for --import");
  flags.add_all(asked.console, "run");
  flags.add_all(asked.options, "adjust", [&](std::string_view group, const auto& field, const Given& given) {
    (group == "instruments" ? asked.given_instruments : asked.given).emplace_back(field.name, given);
  });
}

}  // namespace

Command adjust_command() {
  return console_command<Asked>(
      "adjust", "the bundle of an oriented project again: standard deviations, tests for gross errors, reliability",
      declare, [](Asked& asked, Console& console) -> Result<std::string> {
        for (const auto& [name, given] : asked.given_instruments)
          if (given()) asked.options.changed_instruments.emplace(name);
        COLLINEA_TRY(const std::string text, adjust_as(asked, console.run()));
        return text + "\n";
      });
}

}  // namespace collinea
