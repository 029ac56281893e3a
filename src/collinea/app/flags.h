// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/base/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace collinea {

/// An option as command lines spell it, with its value where there is one: "--max-error-px", "--calibration none".
[[nodiscard]] std::string flag_of(const OptionName& option);

/// Whether the user gave a flag; to be asked once the command line is read.
using Given = std::function<bool()>;

/// The flags of one command. A thin face of the command-line library, so that it is compiled in one place only.
/// Names are given as in options structs (max_error_px) and appear as flags (--max-error-px).
class Flags {
 public:
  explicit Flags(CLI::App& app) : app_(app) {}

  void positional(std::string_view name, std::string& value, std::string_view help, bool required = true);
  /// Any number of them, also none; the last of the positional ones.
  void positional(std::string_view name, std::vector<std::string>& values, std::string_view help);
  /// The same of words that may be numbers below zero, which look like flags; at least one.
  void words(std::string_view name, std::vector<std::string>& values, std::string_view help);
  [[nodiscard]] bool takes_words() const { return takes_words_; }
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

  /// Every field of the options, of their parts and groups, under the heading `group` or their own. A name that is
  /// taken gets the group in front.
  template <class Options>
  void add_all(Options& options, const char* group) {
    add_all(options, group, [](const char*, const auto&, const Given&) {});
  }

  /// The same, and calls seen(group, field, given) for each.
  template <class Options, class Seen>
  void add_all(Options& options, const char* group, Seen&& seen) {
    for_each_group(group, options, [&](const char* its, auto& part) {
      group_ = its;
      for_each_field(part, [&](const auto& field, auto& owner) { seen(its, field, add_field(field, owner)); });
    });
    group_ = {};
  }

  /// The options of one group only, not of those inside it.
  template <class Options, class Seen>
  void add_group(Options& options, const char* group, Seen&& seen) {
    group_ = group;
    for_each_field(options, [&](const auto& field, auto& owner) { seen(group, field, add_field(field, owner)); });
    group_ = {};
  }

  /// The flag by which this command takes an option, as flag_of() unless another option has that flag.
  [[nodiscard]] std::string spelled(const OptionName& option) const;

 private:
  /// A flag whose value is read by hand: take(text) says whether it could be.
  struct Text {
    std::string value_name;            ///< of the value, in the help: "FILE"
    std::string shown;                 ///< the value before; empty: none
    std::vector<Choice> choices = {};  ///< none: anything
    std::function<bool(const std::string&)> take;
  };
  Given add_text(std::string_view name, std::string_view help, Text text);
  template <class T>
  Given add_value(std::string_view name, T& value, std::string_view unit, std::string_view help);
  template <class Owner, class T>
  Given add_field(const Field<Owner, T>& field, Owner& owner);
  [[nodiscard]] std::string new_flag(std::string_view name);
  Given finished(CLI::Option* option);

  CLI::App& app_;
  std::string group_;
  bool takes_words_ = false;
  std::map<std::pair<std::string, std::string>, std::string> flags_;  ///< by group and name of option
};

[[nodiscard]] std::string value_name_of(PathKind kind);
/// "largest distance [px]".
[[nodiscard]] std::string with_unit(std::string_view help, std::string_view unit);

template <class Owner, class T>
Given Flags::add_field(const Field<Owner, T>& field, Owner& owner) {
  using Value = OptionValue<T>;
  T& value = owner.*field.member;
  constexpr bool kIsOptional = requires { value.has_value(); };
  if constexpr (Worded<Value>) {
    Text text{.value_name = "WORD", .shown = {}, .choices = field.choices(), .take = {}};
    if constexpr (kIsOptional)
      text.shown = value ? word_of(*value) : field.automatic ? "auto" : "";
    else
      text.shown = word_of(value);
    text.take = [&value](const std::string& word) {
      const auto known = from_word<Value>(word);
      if constexpr (kIsOptional) {
        value = known;  // only "auto" comes here without being known
      } else if (known) {
        value = *known;
      }
      return true;
    };
    return add_text(field.name, field.help, std::move(text));
  } else if constexpr (detail::kIsWordOr<Value>) {
    Text text{.value_name = "TEXT", .shown = {}, .take = {}};
    if constexpr (kIsOptional)
      text.shown = value ? value->text() : "";
    else
      text.shown = value.text();
    text.take = [&value](const std::string& given) {
      value = Value(given);
      return true;
    };
    return add_text(field.name, with_unit(field.help, field.unit), std::move(text));
  } else if constexpr (std::is_same_v<Value, std::filesystem::path>) {
    return add_text(field.name, field.help, {value_name_of(field.path), {}, {}, [&value](const std::string& path) {
                                               if constexpr (kIsOptional) {
                                                 value.reset();
                                                 if (!path.empty()) value = path;
                                               } else {
                                                 value = path;
                                               }
                                               return true;
                                             }});
  } else {
    return add(field.name, value, field.unit, field.help);
  }
}

/// A command of the program: its flags, and what it does once they are read. The action returns the exit code; it is
/// given the flags as they were declared, to name them.
struct Command {
  std::string name, summary;
  std::function<void(Flags&)> declare;
  std::function<int(const Flags&)> action;
  std::string group = {};  ///< its heading in the help
};

/// Reads the command line and runs the command it names. Returns the exit code.
int dispatch(int argc, char** argv, std::span<const Command> commands);

}  // namespace collinea
