// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

inline constexpr std::size_t kLongestName = 500;  ///< bytes of a name of a point or an image

/// A number of a command. Errors: none, or not finite; `what` names it.
[[nodiscard]] Result<double> number_in(const std::string& word, std::string_view what);
/// The same of a standard deviation: above 0.
[[nodiscard]] Result<double> sigma_in(const std::string& word, std::string_view what);
/// A name of a point or an image, as tables hold it: UTF-8, at most kLongestName bytes, without control characters.
/// Errors say what is wrong with it; `what` names it.
[[nodiscard]] Result<> check_name(const std::string& name, std::string_view what);
/// The same of a name that is new: it also does without commas, semicolons and quotation marks, which separate and
/// enclose fields of tables, and neither begins with # nor is "-".
[[nodiscard]] Result<> check_new_name(const std::string& name, std::string_view what);

/// The words of a command of a kind: its own, and those that say the rest.
template <class Kind>
[[nodiscard]] std::vector<std::string> command_words(const Kind& kind) {
  std::vector<std::string> words = {std::string(Kind::kWord)};
  for (std::string& word : kind.words()) words.push_back(std::move(word));
  return words;
}

/// That a command is written otherwise than `form`.
[[nodiscard]] tl::unexpected<Error> wrong_form(std::string_view form);

}  // namespace collinea
