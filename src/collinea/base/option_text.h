// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "collinea/base/options.h"

namespace collinea {

// One option as text, as the command line takes it: "none", "0.5", "yes", "auto". For files that state options.

namespace detail {

template <class T>
[[nodiscard]] std::string value_text(const T& value) {
  if constexpr (Worded<T>)
    return std::string(word_of(value));
  else if constexpr (kIsWordOr<T>)
    return value.text();
  else if constexpr (std::is_same_v<T, bool>)
    return value ? "yes" : "no";
  else if constexpr (std::is_same_v<T, std::filesystem::path>)
    return value.string();
  else
    return fmt::format("{}", value);  // of a number the shortest digits that read back as the same
}

[[nodiscard]] inline Error invalid(std::string_view name, std::string_view text, std::string_view expected) {
  return {Errc::kBadInput,
          std::string(name) + " = \"" + std::string(text) + "\": " + std::string(expected) + " is expected"};
}

template <class Owner, class T>
[[nodiscard]] Result<OptionValue<T>> value_in(const Field<Owner, T>& field, std::string_view text) {
  using Value = OptionValue<T>;
  if constexpr (Worded<Value>) {
    if (const auto known = from_word<Value>(text)) return *known;
    return tl::unexpected(not_a_choice(field.name, text, field.choices()));
  } else if constexpr (std::is_same_v<Value, bool>) {
    if (text == "yes" || text == "true") return true;
    if (text == "no" || text == "false") return false;
    return tl::unexpected(invalid(field.name, text, "yes or no"));
  } else if constexpr (std::is_arithmetic_v<Value>) {
    const auto number = number_in(text);
    if (!number) return tl::unexpected(invalid(field.name, text, "a number"));
    if constexpr (std::is_integral_v<Value>) {
      if (!(*number == static_cast<double>(static_cast<long long>(*number)) && std::abs(*number) < 1e15) ||
          !std::in_range<Value>(static_cast<long long>(*number)))
        return tl::unexpected(invalid(field.name, text, "a whole number"));
    }
    return static_cast<Value>(*number);
  } else {
    return Value(std::string(text));
  }
}

}  // namespace detail

/// The value of an option as text; nothing where nothing is chosen and no word says so.
template <class Owner, class T>
[[nodiscard]] std::optional<std::string> option_text(const Field<Owner, T>& field, const Owner& owner) {
  const T& value = owner.*field.member;
  if constexpr (requires { value.has_value(); }) {
    if (!value) return field.automatic ? std::optional<std::string>("auto") : std::nullopt;
    return detail::value_text(*value);
  } else {
    return detail::value_text(value);
  }
}

/// Takes an option from such a text. Errors: kBadInput (no such word, no number, out of range), with the option's name.
template <class Owner, class T>
[[nodiscard]] Result<> read_option(const Field<Owner, T>& field, std::string_view text, Owner& owner) {
  if constexpr (requires { (owner.*field.member).has_value(); }) {
    if (field.automatic && text == "auto") {
      (owner.*field.member).reset();
      return {};
    }
  }
  COLLINEA_TRY(OptionValue<T> value, detail::value_in(field, text));
  COLLINEA_TRY(validate_field(field, value));
  owner.*field.member = std::move(value);
  return {};
}

}  // namespace collinea
