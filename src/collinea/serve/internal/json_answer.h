// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/serve/message.h"

namespace collinea {

/// JSON as an answer.
[[nodiscard]] HttpResponse json_answer(std::string text, int status = 200);
/// {"error"}: how every request is refused.
[[nodiscard]] HttpResponse error_answer(int status, std::string_view message);
/// By the kind of failure; options have their names, as in what is asked.
[[nodiscard]] HttpResponse error_answer(const Error& error);
[[nodiscard]] HttpResponse answer_or_error(const Result<std::string>& text);
[[nodiscard]] HttpResponse not_found();
/// `methods`: those that there are.
[[nodiscard]] HttpResponse method_not_allowed(const std::string& methods);

/// Digits alone; nothing when it is anything else, or too large.
[[nodiscard]] std::optional<std::uint64_t> number_of(std::string_view text);

}  // namespace collinea
