// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace collinea {

class OpenFile;

/// A request as the server read it. Names of headers are in lower case.
struct HttpRequest {
  std::string method, target;
  std::map<std::string, std::string> headers = {};
  std::string body = {};

  /// Empty when there is none.
  [[nodiscard]] std::string_view header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string_view() : found->second;
  }
};

/// Bytes of a file, sent without ever being in memory as a whole.
struct FilePart {
  std::shared_ptr<const OpenFile> file;
  std::uint64_t offset = 0, size = 0;
};

/// What is answered: a body, or a part of a file.
struct HttpResponse {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body = {};
  std::optional<FilePart> file = {};
  std::vector<std::pair<std::string, std::string>> headers = {};  ///< beside those that every answer has

  [[nodiscard]] std::uint64_t size() const { return file ? file->size : body.size(); }
};

}  // namespace collinea
