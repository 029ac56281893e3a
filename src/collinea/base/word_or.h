// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <concepts>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "collinea/base/words.h"

namespace collinea {

/// The finite number that the whole text is, in any locale; a plus sign in front is allowed.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

/// Three finite numbers parted by commas, as "0.02,-0.05, -0.19": spaces may stand before each, and nothing else.
using ThreeNumbers = std::array<double, 3>;
[[nodiscard]] std::optional<ThreeNumbers> three_numbers_in(std::string_view text);

/// The value of an option that is a word of an enumeration, or a number (or three of them), or else the path of a file
/// or other text:
///
///     WordOr<VolumeBase, double, std::filesystem::path> base = VolumeBase::kRim;
///     base = "310.5";                                       // base.get<double>()
///     base = "may/dsm.tif";                                 // base.get<std::filesystem::path>()
///
/// A text is the first of them that it can be, in their order; the last takes every text.
template <Worded Enum, class... Other>
class WordOr {
  using Value = std::variant<Enum, Other...>;
  using Last = std::variant_alternative_t<sizeof...(Other), Value>;
  static_assert(std::same_as<Last, std::filesystem::path> || std::same_as<Last, std::string>);

 public:
  WordOr() : WordOr(Enum{}) {}  ///< the word of the enumeration's 0
  WordOr(Enum word) : text_(word_of(word)), value_(word) {}
  template <std::convertible_to<std::string_view> Text>
  WordOr(const Text& text) : text_(std::string_view(text)), value_(read(text_)) {}

  /// As it was given.
  [[nodiscard]] const std::string& text() const { return text_; }
  /// The word; nothing where it is none.
  [[nodiscard]] std::optional<Enum> word() const {
    const Enum* word = get<Enum>();
    return word ? std::optional(*word) : std::nullopt;
  }
  /// What it is, where it is a T; otherwise null.
  template <class T>
  [[nodiscard]] const T* get() const {
    return std::get_if<T>(&value_);
  }
  /// The words that it may be, with their meanings.
  [[nodiscard]] static constexpr auto table() { return words(Enum{}); }

  friend bool operator==(const WordOr& a, const WordOr& b) { return a.text_ == b.text_; }

 private:
  static Value read(const std::string& text) {
    if (const auto word = from_word<Enum>(text)) return *word;
    if constexpr ((std::same_as<Other, double> || ...))
      if (const auto number = number_in(text)) return *number;
    if constexpr ((std::same_as<Other, ThreeNumbers> || ...))
      if (const auto numbers = three_numbers_in(text)) return *numbers;
    return Last(text);
  }

  std::string text_;
  Value value_;
};

namespace detail {
template <class T>
inline constexpr bool kIsWordOr = false;
template <class Enum, class... Other>
inline constexpr bool kIsWordOr<WordOr<Enum, Other...>> = true;
}  // namespace detail

}  // namespace collinea
