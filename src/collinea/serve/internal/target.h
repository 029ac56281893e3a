// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace collinea {

/// The target of a request in its parts, with escapes resolved: "/api/projects/7/files/a%20b?x=1".
struct Target {
  std::vector<std::string> path;             ///< "api", "projects", ...; empty of "/"
  std::map<std::string, std::string> query;  ///< the first of those with one name
};

/// Nothing when it does not begin with "/", an escape is broken, or it holds control characters. A part of the path may
/// be anything else, also "..": who makes a file of it must look.
[[nodiscard]] std::optional<Target> parsed_target(std::string_view target);

}  // namespace collinea
