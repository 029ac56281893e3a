// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/file_options.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "collinea/base/nearest_names.h"
#include "collinea/base/option_text.h"

namespace collinea {
namespace {

// What the measurements, roles and parameters of the file say already.
constexpr std::string_view kInFile[] = {"calibration", "additional",   "additional_fixed", "use_positions",
                                        "use_control", "use_geodetic", "given_sigmas"};

// Calls visit(field, owner) for every option, in its group or another.
template <class Options, class Visit>
void for_each_option(Options& options, Visit&& visit) {
  for_each_group("", options, [&](const char*, auto& group) { for_each_field(group, visit); });
}

Error at_line(const AdjustmentFileOption& one, Error error) {
  error.code = Errc::kBadFormat;
  error.options.clear();
  return std::move(error).within("line " + std::to_string(one.line) + ": option " + one.name);
}

Result<> take(const AdjustmentFileOption& one, AdjustmentOptions& options) {
  Result<> taken = tl::unexpected(Error{Errc::kBadFormat, ""});
  std::vector<std::string> known;
  bool found = false;
  for_each_option(options, [&](const auto& field, auto& owner) {
    known.emplace_back(field.name);
    if (found || field.name != one.name) return;
    found = true;
    taken = read_option(field, one.value, owner);
  });
  if (found) return taken.map_error([&](Error error) { return at_line(one, std::move(error)); });
  return tl::unexpected(with_nearest(
      Error{Errc::kBadFormat, "line " + std::to_string(one.line) + ": adjust has no option \"" + one.name + "\""},
      one.name, known));
}

}  // namespace

Result<AdjustmentOptions> options_in(const std::vector<AdjustmentFileOption>& stated) {
  AdjustmentOptions options;
  for (const AdjustmentFileOption& one : stated) COLLINEA_TRY(take(one, options));
  return options;
}

std::vector<AdjustmentFileOption> changed_options(const AdjustmentOptions& options) {
  std::vector<AdjustmentFileOption> defaults;
  const AdjustmentOptions untouched;
  for_each_option(untouched, [&](const auto& field, const auto& owner) {
    defaults.push_back({std::string(field.name), option_text(field, owner).value_or("")});
  });
  std::vector<AdjustmentFileOption> chosen;
  std::size_t next = 0;
  for_each_option(options, [&](const auto& field, const auto& owner) {
    const auto text = option_text(field, owner);
    if (const std::string& by_default = defaults[next++].value; text && *text != by_default)
      chosen.push_back({std::string(field.name), *text});
  });
  return chosen;
}

std::vector<AdjustmentFileOption> options_of(const AdjustmentTask& task, AdjustmentOptions asked) {
  asked.loss = task.options.adjust.loss;
  asked.position_loss = task.options.adjust.position_loss;
  asked.snoop = task.snoop.has_value();
  asked.snoop_given = task.snoop == SnoopedKinds::kGiven;
  std::vector<AdjustmentFileOption> stated;
  for_each_field(asked, [&](const auto& field, const auto& owner) {
    if (std::find(std::begin(kInFile), std::end(kInFile), field.name) != std::end(kInFile)) return;
    if (const auto text = option_text(field, owner); text && !text->empty())
      stated.push_back({std::string(field.name), *text});
  });
  return stated;
}

}  // namespace collinea
