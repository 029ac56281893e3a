// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/bounded_json.h"

#include <stdexcept>

namespace collinea {

nlohmann::ordered_json bounded_json(std::string_view body) {
  using json = nlohmann::ordered_json;
  return json::parse(body, [](int depth, json::parse_event_t, json&) {
    constexpr int kDeepest = 8;
    if (depth > kDeepest) throw std::invalid_argument("it is nested too deep");
    return true;
  });
}

ImageId image_in(const nlohmann::ordered_json& number) {
  if (!number.is_number_unsigned() || number.get<std::uint64_t>() >= ImageId::kNone)
    throw std::invalid_argument("an image is asked for by its number");
  return ImageId{number.get<std::uint32_t>()};
}

}  // namespace collinea
