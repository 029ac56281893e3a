// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "collinea/app/exit_code.h"

namespace collinea {

namespace {

std::string spelled_as_flag(std::string_view name) {
  std::string text(name);
  std::replace(text.begin(), text.end(), '_', '-');
  return "--" + text;
}

// "robust loss: none | huber | cauchy (redescends)".
std::string with_choices(std::string_view help, const std::vector<Choice>& choices) {
  std::string text(help);
  for (std::size_t i = 0; i < choices.size(); ++i) {
    text += (i == 0 ? ": " : " | ") + std::string(choices[i].word);
    if (!choices[i].meaning.empty()) text += " (" + std::string(choices[i].meaning) + ")";
  }
  return text;
}

// "-12.5": no flag begins with a digit.
bool is_below_zero(std::string_view word) {
  return word.size() > 1 && word[0] == '-' && (word[1] == '.' || (word[1] >= '0' && word[1] <= '9'));
}

// "--snoop yes" is "--snoop=yes": flags without a value may have one of these behind them. A space hides the minus of a
// number from who looks for flags.
std::vector<std::string> with_answers(int argc, char** argv, const CLI::App& command, bool takes_words) {
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (takes_words && is_below_zero(word)) {
      words.push_back(" " + std::string(word));
      continue;
    }
    const bool answers = word == "yes" || word == "no" || word == "true" || word == "false";
    const CLI::Option* asked = answers && words.size() > 1 && words.back().starts_with("--")
                                   ? command.get_option_no_throw(words.back())
                                   : nullptr;
    if (asked != nullptr && asked->get_items_expected_max() == 0)
      words.back() += "=" + std::string(word == "yes" ? "true" : word == "no" ? "false" : word);
    else
      words.emplace_back(word);
  }
  return words;
}

}  // namespace

std::string value_name_of(PathKind kind) {
  switch (kind) {
    case PathKind::kFile:
    case PathKind::kOutput:
      return "FILE";
    case PathKind::kFolder:
      return "FOLDER";
    default:
      return "PATH";
  }
}

std::string with_unit(std::string_view help, std::string_view unit) {
  return std::string(help) + (unit.empty() || unit == "1" ? "" : " [" + std::string(unit) + "]");
}

std::string flag_of(const OptionName& option) {
  return spelled_as_flag(option.name) + (option.value.empty() ? "" : " " + option.value);
}

std::string Flags::spelled(const OptionName& option) const {
  const std::string value = option.value.empty() ? "" : " " + option.value;
  if (const auto known = flags_.find({option.group, option.name}); known != flags_.end()) return known->second + value;
  for (const auto& [name, flag] : flags_)
    if (name.second == option.name) return flag + value;
  return flag_of(option);
}

std::string Flags::new_flag(std::string_view name) {
  std::string flag = spelled_as_flag(name);
  if (app_.get_option_no_throw(flag) != nullptr) flag = spelled_as_flag(group_ + "_" + std::string(name));
  flags_[{group_, std::string(name)}] = flag;
  return flag;
}

Given Flags::finished(CLI::Option* option) {
  if (!group_.empty()) option->group(group_);
  return [option] { return option->count() > 0; };
}

namespace {

// Where things go has a short form in every command.
std::string with_short_form(const std::string& flag) { return flag == "--out" ? "-o," + flag : flag; }

}  // namespace

template <class T>
Given Flags::add_value(std::string_view name, T& value, std::string_view unit, std::string_view help) {
  auto* option = app_.add_option(with_short_form(new_flag(name)), value, with_unit(help, unit));
  if constexpr (requires { value.has_value(); }) {
    if (value) option->capture_default_str();
  } else {
    option->capture_default_str();
  }
  return finished(option);
}

Given Flags::add_text(std::string_view name, std::string_view help, Text text) {
  const std::string flag = new_flag(name);
  auto* option = app_.add_option_function<std::string>(
      with_short_form(flag), [take = text.take](const std::string& value) { take(value); },
      with_choices(help, text.choices));
  option->type_name(text.value_name)->default_str(text.shown);
  if (!text.choices.empty())
    option->check([choices = text.choices](const std::string& word) {
      std::vector<std::string_view> known;
      for (const Choice& choice : choices) {
        if (choice.word == word) return std::string();
        known.push_back(choice.word);
      }
      return "choose " + listed(known);
    });
  return finished(option);
}

