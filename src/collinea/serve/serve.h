// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"

namespace collinea {

struct ServeOptions {
  int port = 8471;
  std::optional<std::string> listen;
  bool open = false;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ServeOptions;
    visit(Field{"port", &O::port, "1", "port of the server; 0: any that is free", 0, 65535});
    visit(Field{"listen", &O::listen, "",
                "address to be reached at from other machines, 0.0.0.0 for all that this one has; nothing: from this "
                "machine alone"});
    visit(Field{"open", &O::open, "", "opens the page in the browser"});
  }
};

/// Serves projects, and those in these folders, to browsers until a stop is requested; nothing given: the folder that
/// it is started in. `show` takes the lines that have a link, from any thread. Errors: a folder that is not there, a
/// port that cannot be had.
[[nodiscard]] Result<> serve(std::vector<std::filesystem::path> roots, const ServeOptions& options, const Run& run,
                             const std::function<void(std::string_view line)>& show);

}  // namespace collinea
