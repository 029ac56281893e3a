// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "collinea/base/result.h"

namespace collinea {

/// Everything a long computation may ask of the world around it. Passed down, never global.
struct Run {
  std::stop_token stop = {};                                               ///< set by Ctrl-C
  std::function<void(std::string_view stage, double done)> progress = {};  ///< done in [0, 1]; called from any thread
  std::function<void(std::string_view line)> log = {};                     ///< called from any thread
  int threads = 1;
  std::uint64_t seed = 1;     ///< same inputs + same seed = same bits, whatever `threads` is
  SpellOption spelling = {};  ///< of an option in a logged line; nothing: its name

  [[nodiscard]] bool stopped() const { return stop.stop_requested(); }
  void report(std::string_view stage, double done) const {
    if (progress) progress(stage, done);
  }
  void say(std::string_view line) const {
    if (log) log(line);
  }
  /// An option as the user types it: "--given-sigmas".
  [[nodiscard]] std::string spelled(const OptionName& option) const {
    return spelling ? spelling(option) : option.name;
  }
};

}  // namespace collinea