void Flags::positional(std::string_view name, std::string& value, std::string_view help, bool required) {
  app_.add_option(std::string(name), value, std::string(help))->required(required);
}

void Flags::positional(std::string_view name, std::vector<std::string>& values, std::string_view help) {
  app_.add_option(std::string(name), values, std::string(help));
}

void Flags::words(std::string_view name, std::vector<std::string>& values, std::string_view help) {
  takes_words_ = true;
  const auto take = [&values](const std::vector<std::string>& words) {
    for (const std::string& word : words) values.push_back(word.starts_with(" -") ? word.substr(1) : word);
  };
  app_.add_option_function<std::vector<std::string>>(std::string(name), take, std::string(help))->required();
}

void Flags::required(std::string_view short_form, std::string_view name, std::string& value, std::string_view help) {
  app_.add_option(std::string(short_form) + "," + new_flag(name), value, std::string(help))->required();
}

Given Flags::add(std::string_view name, bool& value, std::string_view, std::string_view help) {
  const std::string flag = new_flag(name);
  return finished(app_.add_flag(flag + ",!--no-" + flag.substr(2), value,
                                std::string(help) + (value ? " (default: yes)" : " (default: no)")));
}

Given Flags::add(std::string_view name, int& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, double& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::string& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::uint64_t& value, std::string_view unit, std::string_view help) {
  const Given given = add_value(name, value, unit, help);
  app_.get_option(flags_.at({group_, std::string(name)}))
      ->check([](const std::string& text) {  // otherwise -1 becomes 2^64 - 1
        return text.starts_with('-') ? "must not be negative" : std::string();
      });
  return given;
}
Given Flags::add(std::string_view name, std::optional<bool>& value, std::string_view, std::string_view help) {
  const std::string flag = new_flag(name);
  return finished(app_.add_flag_function(
      flag + ",!--no-" + flag.substr(2), [&value](std::int64_t times) { value = times > 0; }, std::string(help)));
}
Given Flags::add(std::string_view name, std::optional<int>& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::optional<double>& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::optional<std::string>& value, std::string_view unit,
                 std::string_view help) {
  if (name != "out") return add_value(name, value, unit, help);
  return finished(app_.add_option("-o," + new_flag(name), value, with_unit(help, unit)));  // as where it is required
}

int dispatch(int argc, char** argv, std::span<const Command> commands) {
  CLI::App app{
      "collinea: photographs and survey control in; oriented images, point cloud, surface model, orthophoto and\n"
      "quality report out.\n\n"
      "exit codes: 0 done, 1 defect in the program, 2 bad input or usage, 3 not found, 4 broken file,\n"
      "5 unsupported, 6 geometry has no solution, 7 not converged, 8 files differ (verify),\n"
      "130 stopped by the user",
      "collinea"};
  app.set_version_flag("--version", "collinea " COLLINEA_VERSION);
  app.require_subcommand(1);
  std::vector<Flags> flags;
  for (const Command& command : commands) {
    CLI::App* sub = app.add_subcommand(command.name, command.summary);
    if (!command.group.empty()) sub->group(command.group);
    command.declare(flags.emplace_back(*sub));
  }
  const std::string_view first = argc > 1 ? argv[1] : "";
  const auto its =
      std::find_if(commands.begin(), commands.end(), [&](const Command& command) { return command.name == first; });
  const bool known = its != commands.end();
  if (!known && !first.empty() && !first.starts_with('-')) {
    fmt::print(stderr, "error: no command is called \"{}\"; `collinea --help` lists them\n", first);
    return exit_code(Errc::kBadInput);
  }
  try {
    const bool takes_words = known && flags[static_cast<std::size_t>(its - commands.begin())].takes_words();
    std::vector<std::string> words =
        with_answers(argc, argv, known ? *app.get_subcommand(std::string(first)) : app, takes_words);
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : exit_code(Errc::kBadInput);
  }
  for (std::size_t i = 0; i < commands.size(); ++i)
    if (app.got_subcommand(commands[i].name)) return commands[i].action(flags[i]);
  return exit_code(Errc::kBadInput);
}

}  // namespace collinea
