// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/serve/message.h"

namespace collinea {

/// JSON as an answer.
[[nodiscard]] HttpResponse json_answer(std::string text, int status = 200);
/// {"error"}: how every request is refused.
[[nodiscard]] HttpResponse error_answer(int status, std::string_view message);

}  // namespace collinea
