// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/json_answer.h"

#include <nlohmann/json.hpp>

#include "collinea/project/json_text.h"

namespace collinea {

HttpResponse json_answer(std::string text, int status) {
  return {.status = status, .type = "application/json", .body = std::move(text)};
}

HttpResponse error_answer(int status, std::string_view message) {
  return json_answer(json_text({{"error", message}}), status);
}

}  // namespace collinea
