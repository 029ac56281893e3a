// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace collinea {

/// The word by which people, files and other programs name a value of an enumeration. Beside each enumeration stands
/// one table of them, found by `words`:
///
///     enum class OrientMode { kAuto, kIncremental, kGlobal };
///     inline constexpr Word<OrientMode> kOrientModeWords[] = {
///         {OrientMode::kAuto, "auto", "global from 300 images on"}, ...};
///     constexpr std::span<const Word<OrientMode>> words(OrientMode) { return kOrientModeWords; }
template <class Enum>
struct Word {
  Enum value;
  std::string_view word;
  std::string_view meaning = {};  ///< for lists of choices; empty: the word says it
};

/// An enumeration, or another closed list of values, with a table of words.
template <class Enum>
concept Worded = requires(const Enum value) {
  words(value).front().word;
};

/// The word of a value; empty when the table lacks it.
template <Worded Enum>
[[nodiscard]] constexpr std::string_view word_of(Enum value) {
  for (const auto& entry : words(value))
    if (entry.value == value) return entry.word;
  return {};
}

/// The value with this word; nothing when there is none.
template <Worded Enum>
[[nodiscard]] constexpr std::optional<Enum> from_word(std::string_view word) {
  for (const auto& entry : words(Enum{}))
    if (entry.word == word) return entry.value;
  return std::nullopt;
}

/// Whether a table has a row for each of the `count` values of an enumeration, in their order, so that a value is the
/// index of its row. `member` of a row is the value that it is of.
template <class Rows, class Enum, class Row>
[[nodiscard]] constexpr bool is_in_order(const Rows& rows, std::size_t count, Enum Row::*member) {
  if (std::size(rows) != count) return false;
  std::size_t i = 0;
  for (const Row& row : rows)
    if (row.*member != static_cast<Enum>(i++)) return false;
  return true;
}

/// The words of a table alone, in its order.
template <class Enum, std::size_t kCount>
[[nodiscard]] constexpr std::array<std::string_view, kCount> only_words(const Word<Enum> (&table)[kCount]) {
  std::array<std::string_view, kCount> out{};
  for (std::size_t i = 0; i < kCount; ++i) out[i] = table[i].word;
  return out;
}

/// "las, laz or copc".
[[nodiscard]] std::string listed(std::span<const std::string_view> choices);

}  // namespace collinea
