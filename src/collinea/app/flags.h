// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace collinea {

/// Whether the user gave a flag; to be asked once the command line is read.
using Given = std::function<bool()>;

/// The flags of one command. A thin face of the command-line library, so that it is compiled in one place only.
/// Names are given as in options structs (max_error_px) and appear as flags (--max-error-px).
class Flags {
 public:
  explicit Flags(CLI::App& app) : app_(app) {}

  void positional(std::string_view name, std::string& value, std::string_view help, bool required = true);
  /// A flag with a short form: "-o".
  void required(std::string_view short_form, std::string_view name, std::string& value, std::string_view help);

  Given add(std::string_view name, bool& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, int& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, double& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::string& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::uint64_t& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::optional<bool>& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::optional<int>& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::optional<double>& value, std::string_view unit, std::string_view help);
  Given add(std::string_view name, std::optional<std::string>& value, std::string_view unit, std::string_view help);

  /// Every field of an options struct, under the heading `group`. A name that is taken gets the group in front.
  template <class Options>
  void add_all(Options& options, std::string_view group) {
    add_all(options, group, [](const auto&, const Given&) {});
  }

  /// The same, and tells seen(field, given) of each.
  template <class Options, class Seen>
  void add_all(Options& options, std::string_view group, Seen&& seen) {
    group_ = group;
    Options::describe(
        [&](const auto& field) { seen(field, add(field.name, options.*field.member, field.unit, field.help)); });
    group_ = {};
  }

 private:
  template <class T>
  Given add_value(std::string_view name, T& value, std::string_view unit, std::string_view help);
  [[nodiscard]] std::string flag_of(std::string_view name) const;

  CLI::App& app_;
  std::string group_;
};

/// A command of the program: its flags, and what it does once they are read. The action returns the exit code.
struct Command {
  std::string name, summary;
  std::function<void(Flags&)> declare;
  std::function<int()> action;
};

/// Reads the command line and runs the command it names. Returns the exit code.
int dispatch(int argc, char** argv, std::span<const Command> commands);

}  // namespace collinea
