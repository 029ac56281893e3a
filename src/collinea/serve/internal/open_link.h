// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "collinea/base/result.h"

namespace collinea {

/// A link that was given to the user's browser, by a file that only the user can read: what stands among the arguments
/// of a program, others on the machine can see. The file is gone at its end.
class OpenedLink {
 public:
  /// Errors: no such file can be made, no program that opens links. The browser has a session of its own, so that
  /// Ctrl-C does not reach it.
  [[nodiscard]] static Result<OpenedLink> open(const std::string& link);

  OpenedLink(OpenedLink&& other) noexcept : folder_(std::exchange(other.folder_, {})) {}
  OpenedLink& operator=(OpenedLink&&) = delete;
  ~OpenedLink();

 private:
  explicit OpenedLink(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

}  // namespace collinea
