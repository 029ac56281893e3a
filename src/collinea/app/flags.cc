// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "collinea/app/exit_code.h"

namespace collinea {

std::string Flags::flag_of(std::string_view name) const {
  const auto spelled = [](std::string text) {
    std::replace(text.begin(), text.end(), '_', '-');
    return "--" + text;
  };
  const std::string flag = spelled(std::string(name));
  if (app_.get_option_no_throw(flag) == nullptr) return flag;
  return spelled(group_ + "_" + std::string(name));
}

template <class T>
Given Flags::add_value(std::string_view name, T& value, std::string_view unit, std::string_view help) {
  std::string text(help);
  if (!unit.empty() && unit != "1") text += " [" + std::string(unit) + "]";
  auto* option = app_.add_option(flag_of(name), value, text);
  if constexpr (requires { value.has_value(); }) {
    if (value) option->capture_default_str();
  } else {
    option->capture_default_str();
  }
  if (!group_.empty()) option->group(group_);
  return [option] { return option->count() > 0; };
}

void Flags::positional(std::string_view name, std::string& value, std::string_view help, bool required) {
  app_.add_option(std::string(name), value, std::string(help))->required(required);
}

void Flags::required(std::string_view short_form, std::string_view name, std::string& value, std::string_view help) {
  app_.add_option(std::string(short_form) + "," + flag_of(name), value, std::string(help))->required();
}

Given Flags::add(std::string_view name, bool& value, std::string_view, std::string_view help) {
  const std::string flag = flag_of(name);
  auto* option = app_.add_flag(flag + ",!--no-" + flag.substr(2), value,
                               std::string(help) + (value ? " (default: yes)" : " (default: no)"));
  if (!group_.empty()) option->group(group_);
  return [option] { return option->count() > 0; };
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
  const std::string flag = flag_of(name);
  const Given given = add_value(name, value, unit, help);
  app_.get_option(flag)->check([](const std::string& text) {  // otherwise -1 becomes 2^64 - 1
    return text.starts_with('-') ? "must not be negative" : std::string();
  });
  return given;
}
Given Flags::add(std::string_view name, std::optional<bool>& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::optional<int>& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::optional<double>& value, std::string_view unit, std::string_view help) {
  return add_value(name, value, unit, help);
}
Given Flags::add(std::string_view name, std::optional<std::string>& value, std::string_view unit,
                 std::string_view help) {
  return add_value(name, value, unit, help);
}

int dispatch(int argc, char** argv, std::span<const Command> commands) {
  CLI::App app{
      "collinea: photographs and survey control in; oriented images, point cloud, surface model, orthophoto and\n"
      "quality report out.\n\n"
      "exit codes: 0 done, 1 defect in the program, 2 bad input or usage, 3 not found, 4 broken file,\n"
      "5 unsupported, 6 geometry has no solution, 7 not converged, 130 stopped by the user",
      "collinea"};
  app.set_version_flag("--version", "collinea " COLLINEA_VERSION);
  app.require_subcommand(1);
  for (const Command& command : commands) {
    CLI::App* sub = app.add_subcommand(command.name, command.summary);
    Flags flags(*sub);
    command.declare(flags);
  }
  const std::string_view first = argc > 1 ? argv[1] : "";
  const bool known =
      std::any_of(commands.begin(), commands.end(), [&](const Command& command) { return command.name == first; });
  if (!known && !first.empty() && !first.starts_with('-')) {
    fmt::print(stderr, "error: no command is called \"{}\"; `collinea --help` lists them\n", first);
    return exit_code(Errc::kBadInput);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : exit_code(Errc::kBadInput);
  }
  for (const Command& command : commands)
    if (app.got_subcommand(command.name)) return command.action();
  return exit_code(Errc::kBadInput);
}

}  // namespace collinea
