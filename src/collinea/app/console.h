// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"

namespace collinea {

/// How progress is shown.
enum class ProgressForm { kAuto, kBar, kLines, kJson, kNone };
inline constexpr Word<ProgressForm> kProgressFormWords[] = {
    {ProgressForm::kAuto, "auto", "bar on a terminal, else lines"},
    {ProgressForm::kBar, "bar"},
    {ProgressForm::kLines, "lines"},
    {ProgressForm::kJson, "json"},
    {ProgressForm::kNone, "none"}};
[[nodiscard]] constexpr std::span<const Word<ProgressForm>> words(ProgressForm) { return kProgressFormWords; }

/// What every long command asks of its user.
struct ConsoleOptions {
  ProgressForm progress = ProgressForm::kAuto;
  int threads = 0;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ConsoleOptions;
    visit(Field{"progress", &O::progress, "", "how progress is shown on stderr"});
    visit(Field{"threads", &O::threads, "1", "processor threads; 0 = all there are. Results do not depend on it", 0});
  }
};

/// Shows a running computation to a person (a bar with the time left on a terminal, a line a step elsewhere) or to a
/// machine (JSON lines), all on stderr; keeps the log file; turns Ctrl-C and SIGTERM into a request to stop,
/// and ends the program with the exit code of a stop when that takes longer than 1.5 s. One at a time.
class Console {
 public:
  static Result<Console> create(const ConsoleOptions& options, SpellOption spelling = {});
  /// Also writes every logged line to this file.
  void log_to(const std::filesystem::path& file);
  /// For the computation, without a seed of its own: refers to this console, which must outlive it.
  [[nodiscard]] Run run();
  /// Tells what went wrong, also where nothing else is shown, and to the log file. Returns the exit code.
  int complain(const Error& error);

  Console(Console&&) noexcept;
  Console& operator=(Console&&) noexcept;
  ~Console();

 private:
  Console();
  struct State;
  std::unique_ptr<State> state_;
};

/// The same where there is no console: prints "error: ..." to stderr.
int complain(const Error& error, const SpellOption& spelling = {});

}  // namespace collinea
