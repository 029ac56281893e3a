// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/internal/words_in.h"

#include <nlohmann/json.hpp>

#include "collinea/io/text.h"

namespace collinea {
namespace {

bool is_utf8(const std::string& text) {
  try {
    (void)nlohmann::json(text).dump();  // writes UTF-8 alone
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace

Result<double> number_in(const std::string& word, std::string_view what) {
  const auto value = finite_number(word);
  if (!value) return fail(Errc::kBadInput, std::string(what) + ": \"" + word + "\" is no number such as 12.5");
  return *value;
}

Result<double> sigma_in(const std::string& word, std::string_view what) {
  COLLINEA_TRY(const double sigma, number_in(word, what));
  if (sigma <= 0) return fail(Errc::kBadInput, std::string(what) + ": a standard deviation has to be above 0");
  return sigma;
}

Result<> check_name(const std::string& name, std::string_view what) {
  if (name.empty()) return fail(Errc::kBadInput, std::string(what) + ": the name is empty");
  if (name.size() > kLongestName)
    return fail(Errc::kBadInput, std::string(what) + ": a name has at most " + std::to_string(kLongestName) + " bytes");
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      return fail(Errc::kBadInput, std::string(what) + ": the name holds a control character");
  if (!is_utf8(name)) return fail(Errc::kBadInput, std::string(what) + ": the name is not UTF-8");
  return {};
}

Result<> check_new_name(const std::string& name, std::string_view what) {
  COLLINEA_TRY(check_name(name, what));
  const bool is_framed = name.front() == ' ' || name.back() == ' ';
  if (name == "-" || name.front() == '#' || is_framed || name.find_first_of(",;\"'") != std::string::npos)
    return fail(Errc::kBadInput,
                std::string(what) + ": \"" + name +
                    "\" cannot be a new name: it begins with # or a space, ends with a space, is -, or "
                    "holds a comma, a semicolon or a quotation mark");
  return {};
}

tl::unexpected<Error> wrong_form(std::string_view form) {
  return fail(Errc::kBadInput, "the command is written: " + std::string(form));
}

}  // namespace collinea
