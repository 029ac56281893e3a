// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/console.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <thread>

#include "collinea/app/exit_code.h"

namespace collinea {
namespace {

using Clock = std::chrono::steady_clock;

enum class Show { kBar, kLines, kJson, kNone };

std::string time_text(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

}  // namespace

struct Console::State {
  std::mutex mutex;
  Show show = Show::kLines;
  int threads = 1;
  std::uint64_t seed = 1;
  std::stop_source stop;
  std::jthread signals;  // waits for Ctrl-C
  std::FILE* log_file = nullptr;

  std::string stage;
  Clock::time_point stage_start, last_shown;
  bool bar_on_screen = false;

  ~State() {
    clear_bar();
    if (log_file) std::fclose(log_file);
  }

  void clear_bar() {
    if (bar_on_screen) std::fputs("\r\x1b[K", stderr);
    bar_on_screen = false;
  }

  void progress(std::string_view name, double done) {
    const std::lock_guard lock(mutex);
    const auto now = Clock::now();
    if (stage != name) {
      stage = name;
      stage_start = now;
      last_shown = {};
    }
    if (done < 1 && now - last_shown < std::chrono::milliseconds(200)) return;
    last_shown = now;
    const double elapsed_s = std::chrono::duration<double>(now - stage_start).count();
    const double left_s = done > 0.01 ? elapsed_s * (1 - done) / done : -1;
    if (show == Show::kJson) {
      fmt::print(stderr, "{{\"stage\":\"{}\",\"done\":{:.4f},\"elapsed_s\":{:.1f},\"left_s\":{}}}\n", escaped(name), done,
                 elapsed_s, left_s < 0 ? "null" : fmt::format("{:.1f}", left_s));
    } else if (show == Show::kBar) {
      constexpr int kWidth = 32;
      const int full = std::clamp(static_cast<int>(done * kWidth + 0.5), 0, kWidth);
      fmt::print(stderr, "\r\x1b[K{:<24} [{:=<{}}{: <{}}] {:3.0f} %  {}", name, "", full, "", kWidth - full, 100 * done,
                 left_s < 0 ? "" : time_text(left_s) + " left");
      bar_on_screen = true;
    }
    std::fflush(stderr);
  }

  void say(std::string_view line) {
    const std::lock_guard lock(mutex);
    clear_bar();
    if (show == Show::kJson)
      fmt::print(stderr, "{{\"log\":\"{}\"}}\n", escaped(line));
    else if (show != Show::kNone)
      fmt::print(stderr, "{}\n", line);
    std::fflush(stderr);
    if (log_file) {
      const std::time_t now = std::time(nullptr);
      fmt::print(log_file, "{:%Y-%m-%d %H:%M:%S} {}\n", fmt::localtime(now), line);
      std::fflush(log_file);
    }
  }

  // Signals are taken by one thread with sigwait: no handler runs inside the computation.
  void watch_signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGUSR2);  // our own wake-up call at the end
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    signals = std::jthread([this, set](std::stop_token finished) {
      int signal = 0;
      while (sigwait(&set, &signal) == 0 && !finished.stop_requested()) {
        if (signal == SIGUSR2) continue;
        if (stop.stop_requested()) _exit(exit_code(Errc::kCancelled));  // asked twice: at once
        stop.request_stop();
        say("stopping; what is done is kept (once more to stop at once)");
      }
    });
  }
  void unwatch_signals() {
    if (!signals.joinable()) return;
    signals.request_stop();
    pthread_kill(signals.native_handle(), SIGUSR2);
    signals.join();
  }
};

Console::Console() : state_(std::make_unique<State>()) {}
Console::Console(Console&&) noexcept = default;
Console& Console::operator=(Console&&) noexcept = default;
Console::~Console() {
  if (state_) state_->unwatch_signals();
}

Result<Console> Console::create(const ConsoleOptions& options) {
  Console console;
  State& state = *console.state_;
  if (options.progress == "auto")
    state.show = isatty(STDERR_FILENO) ? Show::kBar : Show::kLines;
  else if (options.progress == "bar")
    state.show = Show::kBar;
  else if (options.progress == "lines")
    state.show = Show::kLines;
  else if (options.progress == "json")
    state.show = Show::kJson;
  else if (options.progress == "none")
    state.show = Show::kNone;
  else
    return fail(Errc::kBadInput, "--progress " + options.progress + ": choose auto, bar, lines, json or none");
  const int available = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  state.threads = options.threads > 0 ? options.threads : available;
  state.seed = options.seed;
  state.watch_signals();
  return console;
}

void Console::log_to(const std::filesystem::path& file) {
  const std::lock_guard lock(state_->mutex);
  if (state_->log_file) std::fclose(state_->log_file);
  state_->log_file = std::fopen(file.c_str(), "a");
}

Run Console::run() {
  State* state = state_.get();
  return {.stop = state->stop.get_token(),
          .progress = [state](std::string_view stage, double done) { state->progress(stage, done); },
          .log = [state](std::string_view line) { state->say(line); },
          .threads = state->threads,
          .seed = state->seed};
}

int complain(const Error& error) {
  fmt::print(stderr, "error: {}\n", error.message);
  return exit_code(error.code);
}

}  // namespace collinea
