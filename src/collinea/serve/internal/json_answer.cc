// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/json_answer.h"

#include <charconv>
#include <nlohmann/json.hpp>

#include "collinea/project/json_text.h"
#include "collinea/report/error_text.h"

namespace collinea {
namespace {

// The HTTP status of each kind of failure.
constexpr int http_status(Errc code) {
  switch (code) {
    case Errc::kBadInput:
      return 400;
    case Errc::kNotFound:
      return 404;
    case Errc::kBadFormat:
    case Errc::kIllPosed:
    case Errc::kNotConverged:
      return 422;
    case Errc::kUnsupported:
      return 501;
    case Errc::kCancelled:
      return 409;
  }
  return 500;
}

}  // namespace

HttpResponse json_answer(std::string text, int status) {
  return {.status = status, .type = "application/json", .body = std::move(text)};
}

HttpResponse error_answer(int status, std::string_view message) {
  return json_answer(json_text({{"error", message}}), status);
}

HttpResponse error_answer(const Error& error) { return error_answer(http_status(error.code), text_of(error, {})); }

HttpResponse answer_or_error(const Result<std::string>& text) {
  return text ? json_answer(*text) : error_answer(text.error());
}

HttpResponse not_found() { return error_answer(404, "there is nothing of this name"); }

HttpResponse method_not_allowed(const std::string& methods) {
  HttpResponse response = error_answer(405, "this is asked in another way: " + methods);
  response.headers.emplace_back("Allow", methods);
  return response;
}

std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace collinea
